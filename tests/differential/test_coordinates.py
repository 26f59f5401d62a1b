"""Differential coordinates: defining formulas by a second route, invariances, limits on the sphere."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import blob, cylinder, grid, icosphere, torus

from qgeo_filters.differential.coordinates import (
    area_gradient,
    differential_coordinates,
    mixed_voronoi_areas,
    spread_to_neighbours,
)
from qgeo_filters.surface import Surface

SHAPES = {"blob": blob(2), "torus": torus(), "cylinder": cylinder(12, 5), "grid": grid(6, 0.3)}


def rotation(seed: int) -> np.ndarray:
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


@pytest.mark.parametrize("name", SHAPES)
def test_uniform_is_the_vertex_minus_its_neighbours_mean(name):
    surface = Surface(*SHAPES[name])
    neighbours = igl.adjacency_list(surface.faces.astype(np.int64))
    expected = [x - surface.vertices[ring].mean(axis=0) for x, ring in zip(surface.vertices, neighbours, strict=True)]
    np.testing.assert_allclose(differential_coordinates(surface), expected, atol=1e-14)


@pytest.mark.parametrize("name", SHAPES)
def test_cotangent_is_libigls_cotangent_matrix_over_the_area(name):
    surface = Surface(*SHAPES[name])
    cotangent = -igl.cotmatrix(surface.vertices, surface.faces.astype(np.int64)) @ surface.vertices
    np.testing.assert_allclose(area_gradient(surface), cotangent, atol=1e-12)
    # igl's default mass matrix is the same mixed Voronoi area.
    mass = igl.massmatrix(surface.vertices, surface.faces.astype(np.int64), igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    np.testing.assert_allclose(mixed_voronoi_areas(surface), mass, rtol=1e-12)
    expected = cotangent / mass[:, None]
    np.testing.assert_allclose(differential_coordinates(surface, "cotangent"), expected, atol=1e-10)


def test_area_gradient_is_the_derivative_of_the_area():
    surface = Surface(*blob(2))
    direction = np.random.default_rng(0).normal(size=surface.vertices.shape)
    step = 1e-6
    ahead, behind = (surface.with_vertices(surface.vertices + s * direction).area for s in (step, -step))
    assert (ahead - behind) / (2 * step) == pytest.approx(np.sum(area_gradient(surface) * direction), rel=1e-7)


@pytest.mark.parametrize("radius", [0.3, 1.0, 7.0])
def test_cotangent_on_a_sphere_is_two_over_the_radius(radius):
    # The mixed Voronoi area makes this exact to second order at vertices of valence 5 too.
    errors = []
    for level in (2, 3, 4):
        surface = Surface(*icosphere(level, radius))
        delta = differential_coordinates(surface, "cotangent")
        errors.append(np.abs(np.linalg.norm(delta, axis=1) * radius / 2 - 1).max())
        outward = np.einsum("ij,ij->i", delta, surface.vertices) / radius
        assert outward.min() > 1.9 / radius
    assert errors[-1] < 1e-5
    slope = np.polyfit(np.log([4.0, 2.0, 1.0]), np.log(errors), 1)[0]
    assert slope > 1.8


def test_plane_has_no_coordinate_inside():
    vertices, faces = grid(8, 0.3)
    surface = Surface(vertices @ rotation(1), faces)
    inside = np.setdiff1d(np.arange(surface.n_vertices), surface.boundary_vertices)
    assert np.abs(differential_coordinates(surface, "cotangent")[inside]).max() < 1e-10


@given(seed=st.integers(0, 10**6), shift=st.floats(-1e3, 1e3), factor=st.floats(1e-3, 1e3))
@settings(max_examples=20)
def test_equivariance(seed, shift, factor):
    vertices, faces = blob(2, seed=3)
    surface = Surface(vertices, faces)
    turn = rotation(seed)
    moved = Surface(factor * (vertices + shift) @ turn.T, faces)
    for weights, power in (("uniform", 1), ("cotangent", -1)):
        before = differential_coordinates(surface, weights) @ turn.T * factor**power
        np.testing.assert_allclose(differential_coordinates(moved, weights), before, atol=1e-8 * np.abs(before).max())


@pytest.mark.parametrize("name", SHAPES)
def test_mixed_areas_sum_to_the_area(name):
    surface = Surface(*SHAPES[name])
    areas = mixed_voronoi_areas(surface)
    assert areas.sum() == pytest.approx(surface.area, rel=1e-12)
    assert areas.min() > 0


def test_needles_and_loose_vertices_stay_finite():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-12, 0], [0.5, 1, 0.3], [9, 9, 9], [0.5, 0, 0]])
    surface = Surface(vertices, [[0, 1, 2], [0, 2, 3], [2, 1, 3], [0, 5, 1]])
    for weights in ("uniform", "cotangent"):
        delta = differential_coordinates(surface, weights)
        assert np.isfinite(delta).all()
        assert (delta[4] == 0).all()
    # A triangle moves the area by half of its opposite side at most, however thin it is.
    assert np.linalg.norm(area_gradient(surface), axis=1).max() < 3


def test_spreading_reaches_every_vertex_of_the_piece():
    surface = Surface(*grid(6))
    known = np.zeros(surface.n_vertices, dtype=bool)
    known[24] = True
    assert (spread_to_neighbours(surface, np.full(surface.n_vertices, 3.0), known) == 3).all()
    assert (spread_to_neighbours(surface, np.ones(surface.n_vertices), np.zeros_like(known)) == 0).all()


def test_unknown_weights():
    with pytest.raises(ValueError, match="'uniform' or 'cotangent', got 'mean'"):
        differential_coordinates(Surface(*grid(2)), "mean")
