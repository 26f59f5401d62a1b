"""The discrete geodesic graph of a metric: near-exact distances with a bound on the error."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components, dijkstra

from qgeo_filters.geodesics.bands import band_order
from qgeo_filters.geodesics.clusters import compact_order
from qgeo_filters.geodesics.edges import mesh_edges
from qgeo_filters.geodesics.lanes import LANES, aligned_block
from qgeo_filters.geodesics.layout import layout_of
from qgeo_filters.geodesics.metric import IntrinsicMesh, LiftedMetric, cartesian_metric
from qgeo_filters.geodesics.rows import merged, transposed
from qgeo_filters.geodesics.sweeps import relax, write_rows
from qgeo_filters.geodesics.windows import look_from
from qgeo_filters.surface import Surface

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

# Whole numbers of ticks that no path exceeds: sums are then exact, in 32 bits or in the mantissa of a float64.
_SPAN = {np.dtype(np.int32): 2.0**30, np.dtype(np.float64): 2.0**52}
# Of the accuracy, the share that is kept for rounding lengths up to ticks.
_ROUNDING = 0.02
# Width of a band of distance, in mean edge lengths: narrow enough for one pass to do nearly all.
_BAND = 0.25
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
    band, n_bands : float, int
        Width and number of the bands of distance in whose order vertices are swept.
    tick : float
        Unit of ``length`` in the unit of the metric.
    unreached : float
        Path length, in ticks, of what no path leads to.
    accuracy : float
        Bound on the relative error.
    """

    vertex: IntArray
    place: IntArray
    start: npt.NDArray[np.int64]
    neighbour: IntArray
    length: np.ndarray
    mesh_start: IntArray
    mesh_neighbour: IntArray
    mesh_length: FloatArray
    band: float
    n_bands: int
    tick: float
    unreached: float
    accuracy: float

    @property
    def n_vertices(self) -> int:
        """Number of vertices, those without faces included."""
        return len(self.vertex)

    def distances_into(self, out: np.ndarray, rows: npt.NDArray[np.int64], sources: npt.NDArray[np.int64]) -> None:
        """Distances from each source into its row of ``out`` (., n), float32 or float64.

        Sources that follow each other should be close together: so are `vertex`'s.
        """
        n = self.n_vertices
        block = aligned_block(n, self.length.dtype)
        order, distance, awake = np.empty(n, np.int32), np.empty(n), np.empty(n, np.bool_)
        head, following = np.empty(self.n_bands + 1, np.int32), np.empty(len(self.mesh_neighbour), np.int32)
        for first in range(0, len(sources), LANES):
            part = self.place[sources[first : first + LANES]]
            block.fill(self.unreached)
            block[part, np.arange(len(part))] = 0
            count = band_order(
                self.mesh_start, self.mesh_neighbour, self.mesh_length, self.band, part,
                order, distance, awake, head, following,
            )  # fmt: skip
            relax(self.start, self.neighbour, self.length, order[:count], block, awake)
            write_rows(block, self.unreached, self.place, self.tick, out, rows[first : first + LANES])


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
    counts, ends, lengths = _look(mesh, vertex, epsilon, bound, workers)
    length, tick, unreached = _in_ticks(lengths, bound, accuracy)
    backward = transposed(np.concatenate([[0], np.cumsum(counts)]), place[ends], length)
    start, neighbour, length = merged(*transposed(*backward), *backward)
    band = max(_BAND * float(mesh_rows.data.mean()), bound / (4 * len(vertex))) or 1.0
    n_bands = int(bound / band) + 1
    return GeodesicGraph(
        vertex, place, start, neighbour, length,
        mesh_rows.indptr, mesh_rows.indices, mesh_rows.data, band, n_bands, tick, unreached, accuracy,
    )  # fmt: skip


# The last graph of each metric, or of each surface for its own metric: both are immutable.
_kept: WeakKeyDictionary[LiftedMetric | Surface, GeodesicGraph] = WeakKeyDictionary()


def graph_of(surface: Surface, metric: LiftedMetric | None, accuracy: float, workers: int) -> GeodesicGraph:
    """Graph of a metric, None for the surface's own, kept for as long as the metric or surface lives."""
    key = surface if metric is None else metric
    graph = _kept.get(key)
    if graph is None or graph.accuracy != accuracy:
        mesh = (metric if metric is not None else cartesian_metric(surface)).intrinsic()
        graph = _kept[key] = geodesic_graph(mesh, accuracy, workers=workers)
    return graph


def _look(
    mesh: IntrinsicMesh, vertex: IntArray, epsilon: float, limit: float, workers: int
) -> tuple[npt.NDArray[np.int64], IntArray, FloatArray]:
    """Directed edges of the graph: how many leave each vertex in this order, where they end, their lengths."""
    layout = layout_of(mesh)

    def task(first: int) -> tuple[npt.NDArray[np.int64], IntArray, FloatArray]:
        return look_from(*layout, vertex[first : first + _CHUNK], epsilon, limit)

    with ThreadPoolExecutor(workers) as pool:
        counts, ends, lengths = zip(*pool.map(task, range(0, len(vertex), _CHUNK)), strict=True)
    return np.concatenate(counts), np.concatenate(ends), np.concatenate(lengths)


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
