"""Triangles laid flat from their side lengths alone: apexes, angles, and where geodesics may bend."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.geodesics.flat_corners import flat_views
from qgeo_filters.geodesics.metric import IntrinsicMesh

# Slack of the tests "angle at least 2 pi" (inside) and "at least pi" (boundary), radians. Taking too many
# vertices for ones where a shortest path may bend costs time and never accuracy; on a flat mesh it closes
# the gaps that rounding leaves behind a vertex.
ANGLE_SLACK = 1e-6
SHORT = 1e-8
# Sides whose two shorter ones are longer than the third by no more than this, relatively, are those of a triangle
# without area: each side is rounded, and by as much.
ROUNDING = 4 * np.finfo(np.float64).eps

SIDE = np.dtype(
    [
        ("length", "f8"),
        ("cx", "f8"),  # the apex
        ("cy", "f8"),
        ("from_head", "f8"),  # length - cx, without cancellation
        ("tail", "i8"),  # first vertex
        ("twin", "i8"),  # half-edge across, -1 on the boundary
        ("aligned", "i8"),  # whether the twin starts at the same vertex, as where the orientation flips
    ]
)


class UnfoldedMesh(NamedTuple):
    """Every triangle laid flat beside each of its sides; half-edge h is side ``h % 3`` of face ``h // 3``.

    The frame of a half-edge has its first vertex at the origin, its second on the positive x-axis and the
    third vertex of the face, the apex, at y >= 0.
    """

    sides: npt.NDArray[np.void]  # (3 m,) SIDE
    angles: FloatArray  # (n,) total angle about each vertex
    boundary: npt.NDArray[np.bool_]  # (n,)
    bends: npt.NDArray[np.bool_]  # (n,) a shortest path may bend here: saddle, flat, or reflex on the boundary
    corner_start: IndexArray  # (n + 1,) corners of vertex v are corners[corner_start[v]:corner_start[v + 1]]
    corners: IndexArray  # (3 m,) as 3 f + k
    view_start: IndexArray  # (n + 1,) views of vertex v are views[view_start[v]:view_start[v + 1]]
    views: npt.NDArray[np.void]  # VIEW: what vertices see through a side that they lie on


def triangle_doubled_areas(lengths: FloatArray, rounding: float = ROUNDING) -> FloatArray:
    """Twice the area of triangles with sides (m, 3), by Kahan's formula that keeps the digits of needles.

    Sides that cannot be told from those of three points on a line give 0: rounding them would give a height of 1e-8.
    """
    c, b, a = np.sort(lengths, axis=1).T
    excess = c - (a - b)
    product = (a + (b + c)) * np.where(excess > rounding * a, excess, 0.0) * (c + (a - b)) * (a + (b - c))
    return 0.5 * np.sqrt(np.maximum(product, 0.0))


def _abscissa(own: FloatArray, near: FloatArray, far: FloatArray) -> FloatArray:
    """``(own^2 + near^2 - far^2) / (2 own)`` with an error that is small beside ``near``, however short it is."""
    safe = np.where(own > 0.0, own, 1.0)
    by_near = own + (near - far) * ((near + far) / safe)
    by_own = (own - far) * ((own + far) / safe) + near * (near / safe)
    x = np.where(own > 0.0, 0.5 * np.where(near < own, by_own, by_near), 0.0)
    return np.clip(x, -near, near)  # sides that rounding has left short of the triangle inequality


def apexes(lengths: FloatArray, rounding: float = ROUNDING) -> FloatArray:
    """Third vertex of each triangle beside each of its sides, shape (m, 3, 3).

    Its abscissa from the first vertex of the side, its abscissa backwards from the second one (their sum is
    the length; each has the accuracy that a vertex close to that end needs), and its height.
    """
    back = np.roll(lengths, 1, axis=1)  # from the third vertex to the first
    ahead = np.roll(lengths, -1, axis=1)  # from the second vertex to the third
    height = triangle_doubled_areas(lengths, rounding)[:, None] / np.where(lengths > 0.0, lengths, 1.0)
    height = np.where(lengths > 0.0, height, back)
    return np.stack([_abscissa(lengths, back, ahead), _abscissa(lengths, ahead, back), height], axis=-1)


def corner_angles(lengths: FloatArray, rounding: float = ROUNDING) -> FloatArray:
    """Angle at each corner of triangles given by their sides, shape (m, 3), radians."""
    apex = apexes(lengths, rounding)
    return np.arctan2(apex[..., 2], apex[..., 0])


def vertex_angles(mesh: IntrinsicMesh, rounding: float = ROUNDING) -> FloatArray:
    """Total angle about each vertex, shape (n,), radians."""
    angles = corner_angles(mesh.lengths, rounding)
    return np.bincount(mesh.faces.ravel(), angles.ravel(), minlength=mesh.n_vertices).astype(np.float64)


def boundary_mask(mesh: IntrinsicMesh) -> npt.NDArray[np.bool_]:
    """Whether each vertex lies on the boundary, shape (n,)."""
    on_boundary = np.zeros(mesh.n_vertices, dtype=np.bool_)
    f, k = np.nonzero(mesh.twins < 0)
    on_boundary[mesh.faces[f, k]] = True
    on_boundary[mesh.faces[f, (k + 1) % 3]] = True
    return on_boundary


def corners_around(mesh: IntrinsicMesh) -> tuple[IndexArray, IndexArray]:
    """Corners ``3 f + k`` by vertex, shape (3 m,), and where those of each vertex start, shape (n + 1,)."""
    counts = np.bincount(mesh.faces.ravel(), minlength=mesh.n_vertices)
    return np.concatenate([[0], np.cumsum(counts)]), np.argsort(mesh.faces.ravel(), kind="stable")


def unfolded(mesh: IntrinsicMesh, rounding: float = ROUNDING) -> UnfoldedMesh:
    """The mesh with every triangle laid flat beside each of its sides.

    Triangles have no area whose sides fall short of one, relatively, by no more than ``rounding``.
    """
    faces, lengths = mesh.faces, mesh.lengths
    sides = _laid_flat(mesh, rounding)
    angles, boundary = vertex_angles(mesh, rounding), boundary_mask(mesh)
    bends = angles > np.where(boundary, np.pi, 2 * np.pi) - ANGLE_SLACK
    # A side without length has no windows: both of its ends must pass the wave on instead. So must those of a
    # very short one, where rounding of the long sides leaves the angles uncertain.
    collapsed = lengths <= SHORT * lengths.max(axis=1, keepdims=True)
    bends[faces[collapsed]] = True
    bends[np.roll(faces, -1, axis=1)[collapsed]] = True
    views = flat_views(sides, mesh.n_vertices)
    return UnfoldedMesh(sides, angles, boundary, bends, *corners_around(mesh), *views)


def _laid_flat(mesh: IntrinsicMesh, rounding: float) -> npt.NDArray[np.void]:
    sides = np.zeros(mesh.faces.size, dtype=SIDE)
    sides["length"] = mesh.lengths.ravel()
    sides["cx"], sides["from_head"], sides["cy"] = apexes(mesh.lengths, rounding).reshape(-1, 3).T
    sides["tail"], sides["twin"] = mesh.faces.ravel(), mesh.twins.ravel()
    sides["aligned"] = (sides["twin"] >= 0) & (sides["tail"] == sides["tail"][sides["twin"]])
    return sides


class UnfoldedSides(NamedTuple):
    """The same as `UnfoldedMesh`, as short flat arrays: of these the graph's kernel needs few at a time.

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
    view_start: IndexArray  # (n + 1,), and what vertices see through a side that they lie on, as in `UnfoldedMesh`
    views: npt.NDArray[np.void]


def unfolded_sides(mesh: IntrinsicMesh) -> UnfoldedSides:
    """Planar layout of every triangle from each of its sides."""
    apex = apexes(mesh.lengths)
    corner_start, corners = corners_around(mesh)
    return UnfoldedSides(
        np.ascontiguousarray(mesh.faces, dtype=np.int32).ravel(),
        np.ascontiguousarray(mesh.lengths, dtype=np.float64).ravel(),
        apex[..., 0].ravel(),
        apex[..., 2].ravel(),
        np.ascontiguousarray(mesh.twins, dtype=np.int32).ravel(),
        corner_start.astype(np.int32),
        corners.astype(np.int32),
        *flat_views(_laid_flat(mesh, ROUNDING), mesh.n_vertices),
    )
