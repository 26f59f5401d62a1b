"""Edges collapsed, cheapest first, as long as the surface stays one of the same topology."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.edge_collapse.bucket_queue import BucketQueue, empty_queue, leave, put, take
from qgeo_filters.edge_collapse.quadrics import quadric_minimum, vertex_quadrics
from qgeo_filters.jit import kernel, njit

# A triangle may not turn by more than this (a cosine), nor become a sliver below this quality (1: equilateral), unless
# it was worse. Where nothing is left to collapse, as on meshes that are slivers throughout, that limit is lowered.
_TURN, _SLIVER, _LOWERED, _LEAST_SLIVER = 0.2, 0.1, 0.3, 1e-4
_NONE = -1


class Complex(NamedTuple):
    """Triangles that are changed in place. The corners ``3 f + k`` at each vertex form a ring of links."""

    points: FloatArray  # (n, 3)
    quadrics: FloatArray  # (n, 10)
    faces: IntArray  # (m, 3); -1 in the first place of those that are gone
    face_edges: IntArray  # (m, 3)
    ends: IntArray  # (E, 2); -1 in the first place of those that are gone
    rim: np.ndarray  # (E,) bool, edges of the boundary
    on_rim: np.ndarray  # (n,) bool, vertices of the boundary
    corner: IntArray  # (n,) one corner of each vertex, -1 where there is none
    link: IntArray  # (3 m,) next corner of the same vertex
    marks: IntArray  # (n,)


def collapsed(
    points: FloatArray, faces: IntArray, face_edges: IntArray, edges: IntArray, rim: np.ndarray, n_vertices: int
) -> tuple[FloatArray, IntArray, IndexArray]:
    """Collapse edges until so many vertices are left, or no collapse is allowed any more.

    Parameters
    ----------
    points : (n, 3) float64
        Of a manifold surface in one piece, about the origin and of about unit size; each has a face.
    faces, face_edges : (m, 3) int32
    edges : (E, 2) int32
    rim : (E,) bool
        Edges of the boundary.
    n_vertices : int

    Returns
    -------
    points : (k, 3) float64
    faces : (l, 3) int32
        In the order and orientation of those that were given.
    merged : (n,) int64
        Vertex of the result into which each vertex went.
    """
    n = len(points)
    on_rim = np.zeros(n, dtype=bool)
    on_rim[edges[rim]] = True
    corner, link, marks = (np.full(size, _NONE, dtype=np.int32) for size in (n, faces.size, n))
    whole = Complex(
        points.copy(), vertex_quadrics(points, faces, face_edges, rim), faces.copy(), face_edges.copy(), edges.copy(),
        rim.copy(), on_rim, corner, link, marks,
    )  # fmt: skip
    into, seen = np.arange(n, dtype=np.int32), np.full(len(edges), _NONE, dtype=np.int32)
    _collapse(whole, empty_queue(len(edges)), into, n_vertices, np.empty(3), seen)
    kept = np.flatnonzero(into == np.arange(n))
    renumbered = np.full(n, _NONE, dtype=np.int32)
    renumbered[kept] = np.arange(len(kept))
    left = whole.faces[whole.faces[:, 0] != _NONE]
    return whole.points[kept], renumbered[left], renumbered[into].astype(np.int64)


@njit()
def _collapse(
    whole: Complex, queue: BucketQueue, into: IntArray, n_vertices: int, place: FloatArray, seen: IntArray
) -> None:
    _run(whole, queue, into, n_vertices, place, seen)


@kernel
def _link_corners(faces: IntArray, corner: IntArray, link: IntArray) -> None:
    for c in range(3 * len(faces)):
        v = faces[c // 3, c % 3]
        if corner[v] == _NONE:
            corner[v] = c
            link[c] = c
        else:
            link[c] = link[corner[v]]
            link[corner[v]] = c


@kernel
def _run(
    whole: Complex, queue: BucketQueue, into: IntArray, n_vertices: int, place: FloatArray, seen: IntArray
) -> None:
    _link_corners(whole.faces, whole.corner, whole.link)
    n_left, n_faces, sliver = len(whole.points), len(whole.faces), _SLIVER
    _put_all(whole, queue, place)
    while n_left > n_vertices:
        e = take(queue)
        if e == _NONE:
            if sliver < _LEAST_SLIVER:
                break
            sliver *= _LOWERED
            _put_all(whole, queue, place)
            continue
        a, b = whole.ends[e]
        _cost(whole, a, b, place)
        if not _keeps_topology(whole, e, n_faces) or not _keeps_shape(whole, a, b, place, sliver):
            continue
        n_faces -= 1 if whole.rim[e] else 2
        n_left -= 1
        into[b] = a
        _merge(whole, queue, e, place)
        # costs around the new vertex
        start = whole.corner[a]
        c = start
        while True:
            f, k = c // 3, c % 3
            for j in (k, (k + 2) % 3):
                other = whole.face_edges[f, j]
                if seen[other] != n_left:
                    seen[other] = n_left
                    put(queue, other, _cost(whole, whole.ends[other, 0], whole.ends[other, 1], place))
            c = whole.link[c]
            if c == start:
                break
    for v in range(len(into)):
        root = v
        while into[root] != root:
            root = into[root]
        while into[v] != root:
            into[v], v = root, into[v]


@kernel
def _put_all(whole: Complex, queue: BucketQueue, place: FloatArray) -> None:
    for e in range(len(whole.ends)):
        if whole.ends[e, 0] != _NONE:
            put(queue, e, _cost(whole, whole.ends[e, 0], whole.ends[e, 1], place))


@kernel
def _cost(whole: Complex, a: int, b: int, place: FloatArray) -> float:
    return quadric_minimum(whole.quadrics[a], whole.quadrics[b], whole.points[a], whole.points[b], place)


@kernel
def _keeps_topology(whole: Complex, e: int, n_faces: int) -> bool:
    """The link condition: all vertices next to both ends are opposite to the edge, and so for boundary curves."""
    a, b = whole.ends[e]
    if whole.on_rim[a] and whole.on_rim[b] and not whole.rim[e]:
        return False
    expected = 1 if whole.rim[e] else 2
    if n_faces <= 2 * expected - (1 if whole.rim[e] else 0):
        return False
    marks, start = whole.marks, whole.corner[a]
    c = start
    while True:
        f, k = c // 3, c % 3
        marks[whole.faces[f, (k + 1) % 3]] = a
        marks[whole.faces[f, (k + 2) % 3]] = a
        c = whole.link[c]
        if c == start:
            break
    marks[b] = _NONE
    common, start = 0, whole.corner[b]
    c = start
    while True:
        f, k = c // 3, c % 3
        for j in (1, 2):
            v = whole.faces[f, (k + j) % 3]
            if marks[v] == a:
                marks[v] = _NONE
                common += 1
        c = whole.link[c]
        if c == start:
            break
    # what is left of the marks names a, which no other vertex takes for its own while a is one
    return common == expected


@kernel
def _keeps_shape(whole: Complex, a: int, b: int, place: FloatArray, sliver: float) -> bool:
    """Whether no triangle turns over or becomes a sliver when the ends of an edge go to a place."""
    for v, w in ((a, b), (b, a)):
        start = whole.corner[v]
        c = start
        while True:
            f, k = c // 3, c % 3
            i, j = whole.faces[f, (k + 1) % 3], whole.faces[f, (k + 2) % 3]
            if i != w and j != w and not _fair(whole.points[v], place, whole.points[i], whole.points[j], sliver):
                return False
            c = whole.link[c]
            if c == start:
                break
    return True


@kernel
def _fair(old: FloatArray, new: FloatArray, p: FloatArray, q: FloatArray, sliver: float) -> bool:
    """Whether a triangle stays a good one when its first corner moves."""
    ux, uy, uz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    vx, vy, vz = old[0] - p[0], old[1] - p[1], old[2] - p[2]
    wx, wy, wz = new[0] - p[0], new[1] - p[1], new[2] - p[2]
    mx, my, mz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
    before, after = np.sqrt(mx * mx + my * my + mz * mz), np.sqrt(nx * nx + ny * ny + nz * nz)
    if mx * nx + my * ny + mz * nz < _TURN * before * after:
        return False
    u, v, w = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, wx * wx + wy * wy + wz * wz
    sides = u + v + (v + u - 2 * (ux * vx + uy * vy + uz * vz))
    turned = u + w + (w + u - 2 * (ux * wx + uy * wy + uz * wz))
    factor = 2 * np.sqrt(3.0)
    # no sliver, or a better one than before
    return factor * after > sliver * turned or after * sides >= before * turned


@kernel
def _merge(whole: Complex, queue: BucketQueue, e: int, place: FloatArray) -> None:
    """Collapse an edge into its first end."""
    a, b = whole.ends[e]
    for k in range(3):
        whole.points[a, k] = place[k]
    for k in range(whole.quadrics.shape[1]):
        whole.quadrics[a, k] += whole.quadrics[b, k]
    whole.on_rim[a] |= whole.on_rim[b]
    # triangles at the edge go; of their other two edges that at a stays
    gone0, gone1, kept0, kept1 = _NONE, _NONE, _NONE, _NONE
    start = whole.corner[b]
    c = start
    while True:
        f, k = c // 3, c % 3
        for j in range(3):
            if whole.face_edges[f, j] == e:
                # the edges after and before e in this triangle
                one, two = whole.face_edges[f, (j + 1) % 3], whole.face_edges[f, (j + 2) % 3]
                kept, gone = (one, two) if whole.ends[one, 0] == a or whole.ends[one, 1] == a else (two, one)
                gone0, kept0, gone1, kept1 = gone, kept, gone0, kept0
                whole.rim[kept] |= whole.rim[gone]
                whole.ends[gone, 0] = _NONE
                leave(queue, gone)
                whole.faces[f, 0] = _NONE
        c = whole.link[c]
        if c == start:
            break
    # what is left at b comes to a
    c = start
    while True:
        f, k = c // 3, c % 3
        if whole.faces[f, 0] != _NONE:
            whole.faces[f, k] = a
            for j in range(3):
                other = whole.face_edges[f, j]
                if other == gone0:
                    whole.face_edges[f, j] = other = kept0
                elif other == gone1:
                    whole.face_edges[f, j] = other = kept1
                for i in range(2):
                    if whole.ends[other, i] == b:
                        whole.ends[other, i] = a
        c = whole.link[c]
        if c == start:
            break
    whole.ends[e, 0] = _NONE
    # one ring of both, without the corners of what is gone
    first = whole.corner[a]
    whole.link[first], whole.link[start] = whole.link[start], whole.link[first]
    whole.corner[a] = _cleaned(whole, first)
    for kept in (kept0, kept1):
        if kept != _NONE:
            third = whole.ends[kept, 0] if whole.ends[kept, 1] == a else whole.ends[kept, 1]
            whole.corner[third] = _cleaned(whole, whole.corner[third])


@kernel
def _cleaned(whole: Complex, start: int) -> int:
    """Take corners of triangles that are gone out of a ring of links, of which some stay; one of these."""
    while whole.faces[start // 3, 0] == _NONE:
        start = whole.link[start]
    c = start
    while True:
        after = whole.link[c]
        while whole.faces[after // 3, 0] == _NONE:
            after = whole.link[after]
        whole.link[c] = after
        c = after
        if c == start:
            break
    return start
