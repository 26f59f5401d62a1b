"""Geodesic distances from many vertices or between all: the descriptor matrix D_g of the paper."""

from __future__ import annotations

import os
from typing import Any

import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.geodesics.metric import Metric, metric_for
from qgeo_filters.geodesics.solver import GeodesicSolver
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface


def distances(
    surface: SurfaceLike,
    sources: npt.ArrayLike,
    metric: Metric | None = "cartesian",
    method: str = "graph",
    *,
    accuracy: float = 1e-3,
    workers: int | None = None,
    progress: bool = False,
) -> FloatArray:
    """Geodesic distances from some vertices to all, shape (s, n), in the unit of the vertices.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        Manifold, in any number of pieces, orientable or not.
    sources : array-like of int, shape (s,)
        Vertices, in any order, repeated ones too.
    metric : LiftedMetric, "cartesian" or "lifted"
        By name: the surface's own metric, or `lifted_metric` as it is.
    method : {"graph", "exact", "edges"}, or a name given to `register_method`
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
    ParameterError, MeshError
        Unknown method, source out of range, accuracy out of range, the metric of another surface.

    Notes
    -----
    The graph is kept for as long as the metric (or the surface) lives, so that a second call is quick; `GeodesicSolver`
    keeps it in sight.

    References
    ----------
    Wang, Fang, Xin, He, et al., "Discrete geodesic graph (DGG) for computing geodesic distances on discrete
    surfaces", Computer Aided Geometric Design 52-53, 2017.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> from_two = qg.distances(surface, [0, 7])
    >>> from_two.shape, float(from_two[0, 0])
    ((2, 162), 0.0)
    >>> along_edges = qg.distances(surface, [0, 7], method="edges")
    >>> bool((along_edges >= from_two * (1 - 1e-3)).all())
    True
    """
    surface = as_surface(surface)
    chosen = metric_for(surface, metric, "cartesian")
    solver = GeodesicSolver(surface, chosen, method, accuracy=accuracy, workers=workers)
    return solver.distances(sources, progress=progress)


def distance_matrix(
    surface: SurfaceLike,
    metric: Metric | None = "cartesian",
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
    NonManifoldError, ParameterError, MeshError
        As in `distances`; distances that float32 cannot hold.
    TooLargeError
        The matrix, of 4 n^2 bytes, does not fit into the memory that is free; said before anything is computed.
    ParameterError
        ``out`` is there and is no such array, or that of another mesh, metric or accuracy.
    OSError
        ``out`` cannot be written, or the disk is full; what was written stays usable.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> matrix = qg.distance_matrix(surface)
    >>> matrix.shape, matrix.dtype, bool((matrix == matrix.T).all())
    ((162, 162), dtype('float32'), True)
    >>> near = np.isclose(matrix[5], qg.distances(surface, 5, method="exact")[0], rtol=2e-3)
    >>> bool(near.all())
    True
    """
    surface = as_surface(surface)
    chosen = metric_for(surface, metric, "cartesian")
    solver = GeodesicSolver(surface, chosen, method, accuracy=accuracy, workers=workers)
    return solver.distance_matrix(out=out, progress=progress)
