"""Deformation gradients: the linear map of each triangle, and of its normal, from one position to another."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.jit import njit

# A triangle whose area is below this share of its longest side squared has no direction across: it counts as flat.
_FLAT = 1e-9


class TriangleFrames:
    """Triangles at rest, as frames of two edges and the normal.

    Parameters
    ----------
    vertices : (n, 3) float64
    faces : (m, 3) int

    Attributes
    ----------
    inverses : (m, 3, 3) float64
        Inverse of the matrix whose columns are two edges and the normal, as long as the root of the doubled area;
        zero for triangles without area.
    flat : (m,) bool
        Triangles without area, whose gradient is not known.

    References
    ----------
    Sumner and Popovic, "Deformation transfer for triangle meshes", SIGGRAPH 2004, section 3.
    """

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        self.faces: npt.NDArray[np.int64] = np.ascontiguousarray(faces, dtype=np.int64)
        self.inverses, self.flat = _inverse_frames(np.ascontiguousarray(vertices), self.faces)

    def gradients(self, positions: FloatArray) -> FloatArray:
        """Gradient (m, 3, 3) of each triangle from rest to these positions (n, 3); the identity where it is flat."""
        return _gradients(self.inverses, self.flat, self.faces, np.ascontiguousarray(positions))


@njit()
def _frame(vertices: FloatArray, face: npt.NDArray[np.int64], frame: FloatArray) -> float:
    """Two edges and the scaled normal as columns; returns the doubled area."""
    for c in range(3):
        frame[c, 0] = vertices[face[1], c] - vertices[face[0], c]
        frame[c, 1] = vertices[face[2], c] - vertices[face[0], c]
    x = frame[1, 0] * frame[2, 1] - frame[2, 0] * frame[1, 1]
    y = frame[2, 0] * frame[0, 1] - frame[0, 0] * frame[2, 1]
    z = frame[0, 0] * frame[1, 1] - frame[1, 0] * frame[0, 1]
    double = np.sqrt(x * x + y * y + z * z)
    scale = 1 / np.sqrt(double) if double > 0 else 0.0
    frame[0, 2], frame[1, 2], frame[2, 2] = scale * x, scale * y, scale * z
    return double


@njit()
def _inverse_frames(vertices: FloatArray, faces: npt.NDArray[np.int64]) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    m = len(faces)
    inverses = np.zeros((m, 3, 3))
    flat = np.zeros(m, dtype=np.bool_)
    f = np.empty((3, 3))
    for t in range(m):
        double = _frame(vertices, faces[t], f)
        side = 0.0
        for c in range(3):
            side += max(f[c, 0] * f[c, 0], f[c, 1] * f[c, 1])
        if not double > _FLAT * side:
            flat[t] = True
            continue
        determinant = double * np.sqrt(double)  # of the edges and a normal at right angles to them
        for r in range(3):
            p, q = (r + 1) % 3, (r + 2) % 3
            for c in range(3):
                a, b = (c + 1) % 3, (c + 2) % 3
                inverses[t, r, c] = (f[a, p] * f[b, q] - f[b, p] * f[a, q]) / determinant
    return inverses, flat


@njit()
def _gradients(
    inverses: FloatArray, flat: npt.NDArray[np.bool_], faces: npt.NDArray[np.int64], positions: FloatArray
) -> FloatArray:
    m = len(faces)
    result = np.zeros((m, 3, 3))
    f = np.empty((3, 3))
    for t in range(m):
        if flat[t]:
            for r in range(3):
                result[t, r, r] = 1.0
            continue
        _frame(positions, faces[t], f)
        for r in range(3):
            for c in range(3):
                result[t, r, c] = (
                    f[r, 0] * inverses[t, 0, c] + f[r, 1] * inverses[t, 1, c] + f[r, 2] * inverses[t, 2, c]
                )
    return result
