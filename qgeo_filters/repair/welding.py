"""Boundary edges that lie on each other joined: triangle soups and seams become one surface again.

Edges are joined, not points: what touches in a vertex only stays apart, and what is closed has no boundary to join.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from qgeo_filters import connectivity
from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.equal_rows import equal_rows, occurring

# Corners computed facet by facet differ by a few steps of single precision; in text, in the sixth digit.
_STEPS, _OF_EXTENT = 8, 1e-5
# Nearer than this share of the shortest edge there, vertices are one place and not a small detail.
_OF_SHORTEST_EDGE = 0.1
# Nearest places that are looked at: with the rounding of three coordinates a corner has up to eight.
_NEIGHBOURS = 16
# Faces whose planes meet at an angle with this cosine lie on each other.
_FOLDED = 1 - 1e-6


def welded(vertices: FloatArray, faces: IntArray) -> tuple[IndexArray, float]:
    """Vertex that each vertex becomes when coincident boundary edges are joined, the smallest of each group.

    Parameters
    ----------
    vertices : (n, 3) float64
        Those that no face names may be anything.
    faces : (m, 3) int32
        Valid.

    Returns
    -------
    joined : (n,) int64
    distance : float
        The largest between a vertex and the one that it becomes.

    Notes
    -----
    Positions agree if they are equal, or differ by no more than a tenth of the shortest edge there and a hundred
    thousandth of the mesh's extent; where all coordinates are single-precision numbers also by eight steps of the
    largest, as far from the origin these are rounded more. A sheet folded flat onto itself keeps its
    rim: two faces of one piece that lie on each other are not joined where these are the only ones at an edge. A slit
    cannot be told from a seam, and is closed.
    """
    _, face_edges, counts = connectivity.unique_edges(faces)
    half = np.flatnonzero(counts[face_edges.ravel()] == 1)
    if half.size == 0:
        return np.arange(len(vertices)), 0.0
    tails, heads = faces.ravel()[half], np.roll(faces, -1, axis=1).ravel()[half]
    place = _places(vertices, faces, occurring(np.concatenate([tails, heads]), len(vertices)))
    # Ends in the order of their places, so that equal rows are edges that lie on each other.
    ends = np.column_stack([tails, heads])
    swapped = place[tails] > place[heads]
    ends[swapped] = ends[swapped][:, ::-1]
    key = place[ends[:, 0]] * len(vertices) + place[ends[:, 1]]
    order = np.argsort(key, kind="stable")
    order = order[place[tails[order]] != place[heads[order]]]
    first, second = order[:-1], order[1:]
    joint = np.flatnonzero(key[first] == key[second])
    joint = np.delete(joint, _rims(vertices, faces, half[first[joint]], half[second[joint]], key[first[joint]]))
    pairs = np.concatenate([np.column_stack([ends[first[joint], k], ends[second[joint], k]]) for k in (0, 1)])
    joined = connectivity.smallest_connected(pairs, len(vertices))
    moved = np.flatnonzero(joined != np.arange(len(vertices)))
    distance = np.linalg.norm(vertices[moved] - vertices[joined[moved]], axis=1)
    return joined, float(distance.max(initial=0.0))


def not_welded(count: int) -> str:
    """Advice for a mesh of which `welded` joins so many vertices with others."""
    vertices = "1 boundary vertex coincides" if count == 1 else f"{count} boundary vertices coincide"
    return f"{vertices} with others: the mesh is not welded, repair=True joins them"


def _places(vertices: FloatArray, faces: IntArray, chosen: IndexArray) -> IndexArray:
    """Number of the place of each chosen vertex, equal where positions agree; (n,), 0 for the others."""
    number, first = equal_rows(vertices[chosen])
    points = vertices[chosen[first]]
    shortest = np.full(len(points), np.inf)
    np.minimum.at(shortest, number, _shortest_edges(vertices, faces)[chosen])
    tolerance = _tolerance(vertices[occurring(faces, len(vertices))])
    count = min(_NEIGHBOURS, len(points))
    found = KDTree(points).query(points, k=range(1, count + 1), distance_upper_bound=tolerance)
    distance, neighbour = np.asarray(found[0]), np.asarray(found[1])
    near, column = np.nonzero(np.isfinite(distance))
    other = neighbour[near, column]
    agree = distance[near, column] <= _OF_SHORTEST_EDGE * np.minimum(shortest[near], shortest[other])
    place = np.zeros(len(vertices), dtype=np.int64)
    place[chosen] = connectivity.smallest_connected(np.column_stack([near[agree], other[agree]]), len(points))[number]
    return place


def _shortest_edges(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Length of the shortest edge of the faces at each vertex, (n,); inf without faces."""
    tails, heads = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    length = np.linalg.norm(vertices[tails] - vertices[heads], axis=1)
    shortest = np.full(len(vertices), np.inf)
    np.minimum.at(shortest, tails, length)
    np.minimum.at(shortest, heads, length)
    return shortest


def _tolerance(points: FloatArray) -> float:
    """Distance up to which rounding may have moved two corners apart."""
    with np.errstate(over="ignore"):
        single = bool(np.all(points == points.astype(np.float32)))
    rounding = _STEPS * float(np.finfo(np.float32).eps) * float(np.abs(points).max()) if single else 0.0
    return max(rounding, _OF_EXTENT * float(np.ptp(points, axis=0).max()))


def _rims(vertices: FloatArray, faces: IntArray, half: IndexArray, other: IndexArray, key: IndexArray) -> IndexArray:
    """Which of these pairs of half-edges, sorted by key, are the rim of a sheet that lies folded on itself."""
    _, piece = connectivity.vertex_components(np.concatenate([faces[:, :2], faces[:, 1:]]), len(vertices))
    alone = np.ones(len(key), dtype=bool)
    alone[1:] &= key[1:] != key[:-1]
    alone[:-1] &= key[1:] != key[:-1]
    same = piece[faces.ravel()[half]] == piece[faces.ravel()[other]]
    candidates = np.flatnonzero(alone & same)
    u, w = (_inwards(vertices, faces, halves[candidates]) for halves in (half, other))
    size = np.linalg.norm(u, axis=1) * np.linalg.norm(w, axis=1)
    folded: IndexArray = candidates[np.einsum("ij,ij->i", u, w) > _FOLDED * size]
    return folded


def _inwards(vertices: FloatArray, faces: IntArray, half: IndexArray) -> FloatArray:
    """Vector from each half-edge, at a right angle, to the third corner of its face."""
    face, k = half // 3, half % 3
    a, b, c = (vertices[faces[face, (k + j) % 3]] for j in range(3))
    along = b - a
    square = np.einsum("ij,ij->i", along, along)
    share = np.divide(np.einsum("ij,ij->i", c - a, along), square, out=np.zeros(len(half)), where=square > 0)
    vector: FloatArray = c - a - share[:, None] * along
    return vector
