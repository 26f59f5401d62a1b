"""Sparse rows that every kernel can read: transposing and merging in linear time."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def transposed(start, column, value):  # type: ignore[no-untyped-def]
    """Transpose of a square matrix in compressed rows; the columns of each row come out sorted."""
    n = len(start) - 1
    new_start = np.zeros(n + 1, np.int64)
    for c in column:
        new_start[c + 1] += 1
    for r in range(n):
        new_start[r + 1] += new_start[r]
    new_column, new_value = np.empty_like(column), np.empty_like(value)
    free = new_start[:n].copy()
    for r in range(n):
        for e in range(start[r], start[r + 1]):
            slot = free[column[e]]
            new_column[slot], new_value[slot] = r, value[e]
            free[column[e]] += 1
    return new_start, new_column, new_value


@njit(cache=True, nogil=True)
def merged(start_a, column_a, value_a, start_b, column_b, value_b):  # type: ignore[no-untyped-def]
    """Union of two matrices with sorted rows, the smaller value where both have an entry."""
    n = len(start_a) - 1
    start = np.zeros(n + 1, np.int64)
    column = np.empty(len(column_a) + len(column_b), np.int32)
    value = np.empty(len(column), value_a.dtype)
    size = 0
    for r in range(n):
        i, j = start_a[r], start_b[r]
        while i < start_a[r + 1] or j < start_b[r + 1]:
            take_a = j == start_b[r + 1] or (i < start_a[r + 1] and column_a[i] <= column_b[j])
            if take_a:
                column[size], value[size] = column_a[i], value_a[i]
                if j < start_b[r + 1] and column_b[j] == column_a[i]:
                    value[size] = min(value_a[i], value_b[j])
                    j += 1
                i += 1
            else:
                column[size], value[size] = column_b[j], value_b[j]
                j += 1
            size += 1
        start[r + 1] = size
    return start, column[:size].copy(), value[:size].copy()
