"""Shortest paths in the discrete geodesic graph from sixteen neighbouring sources at once, without a heap.

Vertices are pulled in the order of their distance from the sources: each takes the minimum over its
neighbours for all sources together (vector lanes), so that nearly every value is final after one pass. A vertex whose value
fell wakes those that depend on it, and passes repeat until none is awake. The result is the shortest path
length whatever the order was: it depends neither on the threads nor on the grouping.
"""

from __future__ import annotations

import numpy as np
from numba import njit

LANES = 16


@njit(cache=True, nogil=True)
def distance_order(start, neighbour, length, source, order, distance):  # type: ignore[no-untyped-def]
    """Vertices by increasing distance along edges (Dijkstra, binary heap), the unreachable ones left out; their number."""
    distance[:] = np.inf
    distance[source] = 0.0
    keys = np.empty(64)
    nodes = np.empty(64, np.int32)
    keys[0], nodes[0] = 0.0, source
    size = 1
    done = 0
    while size > 0:
        key, v = keys[0], nodes[0]
        size -= 1
        last_key, last = keys[size], nodes[size]
        i = 0
        while 2 * i + 1 < size:
            child = 2 * i + 1
            if child + 1 < size and keys[child + 1] < keys[child]:
                child += 1
            if keys[child] >= last_key:
                break
            keys[i], nodes[i] = keys[child], nodes[child]
            i = child
        keys[i], nodes[i] = last_key, last
        if key > distance[v]:
            continue
        order[done] = v
        done += 1
        for e in range(start[v], start[v + 1]):
            w = neighbour[e]
            d = key + length[e]
            if d < distance[w]:
                distance[w] = d
                if size == len(keys):
                    more, more_nodes = np.empty(2 * size), np.empty(2 * size, np.int32)
                    more[:size], more_nodes[:size] = keys, nodes
                    keys, nodes = more, more_nodes
                i = size
                size += 1
                while i > 0 and keys[(i - 1) // 2] > d:
                    keys[i], nodes[i] = keys[(i - 1) // 2], nodes[(i - 1) // 2]
                    i = (i - 1) // 2
                keys[i], nodes[i] = d, w
    return done


@njit(cache=True, nogil=True)
def _pull(start, neighbour, length, block, best, t):  # type: ignore[no-untyped-def]
    """Lower the values of t by those of its neighbours; whether any fell."""
    for k in range(LANES):
        best[k] = block[t, k]
    for e in range(start[t], start[t + 1]):
        w = neighbour[e]
        d = length[e]
        for k in range(LANES):
            best[k] = min(best[k], block.dtype.type(block[w, k] + d))
    fell = False
    for k in range(LANES):
        fell |= best[k] < block[t, k]
        block[t, k] = best[k]
    return fell


@njit(cache=True, nogil=True)
def relax(into_start, into, into_length, out_start, out, order, count, block, best, awake):  # type: ignore[no-untyped-def]
    """Bring the block (n, 16) of path lengths to its fixed point.

    ``into`` lists for every vertex the starts of the edges that end there, ``out`` the ends of those that start there.
    """
    awake[:] = True
    waiting = count
    while waiting > 0:
        waiting = 0
        for i in range(count):
            t = order[i]
            if awake[t]:
                awake[t] = False
                if _pull(into_start, into, into_length, block, best, t):
                    for e in range(out_start[t], out_start[t + 1]):
                        awake[out[e]] = True
        for i in range(count):
            if awake[order[i]]:
                waiting += 1
