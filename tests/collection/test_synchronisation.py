"""Cycles, trees and the middle of all ways: which maps are wrong, and what mends them."""

from __future__ import annotations

import numpy as np
import pytest
from collection_family import NAMES, family, mirrored, points_of, true_maps
from in_pieces import in_pieces
from shapes import creature

import qgeo_filters as qg
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.closest_points import closest_points
from qgeo_filters.collection.composition import along, checked_maps, composed
from qgeo_filters.collection.cycles import CycleConsistency, chosen_triangles, cycle_consistency, message_passing
from qgeo_filters.collection.spanning_tree import spanning_tree, template_maps, tree_maps
from qgeo_filters.collection.synchronisation import synchronised_maps
from qgeo_filters.surface import Surface

FAMILY = family(1)
TRUE = true_maps(FAMILY)
WRONG = [("a", "d"), ("b", "f")]


def with_wrong_pairs() -> dict[tuple[str, str], np.ndarray]:
    maps = dict(TRUE)
    for x, y in WRONG:
        maps[x, y] = maps[y, x] = mirrored(FAMILY["a"])
    return maps


def noisy(size: float, seed: int = 0) -> dict[tuple[str, str], BarycentricMap]:
    """True maps, each vertex moved at random along the surface."""
    rng = np.random.default_rng(seed)
    return {
        (x, y): closest_points(
            FAMILY[y].vertices + size * np.sqrt(FAMILY[y].area) * rng.normal(size=FAMILY[y].vertices.shape), FAMILY[y]
        )
        for x, y in TRUE
    }


def test_true_maps_have_no_inconsistency():
    found = cycle_consistency(FAMILY, TRUE)
    off = ~np.eye(len(NAMES), dtype=bool)
    assert found.gaps.tolist() == [0.0] * (6 * 5 * 4)
    assert found.share == 1.0
    assert (found.inconsistency[off] == 0).all()
    assert np.isnan(np.diag(found.inconsistency)).all()
    assert found.wrong() == []


def test_the_wrong_maps_are_found_and_no_others():
    found = cycle_consistency(FAMILY, with_wrong_pairs())
    assert sorted(found.wrong()) == WRONG
    swap = mirrored(FAMILY["a"])
    for x, y in WRONG:
        distances = qg.distance_matrix(FAMILY[y])[np.arange(len(swap)), swap] / np.sqrt(FAMILY[y].area)
        assert found.of(x, y) == pytest.approx(distances.mean(), rel=0.25)  # what it is wrong by
    others = [gap for pair, gap in found.ranked() if pair not in WRONG]
    assert max(others) < 0.01


def test_gaps_of_triangles_are_geodesic_distances():
    """One vertex of one map goes elsewhere: the gap is its distance, in the mean over the points."""
    shapes = {name: FAMILY[name] for name in "abc"}
    maps = {pair: images for pair, images in TRUE.items() if set(pair) <= set("abc")}
    n = shapes["a"].n_vertices
    maps["a", "c"] = np.where(np.arange(n) == 5, 30, np.arange(n))
    found = cycle_consistency(shapes, maps, points=n)
    distance = qg.distances(shapes["c"], [5])[0, 30] / np.sqrt(shapes["c"].area)
    at = np.flatnonzero((found.triangles == [0, 2, 1]).all(axis=1))
    assert found.gaps[at] == pytest.approx([distance / n], rel=1e-5)


