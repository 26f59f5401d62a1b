"""What matching needs to know of a shape, computed once and used against any number of others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._deprecation import renamed_parameters
from qgeo_filters._typing import FloatArray, IndexArray, RepairOption, SingleArray
from qgeo_filters.deformation.arap import ArapSolver
from qgeo_filters.differential.curvature import mean_curvature
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.geodesics.matrix import distance_matrix, distances
from qgeo_filters.geodesics.metric import LiftedMetric, lifted_metric
from qgeo_filters.hosts.dispatch import SurfaceLike, surface_and_repair
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.parallel import single_threaded_blas
from qgeo_filters.sampling import farthest_by_distances
from qgeo_filters.spectral.laplacian import laplacian_spectrum
from qgeo_filters.spectral.spectrum import Spectrum, check_areas, spectrum_of_matrix
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


class PreparedShape:
    """A shape prepared for matching: unit-area copy, distances, spectra, farthest points; each on first use.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        Manifold, in one piece, oriented, or made so by ``repair``.
    curvature_weights : sequence of float, optional
        Weights of mean curvature in the metrics that propose maps, instead of those of the parameters.
    parameters : MatchingParameters, optional
    matrix : callable, optional
        Takes a `LiftedMetric` of the surface, returns the distances between all vertices, shape (n, n), in the unit of
        the surface: for callers who have them or want to keep them. `distance_matrix` by default.
    repair : bool, "auto" or "force"
        Whether what is wrong with the mesh is repaired first: by default, "auto", if something is, see
        `surface_and_repair`. Results are on the vertices that were given all the same.
    progress : bool
        Whether to show a progress bar over the distances.

    Raises
    ------
    MeshError
        Surface not manifold or in several pieces and not to be repaired, not orientable, with a vertex of no area, or
        of fewer than 60 vertices.
    ParameterError
        No metric, or a weight that is negative.

    Notes
    -----
    A shape that is inside out is turned over, since its left would be taken for its right. Memory is O(800 n): the
    matrix of all distances is dropped once it has been used. Distances are measured on the surface as it is, and what
    is derived from them is brought to unit area.
    """

    @renamed_parameters(weights="curvature_weights")
    def __init__(
        self,
        surface: SurfaceLike,
        *,
        curvature_weights: Sequence[float] | None = None,
        parameters: MatchingParameters | None = None,
        matrix: Callable[[LiftedMetric], npt.NDArray[np.float32]] | None = None,
        repair: RepairOption = "auto",
        progress: bool = False,
    ) -> None:
        chosen = MatchingParameters() if parameters is None else parameters
        if curvature_weights is not None:
            chosen = replace(chosen, curvature_weights=tuple(float(weight) for weight in curvature_weights))
        if not chosen.curvature_weights:
            raise ParameterError("at least one metric must propose maps: curvature_weights is empty")
        self.parameters = chosen
        self.given, self.repair = surface_and_repair(surface, repair)
        """The surface that was given: indices of results are those of its vertices and faces; and what was repaired."""
        self.full = self.given if self.repair is None else self.repair.surface
        """The same, repaired where it had to be: what is matched."""
        check_matchable(self.full, chosen, repaired=self.repair is not None)
        self.winding = self.full.winding
        """Which side of that surface is out; what looks inwards is turned over, vertices as they are."""
        self.surface = self.full.turned_over() if self.winding == "inward" else self.full
        self.scale = float(np.sqrt(self.surface.area))
        centre = self.surface.vertex_areas @ self.surface.vertices / self.surface.area
        self.unit = Surface((self.surface.vertices - centre) / self.scale, self.surface.faces)
        self.symmetries: dict[tuple[float, MatchingParameters], Any] = {}
        """Self-symmetries that were found, by tolerance and parameters."""
        self._matrix = matrix
        self._progress = progress

    def __repr__(self) -> str:
        return f"PreparedShape({self.surface!r}, curvature_weights={self.parameters.curvature_weights})"

    @classmethod
    def of(
        cls,
        shape: Shape,
        parameters: MatchingParameters | None = None,
        *,
        repair: RepairOption = "auto",
        progress: bool = False,
    ) -> PreparedShape:
        """The prepared shape itself, or that of a surface."""
        if isinstance(shape, PreparedShape):
            return shape
        return cls(shape, parameters=parameters, repair=repair, progress=progress)

    def prepare(self) -> PreparedShape:
        """The same shape, with everything that matching takes from it computed now."""
        # Cached properties: looking at one computes it.
        for name in ("embeddings", "laplacian", "normals", "log_hks", "smoothed_mean_curvature"):
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
        return lifted_metric(self.surface, curvature_weight=self.parameters.curvature_weights[0])

    def distances(self, sources: npt.ArrayLike) -> FloatArray:
        """Distances from some vertices to all in the first metric, (s, n)."""
        return distances(self.metric.surface, sources, self.metric) / self.scale

    @cached_property
    def embeddings(self) -> tuple[MetricEmbedding, ...]:
        """The shape in each metric; the same farthest points in all."""
        return tuple(self._embedded(weight) for weight in self.parameters.curvature_weights)

    @cached_property
    def fps(self) -> IndexArray:
        """Farthest points, (m,) with m up to 2000, the vertex of largest mean distance first."""
        _ = self.embeddings  # the first embedding chooses them, with all distances at hand
        return self._fps

    @property
    def fps_distances(self) -> SingleArray:
        """Distances from the first farthest points to all vertices in the first metric, (r, n)."""
        return self.embeddings[0].fps_distances

    @property
    def spectrum(self) -> Spectrum:
        """First eigenfunctions of the distances in the last metric, which is that of the paper's functions."""
        return self.embeddings[-1].spectrum

    @cached_property
    @single_threaded_blas
    def laplacian_spectrum(self) -> Spectrum:
        """Eigenpairs of the Laplace-Beltrami operator, up to 200."""
        return laplacian_spectrum(self.unit, min(self.parameters.laplacian_functions, self.n_vertices // 3))

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
        """Mean curvature after some heat, (n,), in units of 1 / sqrt(area): what bulges and what is hollow."""
        limit = self.parameters.curvature_limit
        curvature = np.clip(mean_curvature(self.unit), -limit, limit)
        functions = self.laplacian.astype(np.float64)
        decay = np.exp(-self.parameters.curvature_time * self.laplacian_spectrum.eigenvalues)
        return frozen(functions @ (decay * (functions.T @ (self.areas * curvature))))

    @cached_property
    def arap(self) -> ArapSolver:
        """Its as-rigid-as-possible deformation."""
        return ArapSolver(self.unit.vertices, self.unit.faces)

    @cached_property
    def mirrored(self) -> PreparedShape:
        """Its image in a mirror, vertex by vertex: intrinsically the same, and nothing is computed again."""
        other = object.__new__(PreparedShape)
        other.__dict__.update({key: value for key, value in self.__dict__.items() if key not in _EXTRINSIC})
        # Reflected faces turn over, so that normals keep pointing out.
        flip = np.array([-1.0, 1.0, 1.0])
        other.surface = Surface(self.surface.vertices * flip, self.surface.faces[:, ::-1])
        other.unit = Surface(self.unit.vertices * flip, self.unit.faces[:, ::-1])
        for name in _INTRINSIC:
            other.__dict__[name] = getattr(self, name)
        return other

    @single_threaded_blas
    def _embedded(self, weight: float) -> MetricEmbedding:
        given = self.parameters
        first = weight == given.curvature_weights[0]
        metric = self.metric if first else lifted_metric(self.surface, curvature_weight=weight)
        if self._matrix is None:
            matrix = distance_matrix(self.surface, metric, progress=self._progress)
        else:
            matrix = self._matrix(metric)
        k = min(given.distance_functions, self.n_vertices // 3)
        spectrum = spectrum_of_matrix(matrix, self.surface.vertex_areas, k, tolerance=given.eigen_tolerance)
        spectrum = self._in_unit_area(spectrum)
        if "_fps" not in self.__dict__:
            self._fps = farthest_rows(matrix, self.areas, min(given.fps_count, self.n_vertices))
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


#: What `match` and `self_symmetry` take.
Shape = SurfaceLike | PreparedShape

_EXTRINSIC = ("surface", "unit", "normals", "arap", "mirrored")
# Equal on both sides of a mirror, and shared: computed anew they would differ by rounding.
_INTRINSIC = (
    "metric", "embeddings", "fps", "laplacian", "laplacian_spectrum", "areas", "log_hks", "smoothed_mean_curvature"
)  # fmt: skip


def check_matchable(surface: Surface, parameters: MatchingParameters | None = None, *, repaired: bool = False) -> None:
    """Raise `MeshError`, saying why, for a surface that cannot be matched."""
    surface.require_manifold("matching")
    surface.require_connected("matching")
    if not surface.is_oriented and repaired:
        raise MeshError(
            "matching tells a shape from its mirror image by the side of the surface that is out, but it is one-sided "
            f"(as a Moebius band, or a scan with wrong bridges; Euler characteristic {surface.euler_characteristic}), "
            "which no turning of faces mends: wrap or remesh it first"
        )
    if not surface.is_oriented:
        raise MeshError(
            "matching tells a shape from its mirror image by the orientation of its faces, but neighbouring faces "
            "disagree; repair=True turns them, unless the surface is one-sided"
        )
    check_areas(surface.vertex_areas)
    least = (parameters or MatchingParameters()).minimum_vertices
    if surface.n_vertices < least:
        raise MeshError(f"matching needs at least {least} vertices, got {surface.n_vertices}")


def check_same_size(x: Surface, y: Surface, ratio: float = MatchingParameters.same_area) -> None:
    """Raise `ParameterError` for shapes whose areas differ by more than this ratio."""
    if not 1 / ratio <= x.area / y.area <= ratio:
        raise ParameterError(
            f"the areas of X and Y are {x.area:.6g} and {y.area:.6g}: shapes of different size are compared with "
            "normalize=True"
        )


def farthest_rows(matrix: npt.NDArray[np.float32], areas: FloatArray, count: int) -> IndexArray:
    """Farthest points, shape (count,), from all distances: each is the farthest from those before it.

    The first is the vertex of largest mean distance, so that the numbering does not matter.
    """
    return frozen(farthest_by_distances(matrix, count, int((matrix @ areas.astype(np.float32)).argmax())))
