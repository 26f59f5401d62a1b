"""Multiplicities that Lanczos from one vector passes over, and those that a block does."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator, aslinearoperator

from qgeo_filters.spectral.block_lanczos import block_eigenpairs
from qgeo_filters.spectral.deflated_lanczos import largest_eigenpairs

both = pytest.mark.parametrize("solver", [largest_eigenpairs, block_eigenpairs], ids=["single", "block"])


@both
@pytest.mark.parametrize("copies", [1, 2, 5, 12, 20])
def test_every_copy_of_an_eigenvalue_is_found(solver, copies):
    n, k = 400, 24
    values = np.repeat([9.0, -7, 5, -4, 3, 2.5, -2, 1.5] + [1.0 / (j + 1) for j in range(400)], copies)[:n]
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(n, n)))[0]
    found, vectors = solver(aslinearoperator((turn * values) @ turn.T), k)
    expected = values[np.lexsort((-values, -np.abs(values)))][:k]
    np.testing.assert_allclose(found, expected, atol=1e-5)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(k), atol=1e-12)
    residual = (turn * values) @ (turn.T @ vectors) - vectors * found
    assert np.abs(residual).max() < 1e-4


@both
def test_rank_below_k(solver):
    n = 200
    x = np.random.default_rng(0).normal(size=(n, 3))
    basis = np.linalg.qr(x)[0]
    low = basis @ np.diag([3.0, -2, 1]) @ basis.T
    values, vectors = solver(aslinearoperator(low), 6)
    np.testing.assert_allclose(values, [3, -2, 1, 0, 0, 0], atol=1e-10)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(6), atol=1e-10)


@both
def test_only_products_are_taken(solver):
    diagonal = np.linspace(1, 2, 100)
    operator = LinearOperator((100, 100), matvec=lambda x: diagonal * x.ravel(), dtype=np.float64)
    np.testing.assert_allclose(solver(operator, 3)[0], diagonal[:-4:-1], rtol=1e-6)


def test_a_block_reads_the_matrix_once_for_many_products():
    """Residuals meet the tolerance, with a product of the whole block for each reading."""
    n, k = 600, 40
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(n, n)))[0]
    spectrum = (-1.0) ** np.arange(n) * np.arange(1, n + 1) ** -1.5
    matrix = (turn * spectrum) @ turn.T
    readings = []

    def product(x):
        readings.append(x.shape[1])
        return matrix @ x

    operator = LinearOperator((n, n), matvec=lambda x: matrix @ x, matmat=product, dtype=np.float64)
    values, vectors = block_eigenpairs(operator, k, 1e-4)
    assert len(readings) < k / 2
    np.testing.assert_allclose(values, spectrum[:k], rtol=1e-7)
    residual = np.linalg.norm(matrix @ vectors - vectors * values, axis=0)
    assert (residual <= 2e-4 * np.abs(values)).all()
    # Those before the last are better by far.
    assert (residual[: k // 4] <= 1e-8).all()
