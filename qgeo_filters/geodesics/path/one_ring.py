"""Sleeves round a vertex: walking its fan of triangles, and leading a path past it on the other side (Numba)."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.geodesics.unfolding import UnfoldedMesh
from qgeo_filters.jit import ZERO, kernel


@kernel
def other_side(h: int, v: int, mesh: UnfoldedMesh) -> int:
    """The other one of the two sides that meet at corner v of the triangle of side h."""
    base = 3 * (h // 3)
    if mesh.sides[h]["tail"] == v:
        return base + (h - base + 2) % 3
    return base + (h - base + 1) % 3


@kernel
def side_opposite(face: int, v: int, mesh: UnfoldedMesh) -> int:
    """Side of the triangle that does not touch its corner v."""
    for k in range(3):
        if mesh.sides[3 * face + k]["tail"] == v:
            return 3 * face + (k + 1) % 3
    return -1


@kernel
def side_between(face: int, v: int, w: int, mesh: UnfoldedMesh) -> int:
    """Side of the triangle between v and w, -1 if it has none."""
    for k in range(3):
        a, b = mesh.sides[3 * face + k]["tail"], mesh.sides[3 * face + (k + 1) % 3]["tail"]
        if (a == v and b == w) or (a == w and b == v):
            return 3 * face + k
    return -1


@kernel
def face_with(v: int, w: int, mesh: UnfoldedMesh) -> int:
    """A triangle with an edge between v and w, -1 if there is none."""
    for c in mesh.corners[mesh.corner_start[v] : mesh.corner_start[v + 1]]:
        base = 3 * (c // 3)
        for k in range(3):
            if mesh.sides[base + k]["tail"] == w:
                return c // 3
    return -1


@kernel
def append_crossing(sleeve: IndexArray, m: int, h: int, mesh: UnfoldedMesh) -> int:
    """Length of the sleeve with half-edge h entered behind its m others; going straight back undoes the last."""
    if m > 0 and sleeve[m - 1] == mesh.sides[h]["twin"]:
        return m - 1
    sleeve[m] = h
    return m + 1


@kernel
def walk_fan(
    v: int, way_out: int, goal: int, w: int, sleeve: IndexArray, m: int, mesh: UnfoldedMesh
) -> tuple[int, float]:
    """Length of the sleeve led about vertex v, starting through ``way_out``, and the angle swept (inf: no way).

    Ends in triangle ``goal``, or, where that is -1, in the first triangle that has vertex w too.
    """
    angle = 0.0
    first = way_out
    while m < len(mesh.corners):
        h = mesh.sides[way_out]["twin"]
        if h < 0:
            break
        m = append_crossing(sleeve, m, h, mesh)
        if h // 3 == goal or (goal < 0 and side_between(h // 3, v, w, mesh) >= 0):
            return m, angle
        side = mesh.sides[h]
        x = side["cx"] if side["tail"] == v else side["from_head"]
        angle += np.arctan2(side["cy"], x)
        way_out = other_side(h, v, mesh)
        if way_out == first:
            break
    return m, np.inf


@kernel
def turn_at(v: int, face: int, goal: int, w: int, sleeve: IndexArray, m: int, mesh: UnfoldedMesh) -> tuple[int, int]:
    """Length of the sleeve led about v from one triangle to the next of `walk_fan`, and that triangle; any way round.

    The side of the smaller angle is taken. -1 twice where the triangles at v do not join.
    """
    if face == goal or (goal < 0 and side_between(face, v, w, mesh) >= 0):
        return m, face
    opposite = side_opposite(face, v, mesh)
    base = 3 * face
    one, two = base + (opposite - base + 1) % 3, base + (opposite - base + 2) % 3
    # Tried out behind the sleeve, where there is nothing to undo.
    trial = sleeve[m:]
    _, first_angle = walk_fan(v, one, goal, w, trial, ZERO, mesh)
    _, second_angle = walk_fan(v, two, goal, w, trial, ZERO, mesh)
    if first_angle == np.inf and second_angle == np.inf:
        return -1, -1
    way_out = one if first_angle <= second_angle else two
    # Half-edges in order; going back over the last one undoes it, so the triangle is not always the last one's.
    last = mesh.sides[way_out]["twin"]
    while not (last // 3 == goal or (goal < 0 and side_between(last // 3, v, w, mesh) >= 0)):
        last = mesh.sides[other_side(last, v, mesh)]["twin"]
    m, _ = walk_fan(v, way_out, goal, w, sleeve, m, mesh)
    return m, last // 3


@kernel
def trimmed(sleeve: IndexArray, m: int, start: int, end: int, mesh: UnfoldedMesh) -> int:
    """Length of the sleeve once all that goes about its own end points is cut off, in place.

    After it no half-edge of the sleeve touches the start or the end.
    """
    skip = 0
    for k in range(m):
        if _has(sleeve[k], start, mesh):
            skip = k + 1
    count = 0
    for k in range(skip, m):
        if _has(sleeve[k], end, mesh):
            break
        sleeve[count] = sleeve[k]
        count += 1
    return count


@kernel
def _has(h: int, v: int, mesh: UnfoldedMesh) -> bool:
    base = 3 * (h // 3)
    return mesh.sides[h]["tail"] == v or mesh.sides[base + (h - base + 1) % 3]["tail"] == v
