"""Factorisations of sparse symmetric positive definite matrices, and the rule of their threads.

SciPy has no sparse Cholesky; SuperLU without pivoting in its symmetric mode comes near. It keeps account of its memory
by thread: what is factorised in one thread and dropped in another is never freed. So factorise and drop in the same
thread; to solve in others meanwhile is safe.
"""

from __future__ import annotations

import logging
import threading
from typing import Any, Literal, NoReturn

from scipy.sparse.linalg import splu

from qgeo_filters._typing import FloatArray

_log = logging.getLogger(__name__)


class SpdFactorisation:
    """Solver of one system: ``solve(b)`` is x with A x = b, for b of shape (n,) or (n, k); see `factorised_spd`.

    Dropped in another thread than the one it was made in, its memory is lost; that is logged as a warning.
    """

    def __init__(self, matrix: Any, ordering: Literal["MMD_AT_PLUS_A", "NATURAL"]) -> None:
        self._thread = threading.get_ident()
        # Positive definite: no pivots, so that the order chosen is kept.
        options = {"SymmetricMode": True}
        self._factors = splu(matrix, permc_spec=ordering, diag_pivot_thresh=0.0, options=options)

    def __call__(self, right: FloatArray) -> FloatArray:
        return self._factors.solve(right)

    def __reduce__(self) -> NoReturn:
        raise TypeError("a factorisation cannot be pickled; factorise again where it is needed")

    def __del__(self) -> None:
        if hasattr(self, "_factors") and threading.get_ident() != self._thread:
            _log.warning("a factorisation of %d unknowns was dropped in another thread: a leak", self._factors.shape[0])


def factorised_spd(matrix: Any, ordering: Literal["MMD_AT_PLUS_A", "NATURAL"] = "MMD_AT_PLUS_A") -> SpdFactorisation:
    """Solver of a sparse symmetric positive definite system, factorised once.

    Parameters
    ----------
    matrix : sparse (n, n), CSC
    ordering : {"MMD_AT_PLUS_A", "NATURAL"}
        Minimum degree on the symmetric pattern, or the order that the unknowns have, if it is a good one already.
    """
    return SpdFactorisation(matrix, ordering)
