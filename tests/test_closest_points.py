"""Closest points that face the same way."""

from __future__ import annotations

import igl
import numpy as np
from shapes import blob, icosphere

from qgeo_filters.closest_points import closest_facing_points
from qgeo_filters.surface import Surface


def places(surface: Surface, faces: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ijk->ik", coordinates, surface.vertices[surface.faces[faces]])


def test_where_nothing_faces_away_they_are_the_closest() -> None:
    surface = Surface(*blob(3))
    points = surface.vertices + 0.05 * surface.vertex_normals
    for normals in (surface.vertex_normals, np.zeros_like(points)):
        faces, coordinates = closest_facing_points(points, normals, surface)
        found = np.linalg.norm(places(surface, faces, coordinates) - points, axis=1)
        squared, _, _ = igl.point_mesh_squared_distance(points, surface.vertices, surface.faces.astype(np.int64))
        np.testing.assert_allclose(found, np.sqrt(squared), atol=1e-9)
        assert coordinates.min() >= 0
        np.testing.assert_allclose(coordinates.sum(axis=1), 1, atol=1e-12)


def test_the_other_side_of_a_thin_lens_is_not_taken() -> None:
    vertices, faces = icosphere(4)
    lens = Surface(vertices * [1, 1, 0.01], faces)
    points = lens.vertices * [1, 1, -0.5]  # nearer to the side across
    inner = np.linalg.norm(lens.vertices[:, :2], axis=1) < 0.8
    for scale, shift in ((1.0, 0.0), (1e-6, 0.0), (1e6, 3e6)):
        moved = lens.with_vertices(scale * lens.vertices + shift)
        found, _ = closest_facing_points(scale * points + shift, lens.vertex_normals, moved)
        up, expected = lens.face_normals[found][:, 2], lens.vertex_normals[:, 2]
        assert (up * expected > 0)[inner & (np.abs(expected) > 0.1)].all()
