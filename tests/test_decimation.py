"""Proxies: topology, orientation and shape are kept, and every vertex of the original has its place."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from shapes import blob, cylinder, grid, icosphere, torus

from qgeo_filters.decimation import Proxy, decimated
from qgeo_filters.errors import DisconnectedError, NonManifoldError, ParameterError
from qgeo_filters.surface import Surface

SHAPES = {
    "blob": Surface(*blob(4)),
    "torus": Surface(*torus(60, 40)),
    "cylinder": Surface(*cylinder(60, 40)),
    "square": Surface(*grid(40, jitter=0.2)),
}


def rotation() -> np.ndarray:
    q, r = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.linalg.det(q)


def gaps(surface: Surface, proxy: Proxy) -> np.ndarray:
    """From each vertex to its place on the proxy, in units of sqrt(area)."""
    return np.linalg.norm(proxy.pulled_back(proxy.surface.vertices) - surface.vertices, axis=1) / surface.area**0.5


def require_sound(surface: Surface, proxy: Proxy) -> None:
    coarse = proxy.surface
    assert coarse.is_manifold
    assert coarse.is_oriented
    assert coarse.components[0] == 1
    assert coarse.genus == surface.genus
    assert len(coarse.boundary_loops) == len(surface.boundary_loops)
    assert coarse.vertex_areas.min() > 0
    assert coarse.attributes == {}
    assert proxy.faces.shape == (surface.n_vertices,)
    assert np.array_equal(proxy.corners, coarse.faces[proxy.faces])
    assert proxy.coordinates.min() >= 0
    np.testing.assert_allclose(proxy.coordinates.sum(axis=1), 1, atol=1e-12)
    assert proxy.vertices.shape == (coarse.n_vertices,)
    assert len(np.unique(proxy.vertices)) == coarse.n_vertices
    for array in (proxy.faces, proxy.corners, proxy.coordinates, proxy.vertices):
        assert not array.flags.writeable


@pytest.mark.parametrize("name", SHAPES)
def test_topology_and_shape_are_kept(name: str) -> None:
    surface = SHAPES[name]
    proxy = decimated(surface, 400)
    require_sound(surface, proxy)
    assert proxy.surface.n_vertices == 400
    assert gaps(surface, proxy).max() < 0.02
    assert abs(proxy.surface.area / surface.area - 1) < 0.02
    # the normal of the triangle where a vertex has its place looks the same way
    agreement = np.einsum("ij,ij->i", proxy.surface.face_normals[proxy.faces], surface.vertex_normals)
    assert np.quantile(agreement, 0.01) > 0.8


@pytest.mark.parametrize("name", SHAPES)
def test_vertices_stand_for_those_of_the_proxy(name: str) -> None:
    surface = SHAPES[name]
    proxy = decimated(surface, 400)
    away = np.linalg.norm(surface.vertices[proxy.vertices] - proxy.surface.vertices, axis=1)
    assert away.max() < 2 * surface.edge_lengths.max()
    normals = surface.vertex_normals[proxy.vertices]
    assert (np.einsum("ij,ij->i", normals, proxy.surface.vertex_normals) > 0).all()
    # and each has its place close by
    there = proxy.pulled_back(proxy.surface.vertices)[proxy.vertices]
    assert np.linalg.norm(there - proxy.surface.vertices, axis=1).max() < 2 * surface.edge_lengths.max()


def test_values_come_back() -> None:
    surface = SHAPES["blob"]
    proxy = decimated(surface, 600)
    direction = np.array([0.3, -0.5, 0.8])
    linear = proxy.pulled_back(proxy.surface.vertices @ direction)
    assert np.abs(linear - surface.vertices @ direction).max() < 0.02 * surface.area**0.5
    labels = proxy.pulled_back(np.arange(proxy.surface.n_vertices))
    assert labels.dtype.kind == "i"
    assert np.array_equal(labels, proxy.nearest_corner)
    assert proxy.pulled_back(proxy.surface.vertices[:, 0] > 0).dtype == bool


def test_a_small_surface_is_its_own_proxy() -> None:
    surface = Surface(*blob(2))
    for n in (surface.n_vertices, surface.n_vertices + 1, 10**6):
        proxy = decimated(surface, n)
        assert proxy.surface is surface
        require_sound(surface, proxy)
        assert np.array_equal(proxy.vertices, np.arange(surface.n_vertices))
        assert np.array_equal(proxy.nearest_corner, np.arange(surface.n_vertices))
        assert np.array_equal(proxy.pulled_back(surface.vertices), surface.vertices)


def test_the_same_again_and_after_a_rigid_motion_and_scaling() -> None:
    surface = SHAPES["blob"]
    proxy, again = decimated(surface, 400), decimated(surface, 400)
    assert np.array_equal(proxy.surface.vertices, again.surface.vertices)
    assert np.array_equal(proxy.surface.faces, again.surface.faces)
    assert np.array_equal(proxy.vertices, again.vertices)
    assert np.array_equal(decimated(surface.with_vertices(1024 * surface.vertices), 400).faces, proxy.faces)
    for scale, shift in ((1.0, 0.0), (1e-9, 0.0), (1e9, 0.0), (1.0, 1e5)):
        moved = surface.with_vertices(scale * (surface.vertices @ rotation().T) + shift)
        other = decimated(moved, 400)
        require_sound(moved, other)
        assert other.surface.n_vertices == proxy.surface.n_vertices
        difference = np.abs(gaps(moved, other) - gaps(surface, proxy))
        assert np.median(difference) < 1e-6
        assert gaps(moved, other).max() < 1.5 * gaps(surface, proxy).max()


def test_handles_and_boundaries_stay_at_few_vertices() -> None:
    for name, n in (("torus", 60), ("cylinder", 40), ("square", 20)):
        proxy = decimated(SHAPES[name], n)
        require_sound(SHAPES[name], proxy)
        assert proxy.surface.n_vertices == n


def test_the_boundary_stays_in_its_place() -> None:
    surface = SHAPES["square"]
    coarse = decimated(surface, 200).surface
    rim = coarse.vertices[coarse.boundary_vertices]
    assert np.abs(np.abs(rim[:, :2] - 0.5).max(axis=1) - 0.5).max() < 0.02
    assert abs(coarse.area - 1) < 0.02


def test_vertices_without_faces_have_their_place_too() -> None:
    whole = SHAPES["blob"]
    lone = 1.1 * whole.vertices[:3]
    surface = Surface(np.vstack([lone, whole.vertices]), whole.faces + 3)
    proxy = decimated(surface, 400)
    assert proxy.faces.shape == (surface.n_vertices,)
    assert gaps(surface, proxy)[:3].max() < 0.1
    assert (proxy.vertices >= 3).all()
    small = decimated(surface, surface.n_vertices)
    assert small.surface is surface
    assert gaps(surface, small)[3:].max() == 0


def test_triangles_without_area_are_no_hindrance() -> None:
    vertices, faces = (array.copy() for array in blob(4))
    for a, b, c in faces[:600:40]:  # a corner slides into the middle of the opposite side
        vertices[a] = (vertices[b] + vertices[c]) / 2
    surface = Surface(vertices, faces)
    assert surface.face_areas.min() < 1e-12
    require_sound(surface, decimated(surface, 400))


def test_a_very_anisotropic_surface() -> None:
    vertices, faces = igl.upsample(*(array.copy() for array in cylinder(200, 6, height=20.0)))
    surface = Surface(vertices, faces)
    proxy = decimated(surface, 300)
    require_sound(surface, proxy)
    assert gaps(surface, proxy).max() < 0.02


def test_sheets_that_lie_close_are_not_confused() -> None:
    vertices, faces = (array.copy() for array in icosphere(5))
    vertices[:, 2] *= 0.004  # a lens, thinner than the sides of the proxy's triangles
    surface = Surface(vertices, faces)
    proxy = decimated(surface, 300)
    # beyond the rim, where above and below meet
    inner = np.linalg.norm(vertices[:, :2], axis=1) < 0.7
    normals = proxy.surface.face_normals[proxy.faces][:, 2]
    assert (np.sign(normals) == np.sign(vertices[:, 2]))[inner & (vertices[:, 2] != 0)].all()


def test_what_cannot_be_a_proxy_is_refused() -> None:
    for n in (3, 0, -1, 2.5, True):
        with pytest.raises(ParameterError, match="n_vertices"):
            decimated(SHAPES["blob"], n)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="n_vertices = 4 cannot be reached"):
        decimated(SHAPES["torus"], 4)
    two = SHAPES["blob"]
    apart = Surface(np.vstack([two.vertices, two.vertices + 5]), np.vstack([two.faces, two.faces + two.n_vertices]))
    with pytest.raises(DisconnectedError):
        decimated(apart, 100)
    fan = Surface([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    with pytest.raises(NonManifoldError):
        decimated(fan, 4)
