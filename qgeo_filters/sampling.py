"""Farthest points: each is the farthest from those before it, by distances, along edges or in an embedding.

No vertex is taken twice. Once only vertices are left that coincide with chosen ones (distance zero), they follow in the
order of their numbers, so that there are always as many points as asked for. Of several that are equally far the one
of lowest number is taken.

References
----------
Gonzalez, "Clustering to minimize the maximum intercluster distance", 1985: the covering radius is at most
twice the best.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.validation import checked_count, checked_index


def farthest_by_distances(matrix: npt.NDArray[np.floating], count: int, start: int) -> IndexArray:
    """Farthest points, shape (count,), from all distances (n, n), of which only the chosen rows are read."""
    return _farthest(lambda point, _: matrix[point], len(matrix), count, start)


def farthest_on_edges(edges: IntArray, lengths: FloatArray, n: int, count: int, start: int) -> IndexArray:
    """Farthest points, shape (count,), of n vertices by the shortest ways along edges (E, 2) of these lengths (E,).

    That is enough to spread by, and costs far less than geodesics. Vertices that no way reaches are farthest of all.
    """
    a, b = edges.T
    ends = np.concatenate([a, b]), np.concatenate([b, a])
    graph = sparse.csr_matrix((np.tile(lengths, 2), ends), shape=(n, n))

    def row(point: int, limit: float) -> FloatArray:
        # Both ways are stored: an undirected search would put them together anew for each point.
        return dijkstra(graph, directed=True, indices=[point], limit=limit)[0]

    return _farthest(row, n, count, start)


def farthest_in_embedding(points: FloatArray, count: int, start: int | None = None) -> IndexArray:
    """Farthest points, shape (count,), of rows (n, d) by Euclidean distance; the first is farthest from their mean."""
    if start is None:
        start = int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmax())
    return _farthest(lambda point, _: np.linalg.norm(points - points[point], axis=1), len(points), count, start)


def _farthest(row: Callable[[int, float], npt.NDArray[np.floating]], n: int, count: int, start: int) -> IndexArray:
    """Farthest points from the row of distances of a point; what lies beyond the limit given to it may be inf."""
    count = checked_count(count, 1, n, "the number of points", f"the number of vertices, {n}")
    chosen = np.empty(count, dtype=np.int64)
    chosen[0] = checked_index(start, n, "start")
    nearest = np.array(row(start, np.inf))
    for i in range(1, count):
        # Chosen points are at distance zero, as are those that coincide with them, and argmax would take one again.
        nearest[chosen[:i]] = -np.inf
        chosen[i] = nearest.argmax()
        # A new point changes nothing beyond the largest distance there is.
        np.minimum(nearest, row(int(chosen[i]), float(nearest[chosen[i]])), out=nearest)
    return chosen
