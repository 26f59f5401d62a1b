"""Shortest paths in the discrete geodesic graph from sixteen neighbouring sources at once.

Vertices are taken in the order of their distance from the sources; each pulls the minimum over its neighbours
for all sources together, so that nearly every value is final after one pass and no heap is needed.
A second pass checks; a vertex whose value fell then wakes its neighbours, until none is awake. Path lengths
are whole numbers and sums of them exact, so that the result depends neither on the order nor on the grouping of the
sources, and is the same from either end of a path.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from qgeo_filters.geodesics.lanes import LANES, pull


@njit(cache=True, nogil=True)
def relax(start, neighbour, length, order, block, awake):  # type: ignore[no-untyped-def]
    """Bring a block (n, 16) of path lengths to its fixed point; the number of rows pulled."""
    for t in order:
        pull(block, t, start, neighbour, length)
    pulled = len(order)
    awake[:] = True
    waiting = len(order)
    while waiting > 0:
        waiting = 0
        for t in order:
            if awake[t]:
                awake[t] = False
                pulled += 1
                if pull(block, t, start, neighbour, length):
                    waiting += 1
                    for e in range(start[t], start[t + 1]):
                        awake[neighbour[e]] = True
    return pulled


@njit(cache=True, nogil=True)
def mesh_order(start, neighbour, length, sources):  # type: ignore[no-untyped-def]
    """Vertices that paths from the sources reach, by distance along edges from the middle one (Dijkstra)."""
    n = len(start) - 1
    order, distance = np.empty(n, np.int32), np.full(n, np.inf)
    keys, nodes = np.empty(len(neighbour) + 1), np.empty(len(neighbour) + 1, np.int32)
    done = 0
    for k in range(len(sources)):
        # The middle first; others only matter where they lie in another piece of the mesh.
        source = sources[(k + len(sources) // 2) % len(sources)]
        if distance[source] < np.inf:
            continue
        distance[source] = keys[0] = 0.0
        nodes[0] = source
        size = 1
        while size > 0:
            key, v = keys[0], nodes[0]
            size -= 1
            _sift_down(keys, nodes, size)
            if key > distance[v]:
                continue
            order[done] = v
            done += 1
            for e in range(start[v], start[v + 1]):
                w, d = neighbour[e], key + length[e]
                if d < distance[w]:
                    distance[w] = d
                    _sift_up(keys, nodes, size, d, w)
                    size += 1
    return order[:done]


@njit(cache=True, nogil=True)
def _sift_down(keys, nodes, size):  # type: ignore[no-untyped-def]
    """Put the entry behind the heap's last one into the free root."""
    key, node = keys[size], nodes[size]
    i = 0
    while 2 * i + 1 < size:
        child = 2 * i + 1
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[i], nodes[i] = keys[child], nodes[child]
        i = child
    keys[i], nodes[i] = key, node


@njit(cache=True, nogil=True)
def _sift_up(keys, nodes, size, key, node):  # type: ignore[no-untyped-def]
    """Add an entry to a heap of this size."""
    i = size
    while i > 0 and keys[(i - 1) // 2] > key:
        keys[i], nodes[i] = keys[(i - 1) // 2], nodes[(i - 1) // 2]
        i = (i - 1) // 2
    keys[i], nodes[i] = key, node


@njit(cache=True, nogil=True)
def solve(start, neighbour, length, order, unreached, sources, block, awake, place, tick, rows):  # type: ignore[no-untyped-def]
    """Distances from up to 16 sources (places) to all vertices into ``rows`` (s, n), in the order of the vertices."""
    block[:] = unreached
    for k in range(LANES):
        block[sources[min(k, len(sources) - 1)], k] = 0
    relax(start, neighbour, length, order, block, awake)
    for v in range(len(place)):
        p = place[v]
        for k in range(len(sources)):
            value = block[p, k]
            rows[k, v] = value * tick if value < unreached else np.inf
