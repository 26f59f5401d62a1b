"""A part of a shape matched to the whole, against the truth that the cut leaves."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import bent, creature, crooked, icosphere

from qgeo_filters.errors import ParameterError
from qgeo_filters.evaluation import geodesic_error
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.partial.distance_bounds import added_costs, distance_bounds, profile_costs, violations
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.matching.partial.partial_match import matched_as_part
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.surface import Surface


def whole() -> Surface:
    """A body with limbs, about a unit of length in size."""
    return Surface(*creature())


def cut(surface: Surface, kept: np.ndarray) -> tuple[Surface, np.ndarray]:
    """The largest piece of what is left of a surface, and its vertices' numbers."""
    piece, numbers = surface.submesh(kept)
    label = piece.components[1]
    piece, again = piece.submesh(label == np.bincount(label).argmax())
    return piece, numbers[again]


def as_part(x: Surface, y: Surface) -> MatchResult:
    """One matched as a part of the other, of the size that it has."""
    return match(x, y, partial=True, normalize=False)


def error(found: MatchResult, truth: np.ndarray) -> float:
    """Mean error of what has a partner, in sqrt(area of Y)."""
    known = found.p2p >= 0
    return float(geodesic_error(found.p2p[known], truth[known], found.y).mean())


@pytest.fixture(scope="module")
def front() -> tuple[Surface, np.ndarray]:
    """What of the body lies on one side of a plane, bent and stored in another order, and where it comes from."""
    body = whole()
    part, truth = cut(body, body.vertices[:, 1] > -0.25)
    posed = Surface(bent(part.vertices, 0.2), part.faces)
    order = np.random.default_rng(0).permutation(posed.n_vertices)
    place = np.argsort(order)
    return Surface(posed.vertices[order], place[posed.faces]), truth[order]


@pytest.fixture(scope="module")
def found(front: tuple[Surface, np.ndarray]) -> MatchResult:
    """The front half on the whole."""
    return as_part(front[0], whole())


def test_a_part_goes_where_it_was_cut_from(found: MatchResult, front: tuple[Surface, np.ndarray]) -> None:
    part, truth = front
    assert error(found, truth) < 0.03
    assert (found.p2p >= 0).mean() > 0.99
    assert found.confident, found.explanation
    assert found.overlap_x > 0.99
    assert found.overlap_y == pytest.approx(part.area / whole().area, abs=0.05)


def test_what_was_cut_away_has_no_partner(found: MatchResult, front: tuple[Surface, np.ndarray]) -> None:
    body, (_, truth) = whole(), front
    gone = np.setdiff1d(np.arange(body.n_vertices), truth)
    assert (found.inverse[gone] < 0).mean() > 0.85
    assert (found.inverse[truth] >= 0).mean() > 0.9
    assert (found.regions_y[found.inverse < 0] == -1).all()
    back = found.inverse >= 0
    there = truth[found.inverse[back]]
    assert geodesic_error(there, np.flatnonzero(back), body).mean() < 0.05


def test_the_other_way_round(found: MatchResult, front: tuple[Surface, np.ndarray]) -> None:
    """Y a part of X: the same map, from the other side."""
    other = as_part(whole(), front[0])
    np.testing.assert_array_equal(other.p2p, found.inverse)
    np.testing.assert_array_equal(other.inverse, found.p2p)
    assert other.overlap_x == found.overlap_y
    assert other.confident == found.confident
    known = other.p2p >= 0
    np.testing.assert_array_equal(np.isnan(other.positions).any(axis=1), ~known)
    moved = np.linalg.norm(other.positions - other.y.vertices[other.p2p], axis=1)[known]
    assert moved.max() < 2 * other.y.edge_lengths.max()


@pytest.mark.slow
def test_neither_numbering_nor_place_matters(found: MatchResult, front: tuple[Surface, np.ndarray]) -> None:
    part = front[0]
    random = np.random.default_rng(1)
    order, faces = random.permutation(part.n_vertices), random.permutation(part.n_faces)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    moved = Surface(part.vertices[order] @ turn.T + [3, -40, 8], np.argsort(order)[part.faces[faces]])
    again = as_part(moved, whole())
    # Near ties fall with the last digits.
    assert geodesic_error(again.p2p, found.p2p[order], whole()).mean() < 0.002
    assert again.confident == found.confident
    repeated = as_part(part, whole())
    np.testing.assert_array_equal(repeated.p2p, found.p2p)


