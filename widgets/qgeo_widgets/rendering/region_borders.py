"""Triangles in which regions meet, cut into pieces of one region each: borders are sharp and no colours mix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray, IntArray

_A, _B, _C = np.eye(3)
_AB, _BC, _CA, _ABC = (_A + _B) / 2, (_B + _C) / 2, (_C + _A) / 2, np.full(3, 1 / 3)
# The first corner is another region than the two others: it is cut off at half the way.
_ONE_OTHER = np.array([[_A, _AB, _CA], [_AB, _B, _C], [_AB, _C, _CA]])
# Three regions, which meet in the middle.
_THREE = np.array(
    [[_A, _AB, _ABC], [_A, _ABC, _CA], [_B, _BC, _ABC], [_B, _ABC, _AB], [_C, _CA, _ABC], [_C, _ABC, _BC]]
)


@dataclass(frozen=True, eq=False)
class Borders:
    """Pieces of triangles, each in one region.

    Attributes
    ----------
    corners : (p, 3) int64
        Vertices of the triangle that each piece is cut from.
    weights : (p, 3, 3) float64
        Barycentric coordinates of each piece's three points in that triangle.
    labels : (p,) int64
        Region of each piece.
    """

    corners: IndexArray
    weights: FloatArray
    labels: IndexArray

    def at_points(self, values: npt.ArrayLike) -> FloatArray:
        """Values (n, d) of vertices at the points of the pieces, shape (3 p, d)."""
        given = np.asarray(values)
        return np.einsum("pqc,pcd->pqd", self.weights, given[self.corners]).reshape(-1, given.shape[1])


def region_borders(faces: IntArray, labels: npt.ArrayLike) -> Borders:
    """Pieces of all triangles whose corners are in more than one region; each point is in the region of most weight.

    That is how `report.render_mesh` draws regions.

    Parameters
    ----------
    faces : (m, 3) int32
    labels : array-like of int, shape (n,)
    """
    regions = np.asarray(labels, dtype=np.int64)
    own = regions[faces]
    same = np.stack([own[:, 1] == own[:, 2], own[:, 2] == own[:, 0], own[:, 0] == own[:, 1]], axis=1)
    kinds = same.sum(axis=1)  # 3 within one region, 1 where one corner is of another, 0 where all differ
    two, three = np.flatnonzero(kinds == 1), np.flatnonzero(kinds == 0)
    turn = (same[two].argmax(axis=1)[:, None] + np.arange(3)) % 3  # the corner opposite to the equal ones comes first
    parts = [
        _pieces(faces[two[:, None], turn].astype(np.int64), _ONE_OTHER, own[two[:, None], turn], [0, 1, 1]),
        _pieces(faces[three].astype(np.int64), _THREE, own[three], [0, 0, 1, 1, 2, 2]),
    ]
    return Borders(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _pieces(
    corners: IndexArray, cut: FloatArray, labels: IndexArray, of_corner: list[int]
) -> tuple[IndexArray, FloatArray, IndexArray]:
    count = len(corners)
    return np.repeat(corners, len(cut), axis=0), np.tile(cut, (count, 1, 1)), labels[:, of_corner].reshape(-1)
