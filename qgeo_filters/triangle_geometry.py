"""Cross products and normals of triangles given as arrays, for what lies below `Surface`."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray


def face_crosses(vertices: np.ndarray, faces: np.ndarray) -> FloatArray:
    """Cross product of two edges of each triangle, shape (m, 3): along the normal, twice the area long."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    crosses: FloatArray = np.cross(b - a, c - a)
    return crosses


def unit_normals(crosses: np.ndarray) -> FloatArray:
    """Normal of length one of each triangle, shape (m, 3), from `face_crosses`; zero where there is no area."""
    length = np.linalg.norm(crosses, axis=1, keepdims=True)
    normals: FloatArray = np.divide(crosses, length, out=np.zeros_like(crosses), where=length > 0)
    return normals
