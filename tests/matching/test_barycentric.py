"""Points within triangles: against libigl's closest points, on sheets that nearly touch, and on bad triangles."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from shapes import blob, grid, icosphere

from qgeo_filters.barycentric import BarycentricMap, nearest_in_triangles
from qgeo_filters.matching.maps.barycentric import barycentric_map
from qgeo_filters.surface import Surface


def points_of(place: BarycentricMap, y: Surface) -> np.ndarray:
    return place.pulled_back(y.vertices)


def test_points_of_the_surface_are_found_where_they_are() -> None:
    """Random points in triangles, each known to be near one of the corners."""
    y = Surface(*blob(3))
    random = np.random.default_rng(0)
    faces = random.integers(y.n_faces, size=500)
    weights = random.dirichlet((1, 1, 1), size=500)
    points = np.einsum("ij,ijk->ik", weights, y.vertices[y.faces[faces]])
    place = barycentric_map(points, y.faces[faces, random.integers(3, size=500)], y)
    np.testing.assert_array_equal(place.faces, faces)
    np.testing.assert_allclose(place.coordinates, weights, atol=1e-9)
    np.testing.assert_array_equal(place.corners, y.faces[faces])
    np.testing.assert_array_equal(place.nearest_corner, y.faces[faces, weights.argmax(axis=1)])


def test_the_nearest_point_is_libigls() -> None:
    """With all triangles in reach, for points off the surface, by position alone."""
    y = Surface(*icosphere(1))
    points = np.random.default_rng(1).normal(scale=1.2, size=(300, 3))
    place = barycentric_map(points, np.zeros(300, int), y, rings=9)
    squared, _, closest = igl.point_mesh_squared_distance(points, y.vertices.copy(), y.faces.astype(np.int64))
    np.testing.assert_allclose(points_of(place, y), closest, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(points_of(place, y) - points, axis=1) ** 2, squared, atol=1e-9)
    assert place.coordinates.min() >= 0
    np.testing.assert_allclose(place.coordinates.sum(axis=1), 1, atol=1e-12)


def test_a_sheet_that_passes_close_is_not_taken() -> None:
    """A strip folded back over itself at a distance of a tenth of an edge: points midway stay with their vertex."""
    vertices, faces = grid(20)
    x, y = vertices[:, 0] * 20, vertices[:, 1] * 20
    strip = Surface(np.column_stack([np.minimum(x, 20 - x), y, np.where(x > 10, 0.1, 0.0)]), faces)
    own = np.flatnonzero((x < 7) & (y < 19))
    points = strip.vertices[own] + [0.2, 0.3, 0.09]
    place = barycentric_map(points, own, strip)
    np.testing.assert_allclose(points_of(place, strip)[:, 2], 0, atol=1e-12)
    np.testing.assert_allclose(points_of(place, strip)[:, :2], points[:, :2], atol=1e-12)
    # By position alone they would be on the other sheet.
    _, _, closest = igl.point_mesh_squared_distance(points, strip.vertices.copy(), faces.astype(np.int64))
    assert (closest[:, 2] == 0.1).all()


def test_triangles_without_area_have_sides() -> None:
    needle = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]])
    dot = np.zeros((3, 3))
    points = np.array([[2.0, 1, 0], [-1, 0, 0], [1, 2, 2]])
    weights, gaps = nearest_in_triangles(points, np.array([needle, needle, dot]))
    np.testing.assert_allclose(gaps, [1, 1, 3])
    np.testing.assert_allclose(weights @ np.array([0.0, 1, 3]), [2, 0, weights[2] @ [0, 1, 3]])
    np.testing.assert_allclose(weights.sum(axis=1), 1)


def test_values_are_interpolated_and_labels_are_not() -> None:
    y = Surface(*grid(4))
    points = np.array([[0.3, 0.55, 0], [0.9, 0.1, 0]])
    nearest = np.linalg.norm(y.vertices[:, None] - points, axis=2).argmin(axis=0)
    place = barycentric_map(points, nearest, y)
    np.testing.assert_allclose(place.pulled_back(y.vertices @ [2.0, -1, 5]), points @ [2.0, -1, 5], atol=1e-12)
    np.testing.assert_allclose(place.pulled_back(y.vertices), points, atol=1e-12)
    labels = np.arange(y.n_vertices) % 3
    np.testing.assert_array_equal(place.pulled_back(labels), labels[place.nearest_corner])
    assert place.pulled_back(labels == 1).dtype == bool


def test_place_size_and_position_do_not_matter() -> None:
    y = Surface(*blob(2))
    random = np.random.default_rng(2)
    points = y.vertices + 0.05 * random.normal(size=y.vertices.shape)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    images = np.arange(y.n_vertices)
    one = barycentric_map(points, images, y)
    other = barycentric_map(1e4 * points @ turn + 7, images, y.with_vertices(1e4 * y.vertices @ turn + 7))
    # The same points, if on an edge then in either triangle.
    np.testing.assert_allclose(points_of(one, y), points_of(other, y), atol=1e-8)


def test_what_does_not_fit_is_refused() -> None:
    y = Surface(*grid(3))
    with pytest.raises(ValueError, match=r"positions have shape \(2, 3\), expected \(3, 3\)"):
        barycentric_map(np.zeros((2, 3)), [0, 1, 2], y)
    with pytest.raises(ValueError, match="p2p"):
        barycentric_map(np.zeros((1, 3)), [99], y)
    with pytest.raises(ValueError, match="at least one ring"):
        barycentric_map(np.zeros((1, 3)), [0], y, rings=0)
    loose = Surface(np.vstack([y.vertices, [[9, 9, 9]]]), y.faces)
    with pytest.raises(ValueError, match=f"vertex {y.n_vertices} of Y, to which p2p leads, has no triangle"):
        barycentric_map(np.zeros((2, 3)), [0, y.n_vertices], loose)
