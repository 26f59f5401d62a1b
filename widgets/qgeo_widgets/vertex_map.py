"""A point map between two surfaces as the widgets use it: forwards, backwards, and which way round."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.maps.orientation import normal_cosines, orientation
from qgeo_filters.missing_values import with_missing
from qgeo_filters.surface import Surface
from qgeo_filters.validation import listed

# Of the lengths of edges: what is farther from all images than most edges are long is covered by no triangle.
_MOST = 0.95


class VertexMap:
    """Map from the vertices of X to those of Y, checked; -1 where a vertex has no partner.

    Parameters
    ----------
    x, y : Surface
        As they were given.
    p2p : array-like of int, shape (n_x,)
        Vertex of Y for each vertex of X; -1: none.
    name : str
        What the caller calls the map, for messages.
    inverse : (n_y,) int64, optional
        Vertex of X for each vertex of Y, -1: none, where that is known; else it is made of the map.
    repairs : pair of Repair or None
        Of X and Y: normals, and ways on Y, are those of what they made.

    Raises
    ------
    ParameterError
        Wrong length, not whole numbers, a vertex that Y does not have, or no partner for any vertex.
    """

    def __init__(
        self,
        x: Surface,
        y: Surface,
        p2p: npt.ArrayLike,
        name: str = "p2p",
        *,
        inverse: IndexArray | None = None,
        repairs: tuple[Repair | None, Repair | None] = (None, None),
    ) -> None:
        try:
            table = np.asarray(p2p)
        except ValueError as error:  # rows of different lengths
            raise ParameterError(f"{name} must be {x.n_vertices} vertex indices in one row: {error}") from error
        if table.shape != (x.n_vertices,) or table.dtype.kind not in "iu":
            raise ParameterError(
                f"{name} must be {x.n_vertices} vertex indices, one for each vertex of X as it was given, "
                f"got {table.dtype} of shape {table.shape}"
            )
        outside = np.flatnonzero((table < -1) | (table >= y.n_vertices))
        if outside.size:
            raise ParameterError(
                f"{name}[{outside[0]}] is vertex {table[outside[0]]}, but Y has {y.n_vertices} vertices "
                f"({outside.size} such: {listed(outside)}); -1 stands for no partner"
            )
        if (table < 0).all():
            raise ParameterError(f"no vertex of X has a partner: all {len(table)} of {name} are -1")
        self.x, self.y = x, y
        self.forward: IndexArray = table.astype(np.int64)
        self._inverse = inverse
        self._repairs = repairs

    @property
    def unmatched(self) -> tuple[int, int]:
        """How many vertices of X and of Y have no partner."""
        return int((self.forward < 0).sum()), int((self.backward < 0).sum())

    @cached_property
    def backward(self) -> IndexArray:
        """A vertex of X for each vertex of Y, (n_y,): one that is mapped there, or nearest to it along edges.

        Of a map in which vertices of X have no partner, -1 for what is farther from all images than triangles reach.
        """
        if self._inverse is not None:
            return self._inverse
        known = np.flatnonzero(self.forward >= 0)
        vertices, first = np.unique(self.forward[known], return_index=True)
        on, stands = self._measured_y
        images = stands[vertices]
        there = images >= 0
        places, second = np.unique(images[there], return_index=True)
        if not places.size:
            raise ParameterError("no vertex of X has its partner on what is measured of Y")
        origin = np.full(on.n_vertices, -1)
        origin[places] = known[first[there][second]]
        gaps, nearest = _nearest(on, places)
        # Pieces of Y that nothing is mapped to take whatever comes first.
        found = np.where(nearest < 0, origin[places[0]], origin[nearest])
        if len(known) < len(self.forward):
            found[~(gaps <= self._reach)] = -1
        back = np.where(stands >= 0, found[stands], -1)
        back[vertices] = known[first]
        return back

    @cached_property
    def orientation(self) -> float:
        """From -1 to 1: how far mapped triangles face the way Y does, see `qgeo_filters.matching.maps.orientation`."""
        of = self._repairs[0]
        x, images = (self.x, self.forward) if of is None else (of.surface, self.forward[of.origin])
        y, stands = self._measured_y
        images = np.where(images >= 0, stands[images], -1)
        corners = images[x.faces]
        known = (corners >= 0).all(axis=1)
        if known.all():
            return orientation(x, y, images)
        if not known.any():
            return 0.0
        areas = x.face_areas[known]
        return float(areas @ normal_cosines(y, corners[known]) / areas.sum())

    def on_y(self, values: np.ndarray) -> np.ndarray:
        """Values (n_x, ...) of X at the vertices of Y; NaN, -1 or False where one has no partner."""
        return with_missing(values[self.backward], self.backward < 0)

    def then(self, on_y: npt.ArrayLike) -> VertexMap:
        """The map followed by a map of Y to itself that is its own inverse, such as a reflection."""
        step = np.asarray(on_y)
        images = np.where(self.forward >= 0, step[self.forward], -1)
        inverse = None if self._inverse is None else np.where(step >= 0, self._inverse[step], -1)
        return VertexMap(self.x, self.y, images, inverse=inverse, repairs=self._repairs)

    @property
    def _measured_y(self) -> tuple[Surface, IndexArray]:
        """What is measured of Y, and its vertex for each given one; -1: none."""
        on = self._repairs[1]
        return (self.y, np.arange(self.y.n_vertices)) if on is None else (on.surface, on.vertex_of_original)

    @property
    def _reach(self) -> float:
        """How far from an image what is covered may lie: most edges are no longer, of X on Y, or of Y."""
        a, b = self.forward[self.x.edges.T]
        whole = (a >= 0) & (b >= 0)
        lengths = np.linalg.norm(self.y.vertices[a[whole]] - self.y.vertices[b[whole]], axis=1)
        return max(float(np.quantile(each, _MOST)) for each in (lengths, self.y.edge_lengths) if each.size)


def _nearest(surface: Surface, vertices: IndexArray) -> tuple[FloatArray, IndexArray]:
    """Distance along edges of each vertex (n,) from the nearest of some, and that; inf and negative for none."""
    a, b = surface.edges.T
    n = surface.n_vertices
    edges = sparse.csr_matrix((surface.edge_lengths, (a, b)), shape=(n, n))
    gaps, _, nearest = dijkstra(edges, directed=False, indices=vertices, min_only=True, return_predecessors=True)
    return gaps, nearest.astype(np.int64)
