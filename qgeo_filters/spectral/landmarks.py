"""Spectrum of the distances from those of some landmarks, in memory O(n landmarks)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy.sparse.linalg import LinearOperator

from qgeo_filters._deprecation import renamed_parameters
from qgeo_filters._typing import FloatArray, IndexArray, RepairOption
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.geodesics.metric import LiftedMetric, Metric, metric_for
from qgeo_filters.geodesics.solver import GeodesicSolver
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.sampling import farthest_on_edges
from qgeo_filters.spectral.biharmonic import Product, biharmonic_interpolation
from qgeo_filters.spectral.given_vertices import spectrum_of_mesh
from qgeo_filters.spectral.proxies import interpolation_over_proxy
from qgeo_filters.spectral.spectrum import (
    Mass,
    Spectrum,
    check_areas,
    check_count,
    check_mass,
    spectrum_of_matrix,
)
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_count, checked_indices, listed

#: Vertices up to which the interpolation is factorised on the surface itself, and those of the proxy for larger ones.
FACTORISED_UP_TO, PROXY_VERTICES = 40_000, 10_000


def farthest_points(
    surface: SurfaceLike, count: int, metric: Metric | None = "cartesian", *, start: int | None = None
) -> IndexArray:
    """Vertices spread evenly over the surface, each the farthest from those before it, shape (count,).

    Distances are those along the edges, which are enough to spread by and cost far less than geodesics.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        In one piece.
    count : int
        Number of points, at most n. The first points of a longer sequence are the shorter one.
    metric : LiftedMetric, "cartesian" or "lifted"
        By name: the surface's own metric, or `lifted_metric` as it is.
    start : int, optional
        First point; the vertex farthest from the centroid by default, which does not depend on the numbering.

    Raises
    ------
    DisconnectedError
        Surface in several pieces.
    ParameterError, MeshError
        ``count`` or ``start`` out of range, the metric of another surface.

    References
    ----------
    Gonzalez, "Clustering to minimize the maximum intercluster distance", 1985: the covering radius is at
    most twice the best.
    """
    surface = as_surface(surface)
    surface.require_connected("farthest point sampling")
    metric = metric_for(surface, metric, "cartesian")
    if start is None:
        centroid = surface.vertex_areas @ surface.vertices / surface.area
        start = int(np.linalg.norm(surface.vertices - centroid, axis=1).argmax())
    return farthest_on_edges(surface.edges, metric.edge_lengths, surface.n_vertices, count, start)


@renamed_parameters(weights="mass")
def landmark_spectrum(
    surface: SurfaceLike,
    k: int = 20,
    metric: Metric | None = "lifted",
    landmarks: int | npt.ArrayLike = 1000,
    mass: Mass = "area",
    *,
    method: str = "graph",
    accuracy: float = 1e-3,
    repair: RepairOption = "auto",
    workers: int | None = None,
    progress: bool = False,
) -> Spectrum:
    """Spectrum of the distances, approximated from those between some landmarks and all vertices.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    k : int
        Number of eigenpairs.
    metric : LiftedMetric, "lifted" or "cartesian"
        By name: `lifted_metric` of the surface as it is, or the surface's own metric.
    landmarks : int or array-like of int
        How many farthest points, or which vertices; more than k. With 1000 the span of the first twenty
        eigenfunctions is off by a sine of .005 to .03, with 500 of .02 to .11 (`benchmarks/spectrum_landmarks.py`).
        A number of them on a surface of more than 40,000 vertices is spread over a proxy of it, which the interpolation
        between them goes through as well: its equations on the surface itself would take gigabytes.
    mass : {"area", "uniform"}
        As in `spectrum_of_matrix`.
    method, accuracy, workers, progress
        As in `distances`.
    repair : bool, "auto" or "force"
        Whether the mesh is repaired first; by default, "auto", if it is not welded or would be refused. Eigenfunctions
        are on the vertices that were given, see `spectrum_on_given`. With a `LiftedMetric`, which belongs
        to its surface, "auto" repairs nothing.

    Returns
    -------
    Spectrum

    See Also
    --------
    landmark_operator : the approximation, its error and its cost.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> full, few = qg.distance_spectrum(surface, k=3), qg.landmark_spectrum(surface, k=3, landmarks=60)
    >>> bool((np.abs(few.eigenvalues / full.eigenvalues - 1) < 0.1).all())
    True
    """
    if repair == "auto" and isinstance(metric, LiftedMetric):
        repair = False

    def compute(mesh: Surface, mended: Repair | None) -> Spectrum:
        there = landmarks
        if mended is not None and np.ndim(landmarks):
            given = checked_indices(np.asarray(landmarks), len(mended.vertex_of_original), "landmarks")
            there = mended.vertex_of_original[given]
            if (there < 0).any():
                gone = listed(given[there < 0])
                raise MeshError(f"landmarks: {gone} had to go when the mesh was repaired ({'; '.join(mended.report)})")
        return _spectrum(mesh, k, metric, there, mass, method, accuracy, workers, progress)

    return spectrum_of_mesh(surface, repair, compute)


def _spectrum(
    surface: Surface,
    k: int,
    metric: Metric | None,
    landmarks: int | npt.ArrayLike,
    mass: Mass,
    method: str,
    accuracy: float,
    workers: int | None,
    progress: bool,
) -> Spectrum:
    surface.require_connected("the spectrum of the distances")
    check_count(k, surface.n_vertices)
    check_areas(surface.vertex_areas)
    check_mass(mass)
    metric = metric_for(surface, metric, "lifted")
    number = np.asarray(landmarks).item() if np.ndim(landmarks) == 0 else None
    interpolation = None
    if number is None:
        points = checked_indices(landmarks, surface.n_vertices, "landmarks")
    elif surface.n_vertices <= FACTORISED_UP_TO:
        points = farthest_points(surface, number, metric)
    else:
        number = checked_count(number, 1, PROXY_VERTICES, "landmarks", f"the {PROXY_VERTICES} vertices of a proxy")
        points, *interpolation = interpolation_over_proxy(metric, number, PROXY_VERTICES)
    if len(points) <= k:
        raise ParameterError(f"{k} eigenpairs need more landmarks than that, got {len(points)}")
    solver = GeodesicSolver(surface, metric, method, accuracy=accuracy, workers=workers)
    operator = landmark_operator(
        metric, points, solver.single_distances(points, progress=progress), interpolation=interpolation
    )
    found = spectrum_of_matrix(operator, surface.vertex_areas, k, mass)
    return replace(found, approximation=f"{len(points)} landmarks")


def landmark_operator(
    metric: LiftedMetric,
    landmarks: npt.ArrayLike,
    rows: npt.ArrayLike,
    *,
    interpolation: Sequence[Product] | None = None,
) -> LinearOperator:
    r"""Symmetric approximation of the distance matrix (n, n) from the rows of m landmarks.

    With R the rows (m, n), G = R at the landmarks (m, m), and W the interpolation (n, m) that carries
    values at the landmarks to the surface,

    .. math:: D \approx W R + R^T W^T - W G W^T,

    which differs from D by :math:`(I - P) D (I - P^T)`, P being the interpolation of a function from its values at
    the landmarks: the product of two interpolation errors. The rows of the landmarks are reproduced. W is
    biharmonic in the metric, :math:`\min \int (\Delta f)^2` for given values, and is never formed: each product with it
    is one sparse solve.

    Parameters
    ----------
    metric : LiftedMetric
    landmarks : array-like of int, shape (m,)
        Different vertices.
    rows : array-like, shape (m, n)
        Distances in this metric from each landmark to all vertices; kept as float32.
    interpolation : pair of callables, optional
        Products with W and with its transpose; `biharmonic_interpolation` by default.

    Returns
    -------
    LinearOperator
        Symmetric, float64, memory O(m n), a product costs O(m n).

    Raises
    ------
    ValueError
        A landmark that is named twice, or rows of another shape.

    Notes
    -----
    The Nystrom extension, :math:`W = R^T G^{-1}`, inverts an indefinite matrix and finds eigenvalues of the wrong
    sign; a quadrature over the landmarks' Voronoi cells is ten times less accurate. Interpolation of both arguments,
    :math:`W G W^T` alone, smooths the cone of the distance at its source; the one-sided terms give it back.

    References
    ----------
    Shamai, Zibulevsky, Kimmel, "Efficient inter-geodesic distance computation and fast classical scaling",
    TPAMI 2020 (:math:`W G W^T`).
    """
    surface = metric.surface
    n = surface.n_vertices
    points = checked_indices(landmarks, n, "landmarks")
    if len(np.unique(points)) < len(points):
        raise ParameterError("the landmarks must be different vertices")
    table = np.asarray(rows, dtype=np.float32)
    if table.shape != (len(points), n):
        raise ParameterError(f"rows must have shape {(len(points), n)}, got {table.shape}")
    between = table[:, points].astype(np.float64)
    between = (between + between.T) / 2
    spread, gathered = biharmonic_interpolation(metric, points) if interpolation is None else interpolation

    def product(x: FloatArray) -> FloatArray:
        columns = np.asarray(x, dtype=np.float64).reshape(n, -1)
        weights = gathered(columns)
        at_landmarks = (table @ columns.astype(np.float32)).astype(np.float64) - between @ weights
        return (table.T @ weights.astype(np.float32) + spread(at_landmarks)).reshape(np.shape(x))

    return LinearOperator((n, n), matvec=product, matmat=product, rmatvec=product, rmatmat=product, dtype=np.float64)
