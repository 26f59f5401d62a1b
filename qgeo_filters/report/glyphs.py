"""Points and curves as small solids, so that they are hidden and shaded like the surface they lie on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.errors import ParameterError


class Glyph(NamedTuple):
    """A solid of one colour."""

    vertices: FloatArray
    faces: IntArray
    color: tuple[float, float, float]


def ball(center: npt.ArrayLike, radius: float, color: tuple[float, float, float], segments: int = 24) -> Glyph:
    """Sphere about a point."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, segments // 2 + 1)
    profile = np.column_stack([np.cos(latitude), np.sin(latitude)])
    around = np.linspace(0.0, 2 * np.pi, segments, endpoint=False)
    rings = np.stack(
        [
            np.outer(profile[:, 0], np.cos(around)),
            np.outer(profile[:, 0], np.sin(around)),
            np.repeat(profile[:, 1:], segments, axis=1),
        ],
        axis=2,
    )
    return Glyph(np.asarray(center, float) + radius * rings.reshape(-1, 3), _sleeve(len(profile), segments), color)


def tube(points: npt.ArrayLike, radius: float, color: tuple[float, float, float], segments: int = 10) -> Glyph:
    """Round tube along a polyline of shape (p, 3), p >= 2; repeated points are passed over.

    Raises
    ------
    ValueError
        If fewer than two different points are left.
    """
    line = np.asarray(points, dtype=np.float64)
    step = np.linalg.norm(np.diff(line, axis=0), axis=1)
    line = line[np.append(True, step > 1e-12 * max(float(step.sum()), 1e-300))]
    if len(line) < 2:
        raise ParameterError("a tube needs at least two different points")
    along = np.diff(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # At a bend the ring lies in the plane that halves the angle.
    tangent = np.concatenate([along[:1], along[:-1] + along[1:], along[-1:]])
    length = np.linalg.norm(tangent, axis=1, keepdims=True)
    tangent = np.where(length > 1e-9, tangent / np.maximum(length, 1e-9), np.concatenate([along, along[-1:]]))
    normal = _transported_normals(tangent)
    across = np.cross(tangent, normal)
    angle = np.linspace(0.0, 2 * np.pi, segments, endpoint=False)
    rings = (
        line[:, None]
        + radius * np.cos(angle)[None, :, None] * normal[:, None]
        + radius * np.sin(angle)[None, :, None] * across[:, None]
    )
    return Glyph(rings.reshape(-1, 3), _sleeve(len(line), segments), color)


def _transported_normals(tangent: FloatArray) -> FloatArray:
    """Unit vectors across the tangents that turn as little as possible from one to the next."""
    normal = np.empty_like(tangent)
    current = np.eye(3)[np.abs(tangent[0]).argmin()]
    for k, direction in enumerate(tangent):
        projected = current - (current @ direction) * direction
        if np.linalg.norm(projected) < 1e-6:  # a turn straight onto the old normal
            helper = np.eye(3)[np.abs(direction).argmin()]
            projected = helper - (helper @ direction) * direction
        normal[k] = current = projected / np.linalg.norm(projected)
    return normal


def _sleeve(rings: int, segments: int) -> IntArray:
    """Triangles between consecutive rings of points."""
    i, j = np.meshgrid(np.arange(rings - 1), np.arange(segments), indexing="ij")
    a, b = (i * segments + j).ravel(), (i * segments + (j + 1) % segments).ravel()
    faces = np.concatenate([np.column_stack([a, b, b + segments]), np.column_stack([a, b + segments, a + segments])])
    return faces.astype(np.int32)
