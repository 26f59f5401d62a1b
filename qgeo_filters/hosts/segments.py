"""Pieces of curves, numbered through all of them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray


def segments(curves: Sequence[FloatArray]) -> tuple[FloatArray, IndexArray]:
    """Points of all curves, (n, 3), and the two ends of each piece, (m, 2)."""
    starts = np.cumsum([0, *map(len, curves)])
    pieces = [np.arange(start, end - 1) for start, end in pairwise(starts)]
    first = np.concatenate([*pieces, np.empty(0, dtype=np.int64)]).astype(np.int64)
    return np.concatenate([*curves, np.empty((0, 3))]), np.column_stack([first, first + 1])
