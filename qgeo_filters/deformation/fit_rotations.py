"""Nearest rotations of many 3 x 3 matrices."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.jit import njit

#: Newton's steps, and the relative change at which they end.
NEWTON_STEPS, SETTLED = 60, 1e-14
#: A quaternion whose four cofactors are all relatively smaller than this is not determined.
UNDETERMINED = 1e-12


@njit()
def fit_rotations(matrices: FloatArray) -> FloatArray:
    """The rotation R that maximises tr(R^T S) for each matrix S, (n, 3, 3); the identity where none is singled out.

    Its quaternion is the eigenvector of the largest eigenvalue of a symmetric 4 x 4 matrix. libigl's function of this
    name does the same in single precision, but holds Python's lock meanwhile, so that maps tried side by side wait.

    References
    ----------
    Horn, "Closed-form solution of absolute orientation using unit quaternions", JOSA A 1987; Theobald, "Rapid
    calculation of RMSDs using a quaternion-based characteristic polynomial", Acta Cryst. A 2005.
    """
    result = np.empty(matrices.shape)
    k = np.empty((4, 4))
    for i in range(len(matrices)):
        _rotation(matrices[i], k, result[i])
    return result


@njit()
def _rotation(s: FloatArray, k: FloatArray, result: FloatArray) -> None:
    squares = 0.0
    for a in range(3):
        for b in range(3):
            squares += s[a, b] * s[a, b]
            result[a, b] = 1.0 if a == b else 0.0
    if squares == 0.0:
        return
    k[0, 0], k[1, 1] = s[0, 0] + s[1, 1] + s[2, 2], s[0, 0] - s[1, 1] - s[2, 2]
    k[2, 2], k[3, 3] = s[1, 1] - s[0, 0] - s[2, 2], s[2, 2] - s[0, 0] - s[1, 1]
    k[0, 1], k[0, 2], k[0, 3] = s[2, 1] - s[1, 2], s[0, 2] - s[2, 0], s[1, 0] - s[0, 1]
    k[1, 2], k[1, 3], k[2, 3] = s[0, 1] + s[1, 0], s[0, 2] + s[2, 0], s[1, 2] + s[2, 1]
    for a in range(4):
        for b in range(a):
            k[a, b] = k[b, a]
    # The characteristic polynomial is z^4 - 2 |S|^2 z^2 - 8 det(S) z + det(K). From above all its roots Newton's method
    # descends to the largest one.
    linear = -8 * _minor(s[0], s[1], s[2], 0, 1, 2)
    constant = 0.0
    for b in range(4):
        constant += k[0, b] * _cofactor(k, 0, b)
    scale = np.sqrt(3 * squares)
    largest = scale
    for _ in range(NEWTON_STEPS):
        value = ((largest * largest - 2 * squares) * largest + linear) * largest + constant
        slope = (4 * largest * largest - 4 * squares) * largest + linear
        if slope <= 0.0:
            break
        step = value / slope
        largest -= step
        if step <= SETTLED * scale:
            break
    for a in range(4):
        k[a, a] -= largest
    best, row = 0.0, 0
    for a in range(4):
        size = abs(_cofactor(k, a, a))
        if size > best:
            best, row = size, a
    if best <= UNDETERMINED * scale**3:
        return
    w, x, y, z = _cofactor(k, row, 0), _cofactor(k, row, 1), _cofactor(k, row, 2), _cofactor(k, row, 3)
    unit = 1 / np.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w * unit, x * unit, y * unit, z * unit
    result[0, 0], result[0, 1], result[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    result[1, 0], result[1, 1], result[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    result[2, 0], result[2, 1], result[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@njit()
def _cofactor(k: FloatArray, row: int, column: int) -> float:
    a, b, c = 1 if row == 0 else 0, 2 if row < 2 else 1, 2 if row == 3 else 3
    p, q, r = 1 if column == 0 else 0, 2 if column < 2 else 1, 2 if column == 3 else 3
    sign = 1.0 if (row + column) % 2 == 0 else -1.0
    return sign * _minor(k[a], k[b], k[c], p, q, r)


@njit()
def _minor(first: FloatArray, second: FloatArray, third: FloatArray, p: int, q: int, r: int) -> float:
    """Determinant of three columns of three rows."""
    return (
        first[p] * (second[q] * third[r] - second[r] * third[q])
        - first[q] * (second[p] * third[r] - second[r] * third[p])
        + first[r] * (second[p] * third[q] - second[q] * third[p])
    )
