"""Path lengths as whole numbers, so that sums of them are exact: in any order, from either end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.geodesics.dgg.csr import Csr, undirected
from qgeo_filters.jit import njit

# Of the accuracy, the share by which one unit may lengthen an edge, and three times that a path.
ROUNDING = 0.01
# Near pairs are kept apart up to this many times the length at which a unit matters.
_REACH = 32
# A graph with more near pairs than this for each vertex counts in 52 bits.
_CROWD = 8


class FixedPoint(NamedTuple):
    """Lengths of the edges of a graph in units, and exact lengths where units are too coarse."""

    length: np.ndarray  # (g,) uint32, or float64 with whole numbers
    unit: float
    unreached: float  # more units than any path has
    near_start: npt.NDArray[np.int64]  # (n + 1,) pairs of vertices that are near each other, in compressed rows
    near: IntArray
    near_length: FloatArray


def to_fixed_point(start: np.ndarray, end: IntArray, length: FloatArray, bound: float, accuracy: float) -> FixedPoint:
    """Lengths of directed edges, in compressed rows, rounded up to units.

    32 bits span the longest path, which is no longer than ``bound``; a unit then is fine enough but for
    edges some 1e5 times shorter. Paths among those are found apart, in float64. Where there are too many of
    them, lengths are whole numbers in float64.
    """
    room = 1.0 + (float(length.max()) / bound if bound > 0 else 0.0)  # for one more edge behind the longest path
    unreached = np.floor((2.0**32 - 1) / room)
    # A path may be longer by a unit for each of its edges: hence the room above the bound.
    unit = 1.001 * bound / unreached if bound > 0 else 1.0
    shortest = unit / (accuracy * ROUNDING)
    n = len(start) - 1
    crowd = _CROWD * n
    pairs = np.zeros(n + 1, np.int64), np.zeros(0, np.int32), np.zeros(0)
    if np.any((length > 0) & (length < shortest)):
        pairs = near_pairs(*_shorter(start, end, length, _REACH * shortest), _REACH * shortest, crowd)
        if len(pairs[1]) >= crowd:
            unit = 1.001 * bound / 2.0**52
            return FixedPoint(
                np.ceil(length / unit), unit, 2.0**52, np.zeros(n + 1, np.int64), *(x[:0] for x in pairs[1:])
            )
        pairs = undirected(*pairs)
    return FixedPoint(np.ceil(length / unit).astype(np.uint32), unit, unreached, *pairs)


def _shorter(start: np.ndarray, end: IntArray, length: FloatArray, most: float) -> Csr:
    """Edges up to a length, in either direction."""
    few = np.flatnonzero(length < most)
    row = np.searchsorted(start, few, side="right") - 1
    few_start = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=len(start) - 1))])
    return undirected(few_start, end[few], length[few])


@njit()
def near_pairs(start, neighbour, length, radius, most):  # type: ignore[no-untyped-def]
    """Shortest paths up to a small radius, from each vertex to those behind it, in compressed rows.

    Stops where there are more than ``most`` of them.
    """
    n = len(start) - 1
    distance = np.full(n, np.inf)
    members = np.empty(n, np.int32)
    row_start = np.zeros(n + 1, np.int64)
    column, value = np.empty(most + n, np.int32), np.empty(most + n)
    size = 0
    for s in range(n):
        members[0], distance[s], count = s, 0.0, 1
        moving = True
        while moving:  # Bellman and Ford: the neighbourhoods are tiny
            moving = False
            for i in range(count):
                v = members[i]
                for e in range(start[v], start[v + 1]):
                    w, d = neighbour[e], distance[v] + length[e]
                    if d < radius and d < distance[w]:
                        if distance[w] == np.inf:
                            members[count] = w
                            count += 1
                        distance[w] = d
                        moving = True
        for i in range(count):
            w = members[i]
            if w > s and size < most:
                column[size], value[size] = w, distance[w]
                size += 1
            distance[w] = np.inf
        row_start[s + 1] = size
        if size >= most:
            break
    return row_start, column[:size].copy(), value[:size].copy()
