"""A binary heap of numbered items whose keys may fall while they wait (Numba)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from numba import njit

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int32]


@njit(cache=True, nogil=True)
def _sift_up(slot: int, heap: IndexArray, slot_of: IndexArray, key: FloatArray) -> None:
    item = heap[slot]
    while slot > 0:
        parent = (slot - 1) >> 1
        if key[heap[parent]] <= key[item]:
            break
        heap[slot] = heap[parent]
        slot_of[heap[slot]] = slot
        slot = parent
    heap[slot] = item
    slot_of[item] = slot


@njit(cache=True, nogil=True)
def heap_lower(item: int, value: float, heap: IndexArray, slot_of: IndexArray, key: FloatArray, size: int) -> int:
    """Number of items once ``item`` waits with a key of at most ``value``.

    ``slot_of`` holds -1 for items that do not wait; ``heap`` has room for all items.
    """
    slot = slot_of[item]
    if slot < 0:
        key[item] = value
        heap[size] = item
        _sift_up(size, heap, slot_of, key)
        return size + 1
    if value < key[item]:
        key[item] = value
        _sift_up(slot, heap, slot_of, key)
    return size


@njit(cache=True, nogil=True)
def heap_pop(heap: IndexArray, slot_of: IndexArray, key: FloatArray, size: int) -> int:
    """Item of the smallest key, taken out of a heap of ``size`` items."""
    top = heap[0]
    slot_of[top] = -1
    size -= 1
    if size > 0:
        item = heap[size]
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
