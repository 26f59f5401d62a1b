"""Collapse of edges on its own: quadrics, the link condition down to the smallest meshes, and places."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob, cylinder, grid, icosphere, torus

from qgeo_filters.barycentric import nearest_in_triangles
from qgeo_filters.decimation import decimated
from qgeo_filters.edge_collapse.collapse import collapsed
from qgeo_filters.edge_collapse.places import nearest_places
from qgeo_filters.edge_collapse.quadrics import vertex_quadrics
from qgeo_filters.errors import ParameterError
from qgeo_filters.surface import Surface


def arguments(surface: Surface) -> tuple[np.ndarray, ...]:
    """What `collapsed` takes of a surface."""
    rim = np.zeros(len(surface.edges), dtype=bool)
    rim[surface.boundary_edges] = True
    return surface.vertices.copy(), surface.faces.copy(), surface.face_edges, surface.edges.copy(), rim


def moebius(n: int = 40) -> Surface:
    """A strip with a half turn, three vertices wide."""
    t, w = np.meshgrid(np.linspace(0, 2 * np.pi, n, endpoint=False), [-0.3, 0.0, 0.3], indexing="ij")
    r = 1 + w * np.cos(t / 2)
    vertices = np.stack([r * np.cos(t), r * np.sin(t), w * np.sin(t / 2)], axis=-1).reshape(-1, 3)
    faces = []
    for i in range(n):
        for j in range(2):
            a, b = 3 * i + j, 3 * i + j + 1
            c, d = (3 * (i + 1) + j, 3 * (i + 1) + j + 1) if i < n - 1 else (2 - j, 1 - j)
            faces += [[a, c, b], [b, c, d]]
    return Surface(vertices, faces)


def random_disc(seed: int) -> Surface:
    """A square with holes: random triangles are taken out as long as it stays a manifold in one piece."""
    rng = np.random.default_rng(seed)
    surface = Surface(*grid(14, jitter=0.3, seed=seed))
    keep = np.ones(surface.n_faces, dtype=bool)
    for f in rng.permutation(surface.n_faces)[:40]:
        keep[f] = False
        trial = Surface(surface.vertices, surface.faces[keep])
        if not trial.is_manifold or trial.components[0] > 1:
            keep[f] = True
    return Surface(surface.vertices, surface.faces[keep])


SHAPES = {
    "sphere": Surface(*icosphere(3)),
    "torus": Surface(*torus(24, 16)),
    "cylinder": Surface(*cylinder(24, 12)),
    "moebius": moebius(),
    "holes 1": random_disc(1),
    "holes 2": random_disc(2),
}


def test_quadrics_are_the_squared_distances_they_stand_for() -> None:
    surface = Surface(*blob(2))
    points, faces, face_edges, _, rim = arguments(surface)
    quadrics = vertex_quadrics(points, faces, face_edges, rim)
    rng = np.random.default_rng(0)
    for v in (0, 17, 100):
        x = points[v] + 0.1 * rng.normal(size=3)
        around = np.flatnonzero((faces == v).any(axis=1))
        planes = np.einsum("ij,ij->i", surface.face_normals[around], x - points[faces[around, 0]]) ** 2
        expected = surface.face_areas[around] @ planes
        normal = (surface.face_areas[around, None] * surface.face_normals[around]).sum(axis=0)
        normal /= np.linalg.norm(normal)
        away = x - points[v]
        line = away @ away - (away @ normal) ** 2
        a = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
        q = quadrics[v]
        value = x @ q[a] @ x - 2 * q[6:9] @ x + q[9]
        weight = (value - expected) / (surface.vertex_areas[v] * line)
        assert 1e-5 < weight < 0.1
        np.testing.assert_allclose(weight, 1e-3, rtol=1e-6)


def test_a_plane_loses_no_area_and_no_corner() -> None:
    surface = Surface(*grid(20, jitter=0.2))
    points, faces, merged = collapsed(*arguments(surface), n_vertices=60)
    assert len(points) == 60
    coarse = Surface(points, faces)
    np.testing.assert_allclose(points[:, 2], 0, atol=1e-12)
    assert (coarse.face_normals[:, 2] > 0.999).all()
    assert abs(coarse.area - 1) < 0.005
    corners = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]])
    assert np.linalg.norm(points[:, None] - corners, axis=2).min(axis=0).max() < 0.03
    assert np.array_equal(np.unique(merged), np.arange(60))


@pytest.mark.parametrize("name", SHAPES)
def test_the_topology_is_kept_down_to_the_smallest_mesh(name: str) -> None:
    surface = SHAPES[name]
    reached = surface.n_vertices
    for n in (150, 100, 70, 50, 40, 30, 25, 20, 15, 12, 10, 9, 8, 7, 6, 5, 4):
        points, faces, merged = collapsed(*arguments(surface), n_vertices=n)
        coarse = Surface(points, faces)
        assert coarse.is_manifold
        assert coarse.unreferenced_vertices.size == 0
        assert coarse.components[0] == 1
        assert coarse.is_oriented == surface.is_oriented
        assert coarse.euler_characteristic == surface.euler_characteristic
        assert len(coarse.boundary_loops) == len(surface.boundary_loops)
        assert len(points) >= min(n, surface.n_vertices)
        assert np.array_equal(np.unique(merged), np.arange(len(points)))
        reached = min(reached, len(points))
        # every edge of a mesh leads from a vertex to itself or to a neighbour
        a, b = merged[surface.edges].T
        joined = {tuple(edge) for edge in np.sort(coarse.edges, axis=1).tolist()}
        assert all(i == j or (min(i, j), max(i, j)) in joined for i, j in zip(a.tolist(), b.tolist(), strict=True))
    assert reached <= {"sphere": 6, "torus": 20, "cylinder": 12, "moebius": 20}.get(name, 120)


def test_too_few_vertices_for_the_holes_are_refused() -> None:
    surface = SHAPES["holes 1"]
    assert len(surface.boundary_loops) > 10
    with pytest.raises(ParameterError, match=r"n_vertices = 8 cannot be reached: with [0-9]+ vertices"):
        decimated(surface, 8)


def test_places_are_the_nearest() -> None:
    surface = Surface(*blob(2))
    rng = np.random.default_rng(3)
    starts = rng.integers(surface.n_vertices, size=200)
    points = surface.vertices[starts] + 0.05 * rng.normal(size=(200, 3))
    faces, weights = nearest_places(points, starts, surface.vertices.copy(), surface.faces.copy())
    found = np.linalg.norm(np.einsum("ij,ijk->ik", weights, surface.vertices[surface.faces[faces]]) - points, axis=1)
    triangles = surface.vertices[surface.faces]
    for i, point in enumerate(points):
        _, gaps = nearest_in_triangles(np.tile(point, (surface.n_faces, 1)), triangles)
        assert found[i] == pytest.approx(gaps.min(), abs=1e-12)


def test_places_of_points_on_needles_and_dots() -> None:
    needle = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 0, 0]])
    dot = np.array([[3.0, 0, 0]] * 3)
    vertices, faces = np.vstack([needle, dot]), np.array([[0, 1, 2], [3, 4, 5]], dtype=np.int32)
    points = np.array([[0.25, 1, 0], [-1, 0, 0], [2, 0, 0], [3, 0, 2.0]])
    found, weights = nearest_places(points, np.array([0, 0, 2, 4]), vertices, faces)
    assert found.tolist() == [0, 0, 0, 1]
    places = np.einsum("ij,ijk->ik", weights, vertices[faces[found]])
    np.testing.assert_allclose(places, [[0.25, 0, 0], [0, 0, 0], [1, 0, 0], [3, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(weights.sum(axis=1), 1)
    assert weights.min() >= 0
