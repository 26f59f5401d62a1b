"""Laplace-Beltrami spectrum against the sphere, the rectangle and Weyl's scale law."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob, grid, icosphere

from qgeo_filters.errors import DisconnectedError
from qgeo_filters.spectral.laplacian import laplacian_spectrum
from qgeo_filters.surface import Surface


def test_sphere_converges_to_l_times_l_plus_one():
    exact = np.repeat([0, 2, 6, 12], [1, 3, 5, 7])
    errors = []
    for level in (2, 3, 4):
        spectrum = laplacian_spectrum(Surface(*icosphere(level, 2.0)), 16)
        errors.append(np.abs(spectrum.eigenvalues * 4 - exact).max())
    assert np.polyfit(np.log([4.0, 2.0, 1.0]), np.log(errors), 1)[0] > 1.8
    assert spectrum.multiplets == ((0,), (1, 2, 3), (4, 5, 6, 7, 8), tuple(range(9, 16)))


def test_square_with_free_boundary():
    spectrum = laplacian_spectrum(Surface(*grid(40, 0.2)), 6)
    np.testing.assert_allclose(spectrum.eigenvalues, np.pi**2 * np.array([0, 1, 1, 2, 4, 4]), rtol=5e-3, atol=1e-8)


@pytest.mark.parametrize("k", [5, 100, 162])
def test_orthonormal_under_its_areas_and_increasing(k):
    surface = Surface(*blob(2))
    spectrum = laplacian_spectrum(surface, k)
    gram = spectrum.eigenfunctions.T @ (spectrum.areas[:, None] * spectrum.eigenfunctions)
    np.testing.assert_allclose(gram, np.eye(k), atol=1e-11)
    assert (np.diff(spectrum.eigenvalues) >= 0).all()
    assert spectrum.eigenvalues[0] == pytest.approx(0, abs=1e-9)
    assert spectrum.areas.sum() == pytest.approx(surface.area, rel=1e-4)
    constant = spectrum.eigenfunctions[:, 0]
    np.testing.assert_allclose(constant, 1 / np.sqrt(spectrum.areas.sum()), rtol=1e-6)


@pytest.mark.parametrize("factor", [1e-9, 1e9])
def test_eigenvalues_scale_as_one_over_the_area(factor):
    vertices, faces = blob(2)
    small, large = (laplacian_spectrum(Surface(s * vertices, faces), 10) for s in (1.0, factor))
    np.testing.assert_allclose(large.eigenvalues * factor**2, small.eigenvalues, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(large.eigenfunctions * factor, small.eigenfunctions, atol=1e-5)


def test_needle_triangles_do_no_harm():
    # The middle of every long side moved to within 1e-9 of one end's neighbour line: angles of nearly 0 and pi.
    vertices, faces = grid(12)
    flat = vertices.copy()
    flat[40] = flat[41] + [1e-9, 0, 0]
    spectrum = laplacian_spectrum(Surface(flat, faces), 4)
    np.testing.assert_allclose(spectrum.eigenvalues, np.pi**2 * np.array([0, 1, 1, 2]), rtol=0.05, atol=1e-6)


def test_bad_requests():
    vertices, faces = grid(4)
    with pytest.raises(ValueError, match="between 1 and the number of vertices, 25"):
        laplacian_spectrum(Surface(vertices, faces), 26)
    with pytest.raises(DisconnectedError, match="spectrum of the Laplacian needs a mesh in one piece"):
        laplacian_spectrum(Surface(np.vstack([vertices, [[9.0, 9, 9]]]), faces), 3, repair=False)
