"""Whether a map keeps the orientation of a surface: what tells it from its mirrored twin."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters.surface import Surface


def orientation(x: Surface, y: Surface, p2p: npt.NDArray[np.int64]) -> float:
    """Mean cosine between the normals of X's mapped triangles and Y's normals at their corners, -1 to 1.

    Weighted by the area of the triangles on X. Near +0.7 for a good map between discrete surfaces and near -0.7 for
    its mirrored twin; triangles that the map collapses count as zero.
    """
    return float(x.face_areas @ normal_cosines(y, p2p[x.faces]) / x.area)


def normal_cosines(y: Surface, corners: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """Cosine (m,) between the normal of each triangle of vertices of Y (m, 3), any three, and Y's normals there."""
    a, b, c = (y.vertices[corners[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    normal = y.vertex_normals[corners].sum(axis=1)
    size = np.linalg.norm(cross, axis=1) * np.linalg.norm(normal, axis=1)
    return np.divide(np.einsum("ij,ij->i", cross, normal), size, out=np.zeros(len(size)), where=size > 0)
