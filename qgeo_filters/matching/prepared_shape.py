"""What matching needs to know of a shape, computed once and used against any number of others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse

from qgeo_filters._deprecation import renamed_parameters
from qgeo_filters._typing import FloatArray, IndexArray, RepairOption, SingleArray
from qgeo_filters.decimation import Proxy, decimated
from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.metric import LiftedMetric
from qgeo_filters.hosts.dispatch import SurfaceLike, surface_and_repair
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.fine_shape import FineShape
from qgeo_filters.matching.intrinsic_shape import IntrinsicShape, MetricEmbedding
from qgeo_filters.matching.level import Level, reflected
from qgeo_filters.matching.matchable import check_matchable
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen


class PreparedShape(Level):
    """A shape prepared for matching, at three resolutions: coarse, with distances and spectra, fine, and full.

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
    A shape that is inside out is turned over, since its left would be taken for its right. What
    it has as a `Level`, such as ``surface`` and ``unit``, is coarse: a proxy on which maps are sought, where the shape
    has more than 2400 vertices. All that is expensive is computed there, on first use: memory is O(n). Distances are
    measured on the surface as it is, and what is derived from them is brought to unit area.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> shape = qg.PreparedShape(x)  # computes nothing yet
    >>> found = qg.match(shape, x.with_vertices(2 * x.vertices))
    >>> again = qg.match(shape, x.with_vertices(3 * x.vertices))  # what belongs to x is there
    >>> found.confident, again.confident
    (True, True)
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
        self.oriented = self.full.turned_over() if self.winding == "inward" else self.full
        """The surface whose map is found, at full resolution."""
        self.fine_proxy = decimated(self.oriented, resolution(self.oriented, chosen.registration_vertices))
        """The surface at which maps are finished: the same, unless it is large."""
        fine = self.fine_proxy.surface
        self.proxy = decimated(fine, resolution(fine, chosen.search_vertices))
        """The surface at which maps are sought, of that at which they are finished: coarser."""
        super().__init__(self.proxy.surface)
        self.intrinsic = IntrinsicShape(self.surface, self.unit, chosen, matrix, progress)
        """What does not change in a mirror."""
        self.symmetries: dict[tuple[float, MatchingParameters], Any] = {}
        """Self-symmetries that were found, by tolerance and parameters."""
        self.rough_reflections: dict[MatchingParameters, list[IndexArray]] = {}
        """What may be one of them, by parameters; see `search.rough_reflections`."""

    def __repr__(self) -> str:
        return f"PreparedShape({self.full!r}, curvature_weights={self.parameters.curvature_weights})"

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
        _ = self.spectrum, self.fps_distances, self.laplacian, self.log_hks, self.smoothed_mean_curvature, self.relief
        _ = self.normals, self.fine.normals, self.fine.laplacian
        return self

    def standing_for(self, repair: Repair) -> PreparedShape:
        """The same shape for the mesh whose repair it is: results are on the vertices that were given."""
        check_matchable(repair.surface, self.parameters, repaired=True)
        other = object.__new__(PreparedShape)
        # Not what refers to the shape itself, which is another one.
        own = {"mirrored", "fine"} if self.fine is self else {"mirrored"}
        other.__dict__.update({name: value for name, value in self.__dict__.items() if name not in own})
        other.given, other.repair, other.full = repair.given, repair, repair.surface
        return other

    @property
    def embeddings(self) -> tuple[MetricEmbedding, ...]:
        """The shape in each metric; the same farthest points in all."""
        return tuple(self.embedding(place) for place in range(len(self.parameters.curvature_weights)))

    def embedding(self, place: int) -> MetricEmbedding:
        """The shape in one metric."""
        return self.intrinsic.embedding(place)

    @property
    def areas(self) -> FloatArray:
        """Area of each vertex, (n,), summing to 1."""
        return self.intrinsic.areas

    @property
    def fps(self) -> IndexArray:
        """Farthest points, (m,) with m up to 2000, the vertex of largest mean distance first."""
        return self.intrinsic.fps

    @property
    def fps_distances(self) -> SingleArray:
        """Distances from the first farthest points to all vertices in the first metric, (r, n)."""
        return self.intrinsic.fps_distances

    @property
    def nearest_fps(self) -> IndexArray:
        """Place of the nearest of these farthest points, for each vertex, (n,)."""
        return self.intrinsic.nearest_fps

    def distances(self, sources: npt.ArrayLike) -> FloatArray:
        """Distances from some vertices to all in the first metric, (s, n)."""
        return self.intrinsic.distances(sources)

    @property
    def spectrum(self) -> Spectrum:
        """First eigenfunctions of the distances in the last metric, which is that of the paper's functions."""
        return self.embedding(-1).spectrum

    @property
    def laplacian_spectrum(self) -> Spectrum:
        """Eigenpairs of the Laplace-Beltrami operator, up to 200."""
        return self.intrinsic.laplacian_spectrum

    @property
    def laplacian(self) -> SingleArray:
        """Its eigenfunctions in single precision, (n, up to 200)."""
        return self.intrinsic.laplacian

    @property
    def log_hks(self) -> FloatArray:
        """Heat kernel signature, (n, 3)."""
        return self.intrinsic.log_hks

    @property
    def smoothed_mean_curvature(self) -> FloatArray:
        """Mean curvature after a little heat, (n,), in 1 / sqrt(area)."""
        return self.intrinsic.smoothed_mean_curvature

    @property
    def relief(self) -> FloatArray:
        """Height over the surface after more heat, (n,), in sqrt(area): what bulges and what is hollow."""
        return self.intrinsic.relief

    @cached_property
    def fine(self) -> Level:
        """The shape at the resolution at which maps are finished; itself where that is this one."""
        same = self.proxy.surface is self.fine_proxy.surface
        return self if same else FineShape(self.fine_proxy.surface, self.proxy, self)

    def finer(self) -> PreparedShape | None:
        """The shape prepared anew, to be searched where maps are finished; None where it is searched there already."""
        if self.proxy.surface is self.fine_proxy.surface:
            return None
        given = replace(self.parameters, search_vertices=self.parameters.registration_vertices)
        return PreparedShape(self.full, parameters=given, matrix=self.intrinsic.matrix, repair=False)

    @cached_property
    def full_vertices(self) -> IndexArray:
        """The vertex at full resolution that stands for each vertex, (n,)."""
        return self.fine_proxy.vertices[self.proxy.vertices]

    @cached_property
    def vertex_of_full(self) -> IndexArray:
        """The vertex nearest to each at full resolution, (n_full,)."""
        return self.proxy.nearest_corner[self.fine_proxy.nearest_corner]

    @cached_property
    def interpolation(self) -> sparse.csr_array:
        """Matrix (n_full, n) that takes values at the vertices to all at full resolution."""
        return _matrix(self.fine_proxy) @ _matrix(self.proxy)

    @cached_property
    def full_spectrum(self) -> Spectrum:
        """`spectrum`, interpolated at the vertices at full resolution."""
        if self.oriented is self.surface:
            return self.spectrum
        areas = self.full.vertex_areas / self.full.area
        return replace(
            self.spectrum, eigenfunctions=frozen(self.interpolation @ self.spectrum.eigenfunctions), areas=frozen(areas)
        )

    @cached_property
    def mirrored(self) -> PreparedShape:
        """Its image in a mirror, vertex by vertex: intrinsically the same, and nothing is computed again."""
        other = object.__new__(PreparedShape)
        other.__dict__.update({key: value for key, value in self.__dict__.items() if key not in _EXTRINSIC})
        other.oriented = reflected(self.oriented)
        coarse, fine = reflected(self.surface), self.fine_proxy.surface
        fine = coarse if self.fine is self else other.oriented if fine is self.oriented else reflected(fine)
        other.proxy = replace(self.proxy, surface=coarse)
        other.fine_proxy = replace(self.fine_proxy, surface=fine)
        Level.__init__(other, coarse)
        return other


# A proxy must be worth its while.
_FEW_MORE = 1.2

#: What `match` and `self_symmetry` take.
Shape = SurfaceLike | PreparedShape

# What a mirror changes.
_EXTRINSIC = (
    "oriented",
    "surface",
    "unit",
    "scale",
    "centre",
    "proxy",
    "fine_proxy",
    "fine",
    "normals",
    "arap",
    "mirrored",
)


def resolution(surface: Surface, n_vertices: int) -> int:
    """Number of vertices of a proxy: its own for a surface that has few more."""
    return n_vertices if surface.n_vertices > _FEW_MORE * n_vertices else surface.n_vertices


def _matrix(proxy: Proxy) -> sparse.csr_array:
    n = len(proxy.corners)
    rows = np.repeat(np.arange(n), 3)
    entries = proxy.coordinates.ravel(), (rows, proxy.corners.ravel())
    found = sparse.csr_array(entries, shape=(n, proxy.surface.n_vertices))
    found.eliminate_zeros()
    return found
