"""Errors and protocols on surfaces where distances and maps are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import grid

from qgeo_filters.errors import ParameterError
from qgeo_filters.evaluation import ErrorSummary, error_curve, geodesic_error, mirrored, symmetric_errors
from qgeo_filters.evaluation.tables import PairResult, Row, markdown, rows_by_category
from qgeo_filters.surface import Surface


@pytest.fixture(scope="module")
def square() -> Surface:
    """A 2 x 2 square, so that sqrt(area) is 2."""
    vertices, faces = grid(8)
    return Surface(2 * vertices, faces)


@pytest.fixture(scope="module")
def flip(square: Surface) -> np.ndarray:
    """Left/right map of the square, x -> 2 - x."""
    return np.arange(square.n_vertices).reshape(9, 9)[::-1].ravel()


def test_error_on_a_square_is_the_straight_distance(square: Surface) -> None:
    rng = np.random.default_rng(0)
    p2p, truth = rng.integers(0, square.n_vertices, (2, 200))
    expected = np.linalg.norm(square.vertices[p2p] - square.vertices[truth], axis=1)
    # The graph method is accurate to 1e-3.
    np.testing.assert_allclose(geodesic_error(p2p, truth, square), expected / 2, rtol=2e-3)
    np.testing.assert_allclose(geodesic_error(p2p, truth, square, "none"), expected, rtol=2e-3)
    np.testing.assert_allclose(geodesic_error(p2p, truth, square, "diameter"), expected / 8**0.5, rtol=2e-3)


def test_given_distances_are_used(square: Surface) -> None:
    matrix = np.linalg.norm(square.vertices[:, None] - square.vertices[None], axis=2)
    p2p, truth = np.random.default_rng(1).integers(0, 81, (2, 50))
    np.testing.assert_allclose(geodesic_error(p2p, truth, square, matrix=matrix), matrix[p2p, truth] / 2)


def test_true_map_has_no_error(square: Surface) -> None:
    identity = np.arange(square.n_vertices)
    assert (geodesic_error(identity, identity, square) == 0).all()


def test_error_does_not_depend_on_scale_and_position(square: Surface) -> None:
    moved = Surface(100 * square.vertices + 5, square.faces)
    p2p, truth = np.random.default_rng(2).integers(0, 81, (2, 30))
    np.testing.assert_allclose(geodesic_error(p2p, truth, moved), geodesic_error(p2p, truth, square), rtol=1e-9)


def test_protocols_of_a_mirrored_and_of_a_mixed_map(square: Surface, flip: np.ndarray) -> None:
    identity = np.arange(81)
    assert not mirrored(identity, identity, flip, square)
    assert mirrored(flip, identity, flip, square)
    errors = symmetric_errors(flip, identity, flip, square)
    assert errors.direct.mean() > 0.3
    assert (errors.best_per_pair == 0).all()
    mixed = np.where(identity % 9 < 3, flip, identity)
    errors = symmetric_errors(mixed, identity, flip, square)
    assert not errors.mirrored
    assert errors.best_per_pair.mean() > 0.05
    assert (errors.vertex_minimum == 0).all()


def test_curve_counts_errors_up_to_each_threshold() -> None:
    errors = np.array([0.0, 0.1, 0.1, 0.4])
    np.testing.assert_array_equal(error_curve(errors, [-1, 0, 0.05, 0.1, 0.3, 1]), [0, 0.25, 0.25, 0.75, 0.75, 1])
    summary = ErrorSummary.of(errors)
    assert summary.mean == pytest.approx(0.15)
    assert summary.median == pytest.approx(0.1)
    assert summary.below == (0.25, 0.75, 0.75)


@pytest.mark.parametrize("errors", [[], [[0.1]], [np.nan], [-0.1]])
def test_what_is_no_list_of_distances_is_refused(errors: list) -> None:
    with pytest.raises(ValueError, match="errors"):
        error_curve(errors, [0.1])


def test_bad_maps_are_refused(square: Surface) -> None:
    with pytest.raises(ValueError, match="of one length, got 3 and 2"):
        geodesic_error([0, 1, 2], [0, 1], square)
    with pytest.raises(ValueError, match=r"truth\[1\] is vertex 81"):
        geodesic_error([0, 1], [0, 81], square)
    with pytest.raises(ValueError, match="normalization"):
        geodesic_error([0], [0], square, "area")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="symmetry must hold"):
        mirrored([0], [0], [0], square)


def test_rows_pool_pairs(square: Surface, flip: np.ndarray) -> None:
    identity = np.arange(81)
    good = PairResult("a0 - a1", "a", symmetric_errors(identity, identity, flip, square), seconds=1)
    bad = PairResult("b0 - b1", "b", symmetric_errors(flip, identity, flip, square), confident=False, seconds=3)
    rows = rows_by_category([good, bad], {"tuned": ["a"], "absent": ["c"]})
    assert [row.label for row in rows] == ["a", "b", "tuned", "all"]
    total = rows[-1]
    assert (total.n_pairs, total.n_mirrored, total.n_failed, total.n_confident, total.seconds) == (2, 1, 1, 1, 2)
    assert total.mean == pytest.approx(bad.errors.direct.mean() / 2)
    assert total.worst == pytest.approx(bad.errors.direct.mean())
    assert total.best_per_pair == 0
    table = markdown(rows).splitlines()
    assert len(table) == 6
    assert len({line.count("|") for line in table}) == 1
    with pytest.raises(ValueError, match="no results"):
        Row.of("none", [])


def test_workers_are_checked_and_change_nothing(square: Surface, flip: np.ndarray) -> None:
    truth = np.arange(square.n_vertices)
    found = [geodesic_error(flip, truth, square, workers=workers) for workers in (None, 1, 3)]
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0], found[2])
    assert mirrored(flip, truth, flip, square, workers=2)
    for given in (None, np.zeros((square.n_vertices,) * 2)):
        with pytest.raises(ParameterError, match="workers must be at least 1, got 0"):
            geodesic_error(flip, truth, square, matrix=given, workers=0)
