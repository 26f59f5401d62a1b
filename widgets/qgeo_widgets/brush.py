"""A region that is painted on one of two shapes and seen on both."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray
from qgeo_filters.surface import Surface

#: Radius of the brush, in sqrt(area).
RADIUS = 0.05


class Brush:
    """Dabs of a surface: what lies around a vertex and faces the same way.

    Parameters
    ----------
    surface : Surface
    normals : (n, 3) float64
        Which way each vertex faces.
    unit : float
        What sqrt(area) is taken for.
    """

    def __init__(self, surface: Surface, normals: FloatArray, unit: float) -> None:
        self._surface = surface
        self._normals = normals
        self._tree = cKDTree(surface.vertices)
        self._radius = RADIUS * unit

    def dab(self, vertex: int) -> npt.NDArray[np.int64]:
        """Vertices around one, itself among them; not those of the other side of a thin part."""
        around = np.asarray(self._tree.query_ball_point(self._surface.vertices[vertex], self._radius), dtype=np.int64)
        return np.union1d(around[self._normals[around] @ self._normals[vertex] > 0], [vertex])
