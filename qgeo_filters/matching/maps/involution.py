"""Exact involutions near a symmetric matrix of costs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import min_weight_full_bipartite_matching
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.parallel import worker_count

# Partners that are considered for each point.
_PARTNERS = 12
# Points up to which the sum of costs is the least there is: that takes a minute at 50,000.
_OPTIMAL = 12_000


def nearest_partners(left: npt.NDArray, right: npt.NDArray, count: int) -> tuple[IndexArray, FloatArray]:
    """The ``count`` nearest rows of right for each row of left, and their squared distances, shapes (n, count)."""
    count = min(count, len(right))
    distances, partners = cKDTree(right).query(left, k=np.arange(1, count + 1), workers=worker_count())
    return np.asarray(partners, dtype=np.int64), np.asarray(distances) ** 2


def optimal_involution(first: npt.NDArray, second: npt.NDArray, side: npt.NDArray[np.int8]) -> IndexArray:
    """Involution T (n,) that pairs points of side 1 with points of side -1, or a point with itself.

    Minimises the sum of costs, where x and y paired cost :math:`|first_x - second_y|` each, and a point that is left
    alone :math:`|first_x - second_x|`. Points of side 0 stay alone. The two sides need not have equally many points.
    Of more than 12,000 points those that prefer each other are paired, then those of what is left, until none does.

    Parameters
    ----------
    first, second : (n, d) float
        Embeddings with :math:`|first_x - second_y| = |first_y - second_x|`.
    side : (n,) int
    """
    return _involution(first, second, side, exact=True)


def _involution(first: npt.NDArray, second: npt.NDArray, side: npt.NDArray[np.int8], exact: bool) -> IndexArray:
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
    few = exact and len(side) <= _OPTIMAL
    i, j = (_optimal_pairs if few else _mutual_pairs)(rows, columns, costs, alone[left], alone[right])
    p2p[left[i]], p2p[right[j]] = right[j], left[i]
    if not few and len(i):
        rest = np.setdiff1d(np.arange(len(side)), np.concatenate([left[i], right[j]]))
        p2p[rest] = rest[_involution(first[rest], second[rest], side[rest], exact=False)]
    return p2p


def _optimal_pairs(
    rows: IndexArray, columns: IndexArray, costs: FloatArray, alone_left: FloatArray, alone_right: FloatArray
) -> tuple[IndexArray, IndexArray]:
    """Pairs (row, column) of least cost together, with that of what is left alone."""
    n, m = len(alone_left), len(alone_right)
    # A row that stays alone takes a column of its own. What a column costs alone is saved by whom it is matched with.
    worth = costs < alone_left[rows] + alone_right[columns]
    rows, columns, costs = rows[worth], columns[worth], costs[worth]
    entries = np.concatenate([costs - alone_right[columns], alone_left])
    # The solver takes a cost of zero for no edge: all are moved above it, as each row is matched once.
    entries += 1e-12 - entries.min(initial=0.0)
    places = np.concatenate([rows, np.arange(n)]), np.concatenate([columns, m + np.arange(n)])
    row, column = min_weight_full_bipartite_matching(sparse.csr_matrix((entries, places), shape=(n, m + n)))
    pairs = column < m
    return np.asarray(row[pairs], dtype=np.int64), np.asarray(column[pairs], dtype=np.int64)


def _mutual_pairs(
    rows: IndexArray, columns: IndexArray, costs: FloatArray, alone_left: FloatArray, alone_right: FloatArray
) -> tuple[IndexArray, IndexArray]:
    """Pairs (row, column) that prefer each other, of all points, then of those left, until none does."""
    worth = np.flatnonzero(costs < alone_left[rows] + alone_right[columns])
    order = worth[np.argsort(costs[worth], kind="stable")]
    rows, columns = rows[order], columns[order]
    found = [(np.zeros(0, np.int64), np.zeros(0, np.int64))]
    while len(rows):
        # Cheapest first: the first entry of a row, and of a column, is what it prefers.
        first_of_row, first_of_column = (np.unique(side, return_index=True)[1] for side in (rows, columns))
        mutual = np.intersect1d(first_of_row, first_of_column)
        found.append((rows[mutual], columns[mutual]))
        left = ~(np.isin(rows, rows[mutual]) | np.isin(columns, columns[mutual]))
        rows, columns = rows[left], columns[left]
    return np.concatenate([i for i, _ in found]), np.concatenate([j for _, j in found])
