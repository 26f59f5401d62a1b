"""Extreme eigenpairs of a symmetric operator, with their multiplicities."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh
from scipy.sparse.linalg import LinearOperator, eigsh

from qgeo_filters._typing import FloatArray

# Relative accuracy of the eigenvalues asked of ARPACK: what float32 distances can carry.
_TOLERANCE = 1e-6
# Vectors in the basis beyond the wanted ones.
_SPARE = 100
# Accuracy of the probe for eigenvalues that were passed over, and by how much one of them must be larger.
_PROBE, _LARGER = 1e-2, 1e-4


def largest_eigenpairs(operator: LinearOperator, k: int) -> tuple[FloatArray, FloatArray]:
    """The k eigenvalues of largest absolute value, by decreasing size, and orthonormal eigenvectors (n, k).

    Lanczos from a single vector sees one copy of an eigenvalue that a symmetric mesh repeats exactly, and may converge
    before rounding brings in the others. The operator is therefore deflated by what was found and probed
    again, until nothing larger than the k-th is left.

    Parameters
    ----------
    operator : LinearOperator, shape (n, n)
        Symmetric, float64.
    k : int
        From 1 to n.
    """
    n = operator.shape[0]
    if 3 * k >= n or n <= 64:
        values, vectors = eigh(_symmetrised(operator.matmat(np.eye(n))))
        return _leading(values, vectors, k)
    values, vectors = _lanczos(operator, k)
    while 2 * vectors.shape[1] < n:
        deflated = _deflated(operator, values, vectors)
        if abs(_lanczos(deflated, 1, _PROBE)[0][0]) <= np.sort(np.abs(values))[-k] * (1 + _LARGER):
            break
        values, vectors = _rayleigh_ritz(operator, np.column_stack([vectors, _lanczos(deflated, k)[1]]))
    return _leading(values, vectors, k)


def _lanczos(operator: LinearOperator, k: int, tolerance: float = _TOLERANCE) -> tuple[FloatArray, FloatArray]:
    n = operator.shape[0]
    # A generic start: one that shares a symmetry of the surface would never leave it.
    start = np.random.default_rng(0).standard_normal(n)
    # Many pairs need no basis of twice as many vectors, which all have to be kept orthogonal.
    width = min(n, max(min(2 * k + 1, k + _SPARE), 20))
    values, vectors = eigsh(operator, k=k, which="LM", v0=start, tol=tolerance, ncv=width)
    # ARPACK's vectors are orthonormal to its tolerance only where the products are in float32.
    basis, triangle = np.linalg.qr(vectors)
    return values, basis * np.where(np.diag(triangle) < 0, -1.0, 1.0)


def _deflated(operator: LinearOperator, values: FloatArray, vectors: FloatArray) -> LinearOperator:
    def product(x: FloatArray) -> FloatArray:
        columns = x.reshape(len(vectors), -1)
        rest = operator.matmat(columns) - vectors @ (values[:, None] * (vectors.T @ columns))
        return rest.reshape(x.shape)

    return LinearOperator(operator.shape, matvec=product, matmat=product, dtype=np.float64)


def _rayleigh_ritz(operator: LinearOperator, vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eigenpairs within the span of the vectors, orthonormal to rounding."""
    basis = np.linalg.qr(vectors)[0]
    values, turn = eigh(_symmetrised(basis.T @ operator.matmat(basis)))
    return values, basis @ turn


def _leading(values: FloatArray, vectors: FloatArray, k: int) -> tuple[FloatArray, FloatArray]:
    order = np.lexsort((-values, -np.abs(values)))[:k]
    return values[order], vectors[:, order]


def _symmetrised(matrix: FloatArray) -> FloatArray:
    return (matrix + matrix.T) / 2
