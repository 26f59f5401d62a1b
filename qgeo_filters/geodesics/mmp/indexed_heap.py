"""A binary heap of numbered items whose keys may fall while they wait (Numba)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qgeo_filters.jit import inner, kernel


class IndexedHeap(NamedTuple):
    """Items 0..N-1, some of which wait; the first of ``heap`` has the smallest key."""

    heap: npt.NDArray[np.int64]  # (N + 1,) waiting items; their number is in the last place
    slot_of: npt.NDArray[np.int64]  # (N,) place in ``heap``, -1 for items that do not wait
    key: npt.NDArray[np.float64]  # (N,)


@inner
def new_heap(n_items: int) -> IndexedHeap:
    """A heap in which nothing waits."""
    heap = np.zeros(n_items + 1, dtype=np.int64)
    return IndexedHeap(heap, np.full(n_items, -1, dtype=np.int64), np.empty(n_items))


@kernel
def heap_push(queue: IndexedHeap, item: int, value: float) -> None:
    """Let ``item`` wait with a key of at most ``value``."""
    heap, slot_of, key = queue.heap, queue.slot_of, queue.key
    slot = slot_of[item]
    if slot < 0:
        slot = heap[-1]
        heap[-1] += 1
    elif key[item] <= value:
        return
    key[item] = value
    while slot > 0:
        parent = (slot - 1) >> 1
        if key[heap[parent]] <= value:
            break
        heap[slot] = heap[parent]
        slot_of[heap[slot]] = slot
        slot = parent
    heap[slot] = item
    slot_of[item] = slot


@kernel
def heap_pop(queue: IndexedHeap) -> int:
    """Item of the smallest key, which waits no longer; -1 if none waits."""
    heap, slot_of, key = queue.heap, queue.slot_of, queue.key
    size = heap[-1] - 1
    if size < 0:
        return -1
    heap[-1] = size
    top, item = heap[0], heap[size]
    slot_of[top] = -1
    if size == 0:
        return top
    slot = 0
    while True:
        child = 2 * slot + 1
        if child >= size:
            break
        if child + 1 < size and key[heap[child + 1]] < key[heap[child]]:
            child += 1
        if key[heap[child]] >= key[item]:
            break
        heap[slot] = heap[child]
        slot_of[heap[slot]] = slot
        slot = child
    heap[slot] = item
    slot_of[item] = slot
    return top
