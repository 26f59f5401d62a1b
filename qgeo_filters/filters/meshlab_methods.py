"""Methods of ``pymeshlab.MeshSet`` in PyMeshLab's own naming and habits, bound by `register_pymeshlab`.

As PyMeshLab's filters do, they change the current mesh in place, set the per-vertex scalar (its "quality"), take
keyword arguments in lower case without underscores, and return a dictionary. Those that need a map are in
`meshlab_matching`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters.defaults import CURVATURE_WEIGHT, EIGENPAIRS
from qgeo_filters.differential.scalar import Scalar
from qgeo_filters.errors import MeshError, ParameterError, require_package
from qgeo_filters.filters import meshlab_matching
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.differential import DifferentialCoordinates, SurfaceScalar
from qgeo_filters.filters.geodesics import QuasiGeodesicDistances
from qgeo_filters.filters.meshlab_in_place import set_colors, set_scalar
from qgeo_filters.filters.spectral import QuasiGeodesicSpectrum
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.parallel import default_workers
from qgeo_filters.report.colors import diverging, sequential
from qgeo_filters.surface import Surface


def compute_scalar_by_quasi_geodesic_distance_from_given_point_per_vertex(
    meshset: Any,
    *,
    startpoint: npt.ArrayLike = (0.0, 0.0, 0.0),
    curvatureweight: float = CURVATURE_WEIGHT,
    scalar: Scalar = "mean_curvature",
    colorize: bool = False,
    workers: int | None = None,
) -> dict[str, Any]:
    """Set the scalar to the quasi-geodesic distance from the vertex nearest to a point.

    Parameters
    ----------
    startpoint : (3,) array-like
        In the coordinates of the mesh.
    curvatureweight, scalar
        Of the metric, see `qgeo_filters.QuasiGeodesicDistances`.
    colorize : bool
        Whether vertices are painted by the scalar, too.
    workers : int, optional
        Number of threads; by default all cores that this process may use.

    Returns
    -------
    dict
        ``start_vertex``, and ``maximum`` of the finite distances. Unreachable vertices get ``inf``.
    """
    surface = as_surface(meshset)
    point = np.asarray(startpoint, dtype=float)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise MeshError(f"startpoint must be three finite coordinates, got {startpoint!r}")
    start = int(cKDTree(surface.vertices).query(point)[1])
    filter = QuasiGeodesicDistances(sources=start, scalar=scalar, curvature_weight=curvatureweight)
    with default_workers(workers):
        distance = _run(meshset, surface, filter)["qgeo_distance"]
    if colorize:
        set_colors(meshset, sequential(distance)(distance))
    return {"start_vertex": start, "maximum": float(distance[np.isfinite(distance)].max())}


def compute_scalar_by_quasi_geodesic_spectrum_per_vertex(
    meshset: Any,
    *,
    component: int = 0,
    k: int = EIGENPAIRS,
    curvatureweight: float = CURVATURE_WEIGHT,
    scalar: Scalar = "mean_curvature",
    colorize: bool = False,
    workers: int | None = None,
) -> dict[str, Any]:
    """Set the scalar to one eigenfunction of the quasi-geodesic distances.

    Parameters
    ----------
    component : int
        Which of the ``k`` eigenfunctions, from 0.
    k, curvatureweight, scalar
        See `qgeo_filters.QuasiGeodesicSpectrum`.
    colorize : bool
        Whether vertices are painted by the scalar, too: blue below zero, red above.
    workers : int, optional
        Number of threads; by default all cores that this process may use.

    Returns
    -------
    dict
        ``eigenvalues`` (k,) and ``eigenfunctions`` (n, k).
    """
    if not 0 <= component < k:
        raise ParameterError(f"component must lie between 0 and k - 1 = {k - 1}, got {component}")
    surface = as_surface(meshset)
    filter = QuasiGeodesicSpectrum(k=k, scalar=scalar, curvature_weight=curvatureweight)
    with default_workers(workers):
        _run(meshset, surface, filter, component)
    if colorize:
        shown = filter.spectrum_.eigenfunctions[:, component]
        set_colors(meshset, diverging(shown)(shown))
    return {
        "eigenvalues": filter.spectrum_.eigenvalues.copy(),
        "eigenfunctions": filter.spectrum_.eigenfunctions.copy(),
    }


def compute_scalar_by_lifted_metric_scalar_per_vertex(
    meshset: Any, *, scalar: Scalar = "mean_curvature", smoothing: float = 0.0
) -> dict[str, Any]:
    """Set the scalar to the function f that bends the metric, see `qgeo_filters.SurfaceScalar`."""
    _run(meshset, as_surface(meshset), SurfaceScalar(scalar=scalar, smoothing=smoothing))
    return {}


def compute_scalar_by_differential_norm_per_vertex(meshset: Any, *, weights: Any = "uniform") -> dict[str, Any]:
    """Set the scalar to the length of the differential coordinate, see `qgeo_filters.DifferentialCoordinates`."""
    surface = as_surface(meshset)
    delta = DifferentialCoordinates(weights=weights).compute(surface)["qgeo_delta"]
    set_scalar(meshset, "qgeo_differential_norm", np.linalg.norm(delta, axis=1))
    return {}


METHODS: tuple[Callable[..., dict[str, Any]], ...] = (
    compute_scalar_by_quasi_geodesic_distance_from_given_point_per_vertex,
    compute_scalar_by_quasi_geodesic_spectrum_per_vertex,
    compute_scalar_by_lifted_metric_scalar_per_vertex,
    compute_scalar_by_differential_norm_per_vertex,
    *meshlab_matching.METHODS,
)


def register_pymeshlab() -> list[str]:
    """Names of the methods that are bound to ``pymeshlab.MeshSet``; calling it twice does no harm.

    Raises
    ------
    MissingPackageError
        If PyMeshLab is not installed.

    Examples
    --------
    >>> import pymeshlab
    >>> names = qg.register_pymeshlab()
    >>> names[0]
    'compute_scalar_by_quasi_geodesic_distance_from_given_point_per_vertex'
    >>> all(hasattr(pymeshlab.MeshSet, name) for name in names)
    True
    """
    pymeshlab = require_package("pymeshlab", "meshlab", "register_pymeshlab")
    for method in METHODS:
        setattr(pymeshlab.MeshSet, method.__name__, method)
    return [method.__name__ for method in METHODS]


def _run(meshset: Any, surface: Surface, filter: Filter, component: int | None = None) -> Mapping[str, np.ndarray]:
    result = filter.compute(surface)
    ((name, values),) = result.items()
    set_scalar(meshset, name, values if component is None else values[:, component])
    return result
