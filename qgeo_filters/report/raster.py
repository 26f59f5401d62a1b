"""Which triangle is seen at each pixel, and where in it: a z-buffer without a screen or a GPU."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qgeo_filters.jit import njit


class Fragments(NamedTuple):
    """What the pixels of a picture see, row 0 at the top.

    Attributes
    ----------
    face : (height, width) int32
        Nearest triangle, -1 where there is none.
    weights : (height, width, 3) float32
        Barycentric coordinates of the pixel's centre in that triangle.
    depth : (height, width) float32
        Third screen coordinate, larger is nearer; -inf where there is no triangle.
    """

    face: npt.NDArray[np.int32]
    weights: npt.NDArray[np.float32]
    depth: npt.NDArray[np.float32]


@njit()
def _fill(points, faces, face, weights, depth):  # type: ignore[no-untyped-def]
    height, width = face.shape
    for f in range(faces.shape[0]):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = points[i, 0], points[i, 1], points[i, 2]
        bx, by, bz = points[j, 0], points[j, 1], points[j, 2]
        cx, cy, cz = points[k, 0], points[k, 1], points[k, 2]
        twice_area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if twice_area == 0.0:
            continue  # seen edge-on
        first_x = max(int(np.ceil(min(ax, bx, cx) - 0.5)), 0)
        last_x = min(int(np.floor(max(ax, bx, cx) - 0.5)), width - 1)
        first_y = max(int(np.ceil(min(ay, by, cy) - 0.5)), 0)
        last_y = min(int(np.floor(max(ay, by, cy) - 0.5)), height - 1)
        for y in range(first_y, last_y + 1):
            for x in range(first_x, last_x + 1):
                px, py = x + 0.5, y + 0.5
                u = ((bx - px) * (cy - py) - (by - py) * (cx - px)) / twice_area
                v = ((cx - px) * (ay - py) - (cy - py) * (ax - px)) / twice_area
                w = 1.0 - u - v
                # The allowance closes the cracks that rounding leaves between two triangles on one edge.
                if u < -1e-9 or v < -1e-9 or w < -1e-9:
                    continue
                z = u * az + v * bz + w * cz
                if z > depth[y, x]:
                    depth[y, x] = z
                    face[y, x] = f
                    weights[y, x, 0] = u
                    weights[y, x, 1] = v
                    weights[y, x, 2] = w


def rasterize(points: npt.NDArray[np.float64], faces: npt.NDArray[np.int32], width: int, height: int) -> Fragments:
    """Nearest triangle at every pixel, hidden surfaces removed.

    Parameters
    ----------
    points : (n, 3) float64
        Screen coordinates of the vertices: pixels to the right, pixels down, and depth (larger is nearer).
        Pixel (row r, column c) covers [c, c + 1) x [r, r + 1) and is sampled at its centre.
    faces : (m, 3) int32
    width, height : int
        In pixels.
    """
    face = np.full((height, width), -1, np.int32)
    weights = np.zeros((height, width, 3), np.float32)
    depth = np.full((height, width), -np.inf, np.float32)
    _fill(np.ascontiguousarray(points, np.float64), np.ascontiguousarray(faces, np.int32), face, weights, depth)
    return Fragments(face, weights, depth)
