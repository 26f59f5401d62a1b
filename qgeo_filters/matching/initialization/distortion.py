"""How much many coarse maps distort distances."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.jit import njit


@njit()
def point_distortions(near_x: SingleArray, near_y: SingleArray, maps: IndexArray) -> FloatArray:
    """Mean |d_X(p, q) - d_Y(Tp, Tq)| over all pairs of points, for each map T (..., s) of the rows of maps.

    ``near_x`` (s, s) and ``near_y`` (m, m) are the symmetric distances among the points of either shape.
    """
    count, s = maps.shape
    result = np.empty(count)
    for k in range(count):
        images = maps[k]
        total = 0.0
        for p in range(1, s):
            row_x, row_y = near_x[p], near_y[images[p]]
            for q in range(p):
                total += abs(row_x[q] - row_y[images[q]])
        result[k] = 2 * total / (s * s)
    return result