@pytest.mark.slow
def test_a_part_of_another_size(front: tuple[Surface, np.ndarray]) -> None:
    """At nearly seven eighths of its size it would fit elsewhere; where sizes do not count its own is found."""
    part, truth = front
    small = Surface(0.85 * part.vertices, part.faces)
    found = match(small, whole(), partial=True)
    assert error(found, truth) < 0.03
    assert found.overlap_y == pytest.approx(part.area / whole().area, abs=0.05)


@pytest.mark.slow
def test_a_part_is_found_where_the_whole_match_is_not_sure(front: tuple[Surface, np.ndarray]) -> None:
    part, truth = front
    found = match(part, whole())
    assert found.confident, found.explanation
    assert error(found, truth) < 0.03
    assert found.overlap_y < 0.8
    entire = match(part, whole(), partial=False)
    assert not entire.confident
    assert (entire.p2p >= 0).all()
    assert entire.overlap_x == entire.overlap_y == 1.0


def test_sizes_say_who_is_a_part() -> None:
    body = whole()
    part, _ = cut(body, body.vertices[:, 1] > -0.25)
    assert matched_as_part(part, body, "auto", normalize=False)
    assert matched_as_part(body, part, "auto", normalize=False)
    assert not matched_as_part(part, body, "auto", normalize=True)
    assert not matched_as_part(part, body, False, normalize=False)
    larger = Surface(3 * body.vertices, body.faces)
    assert not matched_as_part(body, larger, "auto", normalize=False)  # both are closed
    assert matched_as_part(body, larger, True, normalize=True)


@pytest.mark.slow
def test_a_mirrored_part_is_not_trusted() -> None:
    """The mirror image of a part of something without a left and right fits nowhere."""
    body = Surface(*crooked(1))
    part, _ = cut(body, body.vertices[:, 2] > -0.2)
    mirrored = Surface(part.vertices * [-1, 1, 1], part.faces[:, ::-1])
    assert not as_part(mirrored, body).confident
    same = as_part(part, body)
    assert same.confident, same.explanation


def test_a_piece_of_a_sphere_fits_everywhere() -> None:
    sphere = Surface(*icosphere(3))
    part, _ = cut(sphere, sphere.vertices[:, 2] > -0.3)
    found = as_part(part, sphere)
    assert not found.confident
    assert found.explanation


def test_what_is_no_part_is_refused() -> None:
    body = whole()
    with pytest.raises(ParameterError, match="neither X nor Y has a boundary"):
        match(body, body, partial=True)
    part, _ = cut(body, body.vertices[:, 1] > 0)
    large = Surface(3 * part.vertices, part.faces)
    with pytest.raises(ParameterError, match=r"X has the boundary, but .* times the area of Y"):
        match(large, body, partial=True)
    with pytest.raises(ParameterError, match=r"Y has the boundary, but .* times the area of X"):
        match(body, large, partial=True)


def test_bounds_hold_on_a_cut() -> None:
    """Distances on the whole lie between the bounds that a part gives, up to the accuracy of the distances."""
    body = whole()
    part, numbers = cut(body, body.vertices[:, 0] < 0.3)
    shape = PartShape(part, 1.0, part.n_vertices, 40, PartialParameters())
    least, most = distance_bounds(shape, 40)
    entire = PartShape(body, 1.0, body.n_vertices, 5, PartialParameters())
    points = numbers[shape.fps]
    there = distances(entire.surface, points)[:, points]
    # The rim is measured along edges, which is too far by some per cent.
    assert violations(0.9 * least, 1.002 * most, there).max() < 1e-3
    assert (least < 0.99 * most).any()
    assert np.median(shape.rim[shape.fps[:10]]) > np.median(shape.rim)


def test_costs_are_those_of_the_formula() -> None:
    random = np.random.default_rng(2)
    most = np.abs(random.normal(size=(4, 3))).astype(np.float32)
    least = (most * random.uniform(0.3, 1, most.shape)).astype(np.float32)
    between = np.abs(random.normal(size=(5, 5))).astype(np.float32)
    images = np.array([4, 0, 2])
    there = between[images].T[None]  # (1, m, l)
    cost = violations(least[:, None], most[:, None], there) + 0.15 * np.abs(most[:, None] - there)
    cost = np.minimum(cost, 0.3)
    weights = random.uniform(0.1, 1, most.shape).astype(np.float32)
    expected = (weights[:, None] * cost).sum(axis=2) / weights.sum(axis=1)[:, None]
    found = profile_costs(least, most, weights, between, images, 0.15, 0.3)
    np.testing.assert_allclose(found, expected, rtol=1e-5)
    added = added_costs(least[0], most[0], between, images[None], 0.15, 0.3)
    np.testing.assert_allclose(added[0], cost[0].sum(axis=1), rtol=1e-5)
