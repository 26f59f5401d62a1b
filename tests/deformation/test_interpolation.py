"""The way from one pose to another: exact at its ends, rigid where it can be, and unwinding what was wound up."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from shapes import arched, blob, creature, cylinder, grid, icosphere

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
    walk = RotationWalk(rotations, start, end)
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
    wanted = Rotation.random(start.n_faces, random_state=0).as_matrix()
    times = np.r_[0.0, 1.0, np.full(LANES - 2, 0.5)]
    found = RotationWalk(wanted, start, start.vertices)(times)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(Rotation.from_quat(found[:, [1, 2, 3, 0], 1]).as_matrix(), wanted, atol=1e-10)
    np.testing.assert_allclose(np.abs(found[:, 0, 0]), 1, atol=1e-12)


def saddle() -> tuple[Surface, np.ndarray]:
    vertices, faces = grid(16)
    x, y, _ = ((vertices - vertices.mean(axis=0)) / np.ptp(vertices[:, 0])).T
    return Surface(vertices, faces), np.ptp(vertices[:, 0]) * np.column_stack([x, y, x**2 - y**2])


def grown_along_axes() -> tuple[Surface, np.ndarray]:
    vertices, faces = icosphere(2)
    return Surface(vertices, faces), vertices**3 + 0.2 * vertices


def wound_up() -> tuple[Surface, np.ndarray]:
    """By one and a half turns: the whole is turned by a half, which goes either way."""
    vertices, faces = cylinder(12, 30, radius=0.2, height=3.0)
    angle = 3 * np.pi * (vertices[:, 2] / 3.0 - 0.5)
    x, y, z = vertices.T
    turned = np.column_stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle), z])
    return Surface(vertices, faces), turned


def folded_creature() -> tuple[Surface, np.ndarray]:
    vertices, faces = creature()
    return Surface(vertices, faces), arched(vertices, 1.2)


SYMMETRIC = {make.__name__: make for make in (saddle, grown_along_axes, wound_up, folded_creature)}


@pytest.mark.parametrize("name", SYMMETRIC)
@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_frames_do_not_depend_on_the_order_of_vertices_and_triangles(name: str, seed: int) -> None:
    """Of symmetric shapes, whose triangles turn alike in many places, so that only rounding tells their steps apart."""
    start, end = SYMMETRIC[name]()
    rng = np.random.default_rng(seed)
    order, triangles = rng.permutation(start.n_vertices), rng.permutation(start.n_faces)
    corners = (rng.integers(0, 3, start.n_faces)[:, None] + np.arange(3)) % 3
    faces = np.take_along_axis(np.argsort(order)[start.faces[triangles]], corners, axis=1)
    shuffled = InterpolationPath(Surface(start.vertices[order], faces), end[order])
    times = np.array([0.25, 0.5, 0.75])
    for found, expected in zip(shuffled.frames(times), InterpolationPath(start, end).frames(times), strict=True):
        np.testing.assert_allclose(found, expected[order], atol=1e-9 * np.sqrt(start.area))


@pytest.mark.parametrize("name", [name for name in SYMMETRIC if name != "wound_up"])  # has no turn of its own
@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_rigid_motion_of_the_end_moves_the_frames_rigidly(name: str, seed: int) -> None:
    start, end = SYMMETRIC[name]()
    moved_end = end @ Rotation.random(random_state=seed).as_matrix().T + np.random.default_rng(seed).normal(size=3)
    found, expected = (InterpolationPath(start, other)(0.5) for other in (moved_end, end))
    np.testing.assert_allclose(lengths(start, found), lengths(start, expected), atol=1e-9 * np.sqrt(start.area))
    back = Similarity.between(found, expected, np.ones(len(found)), 1.0)
    np.testing.assert_allclose(back(found), expected, atol=1e-9 * np.sqrt(start.area))


@pytest.mark.parametrize("name", ["saddle", "grown_along_axes"])
def test_noise_of_single_precision_hardly_changes_frames(name: str) -> None:
    """It takes the tree along other ways; without what neighbours agree on, that is .01 sqrt(area)."""
    start, end = SYMMETRIC[name]()
    expected = InterpolationPath(start, end)(0.5)
    for seed in range(4):
        noise = 1e-7 * np.sqrt(start.area) * np.random.default_rng(seed).normal(size=end.shape)
        found = InterpolationPath(start.with_vertices(start.vertices + noise), end)(0.5)
        back = Similarity.between(found, expected, np.ones(len(found)), 1.0)
        assert np.linalg.norm(back(found) - expected, axis=1).max() < 6e-4 * np.sqrt(start.area)


def test_half_a_turn_goes_one_way_whatever_rounding_says() -> None:
    start = Surface(*blob(2))
    half = Rotation.from_rotvec([0, 0, np.pi]).as_matrix()
    middles = [InterpolationPath(start, start.vertices @ half.T * size)(0.5) for size in 1 + 1e-15 * np.arange(5)]
    np.testing.assert_allclose(middles, np.broadcast_to(middles[0], (5, *middles[0].shape)), atol=1e-9)
