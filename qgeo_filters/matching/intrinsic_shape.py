"""What matching takes from distances and heat on a shape: the same for the shape and its image in a mirror."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.differential.curvature import mean_curvature
from qgeo_filters.geodesics.matrix import distance_matrix, distances
from qgeo_filters.geodesics.metric import LiftedMetric, lifted_metric
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.parallel import single_threaded_blas
from qgeo_filters.sampling import farthest_by_distances
from qgeo_filters.spectral.laplacian import laplacian_spectrum
from qgeo_filters.spectral.spectrum import Spectrum, spectrum_of_matrix
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen


@dataclass(frozen=True, eq=False)
class MetricEmbedding:
    """A unit-area shape in one metric.

    Attributes
    ----------
    curvature_weight : float
        Of mean curvature in the metric, see `lifted_metric`.
    eigenvalues : (k,) float64
        Of the distance operator, by decreasing absolute value.
    eigenfunctions : (n, k) float32
    spectrum : Spectrum
        The first 20 of them, in full precision.
    fps_distances : (r, n) float32
        From the first farthest points to all vertices.
    """

    curvature_weight: float
    eigenvalues: FloatArray
    eigenfunctions: SingleArray
    spectrum: Spectrum
    fps_distances: SingleArray


class IntrinsicShape:
    """Distances, spectra and farthest points of a surface; each on first use.

    Parameters
    ----------
    surface : Surface
    unit : Surface
        The same with unit area.
    parameters : MatchingParameters
    matrix : callable, optional
        See `PreparedShape`.
    progress : bool
    """

    def __init__(
        self,
        surface: Surface,
        unit: Surface,
        parameters: MatchingParameters,
        matrix: Callable[[LiftedMetric], npt.NDArray[np.float32]] | None = None,
        progress: bool = False,
    ) -> None:
        self.surface, self.unit, self.parameters = surface, unit, parameters
        self.scale = float(np.sqrt(surface.area))
        self.matrix = matrix
        self._progress = progress
        self._embeddings: dict[int, MetricEmbedding] = {}
        self._fps: IndexArray | None = None

    def restore(self, embeddings: Sequence[MetricEmbedding], fps: IndexArray, **known: Any) -> None:
        """Take what another process computed of the same surface: nothing of it is computed again.

        Parameters
        ----------
        embeddings : sequence of MetricEmbedding
            In all metrics.
        fps : (m,) int64
        **known : arrays and spectra
            Values of this object's other properties, by name.
        """
        self._embeddings = dict(enumerate(embeddings))
        self._fps = fps
        self.__dict__.update(known)  # where cached properties keep their values

    @property
    def _last(self) -> int:
        return len(self.parameters.curvature_weights) - 1

    @cached_property
    def areas(self) -> FloatArray:
        """Area of each vertex, (n,), summing to 1."""
        return self.unit.vertex_areas

    @cached_property
    def metric(self) -> LiftedMetric:
        """The first metric, on the surface in its own unit."""
        return lifted_metric(self.surface, curvature_weight=self.parameters.curvature_weights[0])

    def distances(self, sources: npt.ArrayLike) -> FloatArray:
        """Distances from some vertices to all in the first metric, (s, n)."""
        return distances(self.metric.surface, sources, self.metric) / self.scale

    def embedding(self, place: int) -> MetricEmbedding:
        """The shape in one of the metrics; the same farthest points in all."""
        place %= self._last + 1
        if place not in self._embeddings:
            if place != self._last and self._fps is None:
                self.embedding(self._last)  # it chooses the farthest points
            self._embeddings[place] = self._embedded(place)
        return self._embeddings[place]

    @property
    def fps(self) -> IndexArray:
        """Farthest points in the last metric, (m,) with m up to 2000, the vertex of largest mean distance first."""
        if self._fps is None:
            self.embedding(self._last)
        assert self._fps is not None
        return self._fps

    @cached_property
    def fps_distances(self) -> SingleArray:
        """Distances from the first farthest points to all vertices in the first metric, (r, n)."""
        if self._last == 0 or 0 in self._embeddings:
            return self.embedding(0).fps_distances
        return frozen(self.distances(self.fps[: self.parameters.fps_rows]).astype(np.float32))

    @cached_property
    def nearest_fps(self) -> IndexArray:
        """Place of the nearest of these farthest points, for each vertex, (n,)."""
        return frozen(self.fps_distances.argmin(axis=0))

    @cached_property
    @single_threaded_blas
    def laplacian_spectrum(self) -> Spectrum:
        """Eigenpairs of the Laplace-Beltrami operator, up to 200."""
        return laplacian_spectrum(self.unit, min(self.parameters.laplacian_functions, self.unit.n_vertices // 3))

    @cached_property
    def laplacian(self) -> SingleArray:
        """Its eigenfunctions in single precision, (n, up to 200)."""
        return frozen(self.laplacian_spectrum.eigenfunctions.astype(np.float32))

    @cached_property
    @single_threaded_blas
    def log_hks(self) -> FloatArray:
        """Heat kernel signature: logarithm of the heat kernel h(t; p, p) at each of ``hks_times``, (n, 3)."""
        squares = self.laplacian.astype(np.float64) ** 2
        decay = np.exp(-np.outer(self.laplacian_spectrum.eigenvalues, self.parameters.hks_times))
        return frozen(np.log(squares @ decay))

    @cached_property
    @single_threaded_blas
    def smoothed_mean_curvature(self) -> FloatArray:
        """Mean curvature after a little heat, (n,), in 1 / sqrt(area): fingers, ears, a nose."""
        limit = self.parameters.curvature_limit
        curvature = np.clip(mean_curvature(self.unit), -limit, limit)
        return frozen(self._heated(curvature, self.parameters.curvature_time))

    @cached_property
    @single_threaded_blas
    def relief(self) -> FloatArray:
        """Height over the surface after more heat, along the normal, (n,), in sqrt(area): what bulges, what is hollow.

        Unlike smoothed curvature, of which fingers and toes have the most, it knows the chest from the back, also of
        different people (benchmarks/README.md, "By what right and wrong maps are told").
        """
        smooth = self._heated(self.unit.vertices, self.parameters.relief_time)
        return frozen(np.einsum("ij,ij->i", self.unit.vertices - smooth, self.unit.vertex_normals))

    def _heated(self, values: FloatArray, time: float) -> FloatArray:
        """Values at the vertices, (n,) or (n, c), after some time of heat."""
        functions = self.laplacian.astype(np.float64)
        decay = np.exp(-self.laplacian_spectrum.eigenvalues * time)
        return np.asarray(functions @ (decay * (functions.T @ (self.areas * values.T).T).T).T)

    @single_threaded_blas
    def _embedded(self, place: int) -> MetricEmbedding:
        given, n = self.parameters, self.unit.n_vertices
        weight = given.curvature_weights[place]
        metric = self.metric if place == 0 else lifted_metric(self.surface, curvature_weight=weight)
        if self.matrix is None:
            matrix = distance_matrix(self.surface, metric, progress=self._progress)
        else:
            matrix = self.matrix(metric)
        k = min(given.distance_functions, n // 3)
        spectrum = spectrum_of_matrix(matrix, self.surface.vertex_areas, k, tolerance=given.eigen_tolerance)
        spectrum = self._in_unit_area(spectrum)
        if self._fps is None:
            self._fps = farthest_rows(matrix, self.areas, min(given.fps_count, n))
        return MetricEmbedding(
            weight,
            spectrum.eigenvalues,
            frozen(spectrum.eigenfunctions.astype(np.float32)),
            spectrum.truncated(min(given.spectrum_functions, k)),
            frozen(matrix[self._fps[: given.fps_rows]] / np.float32(self.scale)),
        )

    def _in_unit_area(self, spectrum: Spectrum) -> Spectrum:
        # The kernel is a length, the measure an area.
        return replace(
            spectrum,
            eigenvalues=frozen(spectrum.eigenvalues / self.scale**3),
            eigenfunctions=frozen(spectrum.eigenfunctions * self.scale),
            areas=self.areas,
        )


def farthest_rows(matrix: npt.NDArray[np.float32], areas: FloatArray, count: int) -> IndexArray:
    """Farthest points, shape (count,), from all distances: each is the farthest from those before it.

    The first is the vertex of largest mean distance, so that the numbering does not matter.
    """
    return frozen(farthest_by_distances(matrix, count, int((matrix @ areas.astype(np.float32)).argmax())))
