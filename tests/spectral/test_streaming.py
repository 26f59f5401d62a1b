"""The spectrum of a matrix that is never stored, against that of the stored one."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob, icosphere

from qgeo_filters.errors import DisconnectedError
from qgeo_filters.geodesics.lifting import lifted_metric
from qgeo_filters.spectral.canonical import subspace_sine
from qgeo_filters.spectral.distance_spectrum import distance_spectrum
from qgeo_filters.spectral.streaming import streamed_spectrum
from qgeo_filters.surface import Surface


@pytest.mark.parametrize("weight", [0.0, 0.03])
def test_passes_bring_it_to_the_full_spectrum(weight: float) -> None:
    surface = Surface(*blob(3))
    metric = lifted_metric(surface, weight=weight)
    full = distance_spectrum(surface, 10, metric)
    sines = []
    for passes in (1, 2, 3):
        streamed = streamed_spectrum(surface, 10, metric, landmarks=60, passes=passes)
        sines.append(subspace_sine(streamed.eigenfunctions, full.eigenfunctions, surface.vertex_areas))
    assert sines[0] > sines[1] > sines[2]
    assert sines[1] < 0.02
    assert np.allclose(streamed.eigenvalues, full.eigenvalues, rtol=1e-4)


def test_signs_and_weights_are_those_of_the_full_spectrum() -> None:
    surface = Surface(*blob(3, seed=4))
    full = distance_spectrum(surface, 4)
    streamed = streamed_spectrum(surface, 4, landmarks=100, passes=3)
    areas = surface.vertex_areas
    overlap = np.einsum("ij,i,ij->j", streamed.eigenfunctions, areas, full.eigenfunctions)
    assert np.allclose(overlap, 1, atol=1e-3)
    gram = streamed.eigenfunctions.T @ (areas[:, None] * streamed.eigenfunctions)
    assert np.allclose(gram, np.eye(4), atol=1e-8)


def test_bad_arguments_get_one_sentence() -> None:
    surface = Surface(*icosphere(2))
    with pytest.raises(ValueError, match="landmarks must be more than 17 and at most the 162 vertices, got 10"):
        streamed_spectrum(surface, 5, landmarks=10)
    with pytest.raises(ValueError, match="passes must be a whole number, at least 1, got 0"):
        streamed_spectrum(surface, 5, landmarks=100, passes=0)
    vertices, faces = icosphere(1)
    two = Surface(np.concatenate([vertices, vertices + 5]), np.concatenate([faces, faces + len(vertices)]))
    with pytest.raises(DisconnectedError):
        streamed_spectrum(two)
