"""The discrete geodesic graph of a metric: near-exact distances with a bound on the error."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import connected_components, dijkstra

from qgeo_filters.geodesics.clusters import compact_order
from qgeo_filters.geodesics.edges import mesh_edges
from qgeo_filters.geodesics.lanes import LANES
from qgeo_filters.geodesics.layout import layout_of
from qgeo_filters.geodesics.metric import IntrinsicMesh
from qgeo_filters.geodesics.sweeps import mesh_order, solve
from qgeo_filters.geodesics.windows import look_from

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

# Whole numbers of ticks that no path exceeds: sums are then exact, in 32 bits or in the mantissa of a float64.
_SPAN = {np.dtype(np.int32): 2.0**30, np.dtype(np.float64): 2.0**52}
# Of the accuracy, the share that is kept for rounding lengths up to ticks.
_ROUNDING = 0.02
# Vertices that one task looks from when the graph is built.
_CHUNK = 128


@dataclass(frozen=True, eq=False)
class GeodesicGraph:
    """Solver that keeps the graph: distances from a group of sources are then one call.

    Inside, vertices are renumbered so that neighbours in number are neighbours on the surface; numbers in that
    order are called places. The graph is undirected, so that distances are the same from either end, bit
    for bit.

    Attributes
    ----------
    vertex, place : (n,) int32
        Vertex at each place, and place of each vertex.
    start, neighbour, length : (n + 1,), (g,), (g,)
        The graph in compressed rows; lengths in ticks, whole numbers in int32 or float64.
    mesh_start, mesh_neighbour, mesh_length : (n + 1,), (2E,), (2E,)
        The edges of the mesh in compressed rows.
    tick : float
        Unit of ``length`` in the unit of the metric.
    unreached : float
        Path length, in ticks, of what no path leads to.
    accuracy : float
        Bound on the relative error.
    """

    vertex: IntArray
    place: IntArray
    start: IntArray
    neighbour: IntArray
    length: np.ndarray
    mesh_start: IntArray
    mesh_neighbour: IntArray
    mesh_length: FloatArray
    tick: float
    unreached: float
    accuracy: float

    @property
    def n_vertices(self) -> int:
        """Number of vertices, those without faces included."""
        return len(self.vertex)

    def distances_into(self, rows: np.ndarray, sources: IntArray) -> None:
        """Fill ``rows`` (s, n), float32 or float64, with the distances from s sources that should be close together."""
        places = self.place[sources]
        order = mesh_order(self.mesh_start, self.mesh_neighbour, self.mesh_length, places)
        block = _aligned((self.n_vertices, LANES), self.length.dtype)
        awake = np.empty(self.n_vertices, np.bool_)
        for first in range(0, len(places), LANES):
            part = slice(first, first + LANES)
            solve(
                self.start, self.neighbour, self.length, order, self.unreached,
                places[part], block, awake, self.place, self.tick, rows[part],
            )  # fmt: skip


def geodesic_graph(mesh: IntrinsicMesh, accuracy: float = 1e-3, *, workers: int = 1) -> GeodesicGraph:
    """Graph whose shortest paths are never below the geodesic distances and at most ``accuracy`` above, relatively.

    Parameters
    ----------
    mesh : IntrinsicMesh
    accuracy : float
        Bound on the relative error, from 1e-6 to 0.1. The mean error is about a tenth of it; the number of
        edges grows as ``accuracy ** -0.5``.
    workers : int
        Threads.

    Raises
    ------
    ValueError
        If the accuracy is out of range.
    """
    if not 1e-6 <= accuracy <= 0.1:
        raise ValueError(f"accuracy is a relative error from 1e-6 to 0.1, got {accuracy}")
    edges = mesh_edges(mesh)
    _, piece = connected_components(edges, directed=False)
    one_of_each = np.unique(piece, return_index=True)[1]
    # The graph holds every edge of the mesh, so that no shortest path in it is longer than this.
    bound = 2.0 * float(dijkstra(edges, indices=one_of_each, min_only=True).max())
    vertex = compact_order(edges.indptr, edges.indices, LANES)
    place = np.empty_like(vertex)
    place[vertex] = np.arange(len(vertex), dtype=vertex.dtype)
    mesh_rows = edges[vertex][:, vertex]
    # The error of many steps is eps + eps^2, that of rounding to ticks comes on top.
    epsilon = accuracy * (1 - 2 * _ROUNDING)
    graph = _joined(*_look(mesh, epsilon, bound, workers), place)
    length, tick, unreached = _in_ticks(graph.data, bound, accuracy)
    return GeodesicGraph(
        vertex, place, graph.indptr, graph.indices, length,
        mesh_rows.indptr, mesh_rows.indices, mesh_rows.data, tick, unreached, accuracy,
    )  # fmt: skip


def _look(mesh: IntrinsicMesh, epsilon: float, limit: float, workers: int) -> tuple[IntArray, IntArray, FloatArray]:
    """Directed edges of the graph: the vertices that they leave, where they end, their lengths."""
    layout = layout_of(mesh)
    n = mesh.n_vertices

    def task(first: int) -> tuple[IntArray, IntArray, FloatArray]:
        return look_from(*layout, first, min(first + _CHUNK, n), epsilon, limit)

    with ThreadPoolExecutor(workers) as pool:
        counts, ends, lengths = zip(*pool.map(task, range(0, n, _CHUNK)), strict=True)
    tails = np.repeat(np.arange(n, dtype=np.int32), np.concatenate(counts))
    return tails, np.concatenate(ends), np.concatenate(lengths)


def _joined(tails: IntArray, heads: IntArray, lengths: FloatArray, place: IntArray) -> sparse.csr_array:
    """Undirected graph over places, the shorter length where the directions differ; zero lengths are stored."""
    n = len(place)
    a, b = place[tails].astype(np.int64), place[heads].astype(np.int64)
    key = np.concatenate([a * n + b, b * n + a])
    length = np.tile(lengths, 2)
    order = np.lexsort((length, key))
    key, length = key[order], length[order]
    first = np.concatenate([[True], key[1:] != key[:-1]])[: len(key)]
    key, length = key[first], length[first]
    start = np.searchsorted(key, np.arange(n + 1) * n).astype(np.int32)
    return sparse.csr_array((length, (key % n).astype(np.int32), start), shape=(n, n))


def _in_ticks(lengths: FloatArray, bound: float, accuracy: float) -> tuple[np.ndarray, float, float]:
    """Lengths rounded up to whole ticks, the tick, and a number of ticks that no path reaches.

    In 32 bits where the shortest edge is then long enough, with 52 bits where edges differ too much in length.
    """
    positive = lengths[lengths > 0]
    shortest = float(positive.min()) if positive.size else 1.0
    narrow, wide = np.dtype(np.int32), np.dtype(np.float64)
    dtype = narrow if bound / _SPAN[narrow] <= shortest * accuracy * _ROUNDING else wide
    # Rounding up may add a tick to each step of a path: hence the room above the bound.
    tick = 1.001 * bound / _SPAN[dtype] if bound > 0 else 1.0
    return np.ceil(lengths / tick).astype(dtype), tick, _SPAN[dtype]


def _aligned(shape: tuple[int, int], dtype: np.dtype) -> np.ndarray:
    """Uninitialised array whose rows of 16 do not straddle cache lines."""
    size = shape[0] * shape[1] * dtype.itemsize
    raw = np.empty(size + 64, np.uint8)
    offset = -raw.ctypes.data % 64
    return raw[offset : offset + size].view(dtype).reshape(shape)
