"""Exact geodesic distance from one vertex by propagation of windows, nearest half-edge first (Numba).

The continuous Dijkstra method of Mitchell, Mount and Papadimitriou (1987; Surazhsky et al., "Fast exact and
approximate geodesics on meshes", SIGGRAPH 2005), with the windows of a half-edge carried over a triangle
together and in order (after Qin et al., "Fast and exact discrete geodesic computation based on
triangle-oriented wavefront propagation", SIGGRAPH 2016), and with windows dropped that a path through a
vertex beats (Xin and Wang, "Improving Chen and Han's algorithm on the discrete geodesic problem", TOG 2009).

Windows live on directed half-edges: those of half-edge h are about to cross face ``h // 3``. The order of
work decides the time only: whatever arrives late and nearer is carried on again. A vertex that lies on a side
that it faces is the source of windows beyond that, too: see `flat_corners`.
"""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.geodesics.flat_corners import carried, split_at
from qgeo_filters.geodesics.mmp.indexed_heap import IndexedHeap, heap_pop, heap_push, new_heap
from qgeo_filters.geodesics.mmp.lower_envelope import (
    TIE,
    Pool,
    distance_at,
    grown_pool,
    insert_window,
    insertion_room,
    new_pool,
    set_spare_window,
    spare_list,
)
from qgeo_filters.geodesics.unfolding import UnfoldedMesh
from qgeo_filters.jit import NONE, kernel, njit

# Where a vertex is this near to a window (relative to the edge) it is reached although the window passes
# it, by a path that bends a little: that bridges gaps left by rounding.
REACH = 1e-6


@kernel
def _note(v: int, value: float, distance: FloatArray, queue: IndexedHeap, mesh: UnfoldedMesh) -> None:
    """Note a path to vertex v; where shortest paths may bend there, v waits to be carried on."""
    if value < distance[v]:
        improved = value < distance[v] * (1.0 - TIE)
        distance[v] = value
        if improved and mesh.bends[v]:
            heap_push(queue, len(mesh.sides) + v, value)


@kernel
def apex_distance(near: float, split: float, sx: float, sy: float, sigma: float, cx: float, cy: float) -> float:
    """Distance of the apex (cx, cy) by way of abscissa ``near``, straight if that is ``split``."""
    if near == split:
        return distance_at(cx, sx, sy + cy, sigma)
    return distance_at(near, sx, sy, sigma) + np.sqrt((cx - near) * (cx - near) + cy * cy)


@kernel
def _is_beaten(
    lo: float,
    hi: float,
    sx: float,
    sy: float,
    sigma: float,
    length: float,
    cx: float,
    cy: float,
    side: float,
    at_origin: float,
    at_opposite: float,
    at_apex: float,
) -> bool:
    """Whether a path through a vertex of the triangle is shorter to all points of a window on one side.

    The side runs from the origin to the apex (cx, cy); the opposite vertex is (length, 0), and the window
    came in through the x-axis (Xin and Wang 2009, theorem 3.2).
    """
    to_lo = distance_at(lo, sx, sy, sigma)
    slack = TIE * (to_lo + side)
    if at_apex + (side - lo) < to_lo - slack or at_origin + hi < distance_at(hi, sx, sy, sigma) - slack:
        return True
    limit = to_lo - slack - at_opposite
    if limit <= 0.0:
        return False
    t = lo / side
    dx, dy = length - t * cx, t * cy
    return dx * dx + dy * dy < limit * limit


@kernel
def _start_from(v: int, distance: FloatArray, queue: IndexedHeap, pool: Pool, mesh: UnfoldedMesh) -> bool:
    """Let vertex v, at its present distance, be the source of windows on all sides that face it.

    False, with v back in the queue, where the pool must grow first.
    """
    sigma = distance[v]
    for c in mesh.corners[mesh.corner_start[v] : mesh.corner_start[v + 1]]:
        f, k = c // 3, c % 3
        side, back = mesh.sides[3 * f + (k + 1) % 3], mesh.sides[3 * f + (k + 2) % 3]
        _note(side["tail"], sigma + mesh.sides[c]["length"], distance, queue, mesh)
        _note(back["tail"], sigma + back["length"], distance, queue, mesh)
        target = side["twin"]
        if target < 0:
            continue
        if not insertion_room(pool, target):
            heap_push(queue, len(mesh.sides) + v, sigma)
            return False
        length = side["length"]
        at_tail, at_head = distance[side["tail"]], distance[back["tail"]]
        if at_tail + length < sigma + back["length"] or at_head + length < sigma + mesh.sides[c]["length"]:
            continue  # a path along the side is shorter to all of its points
        sx = side["cx"] if side["aligned"] else side["from_head"]
        nearest, _ = insert_window(pool, target, length, 0.0, length, sx, side["cy"], sigma, NONE)
        if nearest < np.inf:
            heap_push(queue, target, nearest)
    for view in mesh.views[mesh.view_start[v] : mesh.view_start[v + 1]]:
        set_spare_window(pool, view["lo"], view["hi"], view["sx"], view["sy"], sigma)
        if not _cross_face(view["half"], spare_list(pool), distance, queue, pool, mesh):
            heap_push(queue, len(mesh.sides) + v, sigma)
            return False
    return True


