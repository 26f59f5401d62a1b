"""The way from one pose to another: exact at its ends, rigid where it can be, and unwinding what was wound up."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import arched, blob, creature, cylinder, icosphere

from qgeo_filters.deformation.fit_rotations import fit_rotations
from qgeo_filters.deformation.frame_lanes import LANES
from qgeo_filters.deformation.gradients import TriangleFrames
from qgeo_filters.deformation.interpolation import InterpolationPath
from qgeo_filters.deformation.poisson import PoissonSolver, area_shares
from qgeo_filters.deformation.rotation_walk import RotationWalk
from qgeo_filters.deformation.similarity import Similarity
from qgeo_filters.surface import Surface


def moved(vertices: np.ndarray, by: list[float]) -> np.ndarray:
    return vertices + np.array(by)


def lengths(surface: Surface, positions: np.ndarray) -> np.ndarray:
    ends = positions[surface.edges]
    return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)


def volume(surface: Surface, positions: np.ndarray) -> float:
    a, b, c = (positions[surface.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def test_the_ends_are_exact() -> None:
    start = Surface(*creature())
    end = arched(start.vertices, 1.0) * 1.3 + 0.05 * np.random.default_rng(0).normal(size=start.vertices.shape)
    way = InterpolationPath(start, end)
    np.testing.assert_allclose(way(0.0), start.vertices, atol=1e-9)
    np.testing.assert_allclose(way(1.0), end, atol=1e-9)


@pytest.mark.parametrize("angle", [1.0, 2.0, 3.1])
def test_a_rigid_motion_is_rigid_on_the_way(angle: float) -> None:
    start = Surface(*blob(2))
    axis = np.array([1.0, 2.0, -1.0]) / np.sqrt(6)
    end = start.vertices @ Rotation.from_rotvec(angle * axis).as_matrix().T + [4, 0, 1]
    middle = InterpolationPath(start, end)(0.5)
    np.testing.assert_allclose(lengths(start, middle), lengths(start, start.vertices), rtol=1e-6)
    turned = start.vertices @ Rotation.from_rotvec(0.5 * angle * axis).as_matrix().T
    np.testing.assert_allclose(middle - middle.mean(axis=0), turned - turned.mean(axis=0), atol=1e-6)


def test_growth_is_even() -> None:
    start = Surface(*blob(2))
    found = InterpolationPath(start, 3 * start.vertices)(0.25)
    np.testing.assert_allclose(lengths(start, found), 1.5 * lengths(start, start.vertices), rtol=1e-6)


@pytest.mark.parametrize("turns", [0.4, 1.5, 3.0])
def test_a_rod_that_was_wound_up_unwinds(turns: float) -> None:
    """Twisted by three turns, its end is turned by one and a half in the middle, not by none or by half a one."""
    vertices, faces = cylinder(24, 120, radius=0.1, height=3.0)
    start = Surface(vertices, faces)

    def twisted(share: float) -> np.ndarray:
        angle = 2 * np.pi * turns * share * (vertices[:, 2] / 3.0 - 0.5)
        x, y, z = vertices.T
        return np.column_stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle), z])

    found = InterpolationPath(start, twisted(1.0))(0.5)
    back = Similarity.between(found, twisted(0.5), np.ones(len(found)), 1.0)  # the whole may be turned either way
    assert np.linalg.norm(back(found) - twisted(0.5), axis=1).max() < 0.07


def test_a_creature_that_bends_neither_shrinks_nor_stretches() -> None:
    start = Surface(*creature())
    end = arched(start.vertices, 1.2)
    for t in (0.25, 0.5, 0.75):
        found = InterpolationPath(start, end)(t)
        blend = (1 - t) * lengths(start, start.vertices) + t * lengths(start, end)
        assert np.abs(lengths(start, found) / blend - 1).mean() < 0.015
        expected = (1 - t) * volume(start, start.vertices) + t * volume(start, end)
        assert volume(start, found) == pytest.approx(expected, rel=0.03)


def test_the_way_back_is_the_way_there() -> None:
    start = Surface(*creature())
    end = arched(start.vertices, 1.0)
    there, back = InterpolationPath(start, end), InterpolationPath(start.with_vertices(end), start.vertices)
    assert np.linalg.norm(there(0.3) - back(0.7), axis=1).max() < 0.02 * np.sqrt(start.area)


def test_pieces_each_go_their_own_way() -> None:
    vertices, faces = icosphere(1)
    start = Surface(
        np.concatenate([vertices, moved(vertices, [4, 0, 0])]), np.concatenate([faces, faces + len(vertices)])
    )
    end = np.concatenate([moved(vertices, [0, 2, 0]), moved(vertices, [4, -2, 0])])
    found = InterpolationPath(start, end)(0.5)
    assert np.abs(lengths(start, found) / lengths(start, start.vertices) - 1).max() < 0.02


def test_flat_triangles_and_vertices_without_any_are_borne() -> None:
    vertices, faces = blob(2)
    start = Surface(np.vstack([vertices, [9.0, 9, 9], vertices[:1]]), np.vstack([faces, [[0, 1, len(vertices) + 1]]]))
    end = moved(start.vertices, [1.0, 0, 0])
    found = InterpolationPath(start, end)(0.5)
    np.testing.assert_allclose(found[: len(vertices)], moved(vertices, [0.5, 0, 0]), atol=1e-4)
    assert np.isfinite(found).all()


def one_after_the_other(start: Surface, end: np.ndarray, times: np.ndarray) -> list[np.ndarray]:
    """The method as it is written, by matrices of each triangle and one solve after the other."""
    shares = area_shares(start)
    frames = TriangleFrames(start.vertices, start.faces)
    whole = Similarity.between(start.vertices, end, shares, 1.0)
    turn = Rotation.from_matrix(whole.rotation).as_rotvec()
    gradients = frames.gradients(end @ whole.rotation)
    rotations = fit_rotations(gradients)
    walk = RotationWalk(rotations, start.twins)
    stretches = np.einsum("tji,tjk->tik", rotations, gradients)
    solve = PoissonSolver(start.vertices, start.faces, 1e-6 * shares)
    found = []
    for t in times:
        stretch = (1 - t) * np.eye(3) + t * stretches
        targets = (1 - t) * start.vertices + t * end @ whole.rotation
        turned = Rotation.from_quat(walk(np.full(LANES, t))[:, [1, 2, 3, 0], 0]).as_matrix()
        positions = solve(turned @ stretch, targets)
        for _ in range(4 if 0 < t < 1 else 0):
            fitted = fit_rotations(frames.gradients(positions) @ stretch.transpose(0, 2, 1))
            positions = solve(fitted @ stretch, targets)
        share = shares / shares.sum()
        centre = (1 - t) * share @ start.vertices + t * share @ end
        about = Rotation.from_rotvec(t * turn).as_matrix()
        found.append((positions - share @ positions) @ about.T + centre)
    return found


@pytest.mark.parametrize("count", [1, 3, LANES, LANES + 2])
def test_frames_side_by_side_are_those_of_the_method_one_after_the_other(count: int) -> None:
    """Two triangles without area among them, of which nothing is known."""
    vertices, faces = blob(2)
    vertices = vertices.copy()
    vertices[faces[7, 0]] = vertices[faces[7, 1]]
    start = Surface(vertices, faces)
    assert (TriangleFrames(start.vertices, start.faces).flat).sum() == 2
    end = arched(start.vertices, 0.7) * [1, 1.2, 1] + 0.01 * np.random.default_rng(0).normal(size=vertices.shape)
    times = np.linspace(0, 1, count + 2)[1:] if count > 1 else np.array([0.3])
    found = list(InterpolationPath(start, end).frames(times))
    for frame, t, expected in zip(found, times, one_after_the_other(start, end, times), strict=True):
        np.testing.assert_allclose(frame, expected, atol=1e-9)
        np.testing.assert_allclose(frame, InterpolationPath(start, end)(t), atol=1e-12)


def test_rotations_along_the_walk_are_the_given_ones_at_its_end() -> None:
    start = Surface(*blob(2))
    given = Rotation.random(start.n_faces, random_state=0).as_matrix()
    times = np.r_[0.0, 1.0, np.full(LANES - 2, 0.5)]
    found = RotationWalk(given, start.twins)(times)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(Rotation.from_quat(found[:, [1, 2, 3, 0], 1]).as_matrix(), given, atol=1e-10)
    np.testing.assert_allclose(np.abs(found[:, 0, 0]), 1, atol=1e-12)
