"""The mesh that the browser gets of a surface: the surface itself, or a proxy of it where it is large."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters._typing import IndexArray
from qgeo_filters.caching import cache
from qgeo_filters.decimation import decimated
from qgeo_filters.errors import QgeoError
from qgeo_filters.fingerprint import content_key
from qgeo_filters.surface import Surface

#: Vertices up to which a surface is shown as it is: a browser turns 200,000 triangles without a jerk, and every change
#: of colours is a message of a megabyte and a half.
SHOWN_AS_IT_IS = 120_000
#: Vertices of what is shown of a larger one.
SHOWN_OF_LARGER = 40_000


class DisplayMesh:
    """What is drawn of a surface, and which of its vertices a colour is taken from and a click means.

    Parameters
    ----------
    surface : Surface
    most : int, optional
        Vertices that there is room for, where that is fewer than `SHOWN_AS_IT_IS`.

    Attributes
    ----------
    surface : Surface
        The one that the widget is about.
    shown : Surface
        The one that is drawn: the same, or a proxy. A large surface that has no proxy (in several pieces, or not
        manifold) is drawn as it is.
    """

    def __init__(self, surface: Surface, most: int | None = None) -> None:
        self.surface = surface
        self.shown = surface
        self._vertices: IndexArray | None = None
        self._drawn: IndexArray | None = None
        most = SHOWN_AS_IT_IS if most is None else min(most, SHOWN_AS_IT_IS)
        of_larger = min(most, SHOWN_OF_LARGER)
        if surface.n_vertices > most:
            try:
                key = content_key("display_mesh", surface.vertices, surface.faces, of_larger)
                proxy = cache.get(key, lambda: decimated(surface, of_larger))  # once for both sides of a shape
            except QgeoError:
                return
            self.shown, self._vertices, self._drawn = proxy.surface, proxy.vertices, proxy.nearest_corner

    @property
    def is_proxy(self) -> bool:
        """Whether something else than the surface is drawn."""
        return self._vertices is not None

    @property
    def caption(self) -> str:
        """What a reader has to know of it; empty where the surface itself is drawn."""
        return f", drawn as a mesh of {self.shown.n_vertices}" if self.is_proxy else ""

    def at_vertices(self, values: np.ndarray) -> np.ndarray:
        """Values (n, ...) of the surface at the vertices that are drawn: those of the nearest vertex."""
        return values if self._vertices is None else values[self._vertices]

    def drawn_at(self, vertices: IndexArray) -> IndexArray:
        """The drawn vertex that stands for each vertex of the surface, -1 for -1."""
        return vertices if self._drawn is None else np.where(vertices >= 0, self._drawn[vertices], -1)

    def vertex_at(self, corners: IndexArray, point: npt.ArrayLike) -> int:
        """Vertex of the surface nearest to a point of a drawn triangle with these corners."""
        place = np.asarray(point, dtype=np.float64)
        if self._vertices is not None:
            return int(self._tree.query(place)[1])
        return int(corners[np.linalg.norm(self.surface.vertices[corners] - place, axis=1).argmin()])

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.surface.vertices)
