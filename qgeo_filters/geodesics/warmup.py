"""Compilation of all kernels ahead of the first real call."""

from __future__ import annotations

import numpy as np

from qgeo_filters.geodesics.matrix import distance_matrix, distances
from qgeo_filters.surface import Surface


def warmup() -> None:
    """Compile every kernel of the geodesics, or load it from Numba's cache on disk.

    Takes some seconds once after installation or an update, and well under a second from then on. Without it, the
    first call of each method takes that time.
    """
    tetrahedron = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    distance_matrix(Surface(tetrahedron, faces))
    distances(Surface(tetrahedron, faces), [0])
    # Sides of very different lengths are kept in other numbers, by other kernels.
    needle = Surface(tetrahedron * [1, 1e-9, 1], faces)
    distance_matrix(needle)
    distances(needle, [0])
    distances(Surface(tetrahedron, faces), [0], method="exact")
