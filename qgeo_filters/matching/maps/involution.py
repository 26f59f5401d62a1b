"""Exact involutions near a symmetric matrix of costs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import min_weight_full_bipartite_matching

from qgeo_filters._typing import FloatArray, IndexArray

# Partners that are considered for each point.
_PARTNERS = 12


def nearest_partners(left: npt.NDArray, right: npt.NDArray, count: int) -> tuple[IndexArray, FloatArray]:
    """The ``count`` nearest rows of right for each row of left, and their squared distances, shapes (n, count)."""
    count = min(count, len(right))
    half = (right * right).sum(axis=1)
    partners = np.empty((len(left), count), dtype=np.int64)
    costs = np.empty((len(left), count))
    for first in range(0, len(left), 1024):
        part = left[first : first + 1024]
        squared = half - 2 * (part @ right.T) + (part * part).sum(axis=1)[:, None]
        chosen = np.argpartition(squared, count - 1, axis=1)[:, :count]
        partners[first : first + 1024] = chosen
        costs[first : first + 1024] = np.take_along_axis(squared, chosen, axis=1)
    return partners, np.maximum(costs, 0.0)


def optimal_involution(first: npt.NDArray, second: npt.NDArray, side: npt.NDArray[np.int8]) -> IndexArray:
    """Involution T (n,) that pairs points of side 1 with points of side -1, or a point with itself.

    Minimises the sum of costs, where x and y paired cost :math:`|first_x - second_y|` each, and a point that is left
    alone :math:`|first_x - second_x|`. Points of side 0 stay alone. The two sides need not have equally many points.

    Parameters
    ----------
    first, second : (n, d) float
        Embeddings with :math:`|first_x - second_y| = |first_y - second_x|`.
    side : (n,) int
    """
    p2p = np.arange(len(side))
    left, right = np.flatnonzero(side > 0), np.flatnonzero(side < 0)
    if not (left.size and right.size):
        return p2p
    forth, forth_cost = nearest_partners(first[left], second[right], _PARTNERS)
    back, back_cost = nearest_partners(first[right], second[left], _PARTNERS)
    rows = np.concatenate([np.repeat(np.arange(left.size), forth.shape[1]), back.ravel()])
    columns = np.concatenate([forth.ravel(), np.repeat(np.arange(right.size), back.shape[1])])
    costs = 2 * np.sqrt(np.concatenate([forth_cost.ravel(), back_cost.ravel()]))
    keys, place = np.unique(rows * right.size + columns, return_index=True)
    rows, columns, costs = keys // right.size, keys % right.size, costs[place]
    alone = np.linalg.norm(first - second, axis=1).astype(np.float64)
    # Each point has a shadow on the other side to be matched with where it stays alone; shadows of a pair match
    # each other for nothing, so that a full matching always exists. The solver takes a cost of zero for no edge.
    n, m = left.size, right.size
    free = np.zeros(len(rows))
    table = sparse.coo_matrix(
        (
            np.concatenate([costs, alone[left], alone[right], free]) + 1e-12,
            (
                np.concatenate([rows, np.arange(n), n + np.arange(m), n + columns]),
                np.concatenate([columns, m + np.arange(n), np.arange(m), m + rows]),
            ),
        ),
        shape=(n + m, n + m),
    ).tocsr()
    row, column = min_weight_full_bipartite_matching(table)
    pairs = (row < n) & (column < m)
    p2p[left[row[pairs]]] = right[column[pairs]]
    p2p[right[column[pairs]]] = left[row[pairs]]
    return p2p
