"""First paths between two vertices, as sleeves: along edges, or along the windows of the exact distance (Numba)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.geodesics.flat_corners import split_at
from qgeo_filters.geodesics.mmp.indexed_heap import IndexedHeap, heap_pop, heap_push, new_heap
from qgeo_filters.geodesics.mmp.lower_envelope import Pool
from qgeo_filters.geodesics.mmp.window_propagation import apex_distance, propagate
from qgeo_filters.geodesics.path.one_ring import append_crossing, face_with, side_opposite, trimmed, turn_at
from qgeo_filters.geodesics.unfolding import UnfoldedMesh
from qgeo_filters.jit import NONE, ZERO, inner, kernel

# A ray that comes this near to a vertex, relative to its length, that is as far as it should be, ends there.
ARRIVED = 1e-7


@kernel
def _spoke(c: int, k: int, mesh: UnfoldedMesh) -> tuple[int, int]:
    """The k-th of the two sides that leave corner c, and the vertex at its other end."""
    base = 3 * (c // 3)
    ahead, back = base + (c - base + 1) % 3, base + (c - base + 2) % 3
    return (c, mesh.sides[ahead]["tail"]) if k == 0 else (back, mesh.sides[back]["tail"])


@kernel
def _dijkstra(
    source: int, target: int, queue: IndexedHeap, distance: FloatArray, towards: IndexArray, mesh: UnfoldedMesh
) -> None:
    """Fill distances along edges from the source, and the next vertex on the way to it, until the target is met."""
    distance[source] = 0.0
    heap_push(queue, source, 0.0)
    while True:
        v = heap_pop(queue)
        if v < 0 or v == target:
            return
        for c in mesh.corners[mesh.corner_start[v] : mesh.corner_start[v + 1]]:
            for k in range(2):
                side, w = _spoke(c, k, mesh)
                value = distance[v] + mesh.sides[side]["length"]
                if value < distance[w]:
                    distance[w], towards[w] = value, v
                    heap_push(queue, w, value)


@kernel
def _go_along_edge(v: int, w: int, face: int, sleeve: IndexArray, m: int, mesh: UnfoldedMesh) -> tuple[int, int]:
    """Sleeve from the triangle ``face`` at v (-1: at the start) on along the edge to w."""
    if face < 0:
        return m, face_with(v, w, mesh)
    return turn_at(v, face, NONE, w, sleeve, m, mesh)


@inner
def edge_sleeve(start: int, end: int, mesh: UnfoldedMesh) -> tuple[IndexArray, float, IndexArray]:
    """Sleeve about the shortest path along edges, the length of that (inf where there is none), its vertices."""
    n = len(mesh.angles)
    distance, towards = np.full(n, np.inf), np.full(n, -1, dtype=np.int64)
    _dijkstra(end, start, new_heap(n), distance, towards, mesh)
    sleeve, vertices = np.empty(3 * len(mesh.corners), dtype=np.int64), np.empty(n, dtype=np.int64)
    if distance[start] == np.inf:
        return sleeve[:0], np.inf, vertices[:0]
    vertices[0] = start
    v, face, m, count = start, NONE, ZERO, 1
    while v != end:
        m, face = _go_along_edge(v, towards[v], face, sleeve, m, mesh)
        v = towards[v]
        vertices[count] = v
        count += 1
    m = trimmed(sleeve, m, start, end, mesh)
    return sleeve[:m].copy(), distance[start], vertices[:count].copy()


@kernel
def _turned(x: float, y: float, cx: float, cy: float, side: float, reverse: bool) -> tuple[float, float]:
    """Point (x, y) in the frame of the side from the origin to the apex (cx, cy), the far side of it ahead."""
    ux, uy = cx / side, cy / side
    along = x * ux + y * uy
    return (side - along if reverse else along), y * ux - x * uy


@kernel
def _follow_ray(
    h: int,
    qx: float,
    qy: float,
    sx: float,
    sy: float,
    sigma: float,
    source: int,
    distance: FloatArray,
    sleeve: IndexArray,
    m: int,
    mesh: UnfoldedMesh,
) -> tuple[int, int, int]:
    """Sleeve from the triangle of half-edge h to the pseudo-source at (sx, sy), seen from (qx, qy).

    Both are in the frame of h, the source ahead (y > 0). Returned are the length of the sleeve, the
    vertex that the source is and the last triangle; vertex -1 where rounding lost it.
    """
    reach = ARRIVED * np.sqrt((sx - qx) * (sx - qx) + (sy - qy) * (sy - qy))
    for _ in range(len(mesh.sides)):
        m = append_crossing(sleeve, m, h, mesh)
        base = 3 * (h // 3)
        side, ahead, back = mesh.sides[h], base + (h - base + 1) % 3, base + (h - base + 2) % 3
        c, cx, cy = mesh.sides[back]["tail"], side["cx"], side["cy"]
        here = abs(sx - cx) <= reach and abs(sy - cy) <= reach and abs(distance[c] - sigma) <= reach
        if here and (mesh.bends[c] or c == source):
            return m, c, h // 3
        if (cx - qx) * (sy - qy) - (cy - qy) * (sx - qx) > 0.0:
            way_out, reverse = back, mesh.sides[back]["aligned"] != 0
        else:  # the same in the mirror
            way_out, reverse = ahead, mesh.sides[ahead]["aligned"] == 0
            qx, sx, cx = side["length"] - qx, side["length"] - sx, side["from_head"]
        length = mesh.sides[way_out]["length"]
        h = mesh.sides[way_out]["twin"]
        if h < 0 or length == 0.0:
            break
        qx, qy = _turned(qx, qy, cx, cy, length, reverse)
        sx, sy = _turned(sx, sy, cx, cy, length, reverse)
    return m, -1, -1


@kernel
def _best_edge(
    v: int, source: int, only_bends: bool, distance: FloatArray, passed: npt.NDArray[np.bool_], mesh: UnfoldedMesh
) -> tuple[float, int]:
    """Distance of v by way of its best neighbour, and that; on request only neighbours where paths bend."""
    best, vertex = np.inf, -1
    for c in mesh.corners[mesh.corner_start[v] : mesh.corner_start[v + 1]]:
        for k in range(2):
            side, w = _spoke(c, k, mesh)
            value = distance[w] + mesh.sides[side]["length"]
            if value < best and not passed[w] and (not only_bends or mesh.bends[w] or w == source):
                best, vertex = value, w
    return best, vertex


@kernel
def _best_window(
    v: int, distance: FloatArray, pool: Pool, mesh: UnfoldedMesh
) -> tuple[float, int, float, float, float]:
    """Distance of v by way of what it faces, the half-edge that this is seen through, and the pseudo-source there.

    That is a window on one of the sides that v faces, or a vertex that lies on such a side and sees v through it.
    """
    best, half, best_x, best_y, best_sigma = np.inf, -1, 0.0, 0.0, 0.0
    for c in mesh.corners[mesh.corner_start[v] : mesh.corner_start[v + 1]]:
        h = side_opposite(c // 3, v, mesh)
        cx, cy = mesh.sides[h]["cx"], mesh.sides[h]["cy"]
        row = pool.lists[h]["first"]
        while row >= 0:
            w = pool.windows[row]
            split = split_at(w["sx"], w["sy"], cx, cy)
            near = min(max(split, w["lo"]), w["hi"])
            value = apex_distance(near, split, w["sx"], w["sy"], w["sigma"], cx, cy)
            if value < best:
                best, half, best_x, best_y, best_sigma = value, h, w["sx"], w["sy"], w["sigma"]
            row = w["next"]
        for k in range(len(mesh.views)):
            view = mesh.views[k]
            if view["half"] != h:
                continue
            u = np.searchsorted(mesh.view_start, k, side="right") - 1
            split = split_at(view["sx"], view["sy"], cx, cy)
            near = min(max(split, view["lo"]), view["hi"])
            value = apex_distance(near, split, view["sx"], view["sy"], distance[u], cx, cy)
            if value < best:
                best, half, best_x, best_y, best_sigma = value, h, view["sx"], view["sy"], distance[u]
    return best, half, best_x, best_y, best_sigma


@kernel
def _trace(
    start: int,
    end: int,
    distance: FloatArray,
    passed: npt.NDArray[np.bool_],
    pool: Pool,
    mesh: UnfoldedMesh,
    sleeve: IndexArray,
) -> int:
    """Length of the sleeve that leads down the distance from ``end``, from vertex to vertex where it bends.

    -1 where it loses the way, which takes several vertices in one place.
    """
    v, face, m = start, NONE, ZERO
    while v != end:
        passed[v] = True  # vertices in one place are equally far: never go back
        by_edge, w = _best_edge(v, end, True, distance, passed, mesh)
        by_window, h, sx, sy, sigma = _best_window(v, distance, pool, mesh)
        if by_window < by_edge * (1.0 - ARRIVED * ARRIVED):
            if face >= 0:
                m, face = turn_at(v, face, h // 3, NONE, sleeve, m, mesh)
            side = mesh.sides[h]
            flip = side["aligned"] == 0
            qx = side["from_head"] if flip else side["cx"]
            sx = side["length"] - sx if flip else sx
            kept = m
            m, reached, last = _follow_ray(side["twin"], qx, -side["cy"], sx, sy, sigma, end, distance, sleeve, m, mesh)
            if reached >= 0 and distance[reached] < distance[v]:
                v, face = reached, last
                continue
            m, face = kept, h // 3
            # Lost within rounding of a vertex: go down one edge and look again from there.
            _, w = _best_edge(v, end, False, distance, passed, mesh)
        if w < 0:
            return -1
        m, face = _go_along_edge(v, w, face, sleeve, m, mesh)
        v = w
    return m


@inner
def exact_sleeve(start: int, end: int, mesh: UnfoldedMesh) -> tuple[IndexArray, float]:
    """Sleeve of the shortest path over the surface, and its length; inf where there is none.

    Among vertices in one place the way down the distance may be lost; then it is the sleeve along edges.
    """
    distance = np.empty(len(mesh.angles))
    pool = propagate(end, start, mesh, distance)
    sleeve = np.empty(3 * len(mesh.corners), dtype=np.int64)
    if distance[start] == np.inf:
        return sleeve[:0], np.inf
    passed = np.zeros(len(mesh.angles), dtype=np.bool_)
    m = _trace(start, end, distance, passed, pool, mesh, sleeve)
    if m < 0:
        sleeve, length, _ = edge_sleeve(start, end, mesh)
        return sleeve, length
    return sleeve[: trimmed(sleeve, m, start, end, mesh)].copy(), distance[start]
