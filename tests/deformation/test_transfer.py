"""A deformation carried from one surface to another, and a surface in the pose of another one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import arched, blob, creature, cylinder, icosphere

from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.closest_points import closest_points
from qgeo_filters.deformation.pose import posed
from qgeo_filters.deformation.transfer import GradientTransfer
from qgeo_filters.surface import Surface


def moved(vertices: np.ndarray, by: list[float]) -> np.ndarray:
    return vertices + np.array(by)


def tube(n_around: int, n_along: int) -> Surface:
    """A long cylinder along y."""
    vertices, faces = cylinder(n_around, n_along, radius=0.2, height=3.0)
    return Surface(vertices[:, [1, 2, 0]], faces)


def without(place: BarycentricMap, lost: np.ndarray) -> BarycentricMap:
    known = ~lost
    return BarycentricMap(
        np.where(known, place.faces, -1),
        np.where(known[:, None], place.corners, -1),
        np.where(known[:, None], place.coordinates, np.nan),
    )


def test_a_pose_carried_to_the_same_mesh_is_the_pose() -> None:
    x = Surface(*creature())
    pose = arched(x.vertices, 0.8)
    found = GradientTransfer(x, x, closest_points(x.vertices, x), 0.2)(pose)
    np.testing.assert_allclose(found, pose, atol=1e-9)


@pytest.mark.parametrize("length", [0.1, 1.0, 100.0])
def test_the_error_falls_with_the_square_of_the_mesh_size(length: float) -> None:
    errors = []
    for n in (12, 24, 48):
        x, y = tube(n, n), tube(n + 5, n + 3)
        found = GradientTransfer(x, y, closest_points(y.vertices, x), length)(arched(x.vertices, 0.7))
        errors.append(np.abs(found - arched(y.vertices, 0.7)).max())
    assert errors[2] < 0.004
    assert errors[1] < errors[0] / 2.5
    assert errors[2] < errors[1] / 2.5


def test_a_shape_keeps_what_it_has_of_its_own() -> None:
    """A tube with rings onto which the bending of a smooth one is carried is the bent tube with rings."""
    x, y = tube(40, 60), tube(40, 60)
    rings = 1 + 0.2 * np.cos(12 * y.vertices[:, [1]])
    thick = y.with_vertices(y.vertices * np.hstack([rings, np.ones_like(rings), rings]))
    found = GradientTransfer(x, thick, closest_points(y.vertices, x), 0.2)(arched(x.vertices, 0.5))
    assert np.abs(found - arched(thick.vertices, 0.5)).max() < 0.012
    assert np.abs(arched(y.vertices, 0.5) - arched(thick.vertices, 0.5)).max() > 0.035


def test_a_map_that_is_wrong_by_half_an_edge_spoils_little() -> None:
    x, y = tube(40, 60), tube(31, 43)
    place = closest_points(y.vertices, x)
    rough = closest_points(x.vertices[place.nearest_corner], x)
    pose, truth = arched(x.vertices, 0.7), arched(y.vertices, 0.7)
    found = GradientTransfer(x, y, rough, 0.2)(pose)
    by_map = np.linalg.norm(rough.pulled_back(pose) - truth, axis=1).mean()
    assert np.linalg.norm(found - truth, axis=1).mean() < 0.2 * by_map


def test_what_has_no_partner_goes_with_what_is_near() -> None:
    x, y = tube(24, 36), tube(20, 30)
    place = closest_points(y.vertices, x)
    turn = Rotation.from_rotvec([0, 0, 1.0]).as_matrix()
    found = GradientTransfer(x, y, without(place, y.vertices[:, 1] > 2.0), 0.2)(x.vertices @ turn.T)
    np.testing.assert_allclose(found, y.vertices @ turn.T, atol=1e-9)


def test_a_piece_without_any_partner_goes_where_its_neighbour_goes() -> None:
    x = Surface(*blob(2))
    ball, faces = icosphere(1, 0.1)
    y = Surface(np.concatenate([x.vertices, moved(ball, [3, 0, 0])]), np.concatenate([x.faces, faces + x.n_vertices]))
    lost = np.arange(y.n_vertices) >= x.n_vertices
    place = without(closest_points(y.vertices, x), lost)
    turn = Rotation.from_rotvec([0, 0.7, 0]).as_matrix()
    found = GradientTransfer(x, y, place, 0.2)(x.vertices @ turn.T + [0, 0, 4])
    np.testing.assert_allclose(found, y.vertices @ turn.T + [0, 0, 4], atol=1e-6)


def test_a_piece_without_any_target_keeps_its_place_beside_what_is_nearest_to_it() -> None:
    """As the eyes of a head of which only the skin is mapped."""
    body = Surface(*blob(2))
    (ball, faces), n = icosphere(1, 0.1), body.n_vertices
    eyes = [moved(ball, [0.4 * side, 0, 1.5]) for side in (-1, 1)]
    whole = Surface(
        np.concatenate([body.vertices, *eyes, [[5, 5, 5]]]),
        np.concatenate([body.faces, faces + n, faces + n + len(ball)]),
    )
    turn = Rotation.from_rotvec([0.3, 0.7, 0]).as_matrix()
    truth = whole.vertices @ turn.T + [0, 0, 4]
    targets = np.where(np.arange(whole.n_vertices)[:, None] < n, truth, np.nan)
    np.testing.assert_allclose(posed(whole, targets, 0.05, 0.05), truth, atol=1e-5)


def test_a_triangle_torn_by_the_map_does_not_reach_for_what_lies_between() -> None:
    x = Surface(*creature())
    place = closest_points(x.vertices, x)
    swapped = place.faces.copy()
    swapped[:20] = place.faces[-20:]
    torn = BarycentricMap(swapped, x.faces[swapped].astype(np.int64), place.coordinates)
    found = GradientTransfer(x, x, torn, 0.2)(arched(x.vertices, 0.5))
    right = np.linalg.norm(found - arched(x.vertices, 0.5), axis=1)
    assert np.isfinite(found).all()
    assert np.median(right) < 0.02


@pytest.mark.parametrize("placing", [0.05, 1.0])
def test_a_tube_takes_the_pose_of_a_bent_one_and_keeps_its_lengths(placing: float) -> None:
    y = tube(24, 36)
    truth = arched(y.vertices, 0.7)
    targets = truth + 0.01 * np.random.default_rng(0).normal(size=truth.shape)
    targets[y.vertices[:, 0] > 0.15] = np.nan  # as where a map has no partner
    found = posed(y, targets, 0.1, placing)
    lengths = [np.linalg.norm(p[y.edges[:, 0]] - p[y.edges[:, 1]], axis=1) for p in (y.vertices, found, truth)]
    assert np.linalg.norm(found - truth, axis=1).mean() < 0.03
    assert np.abs(lengths[1] / lengths[0] - 1).mean() < 0.06
    assert np.abs(lengths[2] / lengths[0] - 1).mean() > 0.05  # what is bent is stretched by as much
