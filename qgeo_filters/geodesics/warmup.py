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
    x, y = np.divmod(np.arange(25.0), 5)
    corner = np.arange(20)[np.arange(20) % 5 < 4]
    faces = np.concatenate(
        [np.stack([corner, corner + 5, corner + 6], axis=1), np.stack([corner, corner + 6, corner + 1], axis=1)]
    )
    square = np.stack([x, y, 0 * x], axis=1)
    # Sides of very different lengths are kept in other numbers, by other kernels.
    spike = 1e-9 * square
    spike[-1] = 1
    for vertices in (square, spike):
        surface = Surface(vertices, faces)
        distance_matrix(surface)
        distances(surface, [0])
    distances(surface, [0], method="exact")
