"""Eigenspectrum of the quasi-geodesic distances of a surface (paper, sec. 3, eq. 2)."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import numpy as np

from qgeo_filters._deprecation import renamed_parameters
from qgeo_filters._typing import RepairOption
from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.metric import LiftedMetric, Metric, metric_for
from qgeo_filters.hosts.dispatch import SurfaceLike
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.spectral.given_vertices import spectrum_of_mesh
from qgeo_filters.spectral.landmarks import landmark_spectrum
from qgeo_filters.spectral.proxy_spectrum import proxy_spectrum
from qgeo_filters.spectral.spectrum import (
    Mass,
    Spectrum,
    check_areas,
    check_count,
    check_mass,
    spectrum_of_matrix,
)
from qgeo_filters.surface import Surface

#: What every argument ``landmarks`` of a spectrum takes.
Landmarks: TypeAlias = int | Literal["auto"] | None

#: Vertices up to which "auto" takes all distances.
ALL_DISTANCES_UP_TO = 12_000
# Landmarks beyond that, at least and for each eigenpair, and the accuracy of their distances: a tenth of what the
# landmarks miss.
_LANDMARKS, _PER_PAIR, _ACCURACY = 1000, 10, 1e-2


def is_represented(surface: Surface, landmarks: Landmarks) -> bool:
    """Whether a proxy or landmarks stand for the surface by themselves, because it is large."""
    return landmarks == "auto" and surface.n_vertices > ALL_DISTANCES_UP_TO


def checked_landmarks(landmarks: Landmarks) -> None:
    """Raise `ParameterError` unless it is a number, None or "auto"."""
    number = isinstance(landmarks, (int, np.integer)) and not isinstance(landmarks, bool)
    if not number and landmarks is not None and landmarks != "auto":
        raise ParameterError(f"landmarks must be 'auto', a number, or None for all distances, got {landmarks!r}")


@renamed_parameters(weights="mass")
def distance_spectrum(
    surface: SurfaceLike,
    k: int = 20,
    metric: Metric | None = "lifted",
    mass: Mass = "area",
    landmarks: Landmarks = "auto",
    *,
    matrix: Any = None,
    method: str = "graph",
    accuracy: float = 1e-3,
    repair: RepairOption = "auto",
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
    landmarks : "auto", int or None
        ``"auto"``: all distances of a surface of up to 12,000 vertices, or where their matrix is given. A larger one is
        represented by a proxy in its own metric, see `proxy_spectrum`; where a scalar lifts the metric, which is as
        fine as the mesh, by 1000 landmarks, their distances to an accuracy of .01.
        A number: distances from so many farthest points only, in memory O(n landmarks), see `landmark_spectrum`. None:
        all distances of a surface of any size. The result says which, in `Spectrum.approximation`.
    matrix : array-like or LinearOperator, shape (n, n), optional
        Distances in this metric, where they are at hand.
    method, accuracy, workers, progress
        How to compute them otherwise, as in `distances`.
    repair : bool, "auto" or "force"
        Whether the mesh is repaired first; by default, "auto", if it is not welded or would be refused. Eigenfunctions
        are on the vertices that were given, see `spectrum_on_given`. With a `LiftedMetric` or a matrix,
        which belong to their surface, "auto" repairs nothing.

    Returns
    -------
    Spectrum

    Raises
    ------
    MeshError
        Surface in several pieces, not manifold, or with a vertex of no area.
    TooLargeError
        The distances do not fit into memory.
    ParameterError
        k out of range; landmarks together with a matrix; the metric of another surface.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> spectrum = qg.distance_spectrum(surface, k=5)
    >>> spectrum.eigenfunctions.shape, spectrum.eigenvalues.round(2)
    ((162, 5), array([25.06, -6.99, -5.65, -5.57, -0.71]))
    >>> inner = spectrum.eigenfunctions.T @ (spectrum.areas[:, None] * spectrum.eigenfunctions)
    >>> np.allclose(inner, np.eye(5), atol=1e-6)
    True
    """
    if repair == "auto" and (isinstance(metric, LiftedMetric) or matrix is not None):
        repair = False

    def compute(mesh: Surface, _: Repair | None) -> Spectrum:
        return _spectrum(mesh, k, metric, mass, landmarks, matrix, method, accuracy, workers, progress)

    return spectrum_of_mesh(surface, repair, compute)


def _spectrum(
    surface: Surface,
    k: int,
    metric: Metric | None,
    mass: Mass,
    landmarks: Landmarks,
    matrix: Any,
    method: str,
    accuracy: float,
    workers: int | None,
    progress: bool,
) -> Spectrum:
    surface.require_connected("the spectrum of the distances")
    check_count(k, surface.n_vertices)
    check_areas(surface.vertex_areas)
    check_mass(mass)
    checked_landmarks(landmarks)
    if landmarks not in (None, "auto") and matrix is not None:
        raise ParameterError("landmarks stand for the matrix of distances: pass one or the other")
    if matrix is not None and not isinstance(metric, LiftedMetric):
        return spectrum_of_matrix(matrix, surface.vertex_areas, k, mass)  # a metric by name need not be made
    chosen = metric_for(surface, metric, "lifted")
    if matrix is None and is_represented(surface, landmarks):
        if chosen.curvature_weight == 0:
            return proxy_spectrum(
                surface, k, chosen, mass, method=method, accuracy=accuracy, workers=workers, progress=progress
            )
        landmarks, accuracy = min(max(_LANDMARKS, _PER_PAIR * k), surface.n_vertices), max(accuracy, _ACCURACY)
    if isinstance(landmarks, (int, np.integer)):
        return landmark_spectrum(
            surface, k, chosen, landmarks, mass, method=method, accuracy=accuracy, workers=workers, progress=progress
        )
    if matrix is None:
        matrix = distance_matrix(surface, chosen, method, accuracy=accuracy, workers=workers, progress=progress)
    return spectrum_of_matrix(matrix, surface.vertex_areas, k, mass)