@kernel
def _cross_face(
    h: int, windows_of: int, distance: FloatArray, queue: IndexedHeap, pool: Pool, mesh: UnfoldedMesh
) -> bool:
    """Carry the pending windows of one list, that of half-edge h or the spare one, over the face of h.

    False, with h back in the queue, where the pool must grow first.
    """
    f, k = h // 3, h % 3
    base, ahead, back = mesh.sides[h], mesh.sides[3 * f + (k + 1) % 3], mesh.sides[3 * f + (k + 2) % 3]
    a, b, c = base["tail"], ahead["tail"], back["tail"]
    length, left, right, cx, cy = base["length"], back["length"], ahead["length"], base["cx"], base["cy"]
    from_head = base["from_head"]
    left_target, right_target = back["twin"], ahead["twin"]
    left_hint = right_hint = -1
    left_nearest = right_nearest = np.inf
    complete = True
    row = pool.lists[windows_of]["first"]
    while row >= 0:
        w = pool.windows[row]
        row = w["next"]
        if not w["pending"]:
            continue
        if (left_target >= 0 and not insertion_room(pool, left_target)) or (
            right_target >= 0 and not insertion_room(pool, right_target)
        ):
            complete = False
            break
        w["pending"] = 0
        lo, hi, sx, sy, sigma = w["lo"], w["hi"], w["sx"], w["sy"], w["sigma"]
        split = split_at(sx, sy, cx, cy)
        near = min(max(split, lo), hi)
        if abs(near - split) < REACH * length or distance[c] == np.inf:
            value = apex_distance(near, split, sx, sy, sigma, cx, cy)
            if value < distance[c]:
                _note(c, value, distance, queue, mesh)
        if lo < split and left_target >= 0 and left > 0.0:
            p, q, x, y = carried(lo, hi, sx, sy, split, cx, cy, left)
            if not _is_beaten(p, q, x, y, sigma, length, cx, cy, left, distance[a], distance[b], distance[c]):
                if back["aligned"]:  # the twin starts at the apex
                    p, q, x = left - q, left - p, left - x
                nearest, left_hint = insert_window(pool, left_target, left, p, q, x, y, sigma, left_hint)
                left_nearest = min(left_nearest, nearest)
        if hi > split and right_target >= 0 and right > 0.0:  # the same, seen from the other end
            p, q, x, y = carried(length - hi, length - lo, length - sx, sy, length - split, from_head, cy, right)
            if not _is_beaten(p, q, x, y, sigma, length, from_head, cy, right, distance[b], distance[a], distance[c]):
                if not ahead["aligned"]:
                    p, q, x = right - q, right - p, right - x
                nearest, right_hint = insert_window(pool, right_target, right, p, q, x, y, sigma, right_hint)
                right_nearest = min(right_nearest, nearest)
    if left_nearest < np.inf:
        heap_push(queue, left_target, left_nearest)
    if right_nearest < np.inf:
        heap_push(queue, right_target, right_nearest)
    if not complete:
        heap_push(queue, h, 0.0)
    return complete


@kernel
def _run(target: int, distance: FloatArray, queue: IndexedHeap, pool: Pool, mesh: UnfoldedMesh) -> bool:
    """Work until nothing waits that is nearer than the target; False where the pool must grow first."""
    n_halfedges = len(mesh.sides)
    while True:
        item = heap_pop(queue)
        if item < 0 or (target >= 0 and queue.key[item] > distance[target]):
            return True
        if item < n_halfedges:
            complete = _cross_face(item, item, distance, queue, pool, mesh)
        else:
            complete = _start_from(item - n_halfedges, distance, queue, pool, mesh)
        if not complete:
            return False


@njit()
def propagate(source: int, target: int, mesh: UnfoldedMesh, distance: FloatArray) -> Pool:
    """Fill ``distance`` (n,) with the exact distance of every vertex from the source, inf where unreachable.

    With a target that is not -1 the work ends there: distances beyond that of the target are upper bounds.
    Returned are the windows.
    """
    n_halfedges = len(mesh.sides)
    distance[:] = np.inf
    distance[source] = 0.0
    # Item h < 3 m is a half-edge with pending windows, item 3 m + v a vertex to start from.
    queue = new_heap(n_halfedges + len(distance))
    pool = new_pool(n_halfedges, 2 * n_halfedges + 64)
    heap_push(queue, n_halfedges + source, 0.0)
    while not _run(target, distance, queue, pool, mesh):
        pool = grown_pool(pool)
    return pool
