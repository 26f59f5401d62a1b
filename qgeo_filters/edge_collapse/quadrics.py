"""Quadrics: how far a point is from the planes, lines and boundaries that met at a vertex."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.jit import kernel, njit

# Weight of the lines along the normals beside the planes. It spreads the vertices where the planes leave them free.
_LINES = 1e-3
# Weight of the planes through boundary edges, upright on their triangles, beside the triangles' own.
_BOUNDARY = 10.0
# A minimum whose matrix has a determinant smaller than this, relative to its trace cubed, is not determined.
_FLAT = 1e-12


def vertex_quadrics(vertices: FloatArray, faces: IntArray, face_edges: IntArray, rim: np.ndarray) -> FloatArray:
    """Quadric of each vertex, weighed by area, shape (n, 10).

    A quadric x^T A x - 2 b^T x + c is the row A00, A01, A02, A11, A12, A22, b0, b1, b2, c.

    Parameters
    ----------
    vertices : (n, 3) float64
        About the origin and of about unit size, so that few digits are lost.
    faces, face_edges : (m, 3) int32
    rim : (E,) bool
        Edges of the boundary.

    References
    ----------
    Garland & Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997; Liu, Rahimzadeh & Zordan,
    "Controlling Quadric Error Simplification with Line Quadrics", Computer Graphics Forum 44(5), 2025.
    """
    n = len(vertices)
    total = np.zeros((n, 10))
    _add_all(vertices, faces, face_edges, rim, total, np.zeros((n, 3)), np.zeros(n))
    return total


@njit()
def _add_all(
    vertices: FloatArray, faces: IntArray, face_edges: IntArray, rim: np.ndarray, total: FloatArray,
    normals: FloatArray, areas: FloatArray,
) -> None:  # fmt: skip
    _add_triangles(vertices, faces, face_edges, rim, total, normals, areas)
    _add_lines(vertices, normals, areas, total)


@kernel
def _add_triangles(
    vertices: FloatArray, faces: IntArray, face_edges: IntArray, rim: np.ndarray, total: FloatArray,
    normals: FloatArray, areas: FloatArray,
) -> None:  # fmt: skip
    for f in range(len(faces)):
        p, q, r = vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]]
        ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        vx, vy, vz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(x * x + y * y + z * z)
        if length == 0.0:
            continue
        area = 0.5 * length
        x, y, z = x / length, y / length, z / length
        for k in range(3):
            i, j = faces[f, k], faces[f, (k + 1) % 3]
            _add_plane(total[i], x, y, z, p, area)
            areas[i] += area / 3
            normals[i, 0] += area * x
            normals[i, 1] += area * y
            normals[i, 2] += area * z
            if rim[face_edges[f, k]]:
                tail, head = vertices[i], vertices[j]
                ex, ey, ez = head[0] - tail[0], head[1] - tail[1], head[2] - tail[2]
                square = ex * ex + ey * ey + ez * ez
                side = np.sqrt(square)
                ox, oy, oz = (ey * z - ez * y) / side, (ez * x - ex * z) / side, (ex * y - ey * x) / side
                _add_plane(total[i], ox, oy, oz, tail, _BOUNDARY * square)
                _add_plane(total[j], ox, oy, oz, tail, _BOUNDARY * square)


@kernel
def _add_lines(vertices: FloatArray, normals: FloatArray, areas: FloatArray, total: FloatArray) -> None:
    for v in range(len(vertices)):
        p, q, weight = vertices[v], total[v], _LINES * areas[v]
        # the squared distance to the point, less that to the plane
        q[0] += weight
        q[3] += weight
        q[5] += weight
        for k in range(3):
            q[6 + k] += weight * p[k]
        q[9] += weight * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
        x, y, z = normals[v]
        length = np.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            _add_plane(q, x / length, y / length, z / length, p, -weight)


@kernel
def _add_plane(q: FloatArray, x: float, y: float, z: float, point: FloatArray, weight: float) -> None:
    """Add the squared distance to the plane through a point with this normal."""
    d = x * point[0] + y * point[1] + z * point[2]
    q[0] += weight * x * x
    q[1] += weight * x * y
    q[2] += weight * x * z
    q[3] += weight * y * y
    q[4] += weight * y * z
    q[5] += weight * z * z
    q[6] += weight * d * x
    q[7] += weight * d * y
    q[8] += weight * d * z
    q[9] += weight * d * d


@kernel
def quadric_minimum(q: FloatArray, r: FloatArray, p0: FloatArray, p1: FloatArray, place: FloatArray) -> float:
    """Least value of the sum of two quadrics, and where: of the ends and their middle where none is determined."""
    a, b, c, d, e, f = q[0] + r[0], q[1] + r[1], q[2] + r[2], q[3] + r[3], q[4] + r[4], q[5] + r[5]
    x, y, z, w = q[6] + r[6], q[7] + r[7], q[8] + r[8], q[9] + r[9]
    # cofactors of the symmetric matrix
    m00, m01, m02 = d * f - e * e, c * e - b * f, b * e - c * d
    m11, m12, m22 = a * f - c * c, b * c - a * e, a * d - b * b
    determinant = a * m00 + b * m01 + c * m02
    trace = a + d + f
    if determinant > _FLAT * trace * trace * trace:
        u = (m00 * x + m01 * y + m02 * z) / determinant
        v = (m01 * x + m11 * y + m12 * z) / determinant
        t = (m02 * x + m12 * y + m22 * z) / determinant
        place[0], place[1], place[2] = u, v, t
        return _value(a, b, c, d, e, f, x, y, z, w, u, v, t)
    least = np.inf
    for k in range(3):
        s = 0.5 * k
        u, v, t = (1 - s) * p0[0] + s * p1[0], (1 - s) * p0[1] + s * p1[1], (1 - s) * p0[2] + s * p1[2]
        value = _value(a, b, c, d, e, f, x, y, z, w, u, v, t)
        if value < least:
            least = value
            place[0], place[1], place[2] = u, v, t
    return least


@kernel
def _value(
    a: float, b: float, c: float, d: float, e: float, f: float, x: float, y: float, z: float, w: float,
    u: float, v: float, t: float,
) -> float:  # fmt: skip
    square = a * u * u + d * v * v + f * t * t + 2 * (b * u * v + c * u * t + e * v * t)
    return max(square - 2 * (x * u + y * v + z * t) + w, 0.0)
