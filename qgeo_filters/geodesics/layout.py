"""The unfolded triangles as the graph's kernel reads them: short flat arrays, of which it needs few at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.geodesics.metric import IntrinsicMesh
from qgeo_filters.geodesics.unfolding import apexes, corners_around


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
    """Planar layout of every triangle from each of its sides."""
    apex = apexes(mesh.lengths)
    corner_start, corners = corners_around(mesh)
    return Layout(
        np.ascontiguousarray(mesh.faces, dtype=np.int32).ravel(),
        np.ascontiguousarray(mesh.lengths, dtype=np.float64).ravel(),
        apex[..., 0].ravel(),
        apex[..., 2].ravel(),
        np.ascontiguousarray(mesh.twins, dtype=np.int32).ravel(),
        corner_start.astype(np.int32),
        corners.astype(np.int32),
    )
