"""Closed surfaces around meshes that no repair can mend."""

from __future__ import annotations

import functools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from in_pieces import in_pieces
from shapes import Mesh, bent, creature, icosphere, moebius

import qgeo_filters as qg
from qgeo_filters.animation import places
from qgeo_filters.animation.places import places_on
from qgeo_filters.evaluation import VtsDataset
from qgeo_filters.hosts import dispatch
from qgeo_filters.hosts.dispatch import surface_and_repair
from qgeo_filters.hosts.given_images import images_on_given
from qgeo_filters.matching import match_result
from qgeo_filters.matching.given_vertices import match_on_given
from qgeo_filters.matching.shape_arrays import arrays_of_shape, shape_of_arrays
from qgeo_filters.matching.symmetry import self_symmetry


@functools.cache
def pair(level: int = 4, bend: float = 0.2) -> tuple[Mesh, Mesh, np.ndarray]:
    """A creature and its bent copy in pieces of their own, and the place of each vertex of X on the copy."""
    flat = creature(level=level)
    x = in_pieces(flat)
    y = in_pieces((bent(flat[0], bend), flat[1]), seed=1)
    nearest = np.linalg.norm(x[0][:, None] - flat[0][None], axis=2).argmin(axis=1)
    return x, y, bent(flat[0], bend)[nearest]


def test_what_is_refused_is_matched_as_a_wrap() -> None:
    """Bent so far that the quick search is in doubt."""
    x, y, places = pair(bend=0.4)
    with pytest.raises(qg.MeshError, match="repair='wrap' for a closed surface around all of it"):
        qg.match(x, y)
    found = qg.match(x, y, repair="wrap")
    assert found.confident, found.explanation
    assert found.x.n_vertices == len(x[0]) == len(found.p2p)
    assert len(found.inverse) == len(y[0])
    # The corners of the sheet inside have no place on the wrap.
    np.testing.assert_array_equal(np.flatnonzero(found.p2p < 0), np.arange(len(x[0]) - 4, len(x[0])))
    known = found.p2p >= 0
    unit = np.sqrt(qg.Surface(*creature(level=4)).area)
    off = np.linalg.norm(y[0][found.p2p[known]] - places[known], axis=1) / unit
    assert off.mean() < 0.02
    finer = np.linalg.norm(found.barycentric.pulled_back(y[0])[known] - places[known], axis=1) / unit
    assert finer.mean() < 0.02
    assert np.isnan(found.distortion[~known]).all()
    assert np.isnan(found.positions[~known]).all()
    assert "wrapped in a closed surface" in found.repairs[0]
    errors = found.error(found.p2p)
    assert np.nanmax(errors) == 0  # on the wrap: between pieces of the soup there is no way
    assert np.isfinite(errors[known]).all()


@pytest.mark.slow
def test_what_has_no_partner_on_the_wraps_has_none() -> None:
    x, y, _ = pair()
    shapes = [qg.PreparedShape(mesh, repair="wrap") for mesh in (x, y)]
    found = qg.match(shapes[0].full, shapes[1].full)
    some = np.arange(found.x.n_vertices) % 3 == 0
    part = match_on_given(replace(found, p2p=np.where(some, -1, found.p2p)), *shapes)
    assert shapes[0].repair is not None
    np.testing.assert_array_equal(part.p2p < 0, shapes[0].repair.map_back(np.where(some, -1, 0)) < 0)


@pytest.mark.slow
def test_the_other_shape_may_be_inside_out() -> None:
    x, _, _ = pair()
    vertices, faces = creature(level=3)
    wrap = qg.PreparedShape(qg.wrap_surface(x))
    one, other = (qg.match(wrap, (vertices, f)) for f in (faces, faces[:, ::-1]))
    np.testing.assert_array_equal(one.p2p, other.p2p)


@pytest.mark.slow
def test_errors_are_measured_on_the_wrap_that_was_matched(tmp_path: Path) -> None:
    x, y, places = pair(3)
    wraps = qg.wrap_surface(x), qg.wrap_surface(y, alpha=0.05)
    found = qg.match(*wraps, mirror="no")
    assert (found.wrap_x, found.wrap_y) == (0.03, 0.05)
    found.to_npz(tmp_path / "found.npz")
    again = qg.MatchResult.from_npz(tmp_path / "found.npz")
    assert again.wrap_y == 0.05
    truth = np.linalg.norm(y[0][None] - places[:, None], axis=2).argmin(axis=1)
    truth[found.p2p < 0] = -1
    some = np.flatnonzero(truth >= 0)[::150]
    surface, stands = wraps[1].surface, wraps[1].vertex_of_original
    # None of these changes what was matched: not the sentences of the report.
    for result in (again, replace(found, repairs=tuple(line.replace("wrapped", "...") for line in found.repairs))):
        errors = result.error(truth)
        for v in some:
            way = qg.distances(surface, int(stands[truth[v]]), "cartesian")[0, stands[found.p2p[v]]]
            assert errors[v] * np.sqrt(surface.area) == pytest.approx(way, rel=1e-3, abs=1e-6)
    closed = qg.testing.sample_surface()
    assert qg.match(closed, closed).wrap_y == 0


