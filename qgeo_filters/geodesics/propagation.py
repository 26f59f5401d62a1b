"""Exact geodesic distance from one vertex by propagation of windows, nearest half-edge first (Numba).

The continuous Dijkstra method of Mitchell, Mount and Papadimitriou (1987; Surazhsky et al., "Fast exact and
approximate geodesics on meshes", SIGGRAPH 2005), with the windows of a half-edge carried over a triangle
together and in order (after Qin et al., "Fast and exact discrete geodesic computation based on
triangle-oriented wavefront propagation", SIGGRAPH 2016), and with windows dropped that a path through a
vertex beats (Xin and Wang, "Improving Chen and Han's algorithm on the discrete geodesic problem", TOG 2009).

Windows live on directed half-edges: those of half-edge h are about to cross face ``h // 3``. The order of
work decides the time only: whatever arrives late and nearer is carried on again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

from qgeo_filters.geodesics.envelope import (
    HI,
    LO,
    SIGMA,
    SX,
    SY,
    TIE,
    WIDTH,
    Pool,
    distance_at,
    grown_pool,
    insert_window,
    insertion_room,
    new_pool,
)
from qgeo_filters.geodesics.indexed_heap import heap_lower, heap_pop
from qgeo_filters.geodesics.unfolding import UnfoldedMesh

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int32]
Flags = npt.NDArray[np.bool_]

# A window passes a vertex on the left or right; where the vertex is this near to the window (relative to
# the edge) it is reached all the same, by a path that bends a little: that bridges gaps left by rounding.
REACH = 1e-6


class Front(NamedTuple):
    """What is known so far: distances, and the half-edges and vertices that wait, nearest first.

    Item h < 3 m of the queue is a half-edge with pending windows, item 3 m + v a vertex to start from.
    """

    distance: FloatArray  # (n,) upper bounds, each the length of a path
    heap: IndexArray  # (3 m + n,)
    slot_of: IndexArray  # (3 m + n,)
    key: FloatArray  # (3 m + n,)
    size: IndexArray  # (1,)


@njit(cache=True, nogil=True)
def _enqueue(front: Front, item: int, key: float) -> None:
    front.size[0] = heap_lower(item, key, front.heap, front.slot_of, front.key, front.size[0])


@njit(cache=True, nogil=True)
def _reach(front: Front, mesh: UnfoldedMesh, v: int, distance: float) -> None:
    """Note a path to vertex v; where shortest paths may bend there, it is carried on later."""
    if distance < front.distance[v]:
        improved = distance < front.distance[v] * (1.0 - TIE)
        front.distance[v] = distance
        if improved and mesh.bends[v]:
            _enqueue(front, len(mesh.twins) + v, distance)


@njit(cache=True, nogil=True)
def _deliver(
    front: Front, pool: Pool, mesh: UnfoldedMesh, side: int, reverse: bool, candidate: FloatArray, hint: int
) -> int:
    """Offer a window to the half-edge across ``side``; returns the hint for the next one.

    ``reverse``: the candidate is measured from the second vertex of ``side``.
    """
    target = mesh.twins[side]
    length = mesh.lengths[side]
    lo, hi, sx = candidate[LO], candidate[HI], candidate[SX]
    if reverse == mesh.aligned[side]:
        lo, hi, sx = length - hi, length - lo, length - sx
    nearest, hint = insert_window(pool, target, length, lo, hi, sx, candidate[SY], candidate[SIGMA], hint)
    if nearest < np.inf:
        _enqueue(front, target, nearest)
    return hint


@njit(cache=True, nogil=True)
def _carried(
    near: float, far: float, sx: float, sy: float, split: float, cx: float, cy: float, side: float, out: FloatArray
) -> None:
    """Window [near, far] of the x-axis as it falls on the side from the origin to the apex (cx, cy).

    The source is at (sx, -sy); its ray through ``split`` meets the apex.
    """
    ux, uy = cx / side, cy / side
    out[LO], out[HI] = 0.0, side
    if near > 0.0:
        along, across = sy * near, ux * sy - uy * (near - sx)
        out[LO] = along / across if along < side * across else side
    if far < split:
        along, across = sy * far, ux * sy - uy * (far - sx)
        out[HI] = along / across if along < side * across else side
    out[SX] = sx * ux - sy * uy
    out[SY] = max(sx * uy + sy * ux, 0.0)


@njit(cache=True, nogil=True)
def _beaten(
    candidate: FloatArray,
    side: float,
    length: float,
    ux: float,
    uy: float,
    at_origin: float,
    at_apex: float,
    at_opposite: float,
) -> bool:
    """Whether a path through a vertex of the triangle is shorter to all points of a window on one side.

    The side runs from the origin to the apex in direction (ux, uy); the opposite vertex is (length, 0), and
    the window has come through the x-axis (Xin and Wang 2009, theorem 3.2).
    """
    lo, hi, sx, sy, sigma = candidate[LO], candidate[HI], candidate[SX], candidate[SY], candidate[SIGMA]
    to_lo = distance_at(lo, sx, sy, sigma)
    slack = TIE * (to_lo + side)
    if at_apex + (side - lo) < to_lo - slack:
        return True
    if at_origin + hi < distance_at(hi, sx, sy, sigma) - slack:
        return True
    limit = to_lo - slack - at_opposite
    if limit <= 0.0:
        return False
    dx, dy = length - lo * ux, lo * uy
    return dx * dx + dy * dy < limit * limit


@njit(cache=True, nogil=True)
def _start_from(v: int, front: Front, pool: Pool, mesh: UnfoldedMesh, candidate: FloatArray) -> Pool:
    """Let vertex v, at its present distance, be the source of windows on all sides that face it."""
    distance = front.distance[v]
    for c in mesh.corners[mesh.corner_start[v] : mesh.corner_start[v + 1]]:
        f, k = c // 3, c % 3
        side, back = 3 * f + (k + 1) % 3, 3 * f + (k + 2) % 3
        a, b = mesh.faces[f, (k + 1) % 3], mesh.faces[f, (k + 2) % 3]
        _reach(front, mesh, a, distance + mesh.lengths[c])
        _reach(front, mesh, b, distance + mesh.lengths[back])
        target = mesh.twins[side]
        if target < 0:
            continue
        candidate[LO], candidate[HI] = 0.0, mesh.lengths[side]
        candidate[SX], candidate[SY], candidate[SIGMA] = mesh.apex[side, 0], mesh.apex[side, 1], distance
        if not insertion_room(pool, target):
            pool = grown_pool(pool)
        _deliver(front, pool, mesh, side, False, candidate, -1)
    return pool


@njit(cache=True, nogil=True)
def _cross_face(h: int, front: Front, pool: Pool, mesh: UnfoldedMesh, candidate: FloatArray) -> Pool:
    """Carry the pending windows of half-edge h over its face."""
    f, k = h // 3, h % 3
    ahead, back = 3 * f + (k + 1) % 3, 3 * f + (k + 2) % 3
    a, b, c = mesh.faces[f, k], mesh.faces[f, (k + 1) % 3], mesh.faces[f, (k + 2) % 3]
    length, left, right = mesh.lengths[h], mesh.lengths[back], mesh.lengths[ahead]
    cx, cy = mesh.apex[h, 0], mesh.apex[h, 1]
    left_hint = right_hint = -1
    row = pool.first[h]
    while row >= 0:
        if not pool.pending[row]:
            row = pool.follower[row]
            continue
        pool.pending[row] = False
        w = pool.windows[row]
        lo, hi, sx, sy, sigma = w[LO], w[HI], w[SX], w[SY], w[SIGMA]
        row = pool.follower[row]
        depth = sy + cy
        split = sx + sy * ((cx - sx) / depth) if depth > 0.0 else sx
        nearest = min(max(split, lo), hi)
        if nearest == split:
            _reach(front, mesh, c, sigma + np.sqrt((cx - sx) * (cx - sx) + depth * depth))
        elif abs(nearest - split) < REACH * length or front.distance[c] == np.inf:
            bent = np.sqrt((cx - nearest) * (cx - nearest) + cy * cy)
            _reach(front, mesh, c, distance_at(nearest, sx, sy, sigma) + bent)
        candidate[SIGMA] = sigma
        if lo < split and mesh.twins[back] >= 0 and left > 0.0:
            _carried(lo, hi, sx, sy, split, cx, cy, left, candidate)
            if not _beaten(
                candidate, left, length, cx / left, cy / left, front.distance[a], front.distance[c], front.distance[b]
            ):
                if not insertion_room(pool, mesh.twins[back]):
                    pool = grown_pool(pool)
                left_hint = _deliver(front, pool, mesh, back, True, candidate, left_hint)
        if hi > split and mesh.twins[ahead] >= 0 and right > 0.0:
            # The same from the other end: the origin is b.
            _carried(length - hi, length - lo, length - sx, sy, length - split, length - cx, cy, right, candidate)
            if not _beaten(
                candidate,
                right,
                length,
                (length - cx) / right,
                cy / right,
                front.distance[b],
                front.distance[c],
                front.distance[a],
            ):
                if not insertion_room(pool, mesh.twins[ahead]):
                    pool = grown_pool(pool)
                right_hint = _deliver(front, pool, mesh, ahead, False, candidate, right_hint)
    return pool


@njit(cache=True, nogil=True)
def propagate(source: int, mesh: UnfoldedMesh, distance: FloatArray) -> None:
    """Fill ``distance`` (n,) with the exact distance of every vertex from the source, inf where unreachable."""
    n, n_halfedges = len(distance), len(mesh.twins)
    distance[:] = np.inf
    front = Front(
        distance,
        np.empty(n_halfedges + n, dtype=np.int32),
        np.full(n_halfedges + n, -1, dtype=np.int32),
        np.empty(n_halfedges + n),
        np.zeros(1, dtype=np.int32),
    )
    pool = new_pool(n_halfedges, 2 * n_halfedges + 64)
    candidate = np.empty(WIDTH)
    distance[source] = 0.0
    pool = _start_from(source, front, pool, mesh, candidate)
    while front.size[0] > 0:
        front.size[0] -= 1
        item = heap_pop(front.heap, front.slot_of, front.key, front.size[0] + 1)
        if item < n_halfedges:
            pool = _cross_face(item, front, pool, mesh, candidate)
        else:
            pool = _start_from(item - n_halfedges, front, pool, mesh, candidate)
