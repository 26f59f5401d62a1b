"""Shortest paths along the edges of the mesh: for comparison only, several per cent too long."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.geodesics.distance_solver import DistanceSolver
from qgeo_filters.geodesics.metric import IntrinsicMesh, LiftedMetric


def mesh_edges(mesh: IntrinsicMesh) -> Any:
    """Edges as a symmetric sparse matrix (n, n) of lengths; those of length zero are stored too."""
    tail = mesh.faces.ravel()
    head = np.roll(mesh.faces, -1, axis=1).ravel()
    n = mesh.n_vertices
    key = np.concatenate([tail, head]).astype(np.int64) * n + np.concatenate([head, tail])
    key, first = np.unique(key, return_index=True)
    length = np.tile(mesh.lengths.ravel(), 2)[first]
    start = np.searchsorted(key // n, np.arange(n + 1)).astype(np.int32)
    return sparse.csr_array((length, (key % n).astype(np.int32), start), shape=(n, n))


def edge_distances(mesh: IntrinsicMesh, sources: IndexArray) -> FloatArray:
    """Lengths (s, n) of the shortest paths along edges (Dijkstra), ``inf`` where there is none."""
    return dijkstra(mesh_edges(mesh), directed=True, indices=sources)


class EdgeDistances(DistanceSolver):
    """Dijkstra on the edges of a metric, which are kept as a sparse matrix."""

    group = 64

    def __init__(self, mesh: IntrinsicMesh) -> None:
        self.edges = mesh_edges(mesh)

    @classmethod
    def of(cls, metric: LiftedMetric, accuracy: float, workers: int | None) -> EdgeDistances:
        """Solver of a metric; its error has no bound, and the accuracy is not asked."""
        return cls(metric.intrinsic())

    @property
    def n_vertices(self) -> int:
        """Number of vertices, those without faces included."""
        return self.edges.shape[0]

    def distances_into(self, out: np.ndarray, rows: IndexArray, sources: IndexArray) -> None:
        """Distances from each source into its row of ``out`` (., n)."""
        out[rows] = dijkstra(self.edges, directed=True, indices=sources)
