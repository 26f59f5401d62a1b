"""Corrected normals: always inside the cone of the incident face normals (Fig. 2d of the paper)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls
from shapes import blob, cone, cylinder, grid, icosphere, torus

from qgeo_filters.differential.coordinates import differential_coordinates
from qgeo_filters.differential.normals import vertex_normals
from qgeo_filters.surface import Surface


def crumpled(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = icosphere(2)
    return vertices + np.random.default_rng(seed).normal(scale=0.12, size=vertices.shape), faces


SHAPES = {
    "blob": blob(2), "torus": torus(16, 8), "cylinder": cylinder(12, 5), "grid": grid(6, 0.3), "cone": cone(12, 4),
    "crumpled": crumpled(),
}  # fmt: skip


def faces_around(surface: Surface, vertex: int) -> np.ndarray:
    return surface.face_normals[(surface.faces == vertex).any(axis=1)]


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("corrected", [True, False])
def test_normals_are_unit_and_non_negative_combinations_of_face_normals(name, corrected):
    surface = Surface(*SHAPES[name])
    normals = vertex_normals(surface, corrected)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-12)
    for i, normal in enumerate(normals):
        residual = nnls(faces_around(surface, i).T, normal)[1]
        assert residual < 1e-8, f"the normal of vertex {i} is outside of its faces' cone"


@pytest.mark.parametrize("name", ["blob", "crumpled"])
def test_no_sampled_direction_of_the_cone_is_nearer(name):
    surface = Surface(*SHAPES[name])
    normals = vertex_normals(surface)
    delta = differential_coordinates(surface)
    delta *= np.sign(np.einsum("ij,ij->i", delta, surface.vertex_normals))[:, None]
    delta /= np.linalg.norm(delta, axis=1, keepdims=True)
    rng = np.random.default_rng(0)
    for i in range(0, surface.n_vertices, 5):
        cone_normals = faces_around(surface, i)
        samples = rng.dirichlet(np.full(len(cone_normals), 0.3), 200) @ cone_normals
        samples /= np.linalg.norm(samples, axis=1, keepdims=True)
        # The projection on a cone has the smallest angle to what is projected.
        assert (samples @ delta[i]).max() <= normals[i] @ delta[i] + 1e-9


def test_direction_that_is_inside_already_is_kept():
    apex = np.vstack([[0, 0, 0.8], [[np.cos(t), np.sin(t), 0] for t in np.arange(6) * np.pi / 3]])
    apex[0, :2] = 0.05, -0.02
    surface = Surface(apex, [[0, 1 + j, 1 + (j + 1) % 6] for j in range(6)])
    delta = differential_coordinates(surface)[0]
    np.testing.assert_allclose(vertex_normals(surface)[0], delta / np.linalg.norm(delta), atol=1e-12)


def test_sphere_and_plane():
    sphere = Surface(*icosphere(3, 2.5))
    np.testing.assert_allclose(vertex_normals(sphere), sphere.vertices / 2.5, atol=0.1)  # uniform weights: a slant
    plane = Surface(*grid(6, 0.2))
    np.testing.assert_allclose(vertex_normals(plane), np.tile([0, 0, 1.0], (plane.n_vertices, 1)), atol=1e-12)


def test_inward_faces_give_inward_normals():
    vertices, faces = blob(2)
    outward, inward = Surface(vertices, faces), Surface(vertices, faces[:, ::-1])
    np.testing.assert_allclose(vertex_normals(inward), -vertex_normals(outward), atol=1e-10)


def test_vertex_without_faces_has_no_normal():
    vertices, faces = grid(2)
    surface = Surface(np.vstack([vertices, [[5.0, 5, 5]]]), faces)
    assert (vertex_normals(surface)[-1] == 0).all()
