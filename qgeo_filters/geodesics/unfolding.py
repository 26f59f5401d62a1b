"""Triangles laid flat from their side lengths alone: apexes, angles, and where geodesics may bend."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qgeo_filters.geodesics.metric import IntrinsicMesh

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

# Slack of the tests "angle at least 2 pi" (inside) and "at least pi" (boundary), radians. Taking too many
# vertices for ones where a shortest path may bend costs time and never accuracy; on a flat mesh it closes
# the gaps that rounding leaves behind a vertex.
ANGLE_SLACK = 1e-6


class UnfoldedMesh(NamedTuple):
    """Every triangle laid flat beside each of its sides; half-edge h is side ``h % 3`` of face ``h // 3``.

    The frame of a half-edge has its first vertex at the origin, its second on the positive x-axis and the
    third vertex of the face, the apex, at y >= 0.
    """

    faces: IntArray  # (m, 3)
    twins: IntArray  # (3 m,) -1 on the boundary
    aligned: npt.NDArray[np.bool_]  # (3 m,) the twin starts at the same vertex
    lengths: FloatArray  # (3 m,)
    apex: FloatArray  # (3 m, 2)
    bends: npt.NDArray[np.bool_]  # (n,) a shortest path may bend here: saddle, flat, or reflex on the boundary
    corner_start: IntArray  # (n + 1,) corners of vertex v are corners[corner_start[v]:corner_start[v + 1]]
    corners: IntArray  # (3 m,) as 3 f + k


def triangle_doubled_areas(lengths: FloatArray) -> FloatArray:
    """Twice the area of triangles with sides (m, 3), by Kahan's formula that keeps the digits of needles.

    Sides that rounding has left short of the triangle inequality give 0.
    """
    c, b, a = np.sort(lengths, axis=1).T
    product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return 0.5 * np.sqrt(np.maximum(product, 0.0))


def apexes(lengths: FloatArray) -> FloatArray:
    """Third vertex of each triangle in the frame of each of its sides, shape (m, 3, 2)."""
    own = lengths
    back = np.roll(lengths, 1, axis=1)  # from the third vertex to the first
    ahead = np.roll(lengths, -1, axis=1)  # from the second vertex to the third
    safe = np.where(own > 0.0, own, 1.0)
    x = 0.5 * (own + (back - ahead) * ((back + ahead) / safe))
    y = triangle_doubled_areas(lengths)[:, None] / safe
    return np.stack([np.where(own > 0.0, x, 0.0), np.where(own > 0.0, y, back)], axis=-1)


def corner_angles(lengths: FloatArray) -> FloatArray:
    """Angle at each corner of triangles given by their sides, shape (m, 3), radians."""
    apex = apexes(lengths)
    return np.arctan2(apex[..., 1], apex[..., 0])


def vertex_angles(mesh: IntrinsicMesh) -> FloatArray:
    """Total angle about each vertex, shape (n,), radians."""
    angles = corner_angles(mesh.lengths)
    return np.bincount(mesh.faces.ravel(), angles.ravel(), minlength=mesh.n_vertices).astype(np.float64)


def boundary_mask(mesh: IntrinsicMesh) -> npt.NDArray[np.bool_]:
    """Whether each vertex lies on the boundary, shape (n,)."""
    on_boundary = np.zeros(mesh.n_vertices, dtype=np.bool_)
    f, k = np.nonzero(mesh.twins < 0)
    on_boundary[mesh.faces[f, k]] = True
    on_boundary[mesh.faces[f, (k + 1) % 3]] = True
    return on_boundary


def unfolded(mesh: IntrinsicMesh) -> UnfoldedMesh:
    """The mesh with every triangle laid flat beside each of its sides."""
    faces = np.ascontiguousarray(mesh.faces, dtype=np.int32)
    lengths = np.ascontiguousarray(mesh.lengths, dtype=np.float64)
    twins = np.ascontiguousarray(mesh.twins, dtype=np.int32).ravel()
    tails = faces.ravel()
    aligned = (twins >= 0) & (tails == tails[np.maximum(twins, 0)])
    straight = np.where(boundary_mask(mesh), np.pi, 2 * np.pi)
    bends = vertex_angles(mesh) > straight - ANGLE_SLACK
    # A side without length has no windows: both of its ends must pass the wave on instead.
    collapsed = lengths == 0.0
    bends[faces[collapsed]] = True
    bends[np.roll(faces, -1, axis=1)[collapsed]] = True
    corners = np.argsort(tails, kind="stable").astype(np.int32)
    start = np.concatenate([[0], np.cumsum(np.bincount(tails, minlength=mesh.n_vertices))]).astype(np.int32)
    apex = np.ascontiguousarray(apexes(lengths).reshape(-1, 2))
    return UnfoldedMesh(faces, twins, aligned, lengths.ravel(), apex, bends, start, corners)