@pytest.mark.slow
def test_what_was_matched_is_not_wrapped_once_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its area and distances are known; of a result from a file they are found anew, the same bit for bit."""
    x, y = (qg.Surface(*mesh) for mesh in pair(3)[:2])
    at = int(np.linalg.norm(y.vertices - pair(3)[2][0], axis=1).argmin())
    found = qg.match(x, y, repair="wrap", landmarks=[(0, at)], mirror="no")
    found.to_npz(tmp_path / "found.npz")
    again = qg.MatchResult.from_npz(tmp_path / "found.npz")
    larger = y.with_vertices(3 * y.vertices + 1)

    def made(of: qg.MatchResult) -> list[np.ndarray]:
        posed = qg.transfer_pose(y, x, of, accept_unsure=True).vertices
        back = places_on(x, y, of, accept_unsure=True)
        return [of.error(np.roll(found.p2p, 7)), of.transfer(x.vertices), posed, np.array(back.size)]

    anew, scaled = made(again), places_on(x, larger, again, accept_unsure=True).size
    assert scaled == pytest.approx(3 * anew[-1], rel=0.01)
    assert places_on(x, larger, found, accept_unsure=True).size == scaled
    for module in (dispatch, match_result, places):
        monkeypatch.setattr(module, "wrap_surface", lambda *_, **__: pytest.fail("wrapped once more"))
    for kept, new in zip(made(found), anew, strict=True):
        np.testing.assert_array_equal(kept, new)
    closed = qg.testing.sample_surface()
    assert qg.match(closed, closed).around_x is None


@pytest.mark.slow
def test_a_wrap_of_another_size_stands_for_its_mesh() -> None:
    x, y, places = pair()
    coarser = qg.wrap_surface(x, alpha=0.04), qg.wrap_surface(y, alpha=0.04)
    assert qg.as_surface(coarser[0]) is coarser[0].surface
    found = qg.match(*coarser, landmarks=[(0, int(np.linalg.norm(y[0] - places[0], axis=1).argmin()))])
    assert found.confident, found.explanation
    assert found.x.n_vertices == len(x[0])
    assert "openings up to 4 % of the diagonal" in found.repairs[0]
    known = found.p2p >= 0
    off = np.linalg.norm(y[0][found.p2p[known]] - places[known], axis=1)
    assert off.mean() < 0.02 * np.sqrt(qg.Surface(*creature(level=4)).area)


@pytest.mark.slow
def test_the_mirror_image_of_each_piece_is_found() -> None:
    x = in_pieces(creature(level=4))
    found = self_symmetry(x, repair="wrap")
    assert found.found, found.reason
    known = found.nearest >= 0
    assert known.sum() == len(x[0]) - 4
    mirrored = x[0] * [-1, 1, 1]
    off = np.linalg.norm(x[0][found.nearest[known]] - mirrored[known], axis=1)
    assert off.mean() < 0.04
    assert np.linalg.norm(found.barycentric.pulled_back(x[0])[known] - mirrored[known], axis=1).mean() < 0.03


def test_a_sphere_of_loose_triangles() -> None:
    vertices, faces = icosphere(4)
    soup = (
        vertices[faces].reshape(-1, 3),
        np.random.default_rng(0).permutation(np.arange(3 * len(faces)).reshape(-1, 3)),
    )
    for scale in (1e-6, 1.0, 1e6):
        wrap = qg.wrap_surface((scale * soup[0] + 7 * scale, soup[1]))
        radius = np.linalg.norm(wrap.surface.vertices / scale - 7, axis=1)
        assert np.abs(radius - 1).max() < 0.02
        assert wrap.surface.genus == 0
        assert wrap.surface.winding == "outward"
        # What belongs to a vertex of the wrap comes back to the vertices near it.
        there = wrap.map_back(wrap.surface.vertices) / scale - 7
        assert np.abs(there - soup[0]).max() < 0.02
        assert np.linalg.norm(wrap.given.vertices[wrap.origin] - wrap.surface.vertices, axis=1).max() < 0.1 * scale
        np.testing.assert_allclose(wrap.areas_on_given(wrap.surface.vertex_areas).sum(), wrap.surface.area)


def test_the_input_stays_as_it_is_and_attributes_come_along() -> None:
    vertices, faces = in_pieces(creature(level=3))
    vertices.flags.writeable = faces.flags.writeable = False
    mesh = qg.Surface(vertices, faces, {"height": vertices[:, 2].copy()})
    wrap = qg.wrap_surface(mesh)
    assert wrap.given is mesh
    np.testing.assert_array_equal(wrap.surface.attributes["height"], vertices[wrap.origin, 2])
    again = qg.wrap_surface(mesh)
    np.testing.assert_array_equal(again.surface.vertices, wrap.surface.vertices)


@pytest.mark.slow
def test_openings_are_closed_up_to_the_size_that_is_asked_for() -> None:
    vertices, faces = icosphere(4)
    open_at_top = faces[vertices[faces].mean(axis=1)[:, 2] < 0.99]  # .14 of the radius
    assert qg.wrap_surface((vertices, open_at_top), alpha=0.2).surface.genus == 0
    with pytest.raises(qg.MeshError, match="open sheet"):
        qg.wrap_surface((vertices, open_at_top), alpha=0.02)


def test_values_of_all_kinds_come_back() -> None:
    wrap = qg.wrap_surface(in_pieces(creature(level=3)))
    number = np.arange(wrap.surface.n_vertices)
    inside = wrap.vertex_of_original < 0
    assert inside.sum() == 4
    for kind, missing in ((np.int32, -1), (np.uint16, -1), (bool, False)):
        back = wrap.map_back(number.astype(kind))
        np.testing.assert_array_equal(back[~inside], number.astype(kind)[wrap.vertex_of_original[~inside]])
        assert (back[inside] == missing).all()
    assert np.isnan(wrap.map_back(number.astype(np.float32))[inside]).all()
    with pytest.raises(qg.MeshError, match="do not fit"):
        wrap.map_back(number[:-1])


def test_what_has_no_inside_is_refused() -> None:
    with pytest.raises(
        qg.MeshError, match="open sheet, or open wider than 3 % of the diagonal: a wrap would go inside"
    ):
        qg.wrap_surface(moebius())
    with pytest.raises(qg.MeshError, match="open sheet"):
        qg.match(moebius(), moebius(), repair="wrap")


def test_bodies_apart_from_each_other_are_refused() -> None:
    vertices, faces = icosphere(3)
    two = np.concatenate([vertices, vertices + 5]), np.concatenate([faces, faces + len(vertices)])
    with pytest.raises(qg.DisconnectedError, match="falls into bodies that are more than 3 % of the diagonal apart"):
        qg.wrap_surface(two)


@pytest.mark.parametrize("alpha", [0, -1, 0.9, np.nan, "small", None])
def test_sizes_that_are_none(alpha: object) -> None:
    with pytest.raises(qg.ParameterError, match="alpha must be a fraction of the diagonal"):
        qg.wrap_surface(icosphere(2), alpha=alpha)  # type: ignore[arg-type]


def test_faces_and_vertices_that_are_none_are_left_out() -> None:
    vertices, faces = icosphere(3)
    bad = np.concatenate([vertices, [[np.nan] * 3, [50.0, 0, 0]]]), np.concatenate([faces, [[0, 1, 642], [0, 0, 5]]])
    wrap = qg.wrap_surface(bad)
    assert wrap.surface.genus == 0
    assert np.abs(np.linalg.norm(wrap.surface.vertices, axis=1) - 1).max() < 0.03
    np.testing.assert_array_equal(wrap.vertex_of_original[642:], [-1, -1])
    assert len(wrap.given.vertices) == 644


@pytest.mark.slow
def test_a_prepared_wrap_is_stored_and_restored() -> None:
    x, y, _ = pair(3)
    shape = qg.PreparedShape(x, repair="wrap").prepare()
    arrays, values = arrays_of_shape(shape)
    again = shape_of_arrays(shape.given, arrays, values, shape.parameters)
    other = qg.PreparedShape(y, repair="wrap")
    np.testing.assert_array_equal(qg.match(again, other).p2p, qg.match(shape, other).p2p)


def test_spectra_and_filters_take_it() -> None:
    x = in_pieces(creature(level=3))
    whole = qg.laplacian_spectrum(creature(level=3), k=6)
    found = qg.laplacian_spectrum(x, k=6, repair="wrap")
    assert found.eigenfunctions.shape == (len(x[0]), 6)
    np.testing.assert_allclose(found.eigenvalues[1:], whole.eigenvalues[1:], rtol=0.25)
    there = qg.QuasiGeodesicDistances(sources=0)(qg.Surface(*x), repair="wrap").attributes["qgeo_distance"]
    assert there.shape == (len(x[0]),)
    _, wrap = surface_and_repair(x, "wrap")
    assert wrap is not None
    whole_way = qg.distances(qg.Surface(*creature(level=3)), 0).max()
    assert 0.7 * whole_way < np.nanmax(there) < 1.4 * whole_way


def test_vertices_as_values_are_given_ones_and_not_of_the_resolution_of_the_wrap() -> None:
    """A known map of the wrap: its mirror image in space."""
    x = in_pieces(creature(level=4))
    wrap = qg.wrap_surface(x, alpha=0.06)
    at = wrap.surface.vertices
    images = np.linalg.norm(at[:, None] * [-1, 1, 1] - at[None], axis=2).argmin(axis=1)
    back = images_on_given(images, wrap, wrap, wrap.surface)
    there = wrap.vertex_of_original >= 0
    np.testing.assert_array_equal(back >= 0, there)
    off = np.linalg.norm(x[0][back[there]] - x[0][there] * [-1, 1, 1], axis=1)
    by_index = wrap.origin[images[wrap.vertex_of_original[there]]]
    coarse = np.linalg.norm(x[0][by_index] - x[0][there] * [-1, 1, 1], axis=1)
    assert off.mean() < 0.6 * coarse.mean()
    assert off.mean() < 0.3 * wrap.surface.edge_lengths.mean()
    nothing = images_on_given(np.arange(len(at)), wrap, wrap, wrap.surface)
    np.testing.assert_array_equal(nothing[there], np.flatnonzero(there))
    some = np.where(np.arange(len(at)) % 3 == 0, -1, images)
    np.testing.assert_array_equal(
        images_on_given(some, wrap, wrap, wrap.surface) < 0, wrap.map_back(np.where(some < 0, -1, 0)) < 0
    )


def test_a_map_that_is_torn_leads_to_one_of_its_sides() -> None:
    vertices, faces = icosphere(3)
    wrap = qg.wrap_surface((vertices, faces), alpha=0.1)
    at = wrap.surface.vertices
    nearest = np.linalg.norm(at[:, None] * np.where(at[:, [2]] > 0, 1, -1)[:, None] - at[None], axis=2).argmin(axis=1)
    back = images_on_given(nearest, wrap, wrap, wrap.surface)
    # Above the equator itself, below it the point opposite: nothing comes to lie between the two.
    goal = np.where(vertices[:, [2]] > 0, vertices, -vertices)
    gaps = np.minimum(np.linalg.norm(vertices[back] - goal, axis=1), np.linalg.norm(vertices[back] + goal, axis=1))
    assert gaps.max() < 3 * wrap.surface.edge_lengths.max()
    assert gaps.mean() < 0.5 * wrap.surface.edge_lengths.mean()


@pytest.mark.slow
def test_a_symmetry_as_an_attribute_is_on_given_vertices() -> None:
    x = in_pieces(creature(level=4))
    found = qg.SelfSymmetry()(qg.Surface(*x), repair="wrap").attributes["qgeo_symmetry"]
    known = found >= 0
    assert (~known).sum() == 4
    assert np.linalg.norm(x[0][found[known]] - x[0][known] * [-1, 1, 1], axis=1).mean() < 0.05


@pytest.mark.slow
def test_maps_of_compatible_poses_are_between_given_vertices() -> None:
    x, y, places = pair()
    found = qg.compatibility([x, y], k=6, repair="wrap")
    known = found.maps[1] >= 0
    assert known.sum() == len(x[0]) - 4
    np.testing.assert_array_equal(found.maps[0][known], np.flatnonzero(known))
    off = np.linalg.norm(y[0][found.maps[1][known]] - places[known], axis=1)
    assert off.mean() < 0.03 * np.sqrt(qg.Surface(*creature(level=4)).area)


def test_piece_by_piece_is_something_else() -> None:
    with pytest.raises(qg.ParameterError, match="a wrap is one piece"):
        qg.match_pieces(icosphere(3), icosphere(3), repair="wrap")


@pytest.mark.slow
def test_raw_skulls_from_ct(data_dir: Path) -> None:
    """Of genus 250 and more, one-sided: refused as they are; by 51 landmarks that were set by hand."""
    folder = data_dir / "harder" / "mouse_skulls_raw"
    if not folder.is_dir():
        pytest.skip("no skulls in the data")
    data = VtsDataset(folder)
    x, y, truth = data.read("CBA_J"), data.read("WSB"), data.truth("CBA_J", "WSB")
    found = qg.match(x, y, repair="wrap")
    assert found.confident, found.explanation
    target = np.full(found.x.n_vertices, -1)
    target[truth.points] = truth.images
    assert np.nanmean(found.error(target)[truth.points]) < 0.03
