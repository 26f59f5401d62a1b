"""Filters of the descriptors: eigenspectrum of the quasi-geodesic distances, and the Laplacian's beside it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from qgeo_filters.defaults import CURVATURE_WEIGHT, EIGENPAIRS
from qgeo_filters.differential.scalar import Scalar
from qgeo_filters.filters import stages
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.geodesics import MetricFilter
from qgeo_filters.filters.registry import registered
from qgeo_filters.spectral.distance_spectrum import Landmarks
from qgeo_filters.spectral.spectrum import Mass, Spectrum
from qgeo_filters.surface import Surface


@registered
class QuasiGeodesicSpectrum(MetricFilter):
    """Adds the first eigenfunctions of the all-pairs quasi-geodesic distances, the paper's shape descriptor.

    Parameters
    ----------
    k : int
        Number of eigenpairs, by decreasing absolute eigenvalue.
    mass : {"area", "uniform"}
        Eigenproblem of the integral operator, or of the plain matrix (paper, eq. (2)).
    landmarks : "auto", int or None
        ``"auto"``: all distances on a mesh of up to 12,000 vertices, a proxy for a larger one. A number: so many
        farthest points stand for all. None: all distances in any case. See `distance_spectrum`.
    scalar, curvature_weight, smoothing, method, accuracy
        See `MetricFilter`.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> filter = qg.QuasiGeodesicSpectrum(k=5)
    >>> filter(surface).attributes["qgeo_phi"].shape, filter.spectrum_.eigenvalues.shape
    ((162, 5), (5,))
    """

    outputs = {"qgeo_phi": "(n, k), 1/length: eigenfunctions of the distance operator, orthonormal over the area"}

    renamed = {"weights": "mass"}

    spectrum_: Spectrum
    """Eigenvalues and eigenfunctions of the last call."""

    def __init__(
        self,
        *,
        k: int = EIGENPAIRS,
        scalar: Scalar = "mean_curvature",
        curvature_weight: float = CURVATURE_WEIGHT,
        mass: Mass = "area",
        landmarks: Landmarks = "auto",
        smoothing: float = 0.0,
        method: str = "graph",
        accuracy: float = 1e-3,
    ) -> None:
        super().__init__(
            scalar=scalar, curvature_weight=curvature_weight, smoothing=smoothing, method=method, accuracy=accuracy
        )
        self.k = k
        self.mass = mass
        self.landmarks = landmarks

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Eigenfunctions by attribute name."""
        self.spectrum_ = stages.spectrum_of(
            self._metric(surface), self.k, self.mass, self.landmarks, self.method, self.accuracy, progress
        )
        return {"qgeo_phi": self.spectrum_.eigenfunctions}


@registered
class LaplacianSpectrum(Filter):
    """Adds the first eigenfunctions of the Laplace-Beltrami operator, for comparison.

    Parameters
    ----------
    k : int
        Number of eigenpairs, by increasing eigenvalue, the constant one included.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> qg.LaplacianSpectrum(k=5)(surface).attributes["qgeo_laplacian_phi"].shape
    (162, 5)
    """

    outputs = {"qgeo_laplacian_phi": "(n, k), 1/length: eigenfunctions of the Laplace-Beltrami operator"}

    spectrum_: Spectrum
    """Eigenvalues and eigenfunctions of the last call."""

    def __init__(self, *, k: int = EIGENPAIRS) -> None:
        self.k = k

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Eigenfunctions by attribute name."""
        self.spectrum_ = stages.laplacian_spectrum_of(surface, self.k)
        return {"qgeo_laplacian_phi": self.spectrum_.eigenfunctions}