def model_gaps(m: int, bad: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Which of the pairs are wrong, and gaps: as far apart as the worst of a triangle's three maps is wrong."""
    wrong = np.zeros((m, m), dtype=bool)
    for i, j in np.random.default_rng(seed).permutation(np.column_stack(np.triu_indices(m, 1)))[:bad]:
        wrong[i, j] = wrong[j, i] = True
    error = np.where(wrong, 0.3, 0.01)
    gaps = np.maximum(np.maximum(error[:, :, None], error[:, None, :]), error.T[None, :, :])
    for i in range(m):
        gaps[i, i, :] = gaps[i, :, i] = gaps[:, i, i] = np.nan
    return wrong, gaps


def test_blame_is_found_where_half_of_the_triangles_are_wrong():
    m = 12
    wrong, gaps = model_gaps(m, 14, seed=3)
    triangles = np.argwhere(np.isfinite(gaps))
    blame = message_passing(m, triangles, gaps[tuple(triangles.T)])
    off = ~np.eye(m, dtype=bool)
    assert (np.nanmedian(gaps[off & ~wrong], axis=1) > 0.05).any()  # the median over triangles would not do
    assert ((blame > 0.15) == wrong)[off].all()
    assert np.array_equal(blame, blame.T, equal_nan=True)


def test_a_sample_of_the_triangles_finds_the_same_wrong_maps():
    """Every map of ninety shapes is judged by 48 others; the sixth part of all maps is wrong."""
    m = 90
    wrong, gaps = model_gaps(m, m * (m - 1) // 12, seed=0)
    pairs = {(x, y) for x in range(m) for y in range(m) if x != y}
    triangles, share = chosen_triangles(range(m), pairs, 48, seed=0)
    assert share == pytest.approx(48 / (m - 2))
    assert len(np.unique(triangles, axis=0)) == len(triangles) == m * (m - 1) * 48
    assert all(len({*row}) == 3 for row in triangles.tolist())
    blame = message_passing(m, triangles, gaps[tuple(triangles.T)])
    assert ((blame > 0.15) == wrong)[~np.eye(m, dtype=bool)].all()


def test_sampled_triangles_are_said_and_their_gaps_are_those_of_all():
    every = cycle_consistency(FAMILY, with_wrong_pairs())
    few = cycle_consistency(FAMILY, with_wrong_pairs(), thirds=3, seed=1)
    assert (every.share, few.share) == (1.0, 0.75)
    assert "75 % of all" in repr(few)
    assert "of all" not in repr(every)
    gap_of = dict(zip(map(tuple, every.triangles.tolist()), every.gaps, strict=True))
    assert len(few.gaps) == 6 * 5 * 3
    assert few.gaps.tolist() == [gap_of[tuple(row)] for row in few.triangles.tolist()]
    assert np.array_equal(few.triangles, cycle_consistency(FAMILY, with_wrong_pairs(), thirds=3, seed=1).triangles)
    assert not np.array_equal(few.triangles, cycle_consistency(FAMILY, with_wrong_pairs(), thirds=3).triangles)
    with pytest.raises(qg.ParameterError, match="thirds must be at least 1, or None for all, got 0"):
        cycle_consistency(FAMILY, TRUE, thirds=0)


def test_pairs_without_a_triangle_are_not_judged():
    maps = {pair: TRUE[pair] for pair in (("a", "b"), ("b", "a"))}
    found = cycle_consistency({name: FAMILY[name] for name in "ab"}, maps)
    assert np.isnan(found.inconsistency).all()
    assert found.ranked() == []
    with pytest.raises(qg.ParameterError, match="no shape called 'z'"):
        found.of("a", "z")


def test_composition_keeps_places_within_triangles():
    x, y, z = (FAMILY[name] for name in "abc")
    rng = np.random.default_rng(0)
    coordinates = rng.dirichlet([1, 1, 1], x.n_vertices)
    faces = rng.integers(0, y.n_faces, x.n_vertices)
    first = BarycentricMap(faces, y.faces[faces].astype(np.int64), coordinates)
    then = BarycentricMap.at_vertices(np.arange(y.n_vertices), z.faces, z.n_vertices)
    there = composed(first, then, z)
    assert points_of(there, z) == pytest.approx(points_of(first, z), abs=1e-9)
    path = along(
        "abca", FAMILY, {pair: BarycentricMap.at_vertices(m, FAMILY[pair[1]].faces, len(m)) for pair, m in TRUE.items()}
    )
    assert np.array_equal(path.nearest_corner, np.arange(x.n_vertices))


def test_the_tree_goes_around_wrong_pairs():
    found = cycle_consistency(FAMILY, with_wrong_pairs())
    tree = spanning_tree(NAMES, dict(found.ranked()))
    assert len(tree) == len(NAMES) - 1
    assert not set(tree) & set(WRONG)
    maps = tree_maps(FAMILY, with_wrong_pairs(), tree)
    assert set(maps) == set(TRUE)
    assert all(np.array_equal(place.nearest_corner, TRUE[pair]) for pair, place in maps.items())


def test_the_tree_is_the_cheapest_of_all():
    costs = {("a", "b"): 3.0, ("b", "c"): 0.0, ("a", "c"): 2.0, ("c", "d"): 5.0, ("d", "c"): 1.0, ("a", "d"): 4.0}
    assert spanning_tree("abcd", costs) == [("a", "c"), ("b", "c"), ("c", "d")]


def test_maps_through_a_template_close_every_circle():
    maps = template_maps(FAMILY, noisy(0.02), "c")
    assert set(maps) == set(TRUE)
    direct = noisy(0.02)
    assert np.array_equal(maps["a", "c"].faces, direct["a", "c"].faces)


def test_the_middle_of_all_ways_is_nearer_to_the_truth_than_each_map():
    maps = noisy(0.03)
    maps["a", "d"] = BarycentricMap.at_vertices(mirrored(FAMILY["a"]), FAMILY["d"].faces, FAMILY["d"].n_vertices)
    better = synchronised_maps(FAMILY, maps, cycle_consistency(FAMILY, maps))
    before, after = (
        {p: np.linalg.norm(points_of(m[p], FAMILY[p[1]]) - FAMILY[p[1]].vertices, axis=1).mean() for p in TRUE}
        for m in (maps, better)
    )
    assert all(after[pair] < before[pair] for pair in TRUE)
    assert np.mean(list(after.values())) < 0.8 * np.mean([before[p] for p in TRUE if p != ("a", "d")])
    assert after["a", "d"] < 0.2 * before["a", "d"]


def test_pairs_without_a_map_get_one():
    maps = {pair: images for pair, images in TRUE.items() if pair != ("a", "f")}
    better = synchronised_maps(FAMILY, maps, cycle_consistency(FAMILY, maps))
    assert np.array_equal(better["a", "f"].nearest_corner, TRUE["a", "f"])


def test_what_has_no_partner_keeps_none():
    lost = np.arange(10)
    maps = {pair: np.where(np.isin(images, lost), -1, images) for pair, images in TRUE.items()}
    consistency = cycle_consistency(FAMILY, maps)
    assert consistency.wrong() == []
    for found in (template_maps(FAMILY, maps, "a"), synchronised_maps(FAMILY, maps, consistency)):
        assert (found["b", "c"].faces[lost] == -1).all()
        assert (found["b", "c"].faces[10:] >= 0).all()


def test_what_does_not_fit_is_named():
    n = FAMILY["a"].n_vertices
    with pytest.raises(qg.ParameterError, match="no shape called 'q'"):
        checked_maps(FAMILY, {("a", "q"): np.arange(n)})
    with pytest.raises(qg.ParameterError, match="map a - b has 3 entries"):
        checked_maps(FAMILY, {("a", "b"): np.arange(3)})
    with pytest.raises(qg.MeshError, match=r"the map a - b\[2\] is vertex"):
        checked_maps(FAMILY, {("a", "b"): np.where(np.arange(n) == 2, n, 0)})
    with pytest.raises(qg.ParameterError, match=r"joins d to the rest \(1 such"):
        spanning_tree("abcd", {("a", "b"): 1.0, ("b", "c"): 1.0})
    with pytest.raises(qg.ParameterError, match="cost of a - b must be a number"):
        spanning_tree("ab", {("a", "b"): np.nan})
    with pytest.raises(qg.ParameterError, match="no tree of the 6 shapes"):
        tree_maps(FAMILY, TRUE, [("a", "b")])
    with pytest.raises(qg.ParameterError, match="1 maps of the tree are missing: b - a"):
        tree_maps({n: FAMILY[n] for n in "ab"}, {("a", "b"): TRUE["a", "b"]}, [("a", "b")])
    with pytest.raises(qg.ParameterError, match="no shape called 'z'"):
        template_maps(FAMILY, TRUE, "z")


def test_inputs_are_not_changed():
    maps = {pair: images.copy() for pair, images in with_wrong_pairs().items()}
    found = cycle_consistency(FAMILY, maps)
    synchronised_maps(FAMILY, maps, found)
    assert isinstance(found, CycleConsistency)
    assert all(np.array_equal(maps[pair], images) for pair, images in with_wrong_pairs().items())


def test_gaps_are_measured_on_what_was_matched():
    """Of meshes that no repair mends on their wraps: zero for equal maps, distances there for one that is another."""
    mesh = Surface(*in_pieces(creature(level=2)))
    wrap = qg.wrap_surface(mesh)
    shapes, number = dict.fromkeys("abc", mesh), np.arange(mesh.n_vertices)
    maps = {(x, y): number for x in "abc" for y in "abc" if x != y}
    wraps = dict.fromkeys("abc", wrap)
    np.testing.assert_array_equal(cycle_consistency(shapes, maps, repairs=wraps).gaps, 0)
    stands = wrap.vertex_of_original
    known = np.flatnonzero(stands >= 0)
    maps["a", "b"] = np.full(mesh.n_vertices, known[0])
    wrong = cycle_consistency(shapes, maps, points=mesh.n_vertices, repairs=wraps)
    way = qg.distances(wrap.surface, int(stands[known[0]]), "cartesian")[0] / np.sqrt(wrap.surface.area)
    row = (wrong.triangles == [0, 1, 2]).all(axis=1)
    np.testing.assert_allclose(wrong.gaps[row], way[stands[known]].mean(), rtol=1e-3)
