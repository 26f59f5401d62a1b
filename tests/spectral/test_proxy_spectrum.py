"""The spectrum of a large surface from a proxy of it, beside that of all its distances."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from shapes import blob, grid
from test_memory import in_limited_process

import qgeo_filters as qg
from qgeo_filters.spectral import distance_spectrum as chooser
from qgeo_filters.spectral import landmarks
from qgeo_filters.spectral.canonical import subspace_sine

K = 10


@pytest.fixture(scope="module")
def surface() -> qg.Surface:
    return qg.Surface(*blob(4, seed=3))


@pytest.fixture(scope="module")
def smooth(surface: qg.Surface) -> qg.LiftedMetric:
    return qg.lifted_metric(surface, surface.vertices[:, 2], 0.1)


@pytest.mark.parametrize("lifted", [False, True])
def test_near_the_spectrum_of_all_distances_and_nearer_from_a_finer_proxy(
    surface: qg.Surface, smooth: qg.LiftedMetric, lifted: bool
) -> None:
    metric = smooth if lifted else "cartesian"
    full = qg.distance_spectrum(surface, K, metric, landmarks=None)
    errors = []
    for vertices in (300, 1200):
        found = qg.proxy_spectrum(surface, K, metric, vertices=vertices)
        sine = subspace_sine(found.eigenfunctions, full.eigenfunctions, full.areas)
        errors.append((sine, np.abs(found.eigenvalues / full.eigenvalues - 1).max()))
        gram = found.eigenfunctions.T @ (found.areas[:, None] * found.eigenfunctions)
        np.testing.assert_allclose(gram, np.eye(K), atol=1e-10)
        np.testing.assert_array_equal(found.areas, surface.vertex_areas)
    (coarse, _), (fine, eigenvalue) = errors
    # With the square of the length of an edge, by four: the proxies are a ninth and a half of a lumpy surface.
    assert fine < min(0.08, 0.4 * coarse), errors
    assert eigenvalue < 0.02, errors


def test_uniform_mass_counts_the_vertices_of_the_surface(surface: qg.Surface) -> None:
    full = qg.distance_spectrum(surface, 5, "cartesian", "uniform", landmarks=None)
    found = qg.proxy_spectrum(surface, 5, "cartesian", "uniform", vertices=1200)
    np.testing.assert_array_equal(found.areas, 1.0)
    np.testing.assert_allclose(found.eigenvalues, full.eigenvalues, rtol=0.01)
    assert subspace_sine(found.eigenfunctions, full.eigenfunctions, full.areas) < 0.06


def test_a_small_surface_is_its_own_proxy() -> None:
    surface = qg.Surface(*blob(2))
    full, found = qg.distance_spectrum(surface, 8), qg.proxy_spectrum(surface, 8)
    np.testing.assert_allclose(found.eigenvalues, full.eigenvalues, rtol=1e-5)
    assert subspace_sine(found.eigenfunctions, full.eigenfunctions, full.areas) < 1e-4


def test_what_was_done_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    surface = qg.Surface(*blob(3))
    assert qg.distance_spectrum(surface, 4).approximation == ""
    assert repr(qg.distance_spectrum(surface, 4)) == "Spectrum(4 eigenpairs on 642 vertices)"
    assert repr(qg.distance_spectrum(surface, 4, landmarks=100)).endswith("642 vertices, from 100 landmarks)")
    monkeypatch.setattr(chooser, "ALL_DISTANCES_UP_TO", 600)
    assert qg.distance_spectrum(surface, 4).approximation == "642 landmarks"
    large = qg.distance_spectrum(surface, 4, "cartesian")
    assert large.approximation.startswith("a proxy of 642 vertices")
    assert large.truncated(2).approximation == large.approximation
    assert qg.distance_spectrum(surface, 4, landmarks=None).approximation == ""
    assert qg.distance_spectrum(surface, 4, matrix=qg.distance_matrix(surface)).approximation == ""
    with pytest.raises(qg.ParameterError, match=r"landmarks must be 'auto', a number, or None .* got 'many'"):
        qg.distance_spectrum(surface, 4, landmarks="many")  # type: ignore[arg-type]


def test_other_surfaces_are_refused(surface: qg.Surface, smooth: qg.LiftedMetric) -> None:
    with pytest.raises(qg.ParameterError, match="k"):
        qg.proxy_spectrum(surface, 400, vertices=300)
    with pytest.raises(qg.ParameterError, match="another surface"):
        qg.proxy_spectrum(surface.turned_over(), 4, smooth)


def test_landmarks_of_a_large_surface_are_interpolated_over_a_proxy(
    surface: qg.Surface, smooth: qg.LiftedMetric, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = qg.distance_spectrum(surface, K, smooth, landmarks=None)
    usual = qg.landmark_spectrum(surface, K, smooth, 300)
    monkeypatch.setattr(landmarks, "FACTORISED_UP_TO", 1000)
    monkeypatch.setattr(landmarks, "PROXY_VERTICES", 900)
    found = qg.landmark_spectrum(surface, K, smooth, 300)
    sines = [subspace_sine(one.eigenfunctions, full.eigenfunctions, full.areas) for one in (usual, found)]
    assert sines[1] < min(2.5 * sines[0], 0.04), sines
    np.testing.assert_allclose(found.eigenvalues, full.eigenvalues, rtol=0.02)
    with pytest.raises(qg.ParameterError, match="landmarks"):
        qg.landmark_spectrum(surface, K, smooth, 901)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="this system does not limit a process's address space")
def test_sixty_thousand_vertices_in_a_gigabyte_and_a_half() -> None:
    ended = in_limited_process(
        """
        surface = qg.Surface(*grid(245))
        found = qg.distance_spectrum(surface, 10, "cartesian", workers=1)
        print(found, found.eigenvalues[0])
        """,
        1.5,
    )
    assert ended.returncode == 0, ended.stderr
    said, _, value = ended.stdout.strip().rpartition(" ")
    assert "60516 vertices, from a proxy of " in said
    # A unit square: the eigenvalue is the same for any number of vertices.
    square = qg.Surface(*grid(40))
    expected = qg.distance_spectrum(square, 1, "cartesian", landmarks=None).eigenvalues[0]
    assert float(value) == pytest.approx(expected, rel=5e-3)
