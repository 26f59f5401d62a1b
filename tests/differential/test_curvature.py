"""Curvatures against formulas: sphere, cylinder, torus, Gauss-Bonnet."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob, cylinder, grid, icosphere, moebius, torus

from qgeo_filters.differential.coordinates import mixed_voronoi_areas
from qgeo_filters.differential.curvature import gaussian_curvature, mean_curvature, principal_curvatures
from qgeo_filters.errors import MeshError
from qgeo_filters.surface import Surface


def torus_curvatures(n_around: int, n_tube: int) -> tuple[Surface, np.ndarray, np.ndarray]:
    surface = Surface(*torus(n_around, n_tube, 1.0, 0.4))
    cosine = (np.hypot(*surface.vertices[:, :2].T) - 1) / 0.4
    return surface, np.full(surface.n_vertices, 1 / 0.4), cosine / (1 + 0.4 * cosine)


def test_torus_converges_to_the_formulas():
    errors = []
    for n in (20, 40, 80):
        surface, along, across = torus_curvatures(2 * n, n)
        mean, gauss = (along + across) / 2, along * across
        errors.append([np.abs(mean_curvature(surface) - mean).max(), np.abs(gaussian_curvature(surface) - gauss).max()])
    slopes = np.polyfit(np.log([4.0, 2.0, 1.0]), np.log(errors), 1)[0]
    assert (slopes > 1.8).all()
    assert np.max(errors[-1]) < 0.01


def test_quadrics_on_the_torus_and_the_names_of_the_curvatures():
    surface, along, across = torus_curvatures(160, 80)
    principal = principal_curvatures(surface, radius=3)
    assert principal.fitted.all()
    assert (principal.k1 >= principal.k2).all()
    np.testing.assert_allclose(principal.k1, along, rtol=0.03)
    np.testing.assert_allclose(principal.k2, across, atol=0.05)
    np.testing.assert_allclose(principal.curvedness, np.sqrt((along**2 + across**2) / 2), rtol=0.03)
    index = 2 / np.pi * np.arctan((along + across) / (along - across))
    np.testing.assert_allclose(principal.shape_index, index, atol=0.02)
    # The first direction runs around the tube, across the circles about the axis.
    circle = np.column_stack([-surface.vertices[:, 1], surface.vertices[:, 0], np.zeros(surface.n_vertices)])
    circle /= np.linalg.norm(circle, axis=1, keepdims=True)
    assert np.abs(np.einsum("ij,ij->i", principal.d1, circle)).max() < 0.05
    assert np.abs(np.einsum("ij,ij->i", principal.d2, circle)).min() > 0.99


@pytest.mark.parametrize("radius", [0.5, 3.0])
def test_sphere_is_positive_with_outward_normals_and_negative_with_inward(radius):
    vertices, faces = icosphere(4, radius)
    for side, winding in ((1, faces), (-1, faces[:, ::-1])):
        surface = Surface(vertices, winding)
        np.testing.assert_allclose(mean_curvature(surface), side / radius, rtol=1e-3)
        np.testing.assert_allclose(gaussian_curvature(surface), 1 / radius**2, rtol=2e-3)
        principal = principal_curvatures(surface)
        np.testing.assert_allclose(principal.k1, side / radius, rtol=0.05)
        np.testing.assert_allclose(principal.k2, side / radius, rtol=0.05)
        np.testing.assert_allclose(principal.shape_index, side, atol=0.02)


def test_open_cylinder_at_its_boundary_too():
    surface = Surface(*cylinder(80, 40, radius=2.0))
    np.testing.assert_allclose(mean_curvature(surface), 0.25, rtol=0.01)
    np.testing.assert_allclose(gaussian_curvature(surface), 0, atol=1e-9)


@pytest.mark.parametrize(("mesh", "euler"), [(blob(3), 2), (torus(), 0)])
def test_gauss_bonnet(mesh, euler):
    surface = Surface(*mesh)
    total = gaussian_curvature(surface) @ mixed_voronoi_areas(surface)
    assert total == pytest.approx(2 * np.pi * euler, abs=1e-9)


@pytest.mark.parametrize("factor", [1e-9, 1e-3, 1e9])
def test_curvatures_scale_with_the_inverse_length(factor):
    vertices, faces = blob(3)
    surface, scaled = Surface(vertices, faces), Surface(factor * vertices, faces)
    np.testing.assert_allclose(mean_curvature(scaled) * factor, mean_curvature(surface), atol=1e-9)
    np.testing.assert_allclose(gaussian_curvature(scaled) * factor**2, gaussian_curvature(surface), atol=1e-9)
    small, large = principal_curvatures(surface), principal_curvatures(scaled)
    np.testing.assert_allclose(large.k1 * factor, small.k1, atol=1e-9)
    np.testing.assert_allclose(large.k2 * factor, small.k2, atol=1e-9)


def test_far_from_the_origin():
    vertices, faces = blob(2)
    near, far = principal_curvatures(Surface(vertices, faces)), principal_curvatures(Surface(vertices + 1e4, faces))
    np.testing.assert_allclose(far.k1, near.k1, atol=1e-6)


def test_one_sided_surface_and_flipped_faces_are_refused():
    vertices, faces = blob(2)
    faces = faces.copy()
    faces[5] = faces[5, ::-1]
    for surface in (Surface(*moebius()), Surface(vertices, faces)):
        for curvature in (mean_curvature, principal_curvatures):
            with pytest.raises(MeshError, match="agree on which side is out"):
                curvature(surface)
        assert np.isfinite(gaussian_curvature(surface)).all()


def test_too_few_neighbours_and_degenerate_meshes_are_refused():
    with pytest.raises(MeshError, match="no vertex of the 3 has as many"):
        principal_curvatures(Surface(np.eye(3), [[0, 1, 2]]))
    with pytest.raises(MeshError, match="positive area"):
        principal_curvatures(Surface([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]))
    with pytest.raises(ValueError, match="radius is a number of rings"):
        principal_curvatures(Surface(*grid(3)), radius=1)


def test_loose_vertices_are_marked_and_change_nothing():
    vertices, faces = blob(2)
    alone = principal_curvatures(Surface(vertices, faces))
    beside = principal_curvatures(Surface(np.vstack([vertices, [[0.0, 0, 0]]]), faces))
    assert beside.fitted.tolist() == [True] * len(vertices) + [False]
    assert beside.k1[-1] == 0
    np.testing.assert_allclose(beside.k1[:-1], alone.k1, atol=1e-9)
