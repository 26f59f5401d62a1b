"""Nearest point of a coarse surface to each vertex, sought from the vertex into which it went."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.jit import kernel, njit


def nearest_places(
    points: FloatArray, starts: IndexArray, vertices: FloatArray, faces: IntArray
) -> tuple[IndexArray, FloatArray]:
    """Triangle nearest to each point (k, 3) and the nearest point's barycentric coordinates (k, 3).

    It is sought downhill, from the triangles around a vertex that is given for each point to those around the corners
    of the nearest of them, and so on: the search stays on one sheet where two pass close to each other.
    """
    corner = np.argsort(faces, axis=None, kind="stable").astype(np.int32)
    first = np.searchsorted(faces.ravel()[corner], np.arange(len(vertices) + 1)).astype(np.int32)
    nearest, coordinates = np.empty(len(points), dtype=np.int64), np.empty((len(points), 3))
    looked = np.full(len(faces), -1, dtype=np.int64)
    _seek(points, starts, vertices, faces, first, corner // 3, nearest, coordinates, np.empty(3), looked)
    return nearest, coordinates


@njit()
def _seek(
    points: FloatArray, starts: IndexArray, vertices: FloatArray, faces: IntArray, first: IntArray, around: IntArray,
    nearest: IndexArray, coordinates: FloatArray, weights: FloatArray, looked: IndexArray,
) -> None:  # fmt: skip
    _seek_all(points, starts, vertices, faces, first, around, nearest, coordinates, weights, looked)


@kernel
def _seek_all(
    points: FloatArray, starts: IndexArray, vertices: FloatArray, faces: IntArray, first: IntArray, around: IntArray,
    nearest: IndexArray, coordinates: FloatArray, weights: FloatArray, looked: IndexArray,
) -> None:  # fmt: skip
    for i in range(len(points)):
        least, best = np.inf, -1
        corners = (starts[i], starts[i], starts[i])
        while True:
            before = best
            for v in corners:
                for j in range(first[v], first[v + 1]):
                    f = around[j]
                    if looked[f] == i:
                        continue
                    looked[f] = i
                    gap = _gap(points[i], vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]], weights)
                    if gap < least:
                        least, best = gap, f
                        coordinates[i, 0], coordinates[i, 1], coordinates[i, 2] = weights[0], weights[1], weights[2]
            if best == before:
                break
            corners = (faces[best, 0], faces[best, 1], faces[best, 2])
        nearest[i] = best


@kernel
def _gap(p: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray, weights: FloatArray) -> float:
    """Squared distance of a point from a triangle, and the weights of the nearest point.

    Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.
    """
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x, y, z = p[0] - a[0], p[1] - a[1], p[2] - a[2]
    d1, d2 = ux * x + uy * y + uz * z, vx * x + vy * y + vz * z
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    d3, d4, d5, d6 = d1 - uu, d2 - uv, d1 - uv, d2 - vv
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    s, t = 0.0, 0.0
    if d1 <= 0 and d2 <= 0:
        pass
    elif d3 >= 0 and d4 <= d3:
        s = 1.0
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        s = d1 / (d1 - d3)
    elif d6 >= 0 and d5 <= d6:
        t = 1.0
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        t = d2 / (d2 - d6)
    elif va <= 0 and d4 >= d3 and d5 >= d6:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        s = 1.0 - t
    else:
        total = va + vb + vc
        if total > 0:
            s, t = vb / total, vc / total
    weights[0], weights[1], weights[2] = max(1.0 - s - t, 0.0), s, t
    x, y, z = x - s * ux - t * vx, y - s * uy - t * vy, z - s * uz - t * vz
    return x * x + y * y + z * z
