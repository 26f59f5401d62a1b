"""A queue of edges by the size of their costs, in which each edge is moved, taken and left out in constant time.

Costs whose logarithms are close count as equal, and are served in the order in which they came: that spreads the
collapses over the surface.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from qgeo_filters._typing import IntArray
from qgeo_filters.jit import kernel

# Buckets to an octave; those of costs from 2^-_LOWEST on.
_FINENESS, _LOWEST, _BUCKETS = 4, 120, 560
_NONE = -1


class BucketQueue(NamedTuple):
    """Doubly linked lists of edges, one for each bucket of costs."""

    first: IntArray
    last: IntArray
    before: IntArray
    after: IntArray
    bucket: IntArray  # of each edge, -1 where it is not in the queue
    lowest: IntArray  # (1,) no bucket below holds an edge


def empty_queue(n_edges: int) -> BucketQueue:
    """Queue for edges 0 to n_edges - 1, of which none is in it."""
    first, last = (np.full(_BUCKETS, _NONE, dtype=np.int32) for _ in range(2))
    before, after, bucket = (np.full(n_edges, _NONE, dtype=np.int32) for _ in range(3))
    return BucketQueue(first, last, before, after, bucket, np.full(1, _BUCKETS, dtype=np.int32))


@kernel
def put(queue: BucketQueue, edge: int, cost: float) -> None:
    """Put an edge in, or move it to where its new cost belongs."""
    bucket = 0
    if cost > 0.0:
        bucket = min(max(int(_FINENESS * (np.log2(cost) + _LOWEST)), 0), _BUCKETS - 1)
    if queue.bucket[edge] == bucket:
        return
    leave(queue, edge)
    queue.bucket[edge] = bucket
    behind = queue.last[bucket]
    queue.before[edge], queue.after[edge] = behind, _NONE
    if behind == _NONE:
        queue.first[bucket] = edge
    else:
        queue.after[behind] = edge
    queue.last[bucket] = edge
    if bucket < queue.lowest[0]:
        queue.lowest[0] = bucket


@kernel
def leave(queue: BucketQueue, edge: int) -> None:
    """Take an edge out, if it is in."""
    bucket = queue.bucket[edge]
    if bucket == _NONE:
        return
    before, after = queue.before[edge], queue.after[edge]
    if before == _NONE:
        queue.first[bucket] = after
    else:
        queue.after[before] = after
    if after == _NONE:
        queue.last[bucket] = before
    else:
        queue.before[after] = before
    queue.bucket[edge] = _NONE


@kernel
def take(queue: BucketQueue) -> int:
    """Take out the edge of least cost, -1 from an empty queue."""
    while queue.lowest[0] < _BUCKETS and queue.first[queue.lowest[0]] == _NONE:
        queue.lowest[0] += 1
    if queue.lowest[0] == _BUCKETS:
        return _NONE
    edge = queue.first[queue.lowest[0]]
    leave(queue, edge)
    return edge
