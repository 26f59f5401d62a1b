"""All-pairs and many-source geodesic distances: the descriptor matrix D of the paper."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import numpy.typing as npt
from tqdm import tqdm

from qgeo_filters.geodesics.edges import edge_distances
from qgeo_filters.geodesics.graph import geodesic_graph
from qgeo_filters.geodesics.metric import IntrinsicMesh, LiftedMetric, cartesian_metric
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_indices

FloatArray = npt.NDArray[np.float64]

# Sources of one task, a few blocks of lanes.
GROUP = 64
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
        Shortest paths in the discrete geodesic graph (near-exact, fastest), exact window propagation, or
        Dijkstra along edges (for comparison: several per cent too long).
    accuracy : float
        Bound on the relative error of the graph method; its mean error is about an eighth of it.
    workers : int, optional
        Threads; all cores by default. The result does not depend on it.
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
        Unknown method, source out of range, accuracy out of range.

    References
    ----------
    Wang, Fang, Xin, He, et al., "Discrete geodesic graph (DGG) for computing geodesic distances on discrete surfaces", CAGD 52, 2017.
    """
    mesh = _checked(surface, metric, method)
    chosen = checked_indices(sources, surface.n_vertices, "sources")
    if method == "exact":
        from qgeo_filters.geodesics.exact import exact_distances

        return exact_distances(mesh, chosen, workers=workers, progress=progress)
    if method == "edges":
        return edge_distances(mesh, chosen)
    threads = worker_count(workers)
    graph = geodesic_graph(mesh, accuracy, workers=threads)
    result = np.empty((len(chosen), graph.n_vertices))
    together = np.argsort(graph.place[chosen], kind="stable")
    parts = [together[i : i + GROUP] for i in range(0, len(chosen), GROUP)]

    def task(part: npt.NDArray[np.int64]) -> None:
        graph.distances_into(result, part, chosen[part])

    run_blocks(task, parts, threads, progress)
    return result


def distance_matrix(
    surface: Surface,
    metric: LiftedMetric | None = None,
    method: str = "graph",
    *,
    accuracy: float = 1e-3,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    progress: bool = False,
) -> npt.NDArray[np.float32]:
    """Geodesic distances between all pairs of vertices, shape (n, n), symmetric with a zero diagonal.

    Parameters
    ----------
    surface, metric, method, accuracy, workers, progress
        As in `distances`.
    out : path, optional
        Write to a chunked Zarr array there, block by block, and return that array: for what does not fit in memory. Resumes
        where an earlier call was interrupted.

    Returns
    -------
    (n, n) float32
        In the unit of the vertices; ``inf`` between pieces of the surface and to vertices without faces.

    Raises
    ------
    NonManifoldError, ValueError
        As in `distances`.
    """
    n = surface.n_vertices
    if out is not None:
        raise NotImplementedError("distance_matrix(out=...) is being written")
    if method != "graph":
        rows = distances(surface, np.arange(n), metric, method, workers=workers, progress=progress)
        matrix = rows.astype(np.float32)
        return np.minimum(matrix, matrix.T)
    mesh = _checked(surface, metric, method)
    threads = worker_count(workers)
    graph = geodesic_graph(mesh, accuracy, workers=threads)
    matrix = np.empty((n, n), np.float32)

    def task(first: int) -> None:
        sources = graph.vertex[first : first + GROUP].astype(np.int64)
        graph.distances_into(matrix, sources, sources)

    run_blocks(task, range(0, n, GROUP), threads, progress)
    return matrix


def worker_count(workers: int | None) -> int:
    """Number of threads asked for, or the cores that this process may use."""
    if workers is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers}")
    return workers


def run_blocks(task: Callable, parts: list | range, workers: int, progress: bool) -> None:
    """Call the task on every part, in threads, under a progress bar; an interruption drops what has not begun."""
    with tqdm(total=len(parts), disable=not progress, unit="block", desc="geodesics") as bar:
        pool = ThreadPoolExecutor(workers)
        try:
            for _ in pool.map(task, parts):
                bar.update()
        finally:
            pool.shutdown(cancel_futures=True)


def _checked(surface: Surface, metric: LiftedMetric | None, method: str) -> IntrinsicMesh:
    if method not in METHODS:
        raise ValueError(f"method must be one of {', '.join(map(repr, METHODS))}, got {method!r}")
    if metric is not None and metric.surface.n_vertices != surface.n_vertices:
        raise ValueError(
            f"the metric belongs to a surface of {metric.surface.n_vertices} vertices, this one has {surface.n_vertices}"
        )
    return (metric or cartesian_metric(surface)).intrinsic()
