"""What matching needs to know of a shape, computed once and used against any number of others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.defaults import CURVATURE_WEIGHT
from qgeo_filters.deformation.arap import Rigidity
from qgeo_filters.differential.curvature import mean_curvature
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.geodesics.matrix import distance_matrix, distances
from qgeo_filters.geodesics.metric import LiftedMetric, lifted_metric
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.sampling import farthest_by_distances
from qgeo_filters.spectral.laplacian import laplacian_spectrum
from qgeo_filters.spectral.spectrum import Spectrum, check_areas, spectrum_of_matrix
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

#: Weights of mean curvature in the metrics that propose maps: the surface's own metric and two lifted ones; their
#: proposals differ. The last is that of the paper's functions.
METRIC_WEIGHTS = (0.0, 0.03, CURVATURE_WEIGHT)
#: Times of heat, in units of the area: a paw, a limb and a half of the shape.
HEAT_TIMES = (0.003, 0.01, 0.03)
#: Fewest vertices of a shape that can be matched: the search needs more points than eigenfunctions.
MINIMUM_VERTICES = 60
# Time of heat, in units of the area, over which the relief is smoothed: a breast, a muzzle. Curvatures beyond this, in
# 1 / sqrt(area), are those of fingers and ears, and of noise.
_RELIEF_TIME, _SHARPEST = 0.001, 30.0
# Eigenfunctions of the distances and of the Laplacian, and farthest points.
_DISTANCE_FUNCTIONS = 100
_LAPLACIAN_FUNCTIONS = 200
# Residual of the last of them, as a fraction of the eigenvalue; the first 20 come out as exact as float32 distances.
_TOLERANCE = 1e-3
# The paper's k0.
_PAPER_FUNCTIONS = 20
_SAMPLES = 2000
# Farthest points whose distances to all vertices are kept.
_ROWS = 800
# Ratio of areas up to which shapes count as of one size.
_SAME_AREA = 1.1


@dataclass(frozen=True, eq=False)
class MetricView:
    """A unit-area shape in one metric.

    Attributes
    ----------
    weight : float
        Weight of mean curvature in the metric, see `lifted_metric`.
    eigenvalues : (k,) float64
        Of the distance operator, by decreasing absolute value.
    eigenfunctions : (n, k) float32
    spectrum : Spectrum
        The first 20 of them, in full precision.
    rows : (r, n) float32
        Distances from the first farthest points to all vertices.
    """

    weight: float
    eigenvalues: FloatArray
    eigenfunctions: SingleArray
    spectrum: Spectrum
    rows: SingleArray


class PreparedShape:
    """A shape prepared for matching: unit-area copy, distances, spectra, farthest points; each on first use.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        Manifold, in one piece, oriented.
    weights : sequence of float
        Weights of mean curvature in the metrics that propose maps.
    matrix : callable, optional
        Takes a `LiftedMetric` of the surface, returns the distances between all vertices, shape (n, n), in the unit of
        the surface: for callers who have them or want to keep them. `distance_matrix` by default.
    progress : bool
        Whether to show a progress bar over the distances.

    Raises
    ------
    MeshError
        Surface not manifold, in several pieces, not orientable, with a vertex of no area, or of fewer than 60
        vertices.

    Notes
    -----
    Memory is O(800 n): the matrix of all distances is dropped once it has been used. Distances are measured on the
    surface as it is, and what is derived from them is brought to unit area.
    """

    def __init__(
        self,
        surface: SurfaceLike,
        *,
        weights: Sequence[float] = METRIC_WEIGHTS,
        matrix: Callable[[LiftedMetric], npt.NDArray[np.float32]] | None = None,
        progress: bool = False,
    ) -> None:
        surface = as_surface(surface)
        check_matchable(surface)
        if not weights:
            raise ParameterError("at least one metric must propose maps: weights is empty")
        self.surface = surface
        self.weights = tuple(float(weight) for weight in weights)
        self.scale = float(np.sqrt(surface.area))
        centre = surface.vertex_areas @ surface.vertices / surface.area
        self.unit = Surface((surface.vertices - centre) / self.scale, surface.faces)
        self._matrix = matrix
        self._progress = progress

    def __repr__(self) -> str:
        return f"PreparedShape({self.surface!r}, weights={self.weights})"

    @classmethod
    def of(cls, shape: SurfaceLike | PreparedShape, progress: bool = False) -> PreparedShape:
        """The descriptor itself, or that of a surface."""
        return shape if isinstance(shape, PreparedShape) else cls(shape, progress=progress)

    def prepared(self) -> PreparedShape:
        """The same descriptor, with everything that matching takes from it computed now."""
        # Cached properties: looking at one computes it.
        for name in ("views", "laplacian", "normals", "heat_kernels", "relief"):
            getattr(self, name)
        return self

    @property
    def n_vertices(self) -> int:
        """Number of vertices."""
        return self.unit.n_vertices

    @cached_property
    def areas(self) -> FloatArray:
        """Area of each vertex, (n,), summing to 1."""
        return self.unit.vertex_areas

    @cached_property
    def normals(self) -> FloatArray:
        """Angle-weighted unit normals, (n, 3)."""
        return self.unit.vertex_normals

    @cached_property
    def metric(self) -> LiftedMetric:
        """The first metric, on the surface in its own unit."""
        return lifted_metric(self.surface, curvature_weight=self.weights[0])

    def distances(self, sources: npt.ArrayLike) -> FloatArray:
        """Distances from some vertices to all in the first metric, (s, n)."""
        return distances(self.metric.surface, sources, self.metric) / self.scale

    @cached_property
    def views(self) -> tuple[MetricView, ...]:
        """The shape in each metric; the same farthest points in all."""
        return tuple(self._view(weight) for weight in self.weights)

    @cached_property
    def samples(self) -> IndexArray:
        """Farthest points, (m,) with m up to 2000, the vertex of largest mean distance first."""
        if not self.views:  # the first view chooses them, with all distances at hand
            raise AssertionError("a descriptor has at least one metric")
        return self._samples

    @cached_property
    def rows(self) -> SingleArray:
        """Distances from the first farthest points to all vertices in the first metric, (r, n)."""
        return self.views[0].rows

    @cached_property
    def laplacian(self) -> SingleArray:
        """Eigenfunctions of the Laplace-Beltrami operator, (n, up to 200)."""
        count = min(_LAPLACIAN_FUNCTIONS, self.n_vertices // 3)
        spectrum = laplacian_spectrum(self.unit, count)
        self._laplacian_eigenvalues = spectrum.eigenvalues
        return frozen(spectrum.eigenfunctions.astype(np.float32))

    @property
    def laplacian_eigenvalues(self) -> FloatArray:
        """Their eigenvalues."""
        if not self.laplacian.size:  # computed together
            raise AssertionError("a matchable shape has eigenfunctions")
        return self._laplacian_eigenvalues

    @cached_property
    def heat_kernels(self) -> FloatArray:
        """Logarithm of the heat kernel h(t; p, p) at each of ``HEAT_TIMES``, (n, 3)."""
        squares = self.laplacian.astype(np.float64) ** 2
        return frozen(np.log(squares @ np.exp(-np.outer(self.laplacian_eigenvalues, HEAT_TIMES))))

    @cached_property
    def relief(self) -> FloatArray:
        """Smoothed mean curvature, (n,), in units of 1 / sqrt(area): what bulges and what is hollow."""
        curvature = np.clip(mean_curvature(self.unit), -_SHARPEST, _SHARPEST)
        functions = self.laplacian.astype(np.float64)
        decay = np.exp(-_RELIEF_TIME * self.laplacian_eigenvalues)
        return frozen(functions @ (decay * (functions.T @ (self.areas * curvature))))

    @cached_property
    def rigidity(self) -> Rigidity:
        """Its as-rigid-as-possible deformation."""
        return Rigidity(self.unit.vertices, self.unit.faces)

    @cached_property
    def mirrored(self) -> PreparedShape:
        """Its image in a mirror, vertex by vertex: intrinsically the same, and nothing is computed again."""
        other = object.__new__(PreparedShape)
        other.__dict__.update({key: value for key, value in self.__dict__.items() if key not in _EXTRINSIC})
        # Reflected faces turn over, so that normals keep pointing out.
        flip = np.array([-1.0, 1.0, 1.0])
        other.surface = Surface(self.surface.vertices * flip, self.surface.faces[:, ::-1])
        other.unit = Surface(self.unit.vertices * flip, self.unit.faces[:, ::-1])
        for name in ("metric", "views", "samples", "rows", "laplacian", "areas"):
            other.__dict__[name] = getattr(self, name)
        other._samples = self._samples
        other._laplacian_eigenvalues = self._laplacian_eigenvalues
        return other

    def _view(self, weight: float) -> MetricView:
        metric = self.metric if weight == self.weights[0] else lifted_metric(self.surface, curvature_weight=weight)
        if self._matrix is None:
            matrix = distance_matrix(self.surface, metric, progress=self._progress)
        else:
            matrix = self._matrix(metric)
        k = min(_DISTANCE_FUNCTIONS, self.n_vertices // 3)
        spectrum = self._in_unit_area(spectrum_of_matrix(matrix, self.surface.vertex_areas, k, tolerance=_TOLERANCE))
        if "_samples" not in self.__dict__:
            self._samples = farthest_rows(matrix, self.areas, min(_SAMPLES, self.n_vertices))
        return MetricView(
            weight,
            spectrum.eigenvalues,
            frozen(spectrum.eigenfunctions.astype(np.float32)),
            spectrum.truncated(min(_PAPER_FUNCTIONS, k)),
            frozen(matrix[self._samples[:_ROWS]] / np.float32(self.scale)),
        )

    def _in_unit_area(self, spectrum: Spectrum) -> Spectrum:
        # The kernel is a length, the measure an area.
        return replace(
            spectrum,
            eigenvalues=frozen(spectrum.eigenvalues / self.scale**3),
            eigenfunctions=frozen(spectrum.eigenfunctions * self.scale),
            areas=self.areas,
        )


_EXTRINSIC = ("surface", "unit", "normals", "rigidity", "mirrored")


def check_matchable(surface: Surface) -> None:
    """Raise `MeshError`, saying why, for a surface that cannot be matched."""
    surface.require_manifold("matching")
    surface.require_connected("matching")
    if not surface.is_oriented:
        raise MeshError(
            "matching tells a shape from its mirror image by the orientation of its faces, but neighbouring faces "
            "disagree; repair=True turns them, unless the surface is one-sided"
        )
    check_areas(surface.vertex_areas)
    if surface.n_vertices < MINIMUM_VERTICES:
        raise MeshError(f"matching needs at least {MINIMUM_VERTICES} vertices, got {surface.n_vertices}")


def check_same_size(x: Surface, y: Surface) -> None:
    """Raise `ValueError` for shapes whose areas differ by more than a tenth."""
    if not 1 / _SAME_AREA <= x.area / y.area <= _SAME_AREA:
        raise ParameterError(
            f"the areas are {x.area:.6g} and {y.area:.6g}: shapes of different size are compared with normalize=True"
        )


def farthest_rows(matrix: npt.NDArray[np.float32], areas: FloatArray, count: int) -> IndexArray:
    """Farthest points, shape (count,), from all distances: each is the farthest from those before it.

    The first is the vertex of largest mean distance, so that the numbering does not matter.
    """
    return frozen(farthest_by_distances(matrix, count, int((matrix @ areas.astype(np.float32)).argmax())))
