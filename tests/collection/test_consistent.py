"""What a collection says of its maps together: contradictions, consistent maps, one connectivity, landmarks on all."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from small_collection import QUICK, poses

import qgeo_filters as qg
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.collection import mending, tasks
from qgeo_filters.errors import ParameterError

pandas = pytest.importorskip("pandas")

NAMES = ("p0", "p1", "p2", "p3")


@pytest.fixture(scope="module")
def matched(tmp_path_factory: pytest.TempPathFactory) -> qg.Collection:
    """Four poses of one mesh, all pairs matched: vertex i is the same point of all."""
    return qg.Collection(poses(4), tmp_path_factory.mktemp("c") / "s.zarr", parameters=QUICK).match(workers=1)


def errors(maps: dict[tuple[str, str], BarycentricMap]) -> np.ndarray:
    """Mean distance of each map from the truth, over sqrt(area)."""
    shapes = poses(4)
    gaps = []
    for (_, y), place in maps.items():
        there = shapes[y].vertices
        gaps.append(np.linalg.norm(place.pulled_back(there) - there, axis=1).mean() / np.sqrt(shapes[y].area))
    return np.array(gaps)


@pytest.mark.slow
def test_maps_go_both_ways_and_agree(matched: qg.Collection) -> None:
    maps = matched.maps()
    assert set(maps) == {(x, y) for x in NAMES for y in NAMES if x != y}
    np.testing.assert_array_equal(maps["p1", "p0"].faces, matched.map("p0", "p1").inverse_barycentric.faces)
    consistency = matched.consistency()
    assert consistency.names == NAMES
    assert consistency.wrong() == []
    as_matched = errors(maps)
    for how in ("tree", "template", "all ways"):
        found = matched.maps(how)
        assert set(found) == set(maps)
        assert errors(found).mean() < as_matched.mean() + 0.01
    for how in ("matched", "tree", "all ways"):
        every, forth, back = matched.maps(how), matched.maps_from("p2", how), matched.maps_to("p2", how)
        for name in ("p0", "p1", "p3"):
            np.testing.assert_array_equal(forth[name].coordinates, every["p2", name].coordinates)
            np.testing.assert_array_equal(back[name].coordinates, every[name, "p2"].coordinates)
    tree = matched.maps("tree")
    round_trip = tree["p0", "p1"].pulled_back(tree["p1", "p0"].pulled_back(matched.surface("p0").vertices))
    assert np.linalg.norm(round_trip - matched.surface("p0").vertices, axis=1).mean() < 0.1


def test_a_wrong_pair_is_named_and_matched_again(matched: qg.Collection, monkeypatch: pytest.MonkeyPatch) -> None:
    """The map of one pair is replaced by a shuffled one: all others say which it is, and where it should go."""
    y, right, match_of = matched.surface("p1"), matched.maps()["p0", "p1"], matched.map
    shuffled = np.random.default_rng(0).permutation(y.n_vertices)
    forth, back = (BarycentricMap.at_vertices(p, y.faces, y.n_vertices) for p in (shuffled, np.argsort(shuffled)))

    def map_of(one: str, other: str) -> object:
        wrong = SimpleNamespace(barycentric=forth, inverse_barycentric=back)
        return wrong if (one, other) == ("p0", "p1") else match_of(one, other)

    monkeypatch.setattr(matched, "map", map_of)
    assert matched.consistency().wrong() == [("p0", "p1")]
    mended, (pair,) = matched.mended()
    assert (pair.x, pair.y) == ("p0", "p1")
    assert pair.mended, pair.explanation
    assert errors({("p0", "p1"): mended["p0", "p1"]})[0] < 0.05
    assert errors({("p0", "p1"): right})[0] < 0.05
    assert errors({("p0", "p1"): forth})[0] > 0.3
    # Kept in the store: another process asks for nothing anew, unless the maps have changed.
    calls: list[int] = []
    match_from = mending.match_from
    monkeypatch.setattr(mending, "match_from", lambda *args, **kwargs: calls.append(1) or match_from(*args, **kwargs))
    other = qg.Collection.open(matched.store.root)
    monkeypatch.setattr(other, "map", map_of)
    again, (same,) = other.mended()
    assert not calls
    assert same == pair
    for key, place in mended.items():
        for name in ("faces", "corners", "coordinates"):
            np.testing.assert_array_equal(getattr(place, name), getattr(again[key], name))
    assert other.status().matched_again == 1
    forth = BarycentricMap.at_vertices(np.roll(shuffled, 1), y.faces, y.n_vertices)
    other.mended()
    assert len(calls) == 1
    assert other.status().matched_again == 1


def test_few_third_shapes_are_said(matched: qg.Collection) -> None:
    assert matched.consistency().share == 1.0
    few = matched.consistency(thirds=1, seed=3)
    assert few.share == 0.5
    np.testing.assert_array_equal(few.triangles, matched.consistency(thirds=1, seed=3).triangles)


def test_one_connectivity_and_landmarks_on_all(matched: qg.Collection) -> None:
    common = matched.common("p1", how="all ways")
    assert common.names == NAMES
    assert common.positions.shape == (4, matched.surface("p1").n_vertices, 3)
    np.testing.assert_array_equal(common["p1"].vertices, matched.surface("p1").vertices)
    marks = {3: "head", 70: "tail"}
    for how in ("matched", "all ways"):
        table = matched.landmark_table(list(marks), "p2", how=how)
        assert list(table.columns) == ["shape", "landmark", "x", "y", "z"]
        assert len(table) == 4 * 2
        for name in NAMES:
            own = matched.surface(name)
            points = table[table["shape"] == name][["x", "y", "z"]].to_numpy()
            gaps = np.linalg.norm(points - own.vertices[list(marks)], axis=1)
            assert (gaps < (1e-9 if name == "p2" else 0.1 * np.sqrt(own.area))).all()


def test_only_the_maps_that_are_needed_are_sought(monkeypatch: pytest.MonkeyPatch) -> None:
    collection = qg.Collection(poses(3), parameters=QUICK)
    asked: list[int] = []
    match = tasks.match
    monkeypatch.setattr(tasks, "match", lambda *args, **kwargs: asked.append(1) or match(*args, **kwargs))
    first = collection.landmarks([5], "p1")
    assert len(asked) == 2
    again = collection.landmarks([5], "p1")
    assert len(asked) == 2
    np.testing.assert_array_equal(first["p2"].points, again["p2"].points)


def test_what_cannot_be_is_said(matched: qg.Collection) -> None:
    with pytest.raises(ParameterError, match="how must be one of 'matched', "):
        matched.maps("best")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="no shape is called 'p9'"):
        matched.landmarks([0], "p9")
    with pytest.raises(ParameterError, match="no shape is called 'p9'"):
        matched.common("p9", how="all ways")
    with pytest.raises(ParameterError, match="no pair joins"):
        qg.Collection(poses(3), parameters=QUICK).maps("tree")
