"""Eq. (3): the bound over all pairs, mirror images of known symmetries, regions, and what the printed sum does."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree
from shapes import blob, icosphere

from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.matching.symmetry_measure import epsilon_bound, symmetry_epsilon, symmetry_regions, symmetry_sum
from qgeo_filters.spectral.spectrum import Spectrum, spectrum_of_matrix
from qgeo_filters.surface import Surface

READINGS = ("absolute", "even", "printed")


def bilateral() -> tuple[Surface, np.ndarray]:
    """A closed surface with exactly one symmetry, x -> -x, and the mirror image of each vertex."""
    sphere, faces = icosphere(3)
    x, y, z = sphere.T
    radius = 1 + 0.3 * z**3 + 0.25 * y * z + 0.35 * np.abs(x) * y + 0.2 * y**2
    surface = Surface(sphere * radius[:, None] * [1.3, 1, 1.6], faces)
    return surface, cKDTree(sphere).query(sphere * [-1, 1, 1])[1]


@pytest.fixture(scope="module")
def mirrored() -> tuple[Surface, np.ndarray, np.ndarray, Spectrum]:
    surface, image = bilateral()
    np.testing.assert_allclose(surface.vertices[image], surface.vertices * [-1, 1, 1], atol=1e-12)
    matrix = distance_matrix(surface)
    return surface, image, matrix, spectrum_of_matrix(matrix, surface.vertex_areas, 20)


@pytest.mark.parametrize("weights", ["area", "uniform"])
@pytest.mark.parametrize("k0", [1, 5, 20])
def test_bound_holds_for_all_pairs(mirrored, weights, k0):
    surface, _, matrix, _ = mirrored
    spectrum = spectrum_of_matrix(matrix, surface.vertex_areas, 20, weights)
    p, q = np.triu_indices(surface.n_vertices, 1)
    bound = epsilon_bound(spectrum, matrix, p, q, k0)
    for reading in READINGS:
        s = symmetry_sum(spectrum, k0, reading)
        # Eigenfunctions of float32 distances satisfy their equation to 1e-6.
        assert (np.abs(s[p] - s[q]) <= bound * (1 + 1e-3) + 1e-4).all()
    if k0 == 1:  # one function and no cancellation: the bound is within sight
        assert np.max(np.abs(s[p] - s[q]) / bound) > 0.2


@pytest.mark.parametrize("name", ["cat0", "wolf0"])
def test_bound_holds_on_real_meshes(data_dir, name):
    path = data_dir / "tosca" / "remeshed" / f"{name}.off"
    counts = np.array(path.read_text().split()[1:3], dtype=int)
    numbers = np.array(path.read_text().split()[4:], dtype=float)
    vertices = numbers[: 3 * counts[0]].reshape(-1, 3)
    surface = Surface(vertices, numbers[3 * counts[0] :].reshape(-1, 4)[:, 1:].astype(int))
    matrix = distance_matrix(surface)
    spectrum = spectrum_of_matrix(matrix, surface.vertex_areas, 20)
    p, q = np.random.default_rng(0).integers(0, surface.n_vertices, (2, 20000))
    a, b = surface.edges.T  # neighbours, where the bound is small
    p, q = np.concatenate([p, a]), np.concatenate([q, b])
    bound = epsilon_bound(spectrum, matrix, p, q)
    for reading in READINGS:
        s = symmetry_sum(spectrum, reading=reading)
        assert (np.abs(s[p] - s[q]) <= bound * (1 + 1e-3) + 1e-3).all()


def test_mirror_images_have_one_sum_except_as_printed(mirrored):
    _, image, _, spectrum = mirrored
    parity = np.einsum("ij,i,ij->j", spectrum.eigenfunctions, spectrum.areas, spectrum.eigenfunctions[image])
    assert (np.abs(parity) > 0.99).all()
    assert (parity < 0).sum() >= 5  # there are antisymmetric functions to break the printed sum
    ratio = {r: symmetry_epsilon(spectrum, image, reading=r) / symmetry_epsilon(spectrum, reading=r) for r in READINGS}
    assert ratio["absolute"] < 0.01
    assert ratio["printed"] > 0.3
    # No antisymmetric function has a third moment, so that the even sum never holds one.
    assert ratio["even"] < 0.01


def test_shape_without_symmetry_has_no_small_epsilon_for_a_wrong_map(mirrored):
    surface = Surface(*blob(3, seed=4))
    spectrum = spectrum_of_matrix(distance_matrix(surface), surface.vertex_areas, 20)
    reflected = cKDTree(surface.vertices).query(surface.vertices * [-1, 1, 1])[1]
    assert symmetry_epsilon(spectrum, reflected) > 0.3 * symmetry_epsilon(spectrum)
    assert symmetry_epsilon(spectrum, np.arange(surface.n_vertices)) == 0


def test_absolute_reading_does_not_depend_on_signs(mirrored):
    _, _, _, spectrum = mirrored
    flips = np.where(np.arange(20) % 3 == 0, -1.0, 1.0)
    flipped = Spectrum(spectrum.eigenvalues, spectrum.eigenfunctions * flips, spectrum.areas, spectrum.multiplets)
    np.testing.assert_array_equal(symmetry_sum(flipped), symmetry_sum(spectrum))
    assert np.abs(symmetry_sum(flipped, reading="printed") - symmetry_sum(spectrum, reading="printed")).max() > 1


def test_epsilon_over_all_pairs_is_the_mean_of_them(mirrored):
    _, _, _, spectrum = mirrored
    for reading in READINGS:
        s = symmetry_sum(spectrum, 8, reading)
        weights = spectrum.areas / spectrum.areas.sum()
        mean_square = weights @ np.subtract.outer(s, s) ** 2 @ weights
        assert symmetry_epsilon(spectrum, k0=8, reading=reading) == pytest.approx(np.sqrt(mean_square), rel=1e-9)


def test_printed_epsilon_knows_only_the_number_of_functions():
    # Of k0 orthonormal functions, all but the first nearly orthogonal to the constant: sqrt(2 (k0 - 1)).
    for mesh in (blob(3, seed=4), bilateral()[0]):
        surface = mesh if isinstance(mesh, Surface) else Surface(*mesh)
        spectrum = spectrum_of_matrix(distance_matrix(surface), surface.vertex_areas, 20, "uniform")
        assert symmetry_epsilon(spectrum, k0=5, reading="printed") == pytest.approx(np.sqrt(8), rel=0.05)


def test_no_unit(mirrored):
    surface, _, matrix, spectrum = mirrored
    scaled = spectrum_of_matrix(1e3 * matrix, 1e6 * surface.vertex_areas, 20)
    np.testing.assert_allclose(symmetry_sum(scaled), symmetry_sum(spectrum), atol=1e-3)
    p, q = np.arange(50), np.arange(50, 100)
    before, after = epsilon_bound(spectrum, matrix, p, q), epsilon_bound(scaled, 1e3 * matrix, p, q)
    np.testing.assert_allclose(after, before, rtol=1e-4)


@pytest.mark.parametrize("n_regions", [1, 2, 8, 30])
def test_bands_of_equal_area_group_mirror_images(mirrored, n_regions):
    surface, image, _, spectrum = mirrored
    regions = symmetry_regions(spectrum, n_regions)
    assert regions.dtype == np.int32
    area = np.bincount(regions, surface.vertex_areas, minlength=n_regions)
    assert len(area) == n_regions
    np.testing.assert_allclose(area, surface.area / n_regions, atol=2 * surface.vertex_areas.max())
    assert (np.diff(symmetry_sum(spectrum)[np.argsort(regions, kind="stable")][:: len(regions) - 1]) >= 0).all()
    same = regions == regions[image]
    assert same.mean() > 1 - 0.005 * n_regions
    assert np.abs(regions - regions[image]).max() <= 1


def test_bands_of_width_epsilon_satisfy_the_equation(mirrored):
    _, _, _, spectrum = mirrored
    s = symmetry_sum(spectrum)
    regions = symmetry_regions(spectrum, epsilon=0.7)
    assert regions.min() == 0
    for band in np.unique(regions):
        assert np.ptp(s[regions == band]) <= 0.7


def test_bad_requests(mirrored):
    _, _, matrix, spectrum = mirrored
    for k0 in (0, 21, 2.5):
        with pytest.raises(ValueError, match="k0 must be between 1 and the 20 eigenpairs"):
            symmetry_sum(spectrum, k0)
    with pytest.raises(ValueError, match="'absolute', 'even' or 'printed', got 'odd'"):
        symmetry_sum(spectrum, reading="odd")
    with pytest.raises(ValueError, match="one vertex for each of the 642, got 3"):
        symmetry_epsilon(spectrum, [0, 1, 2])
    with pytest.raises(ValueError, match="of one length, got 2 and 1"):
        epsilon_bound(spectrum, matrix, [0, 1], [0])
    with pytest.raises(ValueError, match=r"expected \(642, 642\)"):
        epsilon_bound(spectrum, matrix[:5], [0], [1])
    with pytest.raises(ValueError, match="not both"):
        symmetry_regions(spectrum, 4, 0.1)
    for epsilon in (0, -1, np.nan):
        with pytest.raises(ValueError, match="epsilon must be positive"):
            symmetry_regions(spectrum, epsilon=epsilon)
    with pytest.raises(ValueError, match="too fine"):
        symmetry_regions(spectrum, epsilon=1e-12)
    with pytest.raises(ValueError, match="n_regions must be between 1 and the 642"):
        symmetry_regions(spectrum, 0)
