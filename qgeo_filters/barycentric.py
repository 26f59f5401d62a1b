"""Points inside triangles by their barycentric coordinates, and what such points carry over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.array_likes import as_array
from qgeo_filters.missing_values import with_missing
from qgeo_filters.validation import frozen

_SIDES = ((0, 1), (1, 2), (2, 0))


@dataclass(frozen=True, eq=False)
class BarycentricMap:
    """Point of a triangle of Y for each vertex of X.

    Attributes
    ----------
    faces : (n_x,) int64
        Triangle of Y; -1: no point.
    corners : (n_x, 3) int64
        Its vertices; -1 where there is no point.
    coordinates : (n_x, 3) float64
        Weights of the corners, not negative, with sum 1; NaN where there is no point.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> middles = qg.BarycentricMap(np.arange(320), x.faces.astype(np.int64), np.full((320, 3), 1 / 3))
    >>> np.allclose(middles.pulled_back(x.vertices), x.vertices[x.faces].mean(axis=1))
    True
    """

    faces: IndexArray
    corners: IndexArray
    coordinates: FloatArray

    def __repr__(self) -> str:
        known = int((self.faces >= 0).sum())
        lost = f", {len(self.faces) - known} without" if known < len(self.faces) else ""
        return f"{type(self).__name__}({known} points in triangles{lost})"

    @classmethod
    def unknown(cls, count: int) -> BarycentricMap:
        """Map without any point, its arrays open for those that are found."""
        return cls(
            np.full(count, -1, dtype=np.int64), np.full((count, 3), -1, dtype=np.int64), np.full((count, 3), np.nan)
        )

    @classmethod
    def at_vertices(cls, vertices: IndexArray, faces: IntArray, count: int) -> BarycentricMap:
        """Vertices (n_x,) of Y, which has so many, as corners of its triangles; no point for -1, and for loose ones."""
        face_of = np.full(count, -1, dtype=np.int64)
        face_of[faces.ravel()] = np.repeat(np.arange(len(faces)), 3)
        place = cls.unknown(len(vertices))
        known = vertices >= 0
        place.faces[known] = face_of[vertices[known]]
        known &= place.faces >= 0
        place.corners[known] = faces[place.faces[known]]
        place.coordinates[known] = place.corners[known] == vertices[known, None]
        return cls(frozen(place.faces), frozen(place.corners), frozen(place.coordinates))

    @property
    def nearest_corner(self) -> IndexArray:
        """Corner of largest weight, (n_x,); -1 where there is no point."""
        return np.take_along_axis(self.corners, self.coordinates.argmax(axis=1)[:, None], axis=1)[:, 0]

    def only(self, there: npt.NDArray[np.bool_]) -> BarycentricMap:
        """The same points, and none where this (n_x,) is False."""
        return BarycentricMap(
            frozen(np.where(there, self.faces, -1)),
            frozen(np.where(there[:, None], self.corners, -1)),
            frozen(np.where(there[:, None], self.coordinates, np.nan)),
        )

    def pulled_back(self, values: npt.ArrayLike) -> np.ndarray:
        """Values of Y, (n_y, ...), at the images of the vertices of X, (n_x, ...).

        Floating-point values are interpolated. Whole numbers (labels, indices) and booleans are taken from the
        nearest corner, since an interpolated label means nothing. Where there is no point stand NaN, -1, False or "".

        Raises
        ------
        ParameterError
            Unsigned numbers, of which none says "no point", where a point is missing.
        """
        array = as_array(values)
        if array.dtype.kind in "fc":
            return np.einsum("ij,ij...->i...", self.coordinates, array[self.corners])
        return with_missing(array[self.nearest_corner], self.faces < 0)


def nearest_in_triangles(points: FloatArray, triangles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Barycentric coordinates (k, 3) of the point of each triangle (k, 3, 3) nearest to a point, and its distance."""
    a = triangles[:, 0]
    u, v, w = triangles[:, 1] - a, triangles[:, 2] - a, points - a
    uu, uv, vv = (np.einsum("ij,ij->i", *pair) for pair in ((u, u), (u, v), (v, v)))
    wu, wv = (np.einsum("ij,ij->i", w, side) for side in (u, v))
    determinant = uu * vv - uv * uv
    with np.errstate(divide="ignore", invalid="ignore"):
        s, t = (vv * wu - uv * wv) / determinant, (uu * wv - uv * wu) / determinant
        # A triangle without area has no inside, but sides.
        inside = (s >= 0) & (t >= 0) & (s + t <= 1)
        weights = np.where(inside[:, None], np.column_stack([np.maximum(1 - s - t, 0.0), s, t]), 0.0)
    least = np.where(inside, -1.0, np.inf)
    for i, j in _SIDES:
        side = triangles[:, j] - triangles[:, i]
        squared = np.einsum("ij,ij->i", side, side)
        along = np.einsum("ij,ij->i", points - triangles[:, i], side) / np.where(squared > 0, squared, 1.0)
        along = np.clip(along, 0.0, 1.0)
        gap = np.linalg.norm(triangles[:, i] + along[:, None] * side - points, axis=1)
        nearer = gap < least
        least[nearer] = gap[nearer]
        weights[nearer] = 0.0
        weights[nearer, i], weights[nearer, j] = 1 - along[nearer], along[nearer]
    return weights, np.linalg.norm(np.einsum("ij,ijk->ik", weights, triangles) - points, axis=1)
