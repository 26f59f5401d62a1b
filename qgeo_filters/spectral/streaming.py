"""Spectrum of all distances of a surface whose matrix is never stored."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigh, qr

from qgeo_filters.geodesics.lifting import lifted_metric
from qgeo_filters.geodesics.metric import LiftedMetric
from qgeo_filters.geodesics.operator import DistanceOperator
from qgeo_filters.spectral.distance_spectrum import Spectrum, check_areas, check_count
from qgeo_filters.spectral.landmarks import landmark_spectrum
from qgeo_filters.surface import Surface

FloatArray = npt.NDArray[np.float64]

# Eigenfunctions carried beside the wanted ones, so that the last of these converge as well.
_MORE = 12


def streamed_spectrum(
    surface: Surface,
    k: int = 20,
    metric: LiftedMetric | None = None,
    *,
    landmarks: int = 500,
    passes: int = 2,
    accuracy: float = 1e-3,
    workers: int | None = None,
    progress: bool = False,
) -> Spectrum:
    r"""Spectrum of all distances in O(n) memory: the k eigenpairs of largest absolute value.

    Subspace iteration on :math:`A^{1/2} D A^{1/2}`, started from the spectrum of some landmarks. Each pass
    computes all rows of D once and multiplies by all vectors of the subspace, which costs what the matrix itself
    costs; the last pass also gives the Rayleigh quotients.

    Parameters
    ----------
    surface : Surface
        In one piece and manifold.
    k : int
        Number of eigenpairs; at most n.
    metric : LiftedMetric, optional
        Default: `lifted_metric` of the surface, as it is.
    landmarks : int
        Number of farthest points for the start, at most n; more than k + 12.
    passes : int
        Times that the distances are computed, at least 1. A pass shrinks the part of the subspace that is
        wrong by the ratio of the eigenvalues beyond it to those inside.
    accuracy, workers, progress
        As in `DistanceOperator`.

    Returns
    -------
    Spectrum
        Under area weights.

    Raises
    ------
    DisconnectedError, NonManifoldError, MeshError
        As in `distance_spectrum`.
    ValueError
        k, landmarks or passes out of range.

    References
    ----------
    Halko, Martinsson, Tropp, "Finding structure with randomness", SIAM Review 53(2), 2011, algorithms 4.4 and 5.3.
    """
    surface.require_connected("the spectrum of the distances")
    n = surface.n_vertices
    check_count(k, n)
    check_areas(surface.vertex_areas)
    if not isinstance(passes, (int, np.integer)) or passes < 1:
        raise ValueError(f"passes must be a whole number, at least 1, got {passes!r}")
    width = min(k + _MORE, n)
    if not width < landmarks <= n:
        raise ValueError(f"landmarks must be more than {width} and at most the {n} vertices, got {landmarks}")
    if metric is None:
        metric = lifted_metric(surface)
    start = landmark_spectrum(surface, width, metric, landmarks, accuracy=accuracy, progress=progress)
    root = np.sqrt(surface.vertex_areas)[:, None]
    operator = DistanceOperator(surface, metric, accuracy=accuracy, workers=workers, progress=progress)
    basis = root * start.eigenfunctions
    for _ in range(passes - 1):
        basis = qr(root * (operator @ (root * basis)), mode="economic")[0]
    image = root * (operator @ (root * basis))
    quotient = basis.T @ image
    values, vectors = eigh((quotient + quotient.T) / 2)
    largest = np.argsort(-np.abs(values), kind="stable")[:k]
    return Spectrum.of(values[largest], basis @ vectors[:, largest] / root, surface.vertex_areas)
