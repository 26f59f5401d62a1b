"""Multiplicities that Lanczos from one vector passes over."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator, aslinearoperator

from qgeo_filters.spectral.eigensolver import largest_eigenpairs


@pytest.mark.parametrize("copies", [1, 2, 5, 12])
def test_every_copy_of_an_eigenvalue_is_found(copies):
    n, k = 400, 24
    values = np.repeat([9.0, -7, 5, -4, 3, 2.5, -2, 1.5] + [1.0 / (j + 1) for j in range(400)], copies)[:n]
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(n, n)))[0]
    found, vectors = largest_eigenpairs(aslinearoperator((turn * values) @ turn.T), k)
    expected = values[np.lexsort((-values, -np.abs(values)))][:k]
    np.testing.assert_allclose(found, expected, atol=1e-5)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(k), atol=1e-12)
    residual = (turn * values) @ (turn.T @ vectors) - vectors * found
    assert np.abs(residual).max() < 1e-4


def test_rank_below_k():
    n = 200
    x = np.random.default_rng(0).normal(size=(n, 3))
    basis = np.linalg.qr(x)[0]
    low = basis @ np.diag([3.0, -2, 1]) @ basis.T
    values, vectors = largest_eigenpairs(aslinearoperator(low), 6)
    np.testing.assert_allclose(values, [3, -2, 1, 0, 0, 0], atol=1e-10)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(6), atol=1e-10)


def test_only_products_are_taken():
    diagonal = np.linspace(1, 2, 100)
    operator = LinearOperator((100, 100), matvec=lambda x: diagonal * x.ravel(), dtype=np.float64)
    np.testing.assert_allclose(largest_eigenpairs(operator, 3)[0], diagonal[:-4:-1], rtol=1e-6)
