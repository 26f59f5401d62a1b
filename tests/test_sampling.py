"""Farthest points: none twice, none lost, each the farthest there is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from shapes import icosphere

import qgeo_filters as qg
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.matching.intrinsic_shape import farthest_rows
from qgeo_filters.matching.regions import eigenfunction_regions
from qgeo_filters.sampling import farthest_by_distances, farthest_in_embedding, farthest_on_edges


def without_guard(matrix: np.ndarray, count: int, start: int) -> list[int]:
    """The textbook loop; where vertices coincide it takes one twice."""
    points = [start]
    while len(points) < count:
        points.append(int(matrix[points].min(axis=0).argmax()))
    return points


def check_farthest(points: np.ndarray, matrix: np.ndarray, count: int) -> None:
    """Each point is the farthest from those before it, of equals the first that is not taken."""
    assert points.dtype == np.int64
    assert points.shape == (count,)
    assert len(np.unique(points)) == count
    for i in range(1, count):
        gap = matrix[points[:i]].min(axis=0)
        free = np.setdiff1d(np.arange(len(matrix)), points[:i])
        assert points[i] == free[gap[free].argmax()]


def on_a_path(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges that join the points one after the other, and their lengths."""
    edges = np.column_stack([np.arange(len(positions) - 1), np.arange(1, len(positions))])
    return edges, np.linalg.norm(np.diff(positions, axis=0), axis=1)


@settings(max_examples=60)
@given(st.integers(2, 25), st.integers(1, 12), st.booleans(), st.integers(0, 10**6), st.data())
def test_each_is_the_farthest_and_none_is_taken_twice(n: int, sites: int, same: bool, seed: int, data) -> None:
    random = np.random.default_rng(seed)
    positions = random.normal(size=(n, 3))
    if same:  # many vertices at few sites
        positions = positions[random.integers(0, min(sites, n), n)]
    start = data.draw(st.integers(0, n - 1))
    count = data.draw(st.integers(1, n))
    matrix = np.linalg.norm(positions[:, None] - positions, axis=2)
    edges, lengths = on_a_path(positions)
    graph = csr_matrix((lengths, edges.T), shape=(n, n))
    ways: list[tuple[Callable[[int], np.ndarray], np.ndarray]] = [
        (lambda c: farthest_by_distances(matrix, c, start), matrix),
        (lambda c: farthest_by_distances(matrix.astype(np.float32), c, start), matrix.astype(np.float32)),
        (lambda c: farthest_in_embedding(positions, c, start), matrix),
        (lambda c: farthest_on_edges(edges, lengths, n, c, start), dijkstra(graph, directed=False)),
    ]
    for way, distances in ways:
        points = way(count)
        assert points[0] == start
        check_farthest(points, distances, count)
        np.testing.assert_array_equal(np.sort(way(n)), np.arange(n))
        np.testing.assert_array_equal(way(n)[:count], points)
        if not same:
            assert points.tolist() == without_guard(distances, count, start)


def test_what_coincides_comes_last_in_the_order_of_the_numbers() -> None:
    positions = np.array([[0.0], [5], [0], [5], [2], [0]])
    assert farthest_in_embedding(positions, 6, start=2).tolist() == [2, 1, 4, 0, 3, 5]
    # The first is farthest from the mean, whatever the numbering.
    assert farthest_in_embedding(positions, 1).tolist() == [1]


def test_samples_of_a_shape_with_coinciding_vertices_are_different() -> None:
    """Before, the first vertex was taken once for each that coincides with another."""
    positions = np.repeat(icosphere(1)[0], 2, axis=0)
    matrix = np.linalg.norm(positions[:, None] - positions, axis=2).astype(np.float32)
    points = farthest_rows(matrix, np.ones(len(matrix)), len(matrix))
    np.testing.assert_array_equal(np.sort(points), np.arange(len(matrix)))
    assert len(np.unique(positions[points[: len(matrix) // 2]], axis=0)) == len(matrix) // 2


def test_regions_of_vertices_that_coincide() -> None:
    phi = np.repeat(np.array([[0.0, 1], [1, 0], [3, 3]]), 2, axis=0)
    mine, theirs = eigenfunction_regions(phi, phi, np.arange(6), np.ones(6), count=6)
    np.testing.assert_array_equal(mine, theirs)
    np.testing.assert_array_equal(mine[::2], mine[1::2])
    assert len(np.unique(mine)) == 3


@pytest.mark.parametrize("count", [0, 5, -1, True, 2.0, "2"])
def test_numbers_of_points_are_checked(count: object) -> None:
    with pytest.raises(ParameterError, match="number of points must be between 1 and the number of vertices, 4, got"):
        farthest_in_embedding(np.eye(4), count)  # type: ignore[arg-type]


def test_arguments_of_what_calls_it_are_checked() -> None:
    with pytest.raises(MeshError, match="start is vertex 4, but there are 4 vertices"):
        farthest_by_distances(np.ones((4, 4)) - np.eye(4), 2, 4)
    with pytest.raises(ParameterError, match=r"number of points must be between 1 and .* got 30\.7"):
        qg.landmark_spectrum(qg.Surface(*icosphere(2)), 4, landmarks=30.7)
    with pytest.raises(ParameterError, match="number of regions must be between 1 and 6, got True"):
        eigenfunction_regions(np.eye(6), np.eye(6), np.arange(6), np.ones(6), count=True)
