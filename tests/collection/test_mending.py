"""A wrong map of a collection is matched again from the composed one, by the package's own registration."""

from __future__ import annotations

import numpy as np
import pytest
from collection_family import family, mirrored, points_of, true_maps
from shapes import blob

import qgeo_filters as qg
from qgeo_filters.collection.cycles import cycle_consistency
from qgeo_filters.collection.mending import mended_maps
from qgeo_filters.matching.restart import match_from

FAMILY = {name: shape for name, shape in family().items() if name in "abcd"}
TRUE = true_maps(FAMILY)
WRONG = mirrored(FAMILY["a"])


def error(place, name: str) -> float:
    surface = FAMILY[name]
    return float(np.linalg.norm(points_of(place, surface) - surface.vertices, axis=1).mean() / np.sqrt(surface.area))


def test_the_wrong_pair_is_mended_and_the_others_are_left():
    maps = {**TRUE, ("a", "c"): WRONG, ("c", "a"): WRONG}
    found, report = mended_maps(FAMILY, maps, cycle_consistency(FAMILY, maps))
    assert [(pair.x, pair.y, pair.mended) for pair in report] == [("a", "c", True)]
    assert report[0].apart < 0.02
    assert error(found["a", "c"], "c") < 0.02
    assert error(found["c", "a"], "a") < 0.02
    others = [pair for pair in TRUE if set(pair) != {"a", "c"}]
    assert all(np.array_equal(found[pair].nearest_corner, TRUE[pair]) for pair in others)


def test_what_cannot_be_mended_is_named():
    """The shape called c is another one: nothing registers from where its maps say, or not at a like cost."""
    shapes = {**FAMILY, "c": qg.Surface(*blob(1))}
    rng = np.random.default_rng(0)
    n, m = FAMILY["a"].n_vertices, shapes["c"].n_vertices
    maps = {pair: images for pair, images in TRUE.items() if "c" not in pair}
    for name in "abd":
        maps[name, "c"], maps["c", name] = rng.integers(0, m, n), rng.integers(0, n, m)
    found, report = mended_maps(shapes, maps, cycle_consistency(shapes, maps))
    assert {frozenset((pair.x, pair.y)) for pair in report} == {frozenset(("c", name)) for name in "abd"}
    for pair in report:
        assert not pair.mended
        assert pair.explanation
        assert np.array_equal(found[pair.x, pair.y].nearest_corner, maps[pair.x, pair.y])


def test_a_match_from_a_map_keeps_to_it_and_knows_its_rival():
    x, y = (qg.PreparedShape(FAMILY[name]) for name in "ac")
    truth = np.arange(FAMILY["a"].n_vertices)
    rng = np.random.default_rng(0)
    rough = np.where(rng.uniform(size=len(truth)) < 0.2, -1, truth)
    found = match_from(x, y, rough, rival=WRONG)
    assert error(found.barycentric, "c") < 0.02
    assert found.margin > 1
    other = match_from(x, y, WRONG, rival=rough)  # one that reverses the orientation, in its own hand
    assert other.orientation < 0 < found.orientation
    assert other.margin == pytest.approx(1 / found.margin)
    assert [entry.proposed_by for entry in found.log] == ["the given map", "the rival"]


def test_a_map_that_is_none_is_refused():
    n = FAMILY["a"].n_vertices
    with pytest.raises(qg.ParameterError, match=f"p2p must hold a vertex for each of the {n} of X, got 3"):
        match_from(FAMILY["a"], FAMILY["c"], [0, 1, 2])
    with pytest.raises(qg.ParameterError, match="too few to start from"):
        match_from(FAMILY["a"], FAMILY["c"], np.full(n, -1))
    with pytest.raises(qg.ParameterError, match="rival must hold"):
        match_from(FAMILY["a"], FAMILY["c"], np.arange(n), rival=[1])
