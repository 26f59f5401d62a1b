"""The discrete geodesic graph of a metric: near-exact distances with a bound on the error."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components, dijkstra

from qgeo_filters._log import timed
from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.dgg.bucket_order import bucket_order
from qgeo_filters.geodesics.dgg.construction import direct_geodesics_from
from qgeo_filters.geodesics.dgg.csr import undirected
from qgeo_filters.geodesics.dgg.fixed_point import ROUNDING, FixedPoint, to_fixed_point
from qgeo_filters.geodesics.dgg.label_correcting import relax, relax_one, write_near, write_rows
from qgeo_filters.geodesics.dgg.simd import LANES, aligned_block
from qgeo_filters.geodesics.dgg.vertex_ordering import compact_order
from qgeo_filters.geodesics.dijkstra import mesh_edges
from qgeo_filters.geodesics.distance_solver import DistanceSolver
from qgeo_filters.geodesics.metric import IntrinsicMesh, LiftedMetric
from qgeo_filters.geodesics.unfolding import unfolded_sides
from qgeo_filters.memory import release_freed_memory
from qgeo_filters.parallel import GROUP, in_threads
from qgeo_filters.surface import Surface

_log = logging.getLogger(__name__)

# Width of a bucket of distance, in mean edge lengths: narrow enough for one pass to do nearly all.
_BUCKET_WIDTH = 0.25
# Vertices that one task looks from when the graph is built.
_CHUNK = 128
# Sources are taken together where there are more than these few, and close together in a graph beyond the caches.
# Measured: a block costs what six single sources do, and at 50,000 vertices as much as all of its sources from a spread
# of 1600 places on (at 3600 vertices a third of that, whatever the spread).
_FEW, _SPREAD, _IN_CACHE = 6, 1600, 8192


@dataclass(frozen=True, eq=False)
class GeodesicGraph(DistanceSolver):
    """Shortest paths in the graph of a metric, from 32 sources at once.

    Inside, vertices are renumbered so that neighbours in number are neighbours on the surface; numbers in that
    order are called places. The graph is undirected, so that distances are the same from either end, bit
    for bit.

    Attributes
    ----------
    vertex, place : (n,) int32
        Vertex at each place, and place of each vertex.
    start, neighbour : (n + 1,), (g,)
        The graph in compressed rows.
    mesh_start, mesh_neighbour, mesh_length : (n + 1,), (2E,), (2E,)
        The edges of the mesh in compressed rows.
    bucket_width, n_buckets : float, int
        Width and number of the buckets of distance in whose order vertices are relaxed.
    fixed : FixedPoint
        Lengths of the graph's edges as whole numbers.
    accuracy : float
        Bound on the relative error.
    """

    group = GROUP
    symmetric = True

    vertex: IntArray
    place: IntArray
    start: npt.NDArray[np.int64]
    neighbour: IntArray
    mesh_start: IntArray
    mesh_neighbour: IntArray
    mesh_length: FloatArray
    bucket_width: float
    n_buckets: int
    fixed: FixedPoint
    accuracy: float

    @property
    def n_vertices(self) -> int:
        """Number of vertices, those without faces included."""
        return len(self.vertex)

    @property
    def source_order(self) -> IndexArray:
        """All vertices, those that follow each other close together on the surface, shape (n,)."""
        return self.vertex.astype(np.int64)

    def distances_into(self, out: np.ndarray, rows: IndexArray, sources: IndexArray) -> None:
        """Distances from each source into its row of ``out`` (., n), float32 or float64.

        Sources that follow each other should be close together: so are those of `source_order`.
        """
        n, fixed = self.n_vertices, self.fixed
        single, block = np.empty((n, 1), fixed.length.dtype), None
        order, distance, awake = np.empty(n, np.int32), np.empty(n), np.empty(n, np.bool_)
        head, following = np.empty(self.n_buckets + 1, np.int32), np.empty(len(self.mesh_neighbour), np.int32)
        for part in _neighbourly(self.place[sources], n):
            places, some = self.place[sources[part]], rows[part]
            together = len(places) > 1
            if together and block is None:
                block = aligned_block(n, fixed.length.dtype)
            lengths = single if block is None or not together else block
            lengths.fill(fixed.unreached)
            lengths[places, np.arange(len(places))] = 0
            count = bucket_order(
                self.mesh_start, self.mesh_neighbour, self.mesh_length, self.bucket_width, places,
                order, distance, awake, head, following,
            )  # fmt: skip
            if together:
                relax(self.start, self.neighbour, fixed.length, order[:count], lengths, awake)
            else:
                awake[:] = False
                awake[places] = True
                relax_one(self.start, self.neighbour, fixed.length, order[:count], lengths[:, 0], awake)
            write_rows(lengths, fixed.unreached, self.place, fixed.unit, out, some)
            write_near(fixed.near_start, fixed.near, fixed.near_length, self.vertex, places, out, some)


def geodesic_graph(mesh: IntrinsicMesh, accuracy: float = 1e-3, *, workers: int | None = None) -> GeodesicGraph:
    """Graph whose shortest paths are never below the geodesic distances and at most ``accuracy`` above, relatively.

    Parameters
    ----------
    mesh : IntrinsicMesh
    accuracy : float
        Bound on the relative error, from 1e-6 to 0.1. The mean error is about a tenth of it; the number of
        edges grows as ``accuracy ** -0.5``.
    workers : int, optional
        Threads; all cores by default. The graph does not depend on it.

    Raises
    ------
    ValueError
        If the accuracy is out of range.
    """
    if not 1e-6 <= accuracy <= 0.1:
        raise ParameterError(f"accuracy is a relative error from 1e-6 to 0.1, got {accuracy}")
    edges = mesh_edges(mesh)
    _, piece = connected_components(edges, directed=False)
    one_of_each = np.unique(piece, return_index=True)[1]
    # The graph holds every edge of the mesh, so that no shortest path in it is longer than this.
    bound = 2.0 * float(dijkstra(edges, indices=one_of_each, min_only=True).max())
    vertex = compact_order(edges.indptr, edges.indices, LANES)
    place = np.empty_like(vertex)
    place[vertex] = np.arange(len(vertex), dtype=vertex.dtype)
    mesh_rows = edges[vertex][:, vertex]
    # The error of many steps is eps + eps^2, that of rounding to units comes on top.
    epsilon = accuracy * (1 - 3 * ROUNDING) / (1 + accuracy)
    counts, ends, lengths = _direct_geodesics(mesh, vertex, epsilon, bound, workers)
    leaving = np.concatenate([[0], np.cumsum(counts)])
    ends = place[ends]
    fixed = to_fixed_point(leaving, ends, lengths, bound, accuracy)
    del lengths  # the graph is large until it is joined
    start, neighbour, length = undirected(leaving, ends, fixed.length)
    fixed = fixed._replace(length=length)
    bucket_width = max(_BUCKET_WIDTH * float(mesh_rows.data.mean()), bound / (4 * len(vertex))) or 1.0
    n_buckets = int(bound / bucket_width) + 1
    return GeodesicGraph(
        vertex, place, start, neighbour,
        mesh_rows.indptr, mesh_rows.indices, mesh_rows.data, bucket_width, n_buckets, fixed, accuracy,
    )  # fmt: skip


# The last graph of each metric, or of each surface for its own metric: both are immutable.
_kept: WeakKeyDictionary[LiftedMetric | Surface, GeodesicGraph] = WeakKeyDictionary()


def graph_of(metric: LiftedMetric, accuracy: float, workers: int | None) -> GeodesicGraph:
    """Graph of a metric, kept for as long as the metric lives, the surface's own for as long as the surface does."""
    key = metric.surface if metric.edge_lengths is metric.surface.edge_lengths else metric
    graph = _kept.get(key)
    if graph is None or graph.accuracy != accuracy:
        with timed(_log, "graph of %d vertices for accuracy %g", metric.surface.n_vertices, accuracy):
            graph = _kept[key] = geodesic_graph(metric.intrinsic(), accuracy, workers=workers)
        _log.debug("it has %d edges", len(graph.neighbour) // 2)
        release_freed_memory()
    return graph


def _neighbourly(places: IntArray, n: int) -> list[slice]:
    """Runs of sources that are taken together: a block of them where they lie close together, else each alone."""
    parts = []
    for first in range(0, len(places), LANES):
        part = slice(first, min(first + LANES, len(places)))
        spread = int(places[part].max()) - int(places[part].min())
        together = part.stop - part.start > _FEW and (spread <= _SPREAD or n <= _IN_CACHE)
        parts += [part] if together else [slice(i, i + 1) for i in range(part.start, part.stop)]
    return parts


def _direct_geodesics(
    mesh: IntrinsicMesh, vertex: IntArray, epsilon: float, limit: float, workers: int | None
) -> tuple[npt.NDArray[np.int64], IntArray, FloatArray]:
    """Directed edges of the graph: how many leave each vertex in this order, where they end, their lengths."""
    sides = unfolded_sides(mesh)

    def task(first: int) -> tuple[npt.NDArray[np.int64], IntArray, FloatArray]:
        return direct_geodesics_from(*sides, vertex[first : first + _CHUNK], epsilon, limit)

    counts, ends, lengths = zip(*in_threads(task, range(0, len(vertex), _CHUNK), workers), strict=True)
    return np.concatenate(counts), np.concatenate(ends), np.concatenate(lengths)
