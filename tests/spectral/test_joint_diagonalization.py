"""Commutators and Jacobi angles against matrices with known answers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from qgeo_filters.spectral.joint_diagonalization import commutator_norm, joint_diagonalizer


def orthogonal(k: int, seed: int) -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(k, k)))[0]


def symmetric(k: int, seed: int) -> np.ndarray:
    matrix = np.random.default_rng(seed).normal(size=(k, k))
    return matrix + matrix.T


def off_diagonal(matrices: list[np.ndarray], basis: np.ndarray) -> float:
    turned = [basis.T @ matrix @ basis for matrix in matrices]
    return sum(float((matrix**2).sum() - (np.diag(matrix) ** 2).sum()) for matrix in turned)


@given(k=st.integers(1, 8), seed=st.integers(0, 1000))
def test_commuting_matrices_are_diagonalised_exactly(k: int, seed: int) -> None:
    basis = orthogonal(k, seed)
    values = np.random.default_rng(seed + 1).normal(size=(3, k))
    matrices = [basis @ np.diag(row) @ basis.T for row in values]
    joint = joint_diagonalizer(matrices)
    assert joint.residual < 1e-16
    np.testing.assert_allclose(joint.basis.T @ joint.basis, np.eye(k), atol=1e-12)
    for matrix, diagonal in zip(matrices, joint.diagonals, strict=True):
        np.testing.assert_allclose(joint.basis * diagonal @ joint.basis.T, matrix, atol=1e-9)
        np.testing.assert_allclose(np.sort(diagonal), np.linalg.eigvalsh(matrix), atol=1e-9)


def test_one_matrix_gives_its_eigenbasis() -> None:
    matrix = symmetric(12, 0)
    joint = joint_diagonalizer([matrix])
    values = np.linalg.eigvalsh(matrix)
    np.testing.assert_allclose(joint.diagonals[0], values[np.argsort(-np.abs(values))], atol=1e-10)


def test_residual_is_a_minimum_over_small_rotations() -> None:
    matrices = [symmetric(6, 1), symmetric(6, 2)]
    joint = joint_diagonalizer(matrices)
    best = off_diagonal(matrices, joint.basis)
    total = sum(float((matrix**2).sum()) for matrix in matrices)
    assert joint.residual == pytest.approx(best / total)
    assert best <= min(off_diagonal(matrices, np.eye(6)), off_diagonal(matrices, np.linalg.eigh(matrices[0])[1]))
    for p in range(5):
        for q in range(p + 1, 6):
            for angle in (-1e-3, 1e-3):
                turn = np.eye(6)
                turn[[p, p, q, q], [p, q, p, q]] = np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)
                assert off_diagonal(matrices, joint.basis @ turn) >= best


def test_commutator_of_pauli_like_matrices() -> None:
    a, b = np.array([[0.0, 1], [1, 0]]), np.diag([1.0, -1.0])
    # AB - BA = [[0, -2], [2, 0]]
    assert commutator_norm(a, b, relative=False) == pytest.approx(8**0.5)
    assert commutator_norm(a, b) == pytest.approx(8**0.5 / 4)
    assert commutator_norm(a, 3 * a) == 0
    assert commutator_norm(a, np.zeros((2, 2))) == 0


@pytest.mark.parametrize(
    ("matrices", "message"),
    [
        (np.ones((2, 3)), "stack of square"),
        (np.ones((2, 3, 2)), "stack of square"),
        ([[[0.0, 1], [0, 0]]], "matrix 0 is not symmetric"),
        ([[[np.nan]]], "not finite"),
    ],
)
def test_bad_matrices_are_refused(matrices: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        joint_diagonalizer(matrices)


def test_too_few_sweeps_are_told() -> None:
    with pytest.raises(ValueError, match="no convergence in 1 sweeps"):
        joint_diagonalizer([symmetric(6, 1), symmetric(6, 2)], max_sweeps=1)


def test_commutator_refuses_unlike_shapes() -> None:
    with pytest.raises(ValueError, match="of one shape"):
        commutator_norm(np.eye(2), np.eye(3))
