"""Local steps of an interpolation for several moments side by side, so that a processor computes them as one.

The last axis of positions (n, 3, lanes), right-hand sides and rotations is the moment.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.deformation.fit_rotations import NEWTON_STEPS, SETTLED, UNDETERMINED
from qgeo_filters.jit import njit

#: Moments that are computed side by side: a constant, for which the loops over them become vector instructions (with 8
#: the compiler unrolls them instead, which takes 1.4 times as long; benchmarks/deformation.py, speed).
LANES = 16
# Rows of LANES numbers in the scratch of one triangle: frame 0-8, matrix 9-17, quaternion 18-21, largest eigenvalue 22,
# its polynomial 23-25, scale 26.
_ROWS = 27


@njit(error_model="numpy")
def turned_sums(
    faces: npt.NDArray[np.int64],
    cotangents: FloatArray,
    edges: FloatArray,
    stretched: FloatArray,
    times: FloatArray,
    rotations: FloatArray,
    result: FloatArray,
) -> None:
    """Add the divergence of the gradients R S, for rotations R as quaternions (m, 4, lanes), to (n, 3, lanes).

    ``edges`` and ``stretched`` are the first two sides of each triangle at rest and where S takes them at time 1,
    (m, 2, 3).
    """
    scratch = np.empty(_ROWS * LANES)
    for t in range(len(faces)):
        for a in range(4):
            for lane in range(LANES):
                scratch[(18 + a) * LANES + lane] = rotations[t, a, lane]
        _add_sides(faces[t], cotangents[t], edges[t], stretched[t], times, scratch, result)


@njit(error_model="numpy")
def fitted_sums(
    faces: npt.NDArray[np.int64],
    cotangents: FloatArray,
    edges: FloatArray,
    stretched: FloatArray,
    inverses: FloatArray,
    products: FloatArray,
    flat: npt.NDArray[np.bool_],
    times: FloatArray,
    positions: FloatArray,
    result: FloatArray,
) -> None:
    """The same for the rotations R with which R S is nearest to the gradients of positions (n, 3, lanes).

    ``inverses`` are those of `TriangleFrames`, ``products`` with the transpose of S at time 1, (m, 3, 3).
    """
    scratch = np.empty(_ROWS * LANES)
    for t in range(len(faces)):
        if flat[t]:  # its gradient is the identity
            for a in range(3):
                for b in range(3):
                    for lane in range(LANES):
                        scratch[(3 * a + b) * LANES + lane] = 1.0 if a == b else 0.0
        else:
            _set_frame(faces[t], positions, scratch)
        for a in range(3):
            for b in range(3):
                for lane in range(LANES):
                    total = 0.0
                    for c in range(3):
                        now = (1 - times[lane]) * inverses[t, c, b] + times[lane] * products[t, c, b]
                        total += scratch[(3 * a + c) * LANES + lane] * now
                    scratch[(9 + 3 * a + b) * LANES + lane] = total
        _fit(scratch)
        _add_sides(faces[t], cotangents[t], edges[t], stretched[t], times, scratch, result)


@njit(error_model="numpy")
def _set_frame(face: npt.NDArray[np.int64], positions: FloatArray, scratch: FloatArray) -> None:
    """Two sides and the scaled normal as columns."""
    p, q, r = positions[face[0]], positions[face[1]], positions[face[2]]
    for lane in range(LANES):
        a, b, c = q[0, lane] - p[0, lane], q[1, lane] - p[1, lane], q[2, lane] - p[2, lane]
        d, e, f = r[0, lane] - p[0, lane], r[1, lane] - p[1, lane], r[2, lane] - p[2, lane]
        x, y, z = b * f - c * e, c * d - a * f, a * e - b * d
        double = np.sqrt(x * x + y * y + z * z)
        scale = 1 / np.sqrt(double) if double > 0 else 0.0
        scratch[lane], scratch[LANES + lane], scratch[2 * LANES + lane] = a, d, scale * x
        scratch[3 * LANES + lane], scratch[4 * LANES + lane], scratch[5 * LANES + lane] = b, e, scale * y
        scratch[6 * LANES + lane], scratch[7 * LANES + lane], scratch[8 * LANES + lane] = c, f, scale * z


@njit(error_model="numpy")
def _fit(s: FloatArray) -> None:
    """Quaternions of the nearest rotations, see `fit_rotations`."""
    for i in range(LANES):
        a, b, c = s[9 * LANES + i], s[10 * LANES + i], s[11 * LANES + i]
        d, e, f = s[12 * LANES + i], s[13 * LANES + i], s[14 * LANES + i]
        g, h, j = s[15 * LANES + i], s[16 * LANES + i], s[17 * LANES + i]
        squares = a * a + b * b + c * c + d * d + e * e + f * f + g * g + h * h + j * j
        determinant = a * (e * j - f * h) - b * (d * j - f * g) + c * (d * h - e * g)
        k00, k11, k22, k33 = a + e + j, a - e - j, e - a - j, j - a - e
        k01, k02, k03, k12, k13, k23 = h - f, c - g, d - b, b + d, c + g, f + h
        # Minors of the first two rows, and of the last two.
        s0, s1, s2 = k00 * k11 - k01 * k01, k00 * k12 - k02 * k01, k00 * k13 - k03 * k01
        s3, s4, s5 = k01 * k12 - k02 * k11, k01 * k13 - k03 * k11, k02 * k13 - k03 * k12
        c5, c4, c3 = k22 * k33 - k23 * k23, k12 * k33 - k13 * k23, k12 * k23 - k13 * k22
        c2, c1, c0 = k02 * k33 - k03 * k23, k02 * k23 - k03 * k22, k02 * k13 - k03 * k12
        s[23 * LANES + i] = squares
        s[24 * LANES + i] = -8 * determinant
        s[25 * LANES + i] = s0 * c5 - s1 * c4 + s2 * c3 + s3 * c2 - s4 * c1 + s5 * c0
        s[26 * LANES + i] = np.sqrt(3 * squares)
        s[22 * LANES + i] = s[26 * LANES + i]
    for _ in range(NEWTON_STEPS):
        moving = 0
        for i in range(LANES):
            largest, squares = s[22 * LANES + i], s[23 * LANES + i]
            value = ((largest * largest - 2 * squares) * largest + s[24 * LANES + i]) * largest + s[25 * LANES + i]
            slope = (4 * largest * largest - 4 * squares) * largest + s[24 * LANES + i]
            step = value / slope if slope > 0 else 0.0
            s[22 * LANES + i] = largest - step
            moving += 1 if step > SETTLED * s[26 * LANES + i] else 0
        if moving == 0:
            break
    for i in range(LANES):
        a, b, c = s[9 * LANES + i], s[10 * LANES + i], s[11 * LANES + i]
        d, e, f = s[12 * LANES + i], s[13 * LANES + i], s[14 * LANES + i]
        g, h, j = s[15 * LANES + i], s[16 * LANES + i], s[17 * LANES + i]
        largest = s[22 * LANES + i]
        k00, k11, k22, k33 = a + e + j - largest, a - e - j - largest, e - a - j - largest, j - a - e - largest
        k01, k02, k03, k12, k13, k23 = h - f, c - g, d - b, b + d, c + g, f + h
        s0, s1, s2 = k00 * k11 - k01 * k01, k00 * k12 - k02 * k01, k00 * k13 - k03 * k01
        s3, s4, s5 = k01 * k12 - k02 * k11, k01 * k13 - k03 * k11, k02 * k13 - k03 * k12
        c5, c4, c3 = k22 * k33 - k23 * k23, k12 * k33 - k13 * k23, k12 * k23 - k13 * k22
        c2, c1 = k02 * k33 - k03 * k23, k02 * k23 - k03 * k22
        # The adjugate of a symmetric matrix of rank 3 is a multiple of q q^T: its longest column is the best q.
        a00, a01, a02 = k11 * c5 - k12 * c4 + k13 * c3, -k01 * c5 + k02 * c4 - k03 * c3, k13 * s5 - k23 * s4 + k33 * s3
        a03, a11 = -k12 * s5 + k22 * s4 - k23 * s3, k00 * c5 - k02 * c2 + k03 * c1
        a12, a13 = -k03 * s5 + k23 * s2 - k33 * s1, k02 * s5 - k22 * s2 + k23 * s1
        a22, a23 = k03 * s4 - k13 * s2 + k33 * s0, -k02 * s4 + k12 * s2 - k23 * s0
        a33 = k02 * s3 - k12 * s1 + k22 * s0
        best, w, x, y, z = abs(a00), a00, a01, a02, a03
        if abs(a11) > best:
            best, w, x, y, z = abs(a11), a01, a11, a12, a13
        if abs(a22) > best:
            best, w, x, y, z = abs(a22), a02, a12, a22, a23
        if abs(a33) > best:
            best, w, x, y, z = abs(a33), a03, a13, a23, a33
        scale = s[26 * LANES + i]
        known = best > UNDETERMINED * scale * scale * scale
        unit = 1 / np.sqrt(w * w + x * x + y * y + z * z) if known else 0.0
        s[18 * LANES + i] = w * unit if known else 1.0
        s[19 * LANES + i] = x * unit if known else 0.0
        s[20 * LANES + i] = y * unit if known else 0.0
        s[21 * LANES + i] = z * unit if known else 0.0


@njit(error_model="numpy")
def _add_sides(
    face: npt.NDArray[np.int64],
    cotangents: FloatArray,
    edges: FloatArray,
    stretched: FloatArray,
    times: FloatArray,
    s: FloatArray,
    result: FloatArray,
) -> None:
    """Add the weighted sides of one triangle, stretched and turned by the quaternions, to the sums at its corners."""
    for i in range(LANES):
        t = times[i]
        w, x, y, z = s[18 * LANES + i], s[19 * LANES + i], s[20 * LANES + i], s[21 * LANES + i]
        r00, r01, r02 = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
        r10, r11, r12 = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
        r20, r21, r22 = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        a, b = (1 - t) * edges[0, 0] + t * stretched[0, 0], (1 - t) * edges[0, 1] + t * stretched[0, 1]
        c, d = (1 - t) * edges[0, 2] + t * stretched[0, 2], (1 - t) * edges[1, 0] + t * stretched[1, 0]
        e, f = (1 - t) * edges[1, 1] + t * stretched[1, 1], (1 - t) * edges[1, 2] + t * stretched[1, 2]
        s[i], s[LANES + i] = r00 * a + r01 * b + r02 * c, r00 * d + r01 * e + r02 * f
        s[2 * LANES + i], s[3 * LANES + i] = r10 * a + r11 * b + r12 * c, r10 * d + r11 * e + r12 * f
        s[4 * LANES + i], s[5 * LANES + i] = r20 * a + r21 * b + r22 * c, r20 * d + r21 * e + r22 * f
    for axis in range(3):
        p, q, r = result[face[0], axis], result[face[1], axis], result[face[2], axis]
        for i in range(LANES):
            one, two = s[2 * axis * LANES + i], s[(2 * axis + 1) * LANES + i]
            # Opposite corner 0 lies the side from 1 to 2, and so on round.
            opposite, from_two, from_one = cotangents[0] * (two - one), cotangents[1] * two, cotangents[2] * one
            p[i] -= from_two + from_one
            q[i] += from_one - opposite
            r[i] += opposite + from_two
