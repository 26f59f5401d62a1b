"""An order of the vertices in which any few that follow each other are close together on the surface."""

from __future__ import annotations

import numpy as np

from qgeo_filters.jit import njit


@njit()
def _breadth_first(start, neighbour, group, g, source, order, first, mark, stamp):  # type: ignore[no-untyped-def]
    """Breadth-first order of what group g connects with the source into ``order[first:]``; where it ends."""
    order[first] = source
    mark[source] = stamp
    head, tail = first, first + 1
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


@njit()
def compact_order(start, neighbour, leaf):  # type: ignore[no-untyped-def]
    """Permutation of the vertices by recursive bisection of the mesh into pieces of at most ``leaf`` vertices.

    A piece is cut in breadth-first order from one of its far ends; what is not connected with that end
    comes last. Pieces are runs of the permutation whose first place is a multiple of ``leaf``.
    """
    n = len(start) - 1
    order, reached = np.empty(n, np.int32), np.empty(n, np.int32)
    group, mark = np.zeros(n, np.int32), np.full(n, -1, np.int32)
    for v in range(n):
        order[v] = v
    stack = np.empty((128, 2), np.int64)  # deeper than any bisection
    stack[0, 0], stack[0, 1] = 0, n
    depth, groups = 1, 0
    while depth > 0:
        depth -= 1
        first, last = stack[depth, 0], stack[depth, 1]
        groups += 1
        for i in range(first, last):
            group[order[i]] = groups
        end = _breadth_first(start, neighbour, group, groups, order[first], reached, first, mark, 2 * groups)
        stamp = 2 * groups + 1
        source, end = reached[end - 1], first
        i = first
        while end < last:
            end = _breadth_first(start, neighbour, group, groups, source, reached, end, mark, stamp)
            while end < last and mark[order[i]] == stamp:
                i += 1
            source = order[i]
        for i in range(first, last):
            order[i] = reached[i]
        if last - first > leaf:
            half = first + leaf * ((last - first + 2 * leaf - 1) // (2 * leaf))
            stack[depth, 0], stack[depth, 1] = half, last
            stack[depth + 1, 0], stack[depth + 1, 1] = first, half
            depth += 2
    return order
