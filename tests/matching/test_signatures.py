"""Agreement of what surrounds a point with what surrounds its image."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from shapes import icosphere, torus

from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.selection.signatures import (
    curvature_agreement,
    hks_agreement,
    hks_agreements,
    relief_agreement,
)
from qgeo_filters.surface import Surface

Agreement = Callable[[MatchProblem, np.ndarray], float]


def pressed(sign: float) -> tuple[np.ndarray, np.ndarray]:
    """A ball with two bulges in front, and two bulges or hollows of the same size on the back."""
    vertices, faces = icosphere(3)
    radius = np.ones(len(vertices))
    for axis, height in (
        ((0.5, 1, 0.3), 0.25),
        ((-0.5, 1, 0.3), 0.25),
        ((0.5, -1, 0.3), 0.25),
        ((-0.5, -1, 0.3), 0.25),
    ):
        direction = np.array(axis) / np.linalg.norm(axis)
        radius += (1 if axis[1] > 0 else sign) * height * np.exp(30 * (vertices @ direction - 1))
    return vertices * radius[:, None], faces


def half_turn(vertices: np.ndarray) -> np.ndarray:
    """Vertex of the sphere on the other side of the z axis, for each."""
    directions = vertices / np.linalg.norm(vertices, axis=1)[:, None]
    return (directions @ (directions * [-1, -1, 1]).T).argmax(axis=1)


@functools.cache
def described(sign: float) -> PreparedShape:
    return PreparedShape(Surface(*pressed(sign)))


def test_smoothed_curvature_of_a_sphere_is_its_curvature_and_that_of_a_torus_follows_the_formula() -> None:
    sphere = PreparedShape(Surface(*icosphere(3)))
    np.testing.assert_allclose(sphere.smoothed_mean_curvature, np.sqrt(4 * np.pi), rtol=0.01)
    vertices, faces = torus(80, 40)
    ring = PreparedShape(Surface(vertices, faces), parameters=MatchingParameters(search_vertices=10_000))
    outwards = np.hypot(vertices[:, 0], vertices[:, 1])
    cosine = (outwards - 1.0) / 0.4
    expected = (1.0 + 2 * 0.4 * cosine) / (2 * 0.4 * outwards) * ring.scale
    np.testing.assert_allclose(ring.smoothed_mean_curvature, expected, atol=0.06 * np.ptp(expected))  # smoothed


def test_relief_of_a_sphere_is_how_far_heat_draws_it_in() -> None:
    """Positions are eigenfunctions there, of eigenvalue 2 / radius^2."""
    sphere = PreparedShape(Surface(*icosphere(3)))
    radius = 1 / np.sqrt(4 * np.pi)
    drawn_in = radius * (1 - np.exp(-2 / radius**2 * sphere.parameters.relief_time))
    np.testing.assert_allclose(sphere.relief, drawn_in, rtol=0.03)


@pytest.mark.parametrize("agreement", [curvature_agreement, relief_agreement])
def test_curvature_and_relief_tell_a_bulge_from_a_hollow(agreement: Agreement) -> None:
    x = described(-1.0)
    identity, turned = np.arange(x.n_vertices), half_turn(x.unit.vertices)
    assert agreement(MatchProblem(x, x), identity) == 1
    assert agreement(MatchProblem(x, x), turned) < 0.2
    same = described(1.0)
    assert agreement(MatchProblem(same, same), turned) > 0.99


def test_agreement_of_equal_shapes_is_one_and_that_of_a_random_map_near_zero() -> None:
    x = described(1.0)
    shuffled = np.random.default_rng(0).permutation(x.n_vertices)
    for measure in (hks_agreements, curvature_agreement, relief_agreement):
        np.testing.assert_array_equal(measure(MatchProblem(x, x), np.arange(x.n_vertices)), 1)
        np.testing.assert_allclose(measure(MatchProblem(x, x), shuffled), 0, atol=0.2)
    kernels = hks_agreements(MatchProblem(x, x), shuffled)
    assert hks_agreement(MatchProblem(x, x), shuffled) == min(kernels[1:])


@pytest.mark.parametrize("name", ["smoothed_mean_curvature", "relief"])
def test_curvature_and_relief_do_not_change_in_a_mirror_with_the_place_or_with_the_size(name: str) -> None:
    x = described(-1.0)
    here = getattr(x, name)
    np.testing.assert_array_equal(getattr(x.mirrored, name), here)
    vertices, faces = pressed(-1.0)
    flipped = PreparedShape(Surface(vertices * [-1, 1, 1], faces[:, ::-1]))
    np.testing.assert_allclose(getattr(flipped, name), here, atol=1e-3 * np.ptp(here))
    moved = PreparedShape(Surface(17.0 * vertices + 3, faces))
    np.testing.assert_allclose(getattr(moved, name), here, atol=1e-3 * np.ptp(here))


def test_what_maps_like_to_like_is_less_dear() -> None:
    """At the same distortion the map of the bulge onto the hollow ranks last; a power of 0 takes no notice."""
    x = described(-1.0)
    points = x.fps[:300]
    maps = np.stack([points, half_turn(x.unit.vertices)[points]])
    problem = MatchProblem(x, x)
    alike, turned = problem.unlikeness(points, maps)
    assert alike < 0.3 < 1 < turned
    assert np.array_equal(problem.dearness(points, maps), [alike, turned])
    silent = MatchProblem(x, x, replace(MatchingParameters(), unlike_counts=0.0))
    assert np.array_equal(silent.unlikeness(points, maps), [1, 1])
