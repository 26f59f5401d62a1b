"""The spectrum of a matrix that is never stored, against that of the stored one."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob, icosphere

from qgeo_filters.errors import DisconnectedError
from qgeo_filters.geodesics.metric import lifted_metric
from qgeo_filters.spectral.block_krylov import streamed_spectrum
from qgeo_filters.spectral.canonical import subspace_sine
from qgeo_filters.spectral.distance_spectrum import distance_spectrum
from qgeo_filters.surface import Surface


@pytest.mark.parametrize("weight", [0.0, 0.03])
def test_passes_bring_it_to_the_full_spectrum(weight: float) -> None:
    surface = Surface(*blob(3))
    metric = lifted_metric(surface, curvature_weight=weight)
    full = distance_spectrum(surface, 10, metric)
    sines = []
    for passes in (1, 2, 3):
        streamed = streamed_spectrum(surface, 10, metric, landmarks=30, passes=passes)
        sines.append(subspace_sine(streamed.eigenfunctions, full.eigenfunctions, surface.vertex_areas))
    assert sines[0] > sines[1] > sines[2]
    assert sines[1] < 0.01
    assert np.allclose(streamed.eigenvalues, full.eigenvalues, rtol=1e-5)


def test_one_pass_from_enough_landmarks_will_do() -> None:
    """Rows of landmarks carry the roughness of an unsmoothed metric at every vertex, interpolation would not."""
    surface = Surface(*blob(4))
    metric = lifted_metric(surface, np.random.default_rng(0).standard_normal(surface.n_vertices), 0.03)
    full = distance_spectrum(surface, 10, metric)
    streamed = streamed_spectrum(surface, 10, metric, landmarks=300, passes=1)
    assert subspace_sine(streamed.eigenfunctions, full.eigenfunctions, surface.vertex_areas) < 0.02


def test_residuals_bound_the_errors() -> None:
    surface = Surface(*blob(3))
    metric = lifted_metric(surface)
    full = distance_spectrum(surface, 40, metric)
    assert full.residuals is None
    for passes in (1, 2):
        streamed = streamed_spectrum(surface, 12, metric, landmarks=40, passes=passes)
        residuals = streamed.residuals
        assert residuals is not None
        assert (np.abs(streamed.eigenvalues / full.eigenvalues[:12] - 1) <= residuals).all()
        # Davis and Kahan: the sine of a span is at most its residual over the gap to all that is outside.
        for j in (4, 8, 12):
            inside, outside = full.eigenvalues[:j], full.eigenvalues[j:]
            gap = np.abs(inside[:, None] - outside).min()
            bound = np.linalg.norm(residuals[:j] * streamed.eigenvalues[:j]) / gap
            sine = subspace_sine(streamed.eigenfunctions[:, :j], full.eigenfunctions[:, :j], surface.vertex_areas)
            assert sine <= bound
        truncated = streamed.truncated(3).residuals
        assert truncated is not None
        assert np.array_equal(truncated, residuals[:3])


def test_all_eigenpairs_of_a_small_surface() -> None:
    surface = Surface(*icosphere(1))
    metric = lifted_metric(surface, curvature_weight=0)
    streamed = streamed_spectrum(surface, 42, metric, landmarks=42, passes=3)
    full = distance_spectrum(surface, 42, metric)
    assert np.allclose(streamed.eigenvalues, full.eigenvalues, atol=1e-5 * abs(full.eigenvalues[0]))
    gram = streamed.eigenfunctions.T @ (surface.vertex_areas[:, None] * streamed.eigenfunctions)
    assert np.allclose(gram, np.eye(42), atol=1e-8)


def test_signs_and_weights_are_those_of_the_full_spectrum() -> None:
    surface = Surface(*blob(3, seed=4))
    full = distance_spectrum(surface, 4)
    streamed = streamed_spectrum(surface, 4, landmarks=100, passes=3)
    areas = surface.vertex_areas
    overlap = np.einsum("ij,i,ij->j", streamed.eigenfunctions, areas, full.eigenfunctions)
    assert np.allclose(overlap, 1, atol=1e-3)
    gram = streamed.eigenfunctions.T @ (areas[:, None] * streamed.eigenfunctions)
    assert np.allclose(gram, np.eye(4), atol=1e-8)


@pytest.mark.parametrize("scale", [1e-12, 1e20])
def test_no_unit_of_length_is_too_small_or_large(scale: float) -> None:
    surface = Surface(*blob(2))
    other = Surface(scale * surface.vertices, surface.faces)
    one, two = (streamed_spectrum(s, 5, lifted_metric(s), landmarks=50) for s in (surface, other))
    assert np.allclose(two.eigenvalues, scale**3 * one.eigenvalues, rtol=1e-4)
    assert np.allclose(two.eigenfunctions * scale, one.eigenfunctions, atol=1e-3)


def test_bad_arguments_get_one_sentence() -> None:
    surface = Surface(*icosphere(2))
    with pytest.raises(ValueError, match="landmarks must be at least k, 5, and at most the 162 vertices, got 4"):
        streamed_spectrum(surface, 5, landmarks=4)
    with pytest.raises(ValueError, match="passes must be a whole number, at least 1, got 0"):
        streamed_spectrum(surface, 5, landmarks=100, passes=0)
    vertices, faces = icosphere(1)
    two = Surface(np.concatenate([vertices, vertices + 5]), np.concatenate([faces, faces + len(vertices)]))
    with pytest.raises(DisconnectedError):
        streamed_spectrum(two, landmarks=50)
