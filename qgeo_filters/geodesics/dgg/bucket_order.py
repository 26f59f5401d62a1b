"""The order in which vertices are taken: by buckets of distance from the sources, in a compact order within each."""

from __future__ import annotations

import numpy as np

from qgeo_filters.jit import njit


@njit()
def bucket_order(start, neighbour, length, width, sources, order, distance, settled, head, following):  # type: ignore[no-untyped-def]  # fmt: skip
    """Put the vertices that paths from the sources reach into ``order``; their number.

    Distances are along mesh edges from the nearest source (measured: fewer pulls than by the distance from
    the middle of the sources), in buckets of the given width. Counting sort keeps the vertices of a bucket in
    the order of their numbers, that is, close to each other in memory.
    """
    n_buckets = len(head) - 1
    _bucket_dijkstra(start, neighbour, length, width, sources, distance, settled, head, following)
    head[:] = 0
    for v in range(len(order)):
        if settled[v]:
            head[min(int(distance[v] / width), n_buckets - 1) + 1] += 1
    for b in range(n_buckets):
        head[b + 1] += head[b]
    count = head[n_buckets]
    for v in range(len(order)):
        if settled[v]:
            b = min(int(distance[v] / width), n_buckets - 1)
            order[head[b]] = v
            head[b] += 1
    return count


@njit()
def _bucket_dijkstra(start, neighbour, length, width, sources, distance, settled, head, following):  # type: ignore[no-untyped-def]  # fmt: skip
    """Path lengths along mesh edges from the nearest source, the least but for steps within a bucket (Dial 1969).

    A bucket is a chain of directed edges, ``head[b]``, ``following[head[b]]``, ..., that reach its vertices. A
    vertex that was brought nearer stands in several buckets, and counts in the first.
    """
    n_buckets = len(head) - 1
    head[:] = -1
    distance[:] = np.inf
    settled[:] = False
    for source in sources:
        distance[source] = 0.0
    begun = bucket = 0
    while bucket < n_buckets:
        if begun < len(sources):
            v = sources[begun]
            begun += 1
        elif head[bucket] >= 0:
            v = neighbour[head[bucket]]
            head[bucket] = following[head[bucket]]
        else:
            bucket += 1
            continue
        if settled[v]:
            continue
        settled[v] = True
        for e in range(start[v], start[v + 1]):
            w, d = neighbour[e], distance[v] + length[e]
            if d < distance[w] and not settled[w]:
                distance[w] = d
                b = min(int(d / width), n_buckets - 1)
                following[e] = head[b]
                head[b] = e
