"""An order of the vertices in which any few that follow each other are close together on the surface."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def _spread(start, neighbour, group, g, source, order, mark, stamp):  # type: ignore[no-untyped-def]
    """Breadth-first order of the part of group g that is connected with the source; its size."""
    order[0] = source
    mark[source] = stamp
    head, tail = 0, 1
    while head < tail:
        v = order[head]
        head += 1
        for e in range(start[v], start[v + 1]):
            w = neighbour[e]
            if group[w] == g and mark[w] != stamp:
                mark[w] = stamp
                order[tail] = w
                tail += 1
    return tail


@njit(cache=True)
def compact_order(start, neighbour, leaf):  # type: ignore[no-untyped-def]
    """Permutation of the vertices by recursive bisection of the mesh into pieces of at most ``leaf`` vertices.

    A piece is cut in breadth-first order from one of its far ends; what is not connected with that end comes last.
    """
    n = len(start) - 1
    order = np.arange(n).astype(np.int32)
    group = np.zeros(n, np.int32)
    mark = np.full(n, -1, np.int32)
    scratch = np.empty(n, np.int32)
    stack = [(0, n)]
    groups = stamp = 0
    while len(stack) > 0:
        first, last = stack.pop()
        groups += 1
        for i in range(first, last):
            group[order[i]] = groups
        # From the far end of the first vertex's part, then the other parts in turn.
        reached = _spread(start, neighbour, group, groups, order[first], scratch, mark, stamp)
        stamp += 1
        filled = _spread(start, neighbour, group, groups, scratch[reached - 1], scratch, mark, stamp)
        for i in range(first, last):
            v = order[i]
            if mark[v] != stamp:
                filled += _spread(start, neighbour, group, groups, v, scratch[filled:], mark, stamp)
        stamp += 1
        order[first:last] = scratch[: last - first]
        if last - first > leaf:
            # Whole leaves on the left, so that leaves are consecutive runs of the final order.
            half = first + leaf * ((last - first + 2 * leaf - 1) // (2 * leaf))
            stack.append((half, last))
            stack.append((first, half))
    return order
