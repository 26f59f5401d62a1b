"""Rows of a table that are equal, and indices that occur: `numpy.unique` for millions of them."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray


def equal_rows(rows: np.ndarray) -> tuple[IndexArray, IndexArray]:
    """Number of each row, (n,), the same for equal ones, and the first row of each number; NaN equals nothing."""
    order = np.lexsort(rows.T)  # stable: the first of equals comes first
    ordered = rows[order]
    starts = np.ones(len(rows), dtype=bool)
    starts[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    number = np.empty(len(rows), dtype=np.int64)
    number[order] = np.cumsum(starts) - 1
    return number, order[starts]


def occurring(indices: np.ndarray, count: int) -> IndexArray:
    """Those of ``range(count)`` that occur, in order."""
    there = np.zeros(count, dtype=bool)
    there[indices.ravel()] = True
    return np.flatnonzero(there)
