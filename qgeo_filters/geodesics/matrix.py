"""Geodesic distances from many vertices or between all: the descriptor matrix D_g of the paper."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.geodesics.dgg.graph import GeodesicGraph, graph_of
from qgeo_filters.geodesics.dijkstra import edge_distances
from qgeo_filters.geodesics.metric import IntrinsicMesh, LiftedMetric, cartesian_metric
from qgeo_filters.parallel import GROUP, run_tasks, worker_count
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_indices

METHODS = ("graph", "exact", "edges")


def distances(
    surface: Surface,
    sources: npt.ArrayLike,
    metric: LiftedMetric | None = None,
    method: str = "graph",
    *,
    accuracy: float = 1e-3,
    workers: int | None = None,
    progress: bool = False,
) -> FloatArray:
    """Geodesic distances from some vertices to all, shape (s, n), in the unit of the vertices.

    Parameters
    ----------
    surface : Surface
        Manifold, in any number of pieces, orientable or not.
    sources : array-like of int, shape (s,)
        Vertices, in any order, repeated ones too.
    metric : LiftedMetric, optional
        None is the surface's own metric.
    method : {"graph", "exact", "edges"}
        Shortest paths in the discrete geodesic graph (near-exact and by far the fastest), exact window
        propagation, or Dijkstra along edges (for comparison: several per cent too long).
    accuracy : float
        Bound on the relative error of the graph method; its mean error is about a tenth of it.
    workers : int, optional
        Threads; all cores by default. The result does not depend on it, bit for bit.
    progress : bool
        Show a progress bar.

    Returns
    -------
    (s, n) float64
        ``inf`` between pieces of the surface and to vertices without faces. Never below the exact distance.

    Raises
    ------
    NonManifoldError
        Three faces on an edge, or several fans at a vertex.
    ValueError
        Unknown method, source out of range, accuracy out of range, the metric of another surface.

    Notes
    -----
    The graph is kept for as long as the metric (or the surface) lives, so that a second call is quick.

    References
    ----------
    Wang, Fang, Xin, He, et al., "Discrete geodesic graph (DGG) for computing geodesic distances on discrete
    surfaces", Computer Aided Geometric Design 52-53, 2017.
    """
    _check(surface, metric, method)
    chosen = checked_indices(sources, surface.n_vertices, "sources")
    threads = worker_count(workers)
    if method == "graph":
        graph = graph_of(surface, metric, accuracy, threads)
        result = np.empty((len(chosen), graph.n_vertices))
        together = np.argsort(graph.place[chosen], kind="stable")

        def task(first: int) -> None:
            part = together[first : first + GROUP]
            graph.distances_into(result, part, chosen[part])

        run_tasks(task, range(0, len(chosen), GROUP), threads, progress)
        return result
    mesh = _mesh(surface, metric)
    if method == "edges":
        return edge_distances(mesh, chosen)
    from qgeo_filters.geodesics.mmp.exact import exact_distances

    return exact_distances(mesh, chosen, workers=threads, progress=progress)


def distance_matrix(
    surface: Surface,
    metric: LiftedMetric | None = None,
    method: str = "graph",
    *,
    accuracy: float = 1e-3,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    progress: bool = False,
) -> Any:
    """Geodesic distances between all pairs of vertices, shape (n, n), symmetric with a zero diagonal.

    Parameters
    ----------
    surface, metric, method, accuracy, workers, progress
        As in `distances`.
    out : path, optional
        Write the matrix there as a Zarr array, row by row, instead of into memory. An interrupted or killed
        call is continued by the same call: rows already there are not computed again. Needs the package zarr.

    Returns
    -------
    (n, n) float32 array, or zarr.Array where ``out`` is given
        In the unit of the vertices; ``inf`` between pieces of the surface and to vertices without faces.

    Raises
    ------
    NonManifoldError, ValueError
        As in `distances`; distances that float32 cannot hold.
    ValueError
        ``out`` is there and is no such array, or that of another mesh, metric or accuracy.
    OSError
        ``out`` cannot be written, or the disk is full; what was written stays usable.
    """
    _check(surface, metric, method)
    threads = worker_count(workers)
    n = surface.n_vertices
    extent = float((metric.edge_lengths if metric is not None else surface.edge_lengths).sum())
    if extent and not 1e-30 < extent < 1e35:
        raise MeshError(f"edges of {extent:g} units in total: float32 does not hold such distances; rescale the mesh")
    if out is not None:
        if method != "graph":
            raise ParameterError(f"out= is written by the graph method only, not by {method!r}")
        from qgeo_filters.geodesics.storage import stored_matrix

        mesh = _mesh(surface, metric)
        return stored_matrix(
            Path(out), mesh, lambda: graph_of(surface, metric, accuracy, threads), accuracy, threads, progress
        )
    matrix = np.empty((n, n), np.float32)
    if method == "graph":
        graph: GeodesicGraph = graph_of(surface, metric, accuracy, threads)

        def task(first: int) -> None:
            sources = graph.vertex[first : first + GROUP].astype(np.int64)
            graph.distances_into(matrix, sources, sources)

        run_tasks(task, range(0, n, GROUP), threads, progress)
        return matrix
    for first in range(0, n, 1024):
        some = np.arange(first, min(first + 1024, n))
        matrix[some] = distances(surface, some, metric, method, workers=threads, progress=progress)
    _symmetrise(matrix)
    return matrix


def _mesh(surface: Surface, metric: LiftedMetric | None) -> IntrinsicMesh:
    return (metric if metric is not None else cartesian_metric(surface)).intrinsic()


def _check(surface: Surface, metric: LiftedMetric | None, method: str) -> None:
    if method not in METHODS:
        raise ParameterError(f"method must be one of {', '.join(map(repr, METHODS))}, got {method!r}")
    if metric is not None and metric.surface is not surface and metric.surface.n_vertices != surface.n_vertices:
        raise ParameterError(
            f"the metric belongs to a surface of {metric.surface.n_vertices} vertices, "
            f"this one has {surface.n_vertices}"
        )


def _symmetrise(matrix: npt.NDArray[np.float32], size: int = 512) -> None:
    """Put the smaller of both directions into either, in place: they differ by rounding only."""
    for i in range(0, len(matrix), size):
        for j in range(0, i + 1, size):
            lower, upper = matrix[i : i + size, j : j + size], matrix[j : j + size, i : i + size]
            least = np.minimum(lower, upper.T)
            lower[...], upper[...] = least, least.T
