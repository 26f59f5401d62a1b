"""Factorisations of sparse symmetric positive definite matrices, and the rule of their threads.

SciPy has no sparse Cholesky; SuperLU without pivoting in its symmetric mode comes near. It keeps account of its memory
by thread: what is factorised in one thread and dropped in another is never freed. So factorise and drop in the same
thread; to solve in others meanwhile is safe.
"""

from __future__ import annotations

import logging
import threading
from typing import Any, Literal, NoReturn

import numpy as np
import numpy.typing as npt
from scipy.sparse.linalg import splu

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.jit import njit
from qgeo_filters.nested_dissection import nested_dissection

_log = logging.getLogger(__name__)

Ordering = Literal["MMD_AT_PLUS_A", "NATURAL"]

#: Unknowns from which on they are ordered by where they are: minimum degree takes 2 s for 135,000, minutes for 540,000.
MANY = 150_000
#: Unknowns from which on they are shuffled before minimum degree, which takes a minute instead of half a second for the
#: 40,962 of an icosphere in the order in which it was subdivided; it is not slower for scans.
SHUFFLED = 10_000


class SpdFactorisation:
    """Solver of one system: ``solve(b)`` is x with A x = b, for b of shape (n,) or (n, k); see `factorised_spd`.

    Dropped in another thread than the one it was made in, its memory is lost; that is logged as a warning.
    """

    def __init__(self, matrix: Any, ordering: Ordering, points: FloatArray | None = None) -> None:
        self._thread = threading.get_ident()
        self._order, self._factors = _factors(matrix, ordering, points)

    def __call__(self, right: FloatArray) -> FloatArray:
        if self._order is None:
            return self._factors.solve(right)
        solution = np.empty_like(right)
        solution[self._order] = self._factors.solve(right[self._order])
        return solution

    def __reduce__(self) -> NoReturn:
        raise TypeError("a factorisation cannot be pickled; factorise again where it is needed")

    def __del__(self) -> None:
        if hasattr(self, "_factors") and threading.get_ident() != self._thread:
            _log.warning("a factorisation of %d unknowns was dropped in another thread: a leak", self._factors.shape[0])


def factorised_spd(
    matrix: Any, ordering: Ordering = "MMD_AT_PLUS_A", points: FloatArray | None = None
) -> SpdFactorisation:
    """Solver of a sparse symmetric positive definite system, factorised once.

    Parameters
    ----------
    matrix : sparse (n, n), CSC
    ordering : {"MMD_AT_PLUS_A", "NATURAL"}
        Minimum degree on the symmetric pattern, or the order that the unknowns have, if it is a good one already.
    points : (n, 3) float64, optional
        Where the unknowns lie: very many of them are ordered by `nested_dissection`.
    """
    return SpdFactorisation(matrix, ordering, points)


def _factors(matrix: Any, ordering: Ordering, points: FloatArray | None) -> tuple[IndexArray | None, Any]:
    """SuperLU's factors, and the order that the unknowns were brought into before, None for that they had."""
    order = None
    if points is not None and len(points) >= MANY:
        order = nested_dissection(points, matrix)
        matrix, ordering = matrix[order][:, order].tocsc(), "NATURAL"
    elif ordering == "MMD_AT_PLUS_A" and matrix.shape[0] >= SHUFFLED:
        order = np.random.default_rng(0).permutation(matrix.shape[0])
        matrix = matrix[order][:, order].tocsc()
    # Positive definite: no pivots, so that the order chosen is kept.
    return order, splu(matrix, permc_spec=ordering, diag_pivot_thresh=0.0, options={"SymmetricMode": True})


class BlockSolver:
    """Solver of one sparse positive definite system for many columns at once: ``solve(b)``, b of shape (n, k).

    SuperLU goes through its factors once for each column; here each entry meets a row of b, all columns as one vector
    instruction: a third of the time for 24 columns, no gain for three. Holds L and D of the factorisation only.

    Parameters
    ----------
    matrix : sparse (n, n), CSC
    points : (n, 3) float64, optional
        See `factorised_spd`.
    """

    def __init__(self, matrix: Any, points: FloatArray | None = None) -> None:
        order, factors = _factors(matrix, "MMD_AT_PLUS_A", points)
        if not np.array_equal(factors.perm_r, factors.perm_c):
            raise ValueError("the matrix is not positive definite")  # a bug of the caller
        eliminated: IndexArray = np.argsort(factors.perm_c)
        self._order = eliminated if order is None else order[eliminated]
        self._place = np.argsort(self._order)
        lower = factors.L
        lower.sort_indices()  # the diagonal, ones, first in each column
        self._lower = lower.indptr, lower.indices, lower.data
        self._inverse_diagonal = 1 / factors.U.diagonal()

    def __call__(self, right: FloatArray) -> FloatArray:
        """Solution (n, k) for a right-hand side (n, k)."""
        block = right[self._order]
        _solve_block(*self._lower, self._inverse_diagonal, block)
        return block[self._place]


@njit(error_model="numpy")
def _solve_block(
    starts: npt.NDArray[np.int32],
    rows: npt.NDArray[np.int32],
    entries: FloatArray,
    inverse_diagonal: FloatArray,
    block: FloatArray,
) -> None:
    """Solve L D L^T x = block in place; the first entry of each column of L is the diagonal, which is one."""
    n, width = block.shape
    for j in range(n):
        above = block[j]
        for e in range(starts[j] + 1, starts[j + 1]):
            entry, below = entries[e], block[rows[e]]
            for c in range(width):
                below[c] -= entry * above[c]
    for j in range(n - 1, -1, -1):
        above = block[j]
        for c in range(width):
            above[c] *= inverse_diagonal[j]
        for e in range(starts[j] + 1, starts[j + 1]):
            entry, below = entries[e], block[rows[e]]
            for c in range(width):
                above[c] -= entry * below[c]
