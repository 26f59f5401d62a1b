"""What a user knows says where a part lies that fits in two places, and is contradicted in words where it is wrong."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from shapes import bent, limbed

import qgeo_filters as qg
from qgeo_filters.matching.hints import Hints
from qgeo_filters.matching.partial.part_hints import hint_costs, known_of_part, resized
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.surface import Surface

# A body that is itself after half a turn about z: its front fits its front and its back equally well.
LIMBS = ((0.6, 0.7, -0.5), (-0.6, 0.7, -0.5), (0.6, -0.7, -0.5), (-0.6, -0.7, -0.5), (0.0, 1.0, 0.4), (0.0, -1.0, 0.4))
LENGTHS = (1.0, 1.0, 1.0, 1.0, 0.8, 0.8)
PLACES = {"same": (1, 1), "half turn": (-1, -1)}


@functools.cache
def whole() -> Surface:
    return Surface(*limbed(LIMBS, LENGTHS))


@functools.cache
def front() -> tuple[Surface, np.ndarray]:
    """The front of the body in another pose, in another order, and the vertex of the body for each of its own."""
    body = whole()
    part, numbers = body.submesh(body.vertices[:, 1] > -0.2)
    order = np.random.default_rng(3).permutation(part.n_vertices)
    posed = bent(part.vertices, 0.15)[order]
    return Surface(posed, np.argsort(order)[part.faces]), numbers[order]


def images(place: str) -> np.ndarray:
    """True vertex of the body for each of the part, in one of the places."""
    vertices = whole().vertices
    moved = vertices[front()[1]] * [*PLACES[place], 1]
    return np.linalg.norm(vertices[None] - moved[:, None], axis=2).argmin(axis=1)


def tip(limb: int) -> int:
    """Vertex of the part at the end of a limb."""
    direction = np.array(LIMBS[limb]) / np.linalg.norm(LIMBS[limb])
    return int((whole().vertices[front()[1]] @ direction).argmax())


def off(p2p: np.ndarray, place: str) -> float:
    """Mean distance between images and those of a place, in sqrt(area), of what has a partner."""
    known = p2p >= 0
    gaps = np.linalg.norm(whole().vertices[p2p[known]] - whole().vertices[images(place)[known]], axis=1)
    return float(gaps.mean() / np.sqrt(whole().area))


def test_without_hints_both_places_are_as_good() -> None:
    found = qg.match(front()[0], whole(), partial=True, normalize=False)
    assert not found.confident
    assert min(off(found.p2p, place) for place in PLACES) < 0.03


@pytest.mark.parametrize("place", PLACES)
def test_one_landmark_says_which_place(place: str) -> None:
    pair = (tip(0), int(images(place)[tip(0)]))
    found = qg.match(front()[0], whole(), partial=True, normalize=False, landmarks=[pair])
    assert off(found.p2p, place) < 0.03
    assert found.confident, found.explanation
    assert "agrees with the hints" in found.explanation
    assert found.landmark_errors.shape == (1,)
    assert found.landmark_errors[0] < 0.05


@pytest.mark.slow
def test_labels_say_it_too_and_sizes_need_not_count() -> None:
    part, body = front()[0], whole()
    truth = images("half turn")
    labels = np.where(body.vertices[:, 1] < -0.6, 7, -1)
    found = qg.match(part, body, partial=True, labels=(labels[truth], labels))
    assert off(found.p2p, "half turn") < 0.03
    assert found.confident, found.explanation


def test_the_part_may_be_y() -> None:
    part, body = front()[0], whole()
    pair = (int(images("half turn")[tip(0)]), tip(0))
    found = qg.match(body, part, partial=True, normalize=False, landmarks=[pair])
    assert off(found.inverse, "half turn") < 0.03
    assert found.landmark_errors[0] < 0.05


def test_a_landmark_that_fits_nowhere_is_contradicted() -> None:
    """The end of a limb goes to no end of a limb that is far from where its neighbours, known too, go."""
    truth = images("same")
    right = [(tip(limb), int(truth[tip(limb)])) for limb in (0, 1)]
    wrong = (tip(4), int(images("half turn")[tip(4)]))
    found = qg.match(front()[0], whole(), partial=True, normalize=False, landmarks=[*right, wrong])
    assert not found.confident
    assert "landmark 2" in found.explanation
    assert "contradicts the rest" in found.explanation
    assert found.landmark_errors[2] > 0.5


@pytest.mark.slow
def test_hints_on_a_part_that_is_only_found_by_auto() -> None:
    pair = (tip(0), int(images("half turn")[tip(0)]))
    found = qg.match(front()[0], whole(), landmarks=[pair])
    assert found.overlap_y < 0.8
    assert off(found.p2p, "half turn") < 0.03


def test_the_truth_costs_nothing_whatever_the_size() -> None:
    """Distances from known parts lie within the bounds at the truth, of a part as it was cut, at any size."""
    body = whole()
    part, numbers = body.submesh(body.vertices[:, 1] > -0.2)
    prepared = tuple(qg.PreparedShape(surface) for surface in (part, body))
    given, unit = PartialParameters(), float(np.sqrt(body.area))
    shapes = PartShape(part, unit, part.n_vertices, 50, given), PartShape(body, unit, body.n_vertices, 300, given)
    labels = np.where(body.vertices[:, 2] < -0.5, 1, -1)
    ends = [int((part.vertices @ np.array(LIMBS[limb])).argmax()) for limb in (0, 4)]
    hints = Hints.of(part, body, [(end, int(numbers[end])) for end in ends], (labels[numbers], labels))
    known = known_of_part(hints, prepared, shapes, 0)
    assert known is not None
    costs = hint_costs(known, *shapes)
    place = shapes[1].rows[:, numbers[shapes[0].fps]].argmin(axis=0)
    there = costs[np.arange(50), place]
    assert there.mean() < 0.01
    assert costs.mean() > 10 * there.mean()
    larger = resized(known, 2.0)
    np.testing.assert_allclose(larger.to_x, 2 * known.to_x)
    np.testing.assert_array_equal(larger.to_y, known.to_y)
    assert not hint_costs(None, *shapes).any()
