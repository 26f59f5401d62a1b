"""Shortest paths in the discrete geodesic graph from 32 neighbouring sources at once, or from a single one.

Vertices are taken in the order of their distance from the sources; each pulls the minimum over its neighbours
for all sources together, so that nearly every value is final after one pass and no heap is needed.
A second pass checks; a vertex whose value fell then wakes its neighbours, until none is awake. Path lengths
are whole numbers and sums of them exact, so that the result depends neither on the order nor on the grouping of the
sources, and is the same from either end of a path.

Sources far from each other have no common order of distance, and would be pulled over and over: each is taken alone,
and its vertices push what they have to their neighbours.
"""

from __future__ import annotations

import numpy as np

from qgeo_filters.geodesics.dgg.simd import pull
from qgeo_filters.jit import njit


@njit()
def relax(start, neighbour, length, order, block, awake):  # type: ignore[no-untyped-def]
    """Bring a block (n, 32) of path lengths to its fixed point; the number of rows pulled."""
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


@njit()
def relax_one(start, neighbour, length, order, column, awake):  # type: ignore[no-untyped-def]
    """Bring path lengths (n,) from a single source, the only one awake, to their fixed point; rows pushed."""
    pushed, before = 0, -1
    while pushed > before:
        before = pushed
        for t in order:
            if awake[t]:
                awake[t] = False
                pushed += 1
                here = column[t]
                for e in range(start[t], start[t + 1]):
                    reach = here + length[e]
                    if reach < column[neighbour[e]]:
                        column[neighbour[e]] = reach
                        awake[neighbour[e]] = True
    return pushed


@njit()
def write_rows(block, unreached, place, unit, out, rows):  # type: ignore[no-untyped-def]
    """Columns of a block as lengths into the given rows of ``out`` (., n), in the order of the vertices."""
    for v in range(len(place)):
        p = place[v]
        for k in range(len(rows)):
            value = block[p, k]
            out[rows[k], v] = value * unit if value < unreached else np.inf


@njit()
def write_near(start, near, length, vertex, places, out, rows):  # type: ignore[no-untyped-def]
    """Lengths of the near pairs of each of these places into its row of ``out``."""
    for k in range(len(rows)):
        for e in range(start[places[k]], start[places[k] + 1]):
            out[rows[k], vertex[near[e]]] = length[e]
