"""Distances of shapes by their eigenvalues alone."""

from __future__ import annotations

import numpy as np
import pytest

from qgeo_filters.collection.measures import spectral_distances


def by_size(values: np.ndarray) -> np.ndarray:
    """As spectra of distances are ordered."""
    return values[np.argsort(-np.abs(values), kind="stable")]


def test_eigenvalues_of_opposite_signs_may_change_places() -> None:
    """The 17th and 18th of a rough metric do so under any change; the distance is that of equals paired by hand."""
    one, other = np.array([10.0, -4.0, 2.0, -1.99]), np.array([10.0, -4.0, -2.0, 1.99])
    found = spectral_distances("eigenvalues", [one, other])
    size = np.linalg.norm(one)
    assert found[0, 1] == pytest.approx(np.sqrt(2) * 0.01 / size, rel=1e-12)
    assert found[1, 0] == found[0, 1]
    assert np.all(np.diag(found) == 0)


def test_no_farther_than_the_operators() -> None:
    """Hoffman and Wielandt: eigenvalues differ by at most what the symmetric matrices of unit norm do."""
    random = np.random.default_rng(0)
    for _ in range(200):
        n = int(random.integers(2, 20))
        matrices = []
        for scale in (0, 0.1):
            change = random.normal(size=(n, n))
            base = matrices[0] if scale else random.normal(size=(n, n))
            matrix = base + scale / n * (change + change.T) if scale else base + base.T
            matrices.append(matrix / np.linalg.norm(matrix))
        values = [by_size(np.linalg.eigvalsh(matrix)) for matrix in matrices]
        found = spectral_distances("eigenvalues", values)[0, 1]
        assert found <= np.linalg.norm(matrices[0] - matrices[1]) * (1 + 1e-9)


def test_a_shape_without_eigenvalues_is_nowhere() -> None:
    values = np.array([3.0, -1.0])
    found = spectral_distances("eigenvalues", [values, np.zeros(0), values])
    assert np.isnan(found[1]).all()
    assert np.isnan(found[:, 1]).all()
    assert found[0, 2] == 0


def test_shape_dna_weighs_by_number() -> None:
    """All eigenvalues but the zero, each over its number."""
    found = spectral_distances("shape_dna", [np.array([0.0, 5.0, 8.0]), np.array([0.0, 5.0, 14.0])])
    assert found[0, 1] == pytest.approx(3.0, rel=1e-12)
