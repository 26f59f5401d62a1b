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

from qgeo_filters.geodesics.bands import band_order
from qgeo_filters.geodesics.lanes import LANES, aligned_block, pull


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
def solve(start, neighbour, length, mesh_start, mesh_neighbour, mesh_length, width, bands, unreached, place, tick, sources, out, rows):  # type: ignore[no-untyped-def]  # fmt: skip
    """Distances from some places, a few blocks of 16, to all vertices, into the given rows of ``out`` (., n)."""
    n = len(place)
    block = aligned_block(n, length)
    order, distance, awake = np.empty(n, np.int32), np.empty(n), np.empty(n, np.bool_)
    head, following = np.empty(bands + 1, np.int32), np.empty(len(mesh_neighbour), np.int32)
    for first in range(0, len(sources), LANES):
        part = sources[first : first + LANES]
        block[:] = unreached
        for k in range(LANES):
            block[part[min(k, len(part) - 1)], k] = 0
        count = band_order(
            mesh_start, mesh_neighbour, mesh_length, width, part, order, distance, awake, head, following
        )
        relax(start, neighbour, length, order[:count], block, awake)
        for v in range(n):
            p = place[v]
            for k in range(len(part)):
                value = block[p, k]
                out[rows[first + k], v] = value * tick if value < unreached else np.inf
