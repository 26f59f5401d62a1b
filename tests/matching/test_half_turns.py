"""Places of a shape the other way up on one that has grown together."""

from __future__ import annotations

import numpy as np
import pytest
from grown_body import body, grown
from scipy.spatial.transform import Rotation
from shapes import icosphere

from qgeo_filters.evaluation import geodesic_error
from qgeo_filters.matching.partial.half_turns import half_turns, turned_places
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.matching.placement import Placement
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.surface import Surface


def test_an_ellipsoid_is_turned_into_itself_about_its_axes() -> None:
    vertices, faces = icosphere(3)
    surface = Surface(vertices * [1.0, 0.7, 0.5], faces)
    turned = half_turns(surface.vertices, surface.vertex_areas)
    signs = [(-1, -1, 1), (-1, 1, -1), (1, -1, -1)]  # the shortest axis first
    for images, sign in zip(turned, signs, strict=True):
        gaps = np.linalg.norm(surface.vertices[images] - surface.vertices * sign, axis=1)
        assert gaps.max() < surface.edge_lengths.max()


def test_motion_and_scale_change_nothing() -> None:
    surface = body()
    moved = 3 * Rotation.from_rotvec([0.3, -1.0, 0.4]).apply(surface.vertices.copy()) + [5, -2, 1]
    for one, other in zip(
        half_turns(surface.vertices, surface.vertex_areas), half_turns(moved, 9 * surface.vertex_areas), strict=True
    ):
        assert (one == other).mean() > 0.99  # ties may fall either way


@pytest.mark.slow
@pytest.mark.parametrize("turn", [0, 1, 2])
def test_a_place_that_is_turned_round_is_turned_back(turn: int) -> None:
    placement = Placement(MatchProblem.of(body(), grown()), PartialParameters.of_grown_surfaces())
    choice = placement.compared
    points = choice.x.fps[: choice.mapper.count]
    images = half_turns(choice.x.vertices, choice.x.areas)[turn][points]
    (wrong,) = choice.placed([(choice.proposed(images, "a test"), images)])
    places = turned_places(choice, [wrong])
    best = min(places, key=lambda p: p.cost)
    assert len(places) == 3
    assert best is places[turn]
    assert best.cost < wrong.cost / 2
    assert choice.log.maps[best.number].proposed_by == "turned by half a turn"
    assert geodesic_error(best.map.p2p, np.arange(choice.x.n_vertices), choice.y.surface).mean() < 0.03


@pytest.mark.slow
def test_different_places_are_kept_the_cheapest_of_each_kind() -> None:
    choice = Placement(MatchProblem.of(body(), grown()), PartialParameters.of_grown_surfaces()).compared
    points = choice.x.fps[: choice.mapper.count]
    turned = half_turns(choice.x.vertices, choice.x.areas)[0][points]
    right, again, wrong = choice.placed([(choice.proposed(p, "a test"), p) for p in (points, points, turned)])
    kept = choice.different([wrong, again, right], 2)
    assert kept[0] in (right, again)
    assert kept[1] is wrong
    assert choice.different([wrong, right], 1) == [right]
    assert choice.different([], 2) == []
