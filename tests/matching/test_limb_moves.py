"""Limbs moved to what a placed shape leaves uncovered."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import bent, creature

from qgeo_filters.matching.initialization.limb_maps import LimbEnds
from qgeo_filters.matching.partial.limb_moves import uncovered, with_limbs_moved
from qgeo_filters.matching.partial.part_choice import PlacedPart
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.matching.placement import Placement
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.surface import Surface

LIMB = 0


@pytest.fixture(scope="module")
def placement() -> Placement:
    vertices, faces = creature()
    y = Surface(bent(vertices, 0.3), faces)
    return Placement(MatchProblem.of(Surface(vertices, faces), y), PartialParameters.of_grown_surfaces())


@pytest.fixture(scope="module")
def ends(placement: Placement) -> LimbEnds:
    shape = MatchProblem.of(*[Surface(*creature())] * 2).x
    return LimbEnds.of(shape, None, shape.parameters)


@pytest.fixture(scope="module")
def misplaced(placement: Placement, ends: LimbEnds) -> PlacedPart:
    """Each point in its place but for those of a limb, which lie where that begins."""
    choice = placement.compared
    points = choice.x.fps[: choice.mapper.count]
    to_end = ends.distances[LIMB, points]
    others = points[to_end >= 0.4]
    images = points.copy()
    images[to_end < 0.4] = others[to_end[to_end >= 0.4].argmin()]
    (place,) = choice.placed([(choice.log.propose("misplaced", 0.1), images)])
    return place


def test_just_the_limb_is_uncovered(placement: Placement, ends: LimbEnds, misplaced: PlacedPart) -> None:
    parts = uncovered(placement.y, misplaced)
    bare = np.any(parts, axis=0)
    shares = [bare[distance < 0.25].mean() for distance in ends.distances]  # vertices of Y are those of X
    assert shares[LIMB] > 0.5
    assert np.delete(shares, LIMB).max() < 0.1


def test_the_limb_is_moved_there(placement: Placement, ends: LimbEnds, misplaced: PlacedPart) -> None:
    choice = placement.compared
    off = np.linalg.norm(choice.y.vertices[misplaced.map.p2p] - choice.y.vertices, axis=1)
    before = len(choice.log.maps)
    best, tried = with_limbs_moved(choice, ends.distances, misplaced)
    moved = np.linalg.norm(choice.y.vertices[best.map.p2p] - choice.y.vertices, axis=1)
    assert best.cost < misplaced.cost / 2
    assert off[ends.distances[LIMB] < 0.25].mean() > 0.1
    assert moved.max() < 0.1
    assert moved.mean() < 0.02
    assert best in tried
    assert len(choice.log.maps) == before + len(tried)
    assert choice.log.maps[best.number].proposed_by == "a limb moved to what is not covered"


def test_nothing_is_tried_where_all_is_covered(placement: Placement, ends: LimbEnds) -> None:
    choice = placement.compared
    points = choice.x.fps[: choice.mapper.count]
    (place,) = choice.placed([(choice.log.propose("right", 0.0), points)])
    assert uncovered(choice.y, place) == []
    best, tried = with_limbs_moved(choice, ends.distances, place)
    assert best is place
    assert tried == []
