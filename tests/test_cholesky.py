"""Factorisations of positive definite matrices: right, as they were, and dropped where they were made."""

from __future__ import annotations

import gc
import logging
import pickle
import threading

import igl
import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu
from shapes import blob

from qgeo_filters import cholesky
from qgeo_filters.cholesky import BlockSolver, factorised_spd
from qgeo_filters.nested_dissection import nested_dissection


@pytest.fixture(scope="module")
def system() -> sparse.csc_matrix:
    vertices, faces = blob(2)
    stiffness = -igl.cotmatrix(vertices, faces.astype(np.int64))
    return sparse.csc_matrix(stiffness + 0.1 * sparse.eye_array(len(vertices)))


@pytest.mark.parametrize("ordering", ["MMD_AT_PLUS_A", "NATURAL"])
@pytest.mark.parametrize("columns", [(), (3,)])
def test_solutions_are_those_of_superlu_bit_for_bit(system, ordering, columns) -> None:
    right = np.random.default_rng(0).normal(size=(system.shape[0], *columns))
    solve = factorised_spd(system, ordering)
    same = splu(system, permc_spec=ordering, diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve(right)
    np.testing.assert_array_equal(solve(right), same)
    np.testing.assert_allclose(system @ solve(right), right, atol=1e-10)


def test_dropped_in_another_thread_it_says_so(system, caplog: pytest.LogCaptureFixture) -> None:
    def drop(held: list) -> None:
        held.clear()
        gc.collect()

    with caplog.at_level(logging.WARNING, "qgeo_filters"):
        drop([factorised_spd(system)])
        assert not caplog.records
        thread = threading.Thread(target=drop, args=([factorised_spd(system)],))
        thread.start()
        thread.join()
    assert "162 unknowns was dropped in another thread" in caplog.text


def test_it_cannot_be_pickled(system) -> None:
    with pytest.raises(TypeError, match="factorise again"):
        pickle.dumps(factorised_spd(system))


@pytest.mark.parametrize("columns", [1, 3, 24])
def test_a_block_is_solved_as_its_columns_are(system, columns) -> None:
    right = np.random.default_rng(0).normal(size=(system.shape[0], columns))
    given = right.copy()
    found = BlockSolver(system)(right)
    np.testing.assert_allclose(found, factorised_spd(system)(right), rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(right, given)


def test_a_block_solver_may_be_dropped_in_another_thread(system, caplog: pytest.LogCaptureFixture) -> None:
    held = [BlockSolver(system)]
    thread = threading.Thread(target=held.clear)
    thread.start()
    thread.join()
    gc.collect()
    assert not held
    assert not caplog.records


def laplacian_of(vertices: np.ndarray, faces: np.ndarray) -> sparse.csc_matrix:
    return sparse.csc_matrix(-igl.cotmatrix(vertices, faces.astype(np.int64)) + 0.1 * sparse.eye_array(len(vertices)))


@pytest.mark.parametrize("solver", [factorised_spd, BlockSolver])
def test_very_many_unknowns_are_ordered_by_where_they_are(solver, monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces = blob(3)
    matrix, right = laplacian_of(vertices, faces), np.random.default_rng(0).normal(size=(len(vertices), 3))
    monkeypatch.setattr(cholesky, "MANY", len(vertices))
    found = solver(matrix, points=vertices)(right)
    np.testing.assert_allclose(matrix @ found, right, atol=1e-10)


def test_nested_dissection_fills_little_and_leaves_none_out() -> None:
    """No more than 5 n log n entries, the bound of planar graphs but for the constant."""
    vertices, faces = blob(5)
    n, matrix = len(vertices), laplacian_of(vertices, faces)
    order = nested_dissection(vertices, matrix)
    np.testing.assert_array_equal(np.sort(order), np.arange(n))
    permuted = matrix[order][:, order].tocsc()
    factors = splu(permuted, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    assert factors.L.nnz < 5 * n * np.log2(n)


def test_the_order_separates_halves(system) -> None:
    """The last unknowns, the first separator, leave no way between what lies on either side of it."""
    vertices, faces = blob(3)
    matrix = laplacian_of(vertices, faces)
    order = nested_dissection(vertices, matrix)
    for separator in range(1, 120):
        rest = np.sort(order[: len(order) - separator])
        pieces, labels = connected_components(matrix[rest][:, rest], directed=False)
        if pieces > 1:
            assert np.bincount(labels).max() < 0.6 * len(vertices)
            return
    raise AssertionError("a hundred unknowns do not separate the surface")


def test_few_unknowns_and_none_have_an_order_too() -> None:
    for n in (0, 1, 30):
        found = nested_dissection(np.zeros((n, 3)), sparse.eye_array(n).tocsr())
        np.testing.assert_array_equal(np.sort(found), np.arange(n))
