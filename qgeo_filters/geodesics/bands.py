"""The order in which vertices are swept: by bands of distance from the sources, in a compact order within each."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def band_order(start, neighbour, length, width, sources, order, distance, settled, head, following):  # type: ignore[no-untyped-def]  # fmt: skip
    """Put the vertices that paths from the sources reach into ``order``; their number.

    Distances are along mesh edges from the middle source (others only matter where they lie in another piece
    of the mesh), in buckets of the given width. Counting sort keeps the vertices of a band in the order of
    their numbers, that is, close to each other in memory.
    """
    bands = len(head) - 1
    distance[:] = np.inf
    settled[:] = False
    for k in range(len(sources)):
        source = sources[(k + len(sources) // 2) % len(sources)]
        if not settled[source]:
            distance[source] = 0.0
            _bucket_dijkstra(start, neighbour, length, width, source, distance, settled, head, following)
    head[:] = 0
    for v in range(len(order)):
        if settled[v]:
            head[min(int(distance[v] / width), bands - 1) + 1] += 1
    for b in range(bands):
        head[b + 1] += head[b]
    count = head[bands]
    for v in range(len(order)):
        if settled[v]:
            b = min(int(distance[v] / width), bands - 1)
            order[head[b]] = v
            head[b] += 1
    return count


@njit(cache=True, nogil=True)
def _bucket_dijkstra(start, neighbour, length, width, source, distance, settled, head, following):  # type: ignore[no-untyped-def]  # fmt: skip
    """Path lengths along mesh edges from one source, the least but for steps within a bucket (Dial 1969).

    A bucket is a chain of directed edges, ``head[b]``, ``following[head[b]]``, ..., that reach its vertices. A
    vertex that was brought nearer stands in several buckets, and counts in the first.
    """
    bands = len(head) - 1
    head[:] = -1
    v, b = source, 0
    while b < bands:
        if v >= 0 and not settled[v]:
            settled[v] = True
            for e in range(start[v], start[v + 1]):
                w, d = neighbour[e], distance[v] + length[e]
                if d < distance[w] and not settled[w]:
                    distance[w] = d
                    bucket = min(int(d / width), bands - 1)
                    following[e] = head[bucket]
                    head[bucket] = e
        while b < bands and head[b] < 0:
            b += 1
        if b < bands:
            v = neighbour[head[b]]
            head[b] = following[head[b]]
