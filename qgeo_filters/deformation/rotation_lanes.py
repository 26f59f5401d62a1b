"""Rotations of triangles for several moments side by side, see `frame_lanes`: along a tree, and how far they disagree.

The last axis of unit quaternions (m, 4, lanes), w first, is the moment.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.deformation.frame_lanes import LANES
from qgeo_filters.jit import njit


@njit(error_model="numpy")
def walked_rotations(
    steps: FloatArray, walk: npt.NDArray[np.int64], before: npt.NDArray[np.int64], times: FloatArray
) -> FloatArray:
    """Unit quaternions (m, 4, lanes): products of the steps, rotation vectors (m, 3), along the walk, at some times."""
    root = len(steps)
    result = np.empty((len(steps), 4, LANES))
    for t in walk:
        angle = np.sqrt(steps[t, 0] ** 2 + steps[t, 1] ** 2 + steps[t, 2] ** 2)
        unit = 1 / angle if angle > 0 else 0.0
        p = before[t]
        for lane in range(LANES):
            half = 0.5 * times[lane] * angle
            w, sine = np.cos(half), np.sin(half) * unit
            x, y, z = sine * steps[t, 0], sine * steps[t, 1], sine * steps[t, 2]
            if p != root:
                a, b, c, d = result[p, 0, lane], result[p, 1, lane], result[p, 2, lane], result[p, 3, lane]
                w, x, y, z = (
                    a * w - b * x - c * y - d * z,
                    a * x + b * w + c * z - d * y,
                    a * y - b * z + c * w + d * x,
                    a * z + b * y - c * x + d * w,
                )
            result[t, 0, lane], result[t, 1, lane], result[t, 2, lane], result[t, 3, lane] = w, x, y, z
    return result


@njit(error_model="numpy")
def disagreements(
    sides: npt.NDArray[np.int64], steps: FloatArray, weights: FloatArray, times: FloatArray, rotations: FloatArray
) -> FloatArray:
    """Sums (m, 3, lanes) of what turns each triangle to where its neighbours and the steps from them say, weighted.

    ``sides`` (e, 2) are pairs of neighbours, ``steps`` (e, 3) the rotation vector from the first to the second. Of an
    angle it is the sine, twice that of its half times the cosine: nothing says which way half a turn goes.
    """
    result = np.zeros((len(rotations), 3, LANES))
    for e in range(len(sides)):
        one, other = sides[e, 0], sides[e, 1]
        angle = np.sqrt(steps[e, 0] ** 2 + steps[e, 1] ** 2 + steps[e, 2] ** 2)
        unit = 1 / angle if angle > 0 else 0.0
        for lane in range(LANES):
            half = 0.5 * times[lane] * angle
            w, sine = np.cos(half), np.sin(half) * unit
            x, y, z = sine * steps[e, 0], sine * steps[e, 1], sine * steps[e, 2]
            a, b, c, d = (
                rotations[one, 0, lane],
                rotations[one, 1, lane],
                rotations[one, 2, lane],
                rotations[one, 3, lane],
            )
            w, x, y, z = (
                a * w - b * x - c * y - d * z,
                a * x + b * w + c * z - d * y,
                a * y - b * z + c * w + d * x,
                a * z + b * y - c * x + d * w,
            )
            a, b = rotations[other, 0, lane], rotations[other, 1, lane]
            c, d = rotations[other, 2, lane], rotations[other, 3, lane]
            scale = 2 * weights[e] * (w * a + x * b + y * c + z * d)
            turn_x = scale * (x * a - w * b + z * c - y * d)
            turn_y = scale * (y * a - w * c + x * d - z * b)
            turn_z = scale * (z * a - w * d + y * b - x * c)
            result[one, 0, lane] -= turn_x
            result[one, 1, lane] -= turn_y
            result[one, 2, lane] -= turn_z
            result[other, 0, lane] += turn_x
            result[other, 1, lane] += turn_y
            result[other, 2, lane] += turn_z
    return result


@njit(error_model="numpy")
def turn(rotations: FloatArray, by: FloatArray) -> None:
    """Turn rotations further, in place, by (m, 3, lanes): about that axis, by twice the arc tangent of half of it."""
    for t in range(len(rotations)):
        for lane in range(LANES):
            x, y, z = 0.5 * by[t, 0, lane], 0.5 * by[t, 1, lane], 0.5 * by[t, 2, lane]
            a, b, c, d = rotations[t, 0, lane], rotations[t, 1, lane], rotations[t, 2, lane], rotations[t, 3, lane]
            unit = 1 / np.sqrt(1 + x * x + y * y + z * z)
            rotations[t, 0, lane] = unit * (a - x * b - y * c - z * d)
            rotations[t, 1, lane] = unit * (b + x * a + y * d - z * c)
            rotations[t, 2, lane] = unit * (c - x * d + y * a + z * b)
            rotations[t, 3, lane] = unit * (d + x * c - y * b + z * a)
