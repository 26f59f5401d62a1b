"""Spectrum of the distance operator: analytic eigenvalues, invariances, both weightings, bad input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import aslinearoperator
from scipy.spatial.distance import cdist
from scipy.special import eval_legendre
from shapes import blob, grid, icosphere

from qgeo_filters.errors import DisconnectedError, MeshError
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.metric import lifted_metric
from qgeo_filters.spectral.canonical import subspace_sine
from qgeo_filters.spectral.distance_spectrum import distance_spectrum
from qgeo_filters.spectral.spectrum import Spectrum, spectrum_of_matrix
from qgeo_filters.surface import Surface


def sphere_matrix(vertices: np.ndarray, radius: float = 1.0) -> np.ndarray:
    """Great-circle distances, by half the chord: exact for near points too."""
    return 2 * radius * np.arcsin(np.clip(cdist(vertices, vertices) / (2 * radius), 0, 1))


def sphere_eigenvalue(degree: int) -> float:
    """Funk-Hecke: 2 pi times the integral of arccos(t) P_l(t) over [-1, 1], on the unit sphere."""
    return 2 * np.pi * quad(lambda t: np.arccos(t) * eval_legendre(degree, t), -1, 1, epsabs=1e-13)[0]


def gram(spectrum: Spectrum) -> np.ndarray:
    return spectrum.eigenfunctions.T @ (spectrum.areas[:, None] * spectrum.eigenfunctions)


@pytest.fixture(scope="module")
def lopsided() -> tuple[Surface, np.ndarray]:
    surface = Surface(*blob(3, seed=2))
    return surface, distance_matrix(surface)


def test_sphere_has_the_eigenvalues_of_funk_and_hecke():
    # 2 pi^2 once, -pi^2 / 2 three times, nothing of degree 2, -pi^2 / 32 seven times.
    exact = np.repeat([sphere_eigenvalue(0), sphere_eigenvalue(1), sphere_eigenvalue(3)], [1, 3, 7])
    np.testing.assert_allclose(exact[[0, 1, 4]], np.pi**2 * np.array([2, -1 / 2, -1 / 32]), rtol=1e-10)
    assert abs(sphere_eigenvalue(2)) < 1e-10
    errors = []
    for level in (2, 3, 4):
        surface = Surface(*icosphere(level))
        spectrum = spectrum_of_matrix(sphere_matrix(surface.vertices), surface.vertex_areas, 11)
        assert spectrum.multiplets[:2] == ((0,), (1, 2, 3))
        errors.append(np.abs(spectrum.eigenvalues - exact).max())
    slope = np.polyfit(np.log([4.0, 2.0, 1.0]), np.log(errors), 1)[0]
    assert slope > 1.8
    assert errors[-1] < 0.01 * np.pi**2
    # Degree 1 are the coordinates, and degree 3 is the space of seven harmonics, not a basis of it.
    assert subspace_sine(spectrum.eigenfunctions[:, 1:4], surface.vertices, surface.vertex_areas) < 1e-3
    x, y, z = surface.vertices.T
    cubic = np.column_stack([z * (5 * z**2 - 3), x * (5 * z**2 - 1), y * (5 * z**2 - 1),
                             z * (x**2 - y**2), x * y * z, x * (x**2 - 3 * y**2), y * (3 * x**2 - y**2)])  # fmt: skip
    assert subspace_sine(spectrum.eigenfunctions[:, 4:11], cubic, surface.vertex_areas) < 5e-3


def test_circle_in_place_of_a_surface():
    # Arc lengths on n equal arcs of the unit circle are a circulant matrix: 2 pi (pi / 2) once, then for odd j
    # the integral of |t| cos(j t) over the circle, -4 / j^2, twice.
    n = 2000
    step = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    arcs = np.minimum(step, n - step) * 2 * np.pi / n
    spectrum = spectrum_of_matrix(arcs, np.full(n, 2 * np.pi / n), 9)
    exact = [np.pi**2, -4, -4, -4 / 9, -4 / 9, -4 / 25, -4 / 25, -4 / 49, -4 / 49]
    np.testing.assert_allclose(spectrum.eigenvalues, exact, rtol=1e-4)
    assert spectrum.multiplets == ((0,), (1, 2), (3, 4), (5, 6), (7, 8))


@pytest.mark.parametrize("weights", ["area", "uniform"])
def test_eigenpairs_of_the_weighted_matrix(lopsided, weights):
    surface, matrix = lopsided
    spectrum = spectrum_of_matrix(matrix, surface.vertex_areas, 12, weights)
    if weights == "uniform":
        assert (spectrum.areas == 1).all()
    np.testing.assert_allclose(gram(spectrum), np.eye(12), atol=1e-12)
    image = matrix.astype(float) @ (spectrum.areas[:, None] * spectrum.eigenfunctions)
    residual = image - spectrum.eigenfunctions * spectrum.eigenvalues
    norm = np.sqrt(spectrum.areas @ residual**2)
    assert norm.max() < 2e-6 * abs(spectrum.eigenvalues[0])
    root = np.sqrt(spectrum.areas)
    dense = np.linalg.eigvalsh(root[:, None] * matrix.astype(float) * root)
    expected = dense[np.argsort(-np.abs(dense))][:12]
    np.testing.assert_allclose(spectrum.eigenvalues, expected, rtol=1e-4)
    assert (np.diff(np.abs(spectrum.eigenvalues)) <= 0).all()


def test_two_triangulations_of_one_surface_agree():
    vertices = icosphere(4)[0]
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]

    def egg(points: np.ndarray) -> np.ndarray:
        return points * (1 + 0.25 * points[:, :1] + 0.1 * points[:, 1:2] * points[:, 2:3]) * [1.5, 1, 0.8]

    def spectrum(sphere: np.ndarray, level: int) -> tuple[Surface, Spectrum]:
        surface = Surface(egg(sphere), icosphere(level)[1])
        return surface, spectrum_of_matrix(distance_matrix(surface), surface.vertex_areas, 8)

    fine, a = spectrum(vertices, 4)
    squeezed = vertices @ turn * [1, 1, 1.6]  # another, uneven triangulation of the sphere
    other, b = spectrum(squeezed / np.linalg.norm(squeezed, axis=1, keepdims=True), 4)
    np.testing.assert_allclose(a.eigenvalues, b.eigenvalues, rtol=0.02)
    nearest = cdist(fine.vertices, other.vertices).argmin(axis=1)
    overlap = np.einsum("ij,i,ij->j", a.eigenfunctions, a.areas, b.eigenfunctions[nearest])
    simple = [group[0] for group in a.multiplets if len(group) == 1]
    assert len(simple) >= 4
    # Same functions with the same signs, to what the nearest vertex allows.
    assert overlap[simple].min() > 0.99


@given(seed=st.integers(0, 10**6))
@settings(max_examples=5)
def test_numbering_changes_nothing(lopsided, seed):
    surface, matrix = lopsided
    order = np.random.default_rng(seed).permutation(surface.n_vertices)
    before = spectrum_of_matrix(matrix, surface.vertex_areas, 10)
    after = spectrum_of_matrix(matrix[np.ix_(order, order)], surface.vertex_areas[order], 10)
    np.testing.assert_allclose(after.eigenvalues, before.eigenvalues, rtol=1e-5)
    assert after.multiplets == before.multiplets
    for group in before.multiplets:
        columns = list(group)
        x, y = before.eigenfunctions[order][:, columns], after.eigenfunctions[:, columns]
        if len(columns) == 1:
            assert (x.T @ (after.areas[:, None] * y)).item() > 1 - 1e-6
        elif columns[-1] < 9:
            assert subspace_sine(x, y, after.areas) < 1e-3


@pytest.mark.parametrize("factor", [1e-9, 0.5, 1e9])
def test_eigenvalues_scale_as_length_cubed(lopsided, factor):
    surface, matrix = lopsided
    before = spectrum_of_matrix(matrix, surface.vertex_areas, 10)
    after = spectrum_of_matrix(matrix * np.float32(factor), surface.vertex_areas * factor**2, 10)
    np.testing.assert_allclose(after.eigenvalues, before.eigenvalues * factor**3, rtol=1e-5)
    singles = [group[0] for group in before.multiplets if len(group) == 1]
    scaled = after.eigenfunctions * factor
    np.testing.assert_allclose(scaled[:, singles], before.eigenfunctions[:, singles], atol=1e-3)


def test_same_input_same_bits(lopsided):
    surface, matrix = lopsided
    a, b = (spectrum_of_matrix(matrix, surface.vertex_areas, 10) for _ in range(2))
    np.testing.assert_array_equal(a.eigenvalues, b.eigenvalues)
    np.testing.assert_array_equal(a.eigenfunctions, b.eigenfunctions)


def test_kinds_of_matrix_agree(lopsided, tmp_path):
    surface, matrix = lopsided
    zarr = pytest.importorskip("zarr")
    stored = zarr.create_array(tmp_path / "d.zarr", shape=matrix.shape, chunks=(100, len(matrix)), dtype="float32")
    stored[:] = matrix
    expected = spectrum_of_matrix(matrix, surface.vertex_areas, 6)
    double = matrix.astype(np.float64)
    double.setflags(write=False)
    for kind in (double, double.tolist(), aslinearoperator(double), csr_matrix(double), stored):
        got = spectrum_of_matrix(kind, surface.vertex_areas, 6)
        np.testing.assert_allclose(got.eigenvalues, expected.eigenvalues, rtol=1e-5)


def test_distance_spectrum_is_that_of_the_lifted_matrix(lopsided):
    surface, _ = lopsided
    spectrum = distance_spectrum(surface, 8)
    metric = lifted_metric(surface)
    matrix = distance_matrix(surface, metric)
    for other in (spectrum_of_matrix(matrix, surface.vertex_areas, 8), distance_spectrum(surface, 8, matrix=matrix),
                  distance_spectrum(surface, 8, metric)):  # fmt: skip
        np.testing.assert_array_equal(spectrum.eigenvalues, other.eigenvalues)
    uniform = distance_spectrum(surface, 8, metric, "uniform")
    assert uniform.eigenvalues[0] == pytest.approx(np.linalg.eigvalsh(matrix.astype(float))[-1], rel=1e-5)


def test_first_eigenfunction_is_positive_like_a_perron_vector(lopsided):
    surface, matrix = lopsided
    spectrum = spectrum_of_matrix(matrix, surface.vertex_areas, 3)
    assert spectrum.eigenvalues[0] > 0 > spectrum.eigenvalues[1]
    assert spectrum.eigenfunctions[:, 0].min() > 0


@pytest.mark.parametrize("k", [1, 40, 41, 42])
def test_small_surfaces_and_all_eigenpairs(k):
    surface = Surface(*icosphere(1))
    matrix = sphere_matrix(surface.vertices)
    spectrum = spectrum_of_matrix(matrix, surface.vertex_areas, k)
    assert spectrum.k == k
    np.testing.assert_allclose(gram(spectrum), np.eye(k), atol=1e-12)
    if k == surface.n_vertices:
        rebuilt = (spectrum.eigenfunctions * spectrum.eigenvalues) @ spectrum.eigenfunctions.T
        np.testing.assert_allclose(rebuilt, matrix, atol=1e-10)


def test_truncation():
    surface = Surface(*icosphere(2))
    spectrum = spectrum_of_matrix(sphere_matrix(surface.vertices), surface.vertex_areas, 11)
    short = spectrum.truncated(3)
    assert short.k == 3
    assert short.multiplets == ((0,), (1, 2))
    np.testing.assert_array_equal(short.eigenfunctions, spectrum.eigenfunctions[:, :3])
    assert not short.eigenfunctions.flags.writeable
    with pytest.raises(ValueError, match="between 1 and the 11 eigenpairs"):
        spectrum.truncated(12)


def test_bad_requests():
    surface = Surface(*grid(6))
    matrix, areas = cdist(surface.vertices, surface.vertices), surface.vertex_areas
    for k in (0, 50, 2.5):
        with pytest.raises(ValueError, match="between 1 and the number of vertices, 49"):
            spectrum_of_matrix(matrix, areas, k)
    with pytest.raises(ValueError, match=r"expected \(n, n\) and \(n,\)"):
        spectrum_of_matrix(matrix[:, :-1], areas, 3)
    with pytest.raises(ValueError, match="'area' or 'uniform', got 'mass'"):
        spectrum_of_matrix(matrix, areas, 3, "mass")
    with pytest.raises(ValueError, match="not symmetric"):
        spectrum_of_matrix(np.triu(matrix), areas, 3)
    with pytest.raises(ValueError, match="not finite"):
        spectrum_of_matrix(np.where(np.arange(49) == 5, np.inf, matrix), areas, 3)
    with pytest.raises(MeshError, match="a vertex without area, and there are 1: 7"):
        spectrum_of_matrix(matrix, np.where(np.arange(49) == 7, 0, areas), 3)
    with pytest.raises(ValueError, match="pass one or the other"):
        distance_spectrum(surface, 3, landmarks=20, matrix=matrix)


def test_pieces_and_loose_vertices_are_refused():
    vertices, faces = grid(4)
    loose = Surface(np.vstack([vertices, [[5.0, 5, 5]]]), faces)
    apart = Surface(np.vstack([vertices, vertices + 3]), np.vstack([faces, faces + len(vertices)]))
    for surface in (loose, apart):
        with pytest.raises(DisconnectedError, match="2 pieces"):
            distance_spectrum(surface, 3, repair=False)
    assert np.isnan(distance_spectrum(loose, 3).eigenfunctions[-1]).all()
    with pytest.raises(DisconnectedError, match="one piece is needed, and there are 2 pieces, of 32, 32 faces"):
        distance_spectrum(apart, 3)
