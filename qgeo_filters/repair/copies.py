"""Pieces that lie face by face on other pieces: objects written twice, sheets with a back."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters import connectivity
from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.equal_rows import equal_rows, occurring


def without_copies(vertices: FloatArray, faces: IntArray) -> tuple[npt.NDArray[np.bool_], IndexArray, int]:
    """Which faces are not those of copied pieces, the vertex that each vertex becomes, and how many pieces go.

    Every face of a copy has its three corners where those of an earlier face of another piece are. A piece
    that only touches another, or lies on it in part, is none; nor is a sheet that is folded onto itself.
    """
    stands_for = np.arange(len(vertices))
    _, label = connectivity.vertex_components(np.concatenate([faces[:, :2], faces[:, 1:]]), len(vertices))
    piece = label[faces[:, 0]]
    if piece.min() == piece.max():
        return np.ones(len(faces), dtype=bool), stands_for, 0
    used = occurring(faces, len(vertices))
    place = np.zeros(len(vertices), dtype=np.int64)
    place[used], _ = equal_rows(vertices[used])
    # Corners in the order of their places, so that those of a copy stand beside those of its original.
    sorted_faces = np.take_along_axis(faces, np.argsort(place[faces], axis=1), axis=1)
    number, first = equal_rows(place[sorted_faces])
    original = first[number]
    own = np.bincount(piece, piece[original] == piece)
    copied = own[piece] == 0
    stands_for[sorted_faces[copied]] = sorted_faces[original[copied]]
    return ~copied, stands_for, len(occurring(piece[copied], len(own)))
