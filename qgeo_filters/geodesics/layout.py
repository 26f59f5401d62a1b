"""Triangles laid out in the plane from their side lengths: what unfolding needs, computed once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qgeo_filters.geodesics.metric import IntrinsicMesh

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]


class Layout(NamedTuple):
    """Flat arrays over the sides ``3 f + k`` of a mesh, and the corners at each vertex.

    With a side on the x axis, its start at the origin, the third vertex of its triangle lies at
    ``(apex_x, apex_y)``, ``apex_y >= 0``.
    """

    start: IntArray  # (3m,) first vertex of each side
    length: FloatArray  # (3m,)
    apex_x: FloatArray  # (3m,)
    apex_y: FloatArray  # (3m,)
    twin: IntArray  # (3m,) side across, -1 on the boundary
    corner_start: IntArray  # (n + 1,) corners of vertex v are corners[corner_start[v] : corner_start[v + 1]]
    corners: IntArray  # (3m,) each names its vertex by the side that starts there


def layout_of(mesh: IntrinsicMesh) -> Layout:
    """Planar layout of every triangle from each of its sides.

    Needles and triangles that are flat within rounding are safe: the height comes from Kahan's
    form of Heron's formula and is clamped at zero.
    """
    lengths = mesh.lengths
    sides = np.sort(lengths, axis=1)
    c, b, a = sides.T
    double_area = 0.5 * np.sqrt(np.maximum((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c)), 0.0))
    following, previous = np.roll(lengths, -1, axis=1), np.roll(lengths, -2, axis=1)
    safe = np.where(lengths > 0, lengths, 1.0)
    apex_x = np.where(lengths > 0, 0.5 * (lengths + (previous - following) * ((previous + following) / safe)), 0.0)
    apex_y = np.where(lengths > 0, double_area[:, None] / safe, previous)
    start = np.ascontiguousarray(mesh.faces, dtype=np.int32).ravel()
    order = np.argsort(start, kind="stable").astype(np.int32)
    corner_start = np.searchsorted(start[order], np.arange(mesh.n_vertices + 1)).astype(np.int32)
    return Layout(
        start,
        np.ascontiguousarray(lengths, dtype=np.float64).ravel(),
        apex_x.ravel(),
        apex_y.ravel(),
        np.ascontiguousarray(mesh.twins, dtype=np.int32).ravel(),
        corner_start,
        order,
    )
