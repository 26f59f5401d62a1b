"""Sparse rows that every kernel can read: transposing and merging in linear time."""

from __future__ import annotations

import numpy as np

from qgeo_filters.jit import njit

Csr = tuple[np.ndarray, np.ndarray, np.ndarray]  # start (n + 1,), column (g,), value (g,)


@njit()
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


@njit()
def merged(start_a, column_a, value_a, start_b, column_b, value_b):  # type: ignore[no-untyped-def]
    """Union of two matrices with sorted rows, the smaller value where both have an entry."""
    n = len(start_a) - 1
    start = np.zeros(n + 1, np.int64)
    column, value = column_a[:0].copy(), value_a[:0].copy()
    for writing in range(2):  # first only counted, so that no more memory is taken than needed
        size = 0
        for r in range(n):
            i, j = start_a[r], start_b[r]
            while i < start_a[r + 1] or j < start_b[r + 1]:
                has_a = i < start_a[r + 1] and (j == start_b[r + 1] or column_a[i] <= column_b[j])
                has_b = j < start_b[r + 1] and (i == start_a[r + 1] or column_b[j] <= column_a[i])
                if writing:
                    column[size] = column_a[i] if has_a else column_b[j]
                    value[size] = (
                        min(value_a[i], value_b[j]) if has_a and has_b else value_a[i] if has_a else value_b[j]
                    )
                i += has_a
                j += has_b
                size += 1
            start[r + 1] = size
        if not writing:
            column, value = np.empty(size, column_a.dtype), np.empty(size, value_a.dtype)
    return start, column, value


def undirected(start: np.ndarray, column: np.ndarray, value: np.ndarray) -> Csr:
    """Matrix united with its transpose, in compressed and sorted rows, the smaller value where they differ."""
    back = transposed(start, column, value)
    return merged(*transposed(*back), *back)
