"""Eq. (4): pairs, order and signs of eigenfunctions under a map that is known."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob

from qgeo_filters.spectral.commutative import (
    commutative_eigenspectra,
    commutator_norm,
    coupling,
    operator_on_x,
    spectral_distance,
)
from qgeo_filters.spectral.spectrum import Spectrum, spectrum_of_matrix
from qgeo_filters.surface import Surface


def euclidean_spectrum(vertices: np.ndarray, faces: np.ndarray, k: int = 12) -> Spectrum:
    """Spectrum of straight-line distances: quick, and as good as any for the algebra."""
    matrix = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    return spectrum_of_matrix(matrix, Surface(vertices, faces).vertex_areas, k)


@pytest.fixture(scope="module")
def shape() -> tuple[np.ndarray, np.ndarray]:
    return blob(2, seed=3)


@pytest.fixture(scope="module")
def spectrum(shape: tuple[np.ndarray, np.ndarray]) -> Spectrum:
    return euclidean_spectrum(*shape)


@pytest.fixture(scope="module")
def shuffled(spectrum: Spectrum) -> tuple[Spectrum, np.ndarray, np.ndarray, np.ndarray]:
    """The shape 7 times as large with other numbering, order and signs of eigenfunctions; and the map to it."""
    rng = np.random.default_rng(0)
    to_other = rng.permutation(spectrum.n_vertices)
    order, signs = rng.permutation(spectrum.k), rng.choice([-1.0, 1.0], spectrum.k)
    functions = np.empty_like(spectrum.eigenfunctions)
    functions[to_other] = spectrum.eigenfunctions[:, order] * signs / 7
    areas = np.empty_like(spectrum.areas)
    areas[to_other] = spectrum.areas * 49
    return Spectrum(spectrum.eigenvalues[order] * 7**3, functions, areas, ()), to_other, order, signs


def test_order_and_signs_are_recovered(spectrum: Spectrum, shuffled: tuple) -> None:
    other, p2p, order, signs = shuffled
    pairs = commutative_eigenspectra(spectrum, other, p2p)
    np.testing.assert_array_equal(order[pairs.index_y], pairs.index_x)
    np.testing.assert_array_equal(pairs.signs, signs[pairs.index_y])
    np.testing.assert_allclose(pairs.functions_y, pairs.functions_x, atol=1e-10)
    np.testing.assert_allclose(pairs.coupling, np.eye(spectrum.k), atol=1e-9)
    assert pairs.c_xy < 1e-9
    assert abs(pairs.residual) < 1e-12


def test_operators_of_one_shape_commute_through_the_map(spectrum: Spectrum, shuffled: tuple) -> None:
    other, p2p, *_ = shuffled
    carried = operator_on_x(spectrum, other, p2p)
    np.testing.assert_allclose(carried, np.diag(spectrum.eigenvalues) * 7**3, atol=1e-8)
    assert commutator_norm(np.diag(spectrum.eigenvalues), carried) < 1e-12
    wrong = operator_on_x(spectrum, other, np.roll(p2p, 11))
    assert commutator_norm(np.diag(spectrum.eigenvalues), wrong) > 1e-3


def test_assignment_is_no_worse_than_any_swap(shape: tuple, spectrum: Spectrum) -> None:
    vertices, faces = shape
    other = euclidean_spectrum(vertices * [1.0, 1.3, 0.8], faces)
    identity = np.arange(spectrum.n_vertices)
    pairs = commutative_eigenspectra(spectrum, other, identity)
    relative = [s.eigenvalues / np.linalg.norm(s.eigenvalues) for s in (spectrum, other)]
    products = coupling(spectrum, other, identity)
    energy = products**2 * (relative[0][:, None] ** 2 + relative[1] ** 2)
    best = energy[pairs.index_x, pairs.index_y].sum()
    for i in range(spectrum.k):
        for j in range(i):
            swapped = pairs.index_y.copy()
            swapped[[i, j]] = swapped[[j, i]]
            assert energy[pairs.index_x, swapped].sum() <= best * (1 + 1e-12)
    assert pairs.residual == pytest.approx(1 - best / energy.sum())
    assert (np.diag(pairs.coupling) >= 0).all()


def test_smaller_subset_leaves_out_what_has_no_partner(spectrum: Spectrum, shuffled: tuple) -> None:
    other, p2p, order, _ = shuffled
    # One function of Y is replaced by another shape's: its partner on X has none.
    strange = 5
    functions = other.eigenfunctions.copy()
    functions[:, strange] = np.random.default_rng(1).normal(size=len(functions)) / np.sqrt(other.areas.sum())
    broken = Spectrum(other.eigenvalues, functions, other.areas, ())
    pairs = commutative_eigenspectra(spectrum, broken, p2p, size=spectrum.k - 1)
    assert len(pairs.index_x) == spectrum.k - 1
    assert strange not in pairs.index_y
    assert order[strange] not in pairs.index_x
    assert pairs.residual < 1e-12


def test_distance_in_closed_form() -> None:
    """Two functions with disjoint support and mean square 1 are sqrt(2) apart."""
    areas = np.array([1.0, 1.0, 2.0])
    left, right = np.array([[2.0], [0], [0]]), np.array([[0.0], [2], [0]])
    assert spectral_distance(left, right, areas) == pytest.approx(2**0.5)
    assert spectral_distance(left, -right, areas, "vertices") == pytest.approx(2**0.5 / 3**0.5)
    with pytest.raises(ValueError, match="normalization"):
        spectral_distance(left, right, areas, "mean")  # type: ignore[arg-type]


@pytest.mark.parametrize("size", [0, 13, 2.5])
def test_size_out_of_range_is_refused(spectrum: Spectrum, size: object) -> None:
    with pytest.raises(ValueError, match="size must be between 1 and 12"):
        commutative_eigenspectra(spectrum, spectrum, np.arange(spectrum.n_vertices), size=size)  # type: ignore[arg-type]


def test_map_of_wrong_length_is_refused(spectrum: Spectrum) -> None:
    with pytest.raises(ValueError, match="p2p must hold a vertex of Y for each of the"):
        commutative_eigenspectra(spectrum, spectrum, np.arange(5))
