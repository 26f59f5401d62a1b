"""The axis of a symmetry as curves and as a plane: of exact symmetries, and of real poses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shapes import blob, creature, icosphere, torus

import qgeo_filters as qg
from qgeo_filters.evaluation import ToscaRemeshed
from qgeo_filters.matching.mirror_curve import left_right_difference, mirror_plane, zero_curves
from qgeo_filters.surface import Surface


def test_zeros_of_a_height_on_a_sphere_are_a_circle() -> None:
    surface = Surface(*icosphere(4))
    (line,) = zero_curves(surface, surface.vertices @ [0.3, -0.2, 1.0] - 0.31)
    np.testing.assert_array_equal(line[0], line[-1])
    distance = 0.31 / np.linalg.norm([0.3, -0.2, 1.0])
    length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    assert length == pytest.approx(2 * np.pi * np.sqrt(1 - distance**2), rel=0.01)
    assert len(np.unique(line, axis=0)) == len(line) - 1


def test_several_lines_come_by_length_and_open_ones_from_end_to_end() -> None:
    ring = Surface(*torus(60, 30))
    lines = zero_curves(ring, ring.vertices[:, 2] - 1e-4)
    assert len(lines) == 2  # an outer and an inner circle
    outer, inner = (np.hypot(*line[:, :2].T).mean() for line in lines)
    assert outer > inner
    vertices, faces = icosphere(3)
    half = Surface(vertices, faces).submesh(vertices[:, 0] > -0.01)[0]
    (line,) = zero_curves(half, half.vertices[:, 2] - 1e-4)
    assert np.linalg.norm(line[0] - line[-1]) > 1.5
    assert zero_curves(half, np.ones(half.n_vertices)) == ()


@pytest.mark.parametrize("seed", range(3))
def test_the_plane_of_a_reflected_shape_is_found(seed: int) -> None:
    random = np.random.default_rng(seed)
    vertices, faces = blob(3, seed)
    surface = Surface(vertices + np.array([3.0, -1.0, 2.0]), faces)
    normal, offset = random.normal(size=3), random.normal()
    normal /= np.linalg.norm(normal)
    images = surface.vertices - 2 * (surface.vertices @ normal - offset)[:, None] * normal
    plane = mirror_plane(surface, images)
    assert abs(plane.normal @ normal) == pytest.approx(1)
    assert plane.origin @ normal == pytest.approx(offset)
    assert plane.deviation < 1e-12
    np.testing.assert_allclose(plane.reflected(surface.vertices), images, atol=1e-9)
    images[::7] = np.nan  # vertices that are gone
    assert mirror_plane(surface, images).deviation < 1e-12


def test_what_one_side_has_more_is_measured_along_the_normal() -> None:
    vertices, faces = icosphere(4)
    ball = Surface(vertices, faces)
    images = vertices * [-1, 1, 1]
    np.testing.assert_allclose(left_right_difference(ball, images), 0.0, atol=1e-12)
    # A bump of height .05 on one side, of a width over which the normals hardly turn.
    bump = 0.05 * np.exp(-20 * np.linalg.norm(vertices - [0.8, 0.6, 0], axis=1) ** 2)
    mirror = np.linalg.norm(images[:, None] - vertices, axis=2).argmin(axis=1)
    np.testing.assert_allclose(vertices[mirror], images, atol=1e-9)
    lumpy = ball.with_vertices(vertices * (1 + bump)[:, None])
    difference = left_right_difference(lumpy, lumpy.vertices[mirror])
    top = bump.argmax()
    assert difference[top] == pytest.approx(bump[top], rel=0.05)
    assert difference[mirror[top]] == pytest.approx(-bump[top], rel=0.05)
    assert np.abs(difference[bump + bump[mirror] < 1e-6]).max() < 0.004  # but for the plane, which the bump moves
    gone = lumpy.vertices[mirror].copy()
    gone[7] = np.nan
    assert np.isnan(left_right_difference(lumpy, gone)[7])
    assert np.isfinite(np.delete(left_right_difference(lumpy, gone), 7)).all()
    # In the unit of the mesh, and whatever its place.
    moved = lumpy.with_vertices(10 * lumpy.vertices @ np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]) + 5)
    np.testing.assert_allclose(left_right_difference(moved, moved.vertices[mirror]), 10 * difference, atol=1e-9)


def test_a_creature_has_a_plane_and_a_mirror_point_for_every_vertex() -> None:
    """Symmetric in x = 0 but for its mesh, of which one half is moved about a little."""
    vertices, faces = creature(level=2)
    surface = Surface(vertices, faces)
    found = qg.self_symmetry(surface)
    assert found.found, found.reason
    scale = np.sqrt(surface.area)
    true = vertices * [-1, 1, 1]
    points = found.barycentric.pulled_back(vertices)
    assert np.linalg.norm(points - true, axis=1).mean() < 0.01 * scale
    assert found.plane is not None
    assert abs(found.plane.normal[0]) > 0.999
    assert abs(found.plane.origin[0]) < 0.01 * scale
    # The axis lies in the plane, and goes all around.
    assert np.abs(found.curve[0][:, 0]).max() < 0.05 * scale
    np.testing.assert_array_equal(found.curve[0][0], found.curve[0][-1])


def test_what_has_no_symmetry_has_no_axis() -> None:
    surface = Surface(*blob(2, 4, 0.35))
    found = qg.self_symmetry(surface)
    assert not found.found
    assert found.curve == ()
    assert found.plane is None
    np.testing.assert_allclose(found.barycentric.pulled_back(surface.vertices), surface.vertices, atol=1e-12)


@pytest.mark.slow
def test_mirror_points_within_triangles_are_nearer_to_the_truth_than_vertices(data_dir: Path) -> None:
    data = ToscaRemeshed(data_dir / "tosca")
    surface, truth = data.read("cat0"), data.symmetry("cat0")
    found = qg.self_symmetry(surface)
    true = surface.vertices[truth.images]
    points = found.barycentric.pulled_back(surface.vertices)[truth.points]
    to_points = np.linalg.norm(points - true, axis=1).mean()
    assert to_points < np.linalg.norm(surface.vertices[found.p2p][truth.points] - true, axis=1).mean()
    assert to_points < 0.01 * np.sqrt(surface.area)
    assert found.plane is not None  # it stands straight
