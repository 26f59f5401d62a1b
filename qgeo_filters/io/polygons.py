"""Polygons as flat arrays, and triangles that cover each polygon and nothing else.

A fan is taken where each of its triangles is turned as the polygon is, as in every convex one: such triangles cover
a simple polygon exactly once. The other polygons, one after the other, go through `mapbox_earcut` in the plane of their
mean normal (Newell's). It leaves out corners on a straight line, which a neighbour may need; they are put back.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mapbox_earcut
import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import MeshError
from qgeo_filters.io.raw_mesh import counted
from qgeo_filters.io.text_numbers import whole
from qgeo_filters.validation import checked_vertices, listed

_FLAT = 1e-12  # twice an area, where the polygon is about one wide: rounding


@dataclass(frozen=True, eq=False)
class Polygons:
    """Faces of any number of corners.

    Attributes
    ----------
    corners : (total,) int64
        Vertex indices of all faces, one face after the other.
    sizes : (m,) int64
        Number of corners of each face.
    """

    corners: IndexArray
    sizes: IndexArray

    @classmethod
    def of_rows(cls, rows: Sequence[Any] | np.ndarray) -> Polygons:
        """Polygons of m index sequences, or of an array (m, c)."""
        if isinstance(rows, np.ndarray) and rows.ndim == 2:
            return cls.of_flat(rows.ravel(), np.full(len(rows), rows.shape[1]))
        try:
            sizes = np.fromiter(map(len, rows), dtype=np.int64, count=len(rows))
            flat = np.concatenate([np.asarray(row) for row in rows if len(row)] or [np.empty(0, dtype=np.int64)])
        except (TypeError, ValueError) as error:
            raise MeshError(f"faces must be rows of vertex indices: {error}") from error
        return cls.of_flat(flat, sizes)

    @classmethod
    def of_flat(cls, corners: np.ndarray, sizes: npt.ArrayLike) -> Polygons:
        """Polygons of flat arrays of any numeric type; `MeshError` where a corner is no whole number."""
        sizes = np.asarray(sizes, dtype=np.int64)
        if corners.dtype.kind not in "iuf":
            raise MeshError(f"faces must hold whole numbers, got dtype {corners.dtype}")
        if corners.dtype.kind == "f":
            broken = np.flatnonzero(~whole(corners))
            if broken.size:
                face = int(np.searchsorted(np.cumsum(sizes), broken[0], side="right"))
                raise MeshError(f"face {face} refers to vertex {corners[broken[0]]:g}, which is no whole number")
        return cls(corners.astype(np.int64), sizes)

    @property
    def starts(self) -> IndexArray:
        """Position of the first corner of each face in `corners`, shape (m,)."""
        return np.cumsum(self.sizes) - self.sizes

    def selected(self, keep: npt.NDArray[np.bool_]) -> Polygons:
        """Some of the faces."""
        return Polygons(self.corners[np.repeat(keep, self.sizes)], self.sizes[keep])


def triangulated(vertices: npt.ArrayLike, polygons: Polygons, repair: bool) -> tuple[np.ndarray, tuple[str, ...]]:
    """Triangles of faces, and what was changed to get them.

    Parameters
    ----------
    vertices : array-like, shape (n, 3)
    polygons : Polygons
    repair : bool
        Split faces of more than three corners; remove those of fewer, and those whose corners are not there.

    Returns
    -------
    faces : (k, 3) int64
        In the order of the polygons and turned as these are.
    notes : tuple of str

    Raises
    ------
    MeshError
        A face that has not three corners and not `repair`.
    """
    sizes = polygons.sizes
    few, many = sizes < 3, sizes > 3
    if not repair:
        _refuse(sizes, few, many)
    if not few.any() and not many.any():
        return polygons.corners.reshape(-1, 3), ()
    positions = _positions(vertices)
    notes: list[str] = []
    number = np.arange(len(sizes))
    lost = _lost_polygons(positions, polygons)
    if lost.any():
        notes.append(
            f"{counted(lost.sum(), 'polygon')} removed, of which a corner is no vertex or is not finite "
            f"(face {listed(number[lost])})"
        )
        polygons, number = polygons.selected(~lost), number[~lost]
    polygons = _without_repeated_corners(polygons, notes)
    few = polygons.sizes < 3
    if few.any():
        notes.append(f"{counted(few.sum(), 'face')} with fewer than three corners removed (face {listed(number[few])})")
        polygons, number = polygons.selected(~few), number[~few]
    faces, is_wrong = _split(positions, polygons)
    many = polygons.sizes > 3
    if many.any():
        notes.append(f"{counted(many.sum(), 'polygon')} split into {(polygons.sizes[many] - 2).sum()} triangles")
    if is_wrong.any():
        notes.append(
            f"{counted(is_wrong.sum(), 'polygon')} that cannot be covered without overlaps, as it crosses itself "
            f"(face {listed(number[is_wrong])})"
        )
    return faces, tuple(notes)


def strip_triangles(strip: npt.NDArray[np.int64]) -> IndexArray:
    """Triangles of strips that are divided by -1, shape (k, 3).

    Every other triangle is turned, so that all face the same way; those that name a vertex twice only lead from
    one strip to the next.
    """
    triangles = np.lib.stride_tricks.sliding_window_view(strip, 3) if len(strip) > 2 else np.empty((0, 3), np.int64)
    divides = np.flatnonzero(strip == -1)
    position = np.arange(len(triangles))
    begin = np.concatenate([[0], divides + 1])[np.searchsorted(divides, position, side="right")]
    odd = (position - begin) % 2 == 1
    turned = np.where(odd[:, None], triangles[:, [1, 0, 2]], triangles)
    a, b, c = turned.T
    return turned[(turned != -1).all(axis=1) & (a != b) & (b != c) & (c != a)].astype(np.int64)


def _refuse(sizes: IndexArray, few: np.ndarray, many: np.ndarray) -> None:
    if few.any():
        face = few.argmax()
        raise MeshError(
            f"face {face} has {counted(sizes[face], 'corner')} ({counted(few.sum(), 'face')} with fewer than three "
            "corners); repair=True removes them"
        )
    if many.any():
        face = many.argmax()
        raise MeshError(
            f"face {face} has {sizes[face]} corners ({many.sum()} of {len(sizes)} faces are polygons, not "
            "triangles); triangulate the mesh first, or pass repair=True"
        )


def _positions(vertices: npt.ArrayLike) -> FloatArray:
    """Vertices as an array (n, 3), whatever stands in it."""
    try:
        positions = np.asarray(vertices, dtype=np.float64)
        if positions.ndim == 2 and positions.shape[1] == 3:
            return positions
    except (TypeError, ValueError):
        pass
    return checked_vertices(vertices)  # raises, with the reason


def _lost_polygons(positions: FloatArray, polygons: Polygons) -> npt.NDArray[np.bool_]:
    """Which polygons have a corner nowhere; such triangles are left to those who check the mesh."""
    there = (polygons.corners >= 0) & (polygons.corners < len(positions))
    there[there] = np.isfinite(positions[polygons.corners[there]]).all(axis=1)
    face = np.repeat(np.arange(len(polygons.sizes)), polygons.sizes)
    lost = np.zeros(len(polygons.sizes), dtype=bool)
    lost[face[~there]] = True
    return lost & (polygons.sizes > 3)


def _without_repeated_corners(polygons: Polygons, notes: list[str]) -> Polygons:
    """Polygons that name no vertex twice in a row, as triangles do that are written as quadrilaterals."""
    following = np.empty_like(polygons.corners)
    following[:-1] = polygons.corners[1:]
    filled = polygons.sizes > 0
    starts = polygons.starts[filled]
    following[starts + polygons.sizes[filled] - 1] = polygons.corners[starts]
    keep = (polygons.corners != following) | np.repeat(polygons.sizes <= 3, polygons.sizes)
    if keep.all():
        return polygons
    notes.append(f"{counted((~keep).sum(), 'corner')} of polygons removed that only repeat the one beside")
    face = np.repeat(np.arange(len(polygons.sizes)), polygons.sizes)
    return Polygons(polygons.corners[keep], np.bincount(face[keep], minlength=len(polygons.sizes)))


def _split(positions: FloatArray, polygons: Polygons) -> tuple[IndexArray, npt.NDArray[np.bool_]]:
    """Triangles of faces of at least three corners, and of which faces they cannot be right."""
    sizes, starts = polygons.sizes, polygons.starts
    first = np.cumsum(sizes - 2) - (sizes - 2)
    faces = np.empty((int((sizes - 2).sum()), 3), dtype=np.int64)
    is_wrong = np.zeros(len(sizes), dtype=bool)
    for size in np.unique(sizes):
        of_size = np.flatnonzero(sizes == size)
        corners = polygons.corners[starts[of_size][:, None] + np.arange(size)]
        if size == 3:
            faces[first[of_size]] = corners
            continue
        local, is_wrong[of_size] = _local_triangles(positions[corners])
        rows = first[of_size][:, None] + np.arange(size - 2)
        faces[rows] = np.take_along_axis(corners[:, None, :], local, axis=2)
    return faces, is_wrong


def _local_triangles(points: FloatArray) -> tuple[IndexArray, npt.NDArray[np.bool_]]:
    """Triangles of k polygons of c corners as positions among these, (k, c - 2, 3), and where they cannot be right."""
    k, size, _ = points.shape
    points = points - points[:, :1]
    extent = np.abs(points).max(axis=(1, 2), keepdims=True)
    points = np.divide(points, extent, out=np.zeros_like(points), where=extent > 0)
    local = np.tile(_fan(size), (k, 1, 1))
    normal = _crosses(points, local).sum(axis=1)  # Newell's: twice the area long
    quality = _quality(points, normal, local)
    if size == 4:  # one of the two fans is right
        other = (local + 1) % 4
        other_quality = _quality(points, normal, other)
        better = (quality <= _FLAT) & (other_quality > quality)
        local[better], quality[better] = other[better], other_quality[better]
    else:
        for polygon in np.flatnonzero(quality <= _FLAT):
            clipped = _ear_clipped(points[polygon], normal[polygon])
            clipped_quality = _quality(points[polygon, None], normal[polygon, None], clipped[None])
            if clipped_quality[0] > quality[polygon]:
                local[polygon], quality[polygon] = clipped, clipped_quality[0]
    return local, quality < -_FLAT


def _fan(size: int) -> IndexArray:
    second = np.arange(1, size - 1)
    return np.column_stack([np.zeros_like(second), second, second + 1])


def _crosses(points: FloatArray, local: IndexArray) -> FloatArray:
    """Cross product of two edges of each triangle, shape (k, t, 3)."""
    a, b, c = (np.take_along_axis(points, local[:, :, [j]], axis=1) for j in range(3))
    crosses: FloatArray = np.cross(b - a, c - a)
    return crosses


def _quality(points: FloatArray, normal: FloatArray, local: IndexArray) -> FloatArray:
    """Twice the least area of a triangle as seen along the normal, negative where it is turned over, shape (k,)."""
    crosses = _crosses(points, local)
    length = np.linalg.norm(normal, axis=1)
    unit = np.divide(normal, length[:, None], out=np.zeros_like(normal), where=length[:, None] > 0)
    least = np.einsum("ktj,kj->kt", crosses, unit).min(axis=1)
    size = np.linalg.norm(crosses, axis=2).max(axis=1)
    return np.where(length > _FLAT, least, -size)  # a bow tie has no normal


def _ear_clipped(points: FloatArray, normal: FloatArray) -> IndexArray:
    """Triangles of one polygon as positions among its corners, (c - 2, 3); its fan where there are no ears."""
    size = len(points)
    drop = np.abs(normal).argmax()
    u = np.cross(normal, np.eye(3)[drop - 1])
    basis = np.stack([u, np.cross(normal, u)], axis=1)
    basis /= np.maximum(np.linalg.norm(basis, axis=0), np.finfo(float).tiny)
    plane = np.ascontiguousarray(points @ basis)
    ears = mapbox_earcut.triangulate_float64(plane, np.array([size], dtype=np.uint32)).reshape(-1, 3)
    # Along the polygon, corners of a triangle follow each other as they do around the triangle.
    triangles = [tuple(row) for row in np.sort(ears.astype(np.int64), axis=1).tolist()]
    complete = _with_skipped_corners(triangles, size)
    return np.array(complete) if len(complete) == size - 2 else _fan(size)


def _with_skipped_corners(triangles: list[tuple[int, ...]], size: int) -> list[tuple[int, ...]]:
    """Triangles with those corners put back that were left out between two others."""
    apex_of = {}
    for a, b, c in triangles:
        apex_of.update({(a, b): c, (b, c): a, (c, a): b})
    used = sorted({corner for triangle in triangles for corner in triangle})
    for a, b in zip(used, [*used[1:], *used[:1]], strict=True):
        apex = apex_of.get((a, b))
        if (b - a) % size == 1 or apex is None:
            continue
        for edge in ((a, b), (b, apex), (apex, a)):
            apex_of.pop(edge, None)
        chain = [corner % size for corner in range(a, a + (b - a) % size + 1)]
        for p, q in itertools.pairwise(chain):
            apex_of.update({(p, q): apex, (q, apex): p, (apex, p): q})
    return [(a, b, c) for (a, b), c in apex_of.items() if a < min(b, c)]
