"""Eigenspectrum of the quasi-geodesic distances of a surface (paper, sec. 3, eq. 2)."""

from __future__ import annotations

from typing import Any

from qgeo_filters._deprecation import renamed_parameters
from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.metric import LiftedMetric, Metric, metric_for
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.spectral.landmarks import landmark_spectrum
from qgeo_filters.spectral.spectrum import (
    Mass,
    Spectrum,
    check_areas,
    check_count,
    check_mass,
    spectrum_of_matrix,
)


@renamed_parameters(weights="mass")
def distance_spectrum(
    surface: SurfaceLike,
    k: int = 20,
    metric: Metric | None = "lifted",
    mass: Mass = "area",
    landmarks: int | None = None,
    *,
    matrix: Any = None,
    method: str = "graph",
    accuracy: float = 1e-3,
    workers: int | None = None,
    progress: bool = False,
) -> Spectrum:
    r"""Spectrum of the quasi-geodesic distances of a surface: the k eigenpairs of largest absolute value.

    The operator is :math:`(K f)(p) = \int d(p, q) f(q) \, dA(q)`, see `spectrum_of_matrix`.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        In one piece and manifold.
    k : int
        Number of eigenpairs.
    metric : LiftedMetric, "lifted" or "cartesian"
        By name: `lifted_metric` of the surface as it is, or the surface's own metric.
    mass : {"area", "uniform"}
        ``"area"``: the operator above, which two triangulations share. ``"uniform"``: the paper's plain matrix,
        eq. (2).
    landmarks : int, optional
        Distances from this many farthest points only, in memory O(n landmarks); see `landmark_spectrum`.
    matrix : array-like or LinearOperator, shape (n, n), optional
        Distances in this metric, where they are at hand.
    method, accuracy, workers, progress
        How to compute them otherwise, as in `distances`.

    Returns
    -------
    Spectrum

    Raises
    ------
    MeshError
        Surface in several pieces, not manifold, or with a vertex of no area.
    ParameterError
        k out of range; landmarks together with a matrix; the metric of another surface.
    """
    surface = as_surface(surface)
    surface.require_connected("the spectrum of the distances")
    check_count(k, surface.n_vertices)
    check_areas(surface.vertex_areas)
    check_mass(mass)
    if landmarks is not None and matrix is not None:
        raise ParameterError("landmarks stand for the matrix of distances: pass one or the other")
    if matrix is not None and not isinstance(metric, LiftedMetric):
        return spectrum_of_matrix(matrix, surface.vertex_areas, k, mass)  # a metric by name need not be made
    chosen = metric_for(surface, metric, "lifted")
    if landmarks is not None:
        return landmark_spectrum(
            surface, k, chosen, landmarks, mass, method=method, accuracy=accuracy, workers=workers, progress=progress
        )
    if matrix is None:
        matrix = distance_matrix(surface, chosen, method, accuracy=accuracy, workers=workers, progress=progress)
    return spectrum_of_matrix(matrix, surface.vertex_areas, k, mass)
