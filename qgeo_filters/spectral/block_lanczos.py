"""Extreme eigenpairs of a symmetric operator that is cheapest applied to several vectors at once."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import LinearOperator

from qgeo_filters._typing import FloatArray

# Vectors in a block: a dense matrix is read once for each, and rarely repeats an eigenvalue as often.
_WIDTH = 16
# Two eigenvalues this close, as a fraction of the larger, may be one that is repeated.
_REPEATED = 1e-4
# A residual or new direction this small, as a fraction of the largest eigenvalue, is rounding.
_ROUNDING = 1e-12


def block_eigenpairs(operator: LinearOperator, k: int, tolerance: float = 1e-6) -> tuple[FloatArray, FloatArray]:
    """The k eigenvalues of largest absolute value, by decreasing size, and orthonormal eigenvectors (n, k).

    Block Lanczos with full orthogonalisation: as many products as `largest_eigenpairs` takes, but sixteen at a time,
    which for a matrix in memory takes half the time, and for one on disk a fraction. The first eigenpairs converge
    long before the last, to which the tolerance is applied.

    Parameters
    ----------
    operator : LinearOperator, shape (n, n)
        Symmetric, float64.
    k : int
        From 1 to n.
    tolerance : float
        Norm of the residual, as a fraction of the eigenvalue; products in float32 leave about 1e-7 of the largest
        eigenvalue besides.

    References
    ----------
    Golub and Underwood, "The block Lanczos method for computing eigenvalues", Mathematical Software III, 1977.
    """
    width = min(_WIDTH, operator.shape[0])
    while True:
        values, vectors = _converged(operator, k, width, tolerance)
        if width >= k:
            return values, vectors
        # A block sees as many copies of an eigenvalue as it is wide; there may then be more.
        size = np.abs(values)
        if not (size[: 1 - width] - size[width - 1 :] <= _REPEATED * size[: 1 - width]).any():
            return values, vectors
        width *= 2


def _converged(operator: LinearOperator, k: int, width: int, tolerance: float) -> tuple[FloatArray, FloatArray]:
    n = operator.shape[0]
    random = np.random.default_rng(0)
    # A generic start: one that shares a symmetry of the surface would never leave it.
    block = np.linalg.qr(random.standard_normal((n, width)))[0]
    basis = np.zeros((n, 0))
    projected = np.zeros((0, 0))
    while True:
        before = basis.shape[1]
        basis = np.column_stack([basis, block])
        size = basis.shape[1]
        image = operator.matmat(block)
        coupling = basis.T @ image
        projected = np.pad(projected, (0, size - before))
        projected[:, before:] = coupling
        projected[before:] = coupling.T
        block, beyond = np.linalg.qr(image - basis @ coupling)
        # Few are wanted of many: the last are never there sooner.
        if size == n or size >= 2 * k:
            values, turn = eigh(projected)
            largest = np.lexsort((-values, -np.abs(values)))[:k]
            residual = np.linalg.norm(beyond @ turn[before:, largest], axis=0)
            scale = np.abs(values[largest])
            if size == n or (residual <= tolerance * scale + _ROUNDING * scale[0]).all():
                return values[largest], basis @ turn[:, largest]
        # Where the image adds nothing (an invariant subspace), anything orthogonal may be next.
        lost = np.abs(np.diag(beyond)) <= _ROUNDING * np.abs(projected).max()
        block[:, lost] = random.standard_normal((n, int(lost.sum())))
        block = np.linalg.qr(block - basis @ (basis.T @ block))[0][:, : n - size]
