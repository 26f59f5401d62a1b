"""Filters of the self-symmetry."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from qgeo_filters.differential.scalar import Scalar
from qgeo_filters.filters import stages
from qgeo_filters.filters.base import registered
from qgeo_filters.filters.geodesics import Method, MetricFilter
from qgeo_filters.matching.symmetry_measure import Reading, symmetry_epsilon, symmetry_regions, symmetry_sum
from qgeo_filters.spectral.distance_spectrum import Spectrum
from qgeo_filters.surface import Surface


@registered
class SelfSymmetry(MetricFilter):
    """Adds the self-symmetry measure of eq. (3) and its regions of points that may be mirror images of each other.

    Parameters
    ----------
    k0 : int
        Number of eigenfunctions in the sum; the paper takes at most 20.
    n_regions : int
        Number of regions, of equal area.
    reading : {"absolute", "even", "printed"}
        How the sum is read, see `symmetry_sum`.
    scalar, curvature_weight, smoothing, method, accuracy
        See `MetricFilter`.
    """

    outputs = {
        "qgeo_symmetry_sum": "(n,), no unit: sum of eq. (3); mirror images have nearly equal values",
        "qgeo_symmetry_region": "(n,) int32 from 0: band of equal area of that sum",
    }

    spectrum_: Spectrum
    """Spectrum of the last call."""

    epsilon_: float
    """Root mean square difference of the sum over all pairs of points, see `symmetry_epsilon`."""

    def __init__(
        self,
        k0: int = 20,
        n_regions: int = 8,
        reading: Reading = "absolute",
        scalar: Scalar = "mean_curvature",
        curvature_weight: float = 0.03,
        smoothing: float = 0.0,
        method: Method = "graph",
        accuracy: float = 1e-3,
    ) -> None:
        super().__init__(scalar, curvature_weight, smoothing, method, accuracy)
        self.k0 = k0
        self.n_regions = n_regions
        self.reading = reading

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Measure and regions by attribute name."""
        self.spectrum_ = stages.spectrum_of(
            self._metric(surface), self.k0, "area", None, self.method, self.accuracy, progress
        )
        self.epsilon_ = symmetry_epsilon(self.spectrum_, k0=self.k0, reading=self.reading)
        return {
            "qgeo_symmetry_sum": symmetry_sum(self.spectrum_, self.k0, self.reading),
            "qgeo_symmetry_region": symmetry_regions(self.spectrum_, self.n_regions, k0=self.k0, reading=self.reading),
        }
