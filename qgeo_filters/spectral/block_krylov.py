"""Spectrum of all distances of a surface whose matrix is never stored."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import eigh

from qgeo_filters._typing import FloatArray, RepairOption
from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.geodesics.metric import LiftedMetric, Metric, metric_for
from qgeo_filters.geodesics.operator import DistanceOperator
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.spectral.given_vertices import spectrum_of_mesh
from qgeo_filters.spectral.landmarks import farthest_points
from qgeo_filters.spectral.spectrum import Spectrum, check_areas, check_count
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_count


def streamed_spectrum(
    surface: SurfaceLike,
    k: int = 20,
    metric: Metric | None = "lifted",
    *,
    landmarks: int = 1000,
    passes: int = 2,
    accuracy: float = 1e-3,
    repair: RepairOption = "auto",
    workers: int | None = None,
    progress: bool = False,
) -> Spectrum:
    r"""Spectrum of all distances in O(n) memory: the k eigenpairs of largest absolute value.

    Block Lanczos on :math:`K = A^{1/2} D A^{1/2}`: Rayleigh-Ritz over the span of :math:`V, K V, ..., K^{p-1} V` for p
    passes. Each pass computes all rows of D once and multiplies them by a block of 4 k + 20 vectors, which costs hardly
    more than computing them. V spans the leading left singular vectors of the columns of D at some landmarks. The
    images :math:`K x_i` of the k Ritz vectors are known at the end, and one step closer than the vectors:
    the result are the eigenpairs of :math:`\sum_i K x_i \gamma_i^{-1} (K x_i)^T`.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        In one piece and manifold.
    k : int
        Number of eigenpairs; at most n.
    metric : LiftedMetric, "lifted" or "cartesian"
        By name: `lifted_metric` of the surface as it is, or the surface's own metric.
    landmarks : int
        Number of farthest points for the start, at least k and at most n. Their rows are in memory, in float64.
    passes : int
        Times that the distances are computed, at least 1.
    accuracy, workers, progress
        As in `DistanceOperator`.
    repair : bool, "auto" or "force"
        Whether the mesh is repaired first; by default, "auto", if it is not welded or would be refused. Eigenfunctions
        are on the vertices that were given, see `spectrum_on_given`. With a `LiftedMetric`, which belongs
        to its surface, "auto" repairs nothing.

    Returns
    -------
    Spectrum
        Under area weights. Its `residuals` say how exact the Ritz pairs were.

    Raises
    ------
    DisconnectedError, NonManifoldError, MeshError
        As in `distance_spectrum`.
    ParameterError
        k, landmarks or passes out of range, the metric of another surface.

    References
    ----------
    Musco, Musco, "Randomized block Krylov methods for stronger and faster approximate singular value
    decomposition", NeurIPS 2015. Halko, Martinsson, Tropp, "Finding structure with randomness", SIAM Review 53(2),
    2011, sec. 5.5 (the last step, for matrices that are positive).

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> spectrum = qg.streamed_spectrum(surface, k=3, landmarks=60)
    >>> full = qg.distance_spectrum(surface, k=3)
    >>> np.allclose(spectrum.eigenvalues, full.eigenvalues, rtol=1e-3)
    True
    >>> bool((spectrum.residuals < 1e-2).all())
    True
    """
    if repair == "auto" and isinstance(metric, LiftedMetric):
        repair = False

    def compute(mesh: Surface, _: Repair | None) -> Spectrum:
        chosen = metric_for(mesh, metric, "lifted")
        *__, spectrum = spectrum_by_pass(
            mesh, k, chosen, landmarks=landmarks, passes=passes, accuracy=accuracy, workers=workers, progress=progress
        )
        return spectrum

    return spectrum_of_mesh(surface, repair, compute)


def spectrum_by_pass(
    surface: SurfaceLike,
    k: int,
    metric: Metric | None = "lifted",
    *,
    landmarks: int = 1000,
    passes: int = 2,
    accuracy: float = 1e-3,
    workers: int | None = None,
    progress: bool = False,
) -> Iterator[Spectrum]:
    """What `streamed_spectrum` knows after each pass: stop when the residuals are small enough."""
    surface = as_surface(surface)
    surface.require_connected("the spectrum of the distances")
    n = surface.n_vertices
    check_count(k, n)
    check_areas(surface.vertex_areas)
    passes = checked_count(passes, 1, None, "passes")
    if not k <= landmarks <= n:
        raise ParameterError(f"landmarks must be at least k, {k}, and at most the {n} vertices, got {landmarks}")
    metric = metric_for(surface, metric, "lifted")
    operator = DistanceOperator(surface, metric, accuracy=accuracy, workers=workers, progress=progress)
    # Free of the unit of length, so that no scale leaves the range of float32.
    root = np.sqrt(surface.vertex_areas / surface.area)[:, None]
    # Spread by the surface's own metric: the farthest points of a rough one are the tips of its spikes.
    points = farthest_points(surface, landmarks)
    rows = distances(surface, points, metric, accuracy=accuracy, workers=workers, progress=progress)
    block = _leading_range(rows, surface.vertex_areas, min(4 * k + 20, landmarks))
    del rows  # the largest array there is
    basis = images = np.empty((n, 0))
    for _ in range(passes):
        block = _orthonormal_beside(basis, block)
        basis = np.column_stack([basis, block])
        block = root * (operator @ (root * block).astype(np.float32))
        images = np.column_stack([images, block])
        values, vectors, residuals = _eigenpairs(basis, images, k)
        functions = vectors / (root * np.sqrt(surface.area))
        yield Spectrum.of(values * surface.area, functions, surface.vertex_areas, residuals)
        if basis.shape[1] == n:
            return  # nothing is left to find


def _eigenpairs(basis: FloatArray, images: FloatArray, k: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Eigenvalues, orthonormal eigenvectors and residuals of the k leading Ritz pairs, taken one step on.

    The sum of y y^T / value over the images y of the Ritz vectors has the eigenvectors that the next multiplication
    would give.
    """
    quotient = basis.T @ images
    values, turn = eigh((quotient + quotient.T) / 2)
    largest = np.argsort(-np.abs(values), kind="stable")[:k]
    values, turn = values[largest], turn[:, largest]
    stepped = images @ turn
    residuals = np.linalg.norm(stepped - basis @ turn * values, axis=0) / np.abs(values)
    basis, triangle = np.linalg.qr(stepped)
    small = triangle @ (triangle / values).T
    values, turn = eigh((small + small.T) / 2)
    order = np.argsort(-np.abs(values), kind="stable")
    return values[order], basis @ turn[:, order], residuals


def _leading_range(rows: FloatArray, areas: FloatArray, width: int) -> FloatArray:
    """Leading left singular vectors (n, width) of sampled columns of K, not normalised; overwrites the rows (m, n).

    A column counts with the area of its landmark's Voronoi cell, so that C C^T is K^2 by quadrature. The columns
    have the roughness of the metric at every vertex, which no interpolation from landmarks can give.
    """
    cells = np.bincount(rows.argmin(axis=0), areas, minlength=len(rows))
    rows *= np.sqrt(cells)[:, None]
    rows *= np.sqrt(areas)
    turn = eigh(rows @ rows.T)[1]
    return rows.T @ turn[:, : -width - 1 : -1]


def _orthonormal_beside(basis: FloatArray, block: FloatArray) -> FloatArray:
    """Orthonormal vectors, orthogonal to the basis (n, j), that span with it what it spans with the block.

    At most n - j of them.
    """
    beside = block[:, : len(basis) - basis.shape[1]]
    for _ in range(2):  # the first time leaves the rounding errors of what cancels
        beside = np.linalg.qr(beside - basis @ (basis.T @ beside))[0]
    return beside
