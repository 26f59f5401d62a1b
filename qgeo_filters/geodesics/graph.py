"""The discrete geodesic graph of a metric: near-exact distances with a bound on the error."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from qgeo_filters.geodesics.clusters import compact_order
from qgeo_filters.geodesics.edges import mesh_edges
from qgeo_filters.geodesics.layout import layout_of
from qgeo_filters.geodesics.metric import IntrinsicMesh
from qgeo_filters.geodesics.sweeps import LANES, distance_order, relax
from qgeo_filters.geodesics.windows import look_from

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

# Path lengths are whole numbers of ticks, so that sums are exact in any order; this many span a component.
_SPAN = 1 << 30
# Of the accuracy, the share kept for rounding lengths up to ticks.
_ROUNDING = 0.02
# Vertices that one task of the graph's construction looks from.
_CHUNK = 256


@dataclass(frozen=True, eq=False)
class GeodesicGraph:
    """Solver that keeps the graph: each block of sources is then one call.

    Vertices are renumbered so that neighbours in number are neighbours on the surface; positions in
    that order are called places.

    Attributes
    ----------
    vertex : (n,) int32
        Vertex at each place.
    place : (n,) int32
        Place of each vertex.
    into_start, into, into_length : (n + 1,), (g,), (g,)
        Edges that end at each place: where they start, and how many ticks long they are.
    out_start, out : (n + 1,), (g,) int32
        Edges that start at each place: where they end.
    edge_start, edge_end, edge_length : (n + 1,), (2E,), (2E,)
        Edges of the mesh.
    tick : float
        Unit of ``into_length`` in the unit of the metric.
    unreached : int or float
        Value of what no path leads to.
    accuracy : float
        Bound on the relative error.
    """

    vertex: IntArray
    place: IntArray
    into_start: IntArray
    into: IntArray
    into_length: np.ndarray
    out_start: IntArray
    out: IntArray
    edge_start: IntArray
    edge_end: IntArray
    edge_length: FloatArray
    tick: float
    unreached: float
    accuracy: float

    @property
    def n_vertices(self) -> int:
        """Number of vertices."""
        return len(self.vertex)

    def block(self, places: npt.NDArray[np.int64]) -> np.ndarray:
        """Path lengths in ticks from up to 16 places to all, shape (n, 16); unused columns repeat the last."""
        n = self.n_vertices
        lanes = np.resize(places, LANES)
        lanes[len(places) :] = places[-1]
        block = np.full((n, LANES), self.unreached, self.into_length.dtype)
        block[lanes, np.arange(LANES)] = 0
        order, distance = np.empty(n, np.int32), np.empty(n)
        awake, best = np.zeros(n, np.bool_), np.empty(LANES, block.dtype)
        started = np.zeros(n, np.bool_)
        for source in lanes:
            # Mostly once: sources in different pieces of the mesh need an order for each piece.
            if not started[source]:
                count = distance_order(self.edge_start, self.edge_end, self.edge_length, source, order, distance)
                started[order[:count]] = True
                relax(
                    self.into_start, self.into, self.into_length, self.out_start, self.out,
                    order, count, block, best, awake,
                )  # fmt: skip
        return block

    def lengths(self, block: np.ndarray) -> FloatArray:
        """Block of ticks as lengths in the unit of the metric, ``inf`` where no path leads."""
        return np.where(block < self.unreached, block * self.tick, np.inf)


def geodesic_graph(mesh: IntrinsicMesh, accuracy: float = 1e-3, *, workers: int = 1) -> GeodesicGraph:
    """Graph whose shortest paths are the geodesic distances, never below and at most ``accuracy`` above, relatively.

    Parameters
    ----------
    mesh : IntrinsicMesh
    accuracy : float
        Bound on the relative error, from 1e-6 to 0.1. The mean error is about an eighth of it; the number of edges grows as
        ``accuracy ** -0.5``.
    workers : int
        Threads.

    Raises
    ------
    ValueError
        If the accuracy is out of range.
    """
    if not 1e-6 <= accuracy <= 0.1:
        raise ValueError(f"accuracy is a relative error from 1e-6 to 0.1, got {accuracy}")
    n = mesh.n_vertices
    edges = mesh_edges(mesh)
    _, label = sparse.csgraph.connected_components(edges, directed=False)
    one_each = np.unique(label, return_index=True)[1]
    # The graph holds every edge of the mesh: no shortest path in it is longer than this.
    bound = 2.0 * float(dijkstra(edges, directed=False, indices=one_each, min_only=True).max())
    place_order = compact_order(edges.indptr, edges.indices, LANES)
    place = np.empty(n, np.int32)
    place[place_order] = np.arange(n, dtype=np.int32)

    # The error of many steps, 1 + eps + eps^2, is to stay within the accuracy.
    epsilon = accuracy * (1 - _ROUNDING) / (1 + accuracy)
    counts, ends, lengths = _look(mesh, epsilon, bound, workers)
    starts = np.repeat(np.arange(n, dtype=np.int32), counts)
    positive = lengths[lengths > 0]
    tick = bound / _SPAN if bound > 0 else 1.0
    exact_ticks = positive.size == 0 or positive.min() >= tick / (accuracy * _ROUNDING)
    if exact_ticks:
        ticks: np.ndarray = np.ceil(lengths / tick).astype(np.int32)
        unreached: float = _SPAN + 1
    else:  # edges shorter than a tick can tell
        ticks, tick, unreached = lengths, 1.0, np.inf
    order = np.lexsort((place[starts], place[ends]))
    into_start = np.searchsorted(place[ends][order], np.arange(n + 1)).astype(np.int32)
    out_order = np.lexsort((place[ends], place[starts]))
    out_start = np.searchsorted(place[starts][out_order], np.arange(n + 1)).astype(np.int32)
    moved = edges[place_order][:, place_order].tocsr()
    moved.sort_indices()
    return GeodesicGraph(
        place_order, place,
        into_start, place[starts][order], ticks[order],
        out_start, place[ends][out_order],
        moved.indptr.astype(np.int32), moved.indices.astype(np.int32), moved.data,
        tick, unreached, accuracy,
    )  # fmt: skip


def _look(mesh: IntrinsicMesh, epsilon: float, limit: float, workers: int) -> tuple[IntArray, IntArray, FloatArray]:
    """Edges of the graph: how many leave each vertex, where they end, and their lengths."""
    layout = layout_of(mesh)
    firsts = range(0, mesh.n_vertices, _CHUNK)

    def task(first: int) -> tuple[IntArray, IntArray, FloatArray]:
        return look_from(layout, first, min(first + _CHUNK, mesh.n_vertices), epsilon, limit)

    with ThreadPoolExecutor(workers) as pool:
        parts: Iterator[tuple] = pool.map(task, firsts)
        counts, ends, lengths = zip(*parts, strict=True)
    return np.concatenate(counts), np.concatenate(ends), np.concatenate(lengths)
