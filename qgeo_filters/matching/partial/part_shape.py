"""What a partial match needs to know of a shape: distances from farthest points, and how far the rim is."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.decimation import Proxy, decimated
from qgeo_filters.deformation.arap import ArapSolver
from qgeo_filters.differential.curvature import mean_curvature
from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.spectral.laplacian import laplacian_spectrum
from qgeo_filters.surface import Surface

# Stands for "no rim": farther than anything.
_FAR = 1e3


class PartShape:
    """A shape in a given unit of length, described by what a cut elsewhere does not change.

    Parameters
    ----------
    full : Surface
        Manifold, in one piece, oriented, its outside out.
    unit : float
        Length that counts as 1, the same for both shapes: sqrt(area) of the whole.
    size : int
        Number of vertices that are worked on: those of a proxy where the surface has more.
    points : int
        Number of farthest points.
    given : PartialParameters

    Attributes
    ----------
    proxy : Proxy
    surface : Surface
        Its surface in the unit, the centre of its area at the origin.
    centre : (3,) float64
        That centre, in the unit of ``full``.
    """

    def __init__(self, full: Surface, unit: float, size: int, points: int, given: PartialParameters) -> None:
        self.full, self.unit, self.given = full, unit, given
        self.proxy = _proxy(full, size)
        coarse = self.proxy.surface
        self.centre: FloatArray = coarse.vertex_areas @ coarse.vertices / coarse.area
        self.surface = Surface((coarse.vertices - self.centre) / unit, coarse.faces)
        self._count = min(points, self.surface.n_vertices)

    def resized(self, ratio: float) -> PartShape:
        """The same shape, so many times as large; distances are not computed again."""
        return self._changed(ratio, self.rim * ratio)

    def with_shortcuts(self, reach: float) -> PartShape:
        """The same shape where the other one may have grown together so near to each point: as if all were near a rim.

        Distances on that other one are at most those on this shape then, and may be shorter.
        """
        return self._changed(1.0, np.minimum(self.rim, reach))

    def _changed(self, ratio: float, rim: FloatArray) -> PartShape:
        other = PartShape.__new__(PartShape)
        other.full, other.unit, other.given = self.full, self.unit / ratio, self.given
        other.proxy, other.centre, other._count = self.proxy, self.centre, self._count
        other.surface = Surface(self.surface.vertices * ratio, self.surface.faces)
        other.__dict__.update(fps=self.fps, rim=rim, rows=self.rows * np.float32(ratio), laplacian=self.laplacian)
        return other

    @property
    def n_vertices(self) -> int:
        """Number of vertices that are worked on."""
        return self.surface.n_vertices

    @property
    def vertices(self) -> FloatArray:
        """Positions (n, 3) in the unit."""
        return self.surface.vertices

    @property
    def normals(self) -> FloatArray:
        """Unit normals (n, 3)."""
        return self.surface.vertex_normals

    @property
    def areas(self) -> FloatArray:
        """Area of each vertex, (n,)."""
        return self.surface.vertex_areas

    @property
    def area(self) -> float:
        """Area in squared units: of the whole 1, of a part its share."""
        return self.surface.area

    @property
    def has_rim(self) -> bool:
        """Whether there is a boundary."""
        return bool(len(self.surface.boundary_vertices))

    @cached_property
    def laplacian(self) -> SingleArray:
        """Eigenfunctions of the Laplace-Beltrami operator, (n, k)."""
        count = min(self.given.eigenfunctions, self.n_vertices // 3)
        return laplacian_spectrum(self.surface, count).eigenfunctions.astype(np.float32)

    def distances(self, sources: IndexArray) -> FloatArray:
        """Distances from some vertices to all, (s, n)."""
        return distances(self.surface, sources)

    def distance_from(self, inside: npt.NDArray[np.bool_]) -> FloatArray:
        """Distance of each vertex from the nearest of some, (n,), along edges."""
        return np.asarray(dijkstra(self._graph, directed=False, indices=np.flatnonzero(inside), min_only=True))

    @cached_property
    def rim(self) -> FloatArray:
        """Distance of each vertex to the boundary, (n,), along edges; a large number if there is none."""
        if not self.has_rim:
            return np.full(self.n_vertices, _FAR)
        inside = np.zeros(self.n_vertices, dtype=bool)
        inside[self.surface.boundary_vertices] = True
        return self.distance_from(inside)

    @cached_property
    def fps(self) -> IndexArray:
        """Farthest points (m,): the first ones far from the rim too, where distances are those of the whole."""
        rows: list[FloatArray] = []
        chosen: list[int] = []
        # Without a rim the first is the farthest from the centre of the area, which is the origin.
        nearest = self.rim.copy() if self.has_rim else np.linalg.norm(self.vertices, axis=1)
        for i in range(self._count):
            if i == self.given.inner_points:
                nearest = np.min(rows, axis=0)
            nearest[chosen] = -1.0
            chosen.append(int(nearest.argmax()))
            rows.append(dijkstra(self._graph, directed=False, indices=chosen[-1:])[0])
            nearest = rows[0].copy() if i == 0 and not self.has_rim else np.minimum(nearest, rows[-1])
        return np.array(chosen, dtype=np.int64)

    @cached_property
    def rows(self) -> SingleArray:
        """Distances from the farthest points to all vertices, (m, n)."""
        return self.distances(self.fps).astype(np.float32)

    @cached_property
    def bulge(self) -> FloatArray:
        """Mean curvature around each farthest point, (m,): what bulges and what is hollow."""
        limit = self.given.curvature_limit
        curvature = np.clip(mean_curvature(self.surface), -limit, limit)
        weights = np.exp(-((self.rows / self.given.bulge_radius) ** 2)) * self.areas
        return np.asarray(weights @ curvature / weights.sum(axis=1))

    @cached_property
    def balls(self) -> FloatArray:
        """Area of the geodesic ball of each radius around each farthest point, (m, r)."""
        return np.stack([(self.rows <= radius) @ self.areas for radius in self.given.ball_radii], axis=1)

    @cached_property
    def arap(self) -> ArapSolver:
        """Its as-rigid-as-possible deformation, in this unit."""
        return ArapSolver(self.vertices, self.surface.faces)

    @cached_property
    def _graph(self) -> sparse.csr_matrix:
        a, b = self.surface.edges.T
        return sparse.csr_matrix((self.surface.edge_lengths, (a, b)), shape=(self.n_vertices,) * 2)


def _proxy(full: Surface, size: int) -> Proxy:
    """Proxy of about so many vertices, or of twice as many and so on where rims and handles need them."""
    while True:
        try:
            return decimated(full, size)
        except ParameterError:
            if size >= full.n_vertices:
                raise
            size *= 2
