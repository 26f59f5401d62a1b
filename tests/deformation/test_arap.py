"""Deformations as rigid as possible."""

from __future__ import annotations

import itertools
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import blob, icosphere

from qgeo_filters.deformation.arap import ArapSolver, Pull

# libigl fits rotations in single precision.
SINGLE = 2e-5

VERTICES, FACES = blob(3, 0)
N = len(VERTICES)


@pytest.fixture
def arap() -> ArapSolver:
    return ArapSolver(VERTICES, FACES)


def moved(seed: int = 0) -> np.ndarray:
    turn = Rotation.from_rotvec(np.random.default_rng(seed).normal(size=3))
    return turn.apply(np.array(VERTICES)) + np.array([1.0, -2.0, 3.0])


def test_a_rigid_motion_has_no_strain_and_a_reflection_has(arap: ArapSolver) -> None:
    assert arap.energy(moved()) < 1e-6
    assert arap.energy(VERTICES * [-1, 1, 1]) > 1
    assert arap.energy(1.1 * VERTICES) > 0.01


def test_strain_does_not_change_with_the_place(arap: ArapSolver) -> None:
    bent = VERTICES + 0.1 * np.sin(3 * VERTICES[:, [1, 2, 0]])
    turn = Rotation.from_rotvec([1, 2, 3]).as_matrix()
    assert arap.energy(bent) == pytest.approx(arap.energy(bent @ turn.T + 5), rel=SINGLE)


@pytest.mark.parametrize("smooth", [0, 3, 30])
def test_targets_that_are_a_rigid_motion_are_reached_and_stay(arap: ArapSolver, smooth: int) -> None:
    pull = Pull(2.0, np.full(N, 2.0))
    targets = moved()
    there = arap.iterate(arap.prefactor(pull), pull, targets, targets, smooth)
    np.testing.assert_allclose(there, targets, atol=SINGLE)


def test_the_energy_never_grows(arap: ArapSolver) -> None:
    """Each step minimises over rotations, then over positions: the energy never grows."""
    pull = Pull("random", np.random.default_rng(0).uniform(0.1, 1, N))
    targets = VERTICES + 0.2 * np.random.default_rng(1).normal(size=(N, 3))
    before, after = VERTICES, VERTICES
    energies = []
    for _ in range(5):
        after = arap.iterate(arap.prefactor(pull), pull, before, targets, 0)
        energies.append(arap.energy(after) + 2 * (pull.values[:, None] * (after - targets) ** 2).sum())
        before = after
    # Each pair of neighbours counts twice in the strain.
    assert all(later <= earlier * (1 + 1e-6) for earlier, later in itertools.pairwise(energies))


def test_wide_averages_turn_a_twisted_neighbourhood_as_a_whole(arap: ArapSolver) -> None:
    noisy = moved() + 0.02 * np.random.default_rng(3).normal(size=(N, 3))
    narrow, wide = (arap._rotations(noisy, smooth) for smooth in (0, 30))
    whole = Rotation.from_rotvec(np.random.default_rng(0).normal(size=3)).as_matrix()
    assert np.linalg.norm(wide - whole, axis=(1, 2)).mean() < 0.3 * np.linalg.norm(narrow - whole, axis=(1, 2)).mean()
    np.testing.assert_allclose(np.linalg.det(narrow), 1, atol=SINGLE)
    np.testing.assert_allclose(
        narrow @ narrow.transpose(0, 2, 1), np.broadcast_to(np.eye(3), narrow.shape), atol=SINGLE
    )


def test_factorisations_are_kept_for_equal_pulls_only_and_not_for_ever(arap: ArapSolver) -> None:
    one, other = Pull(1.0, np.ones(N)), Pull(2.0, np.full(N, 2.0))
    solve = arap.prefactor(one)
    assert arap.prefactor(Pull(1.0, np.ones(N))) is solve
    assert arap.prefactor(other) is not solve
    right = np.random.default_rng(0).normal(size=(N, 3))
    assert not np.allclose(solve(right), arap.prefactor(other)(right))
    for k in range(40):
        arap.prefactor(Pull(3.0 + k, np.full(N, 3.0 + k)))
    assert arap.n_factorised <= 32
    np.testing.assert_allclose(arap.prefactor(one)(right), solve(right))


def test_released_factorisations_are_made_again(arap: ArapSolver) -> None:
    pull = Pull(1.0, np.ones(N))
    solve = arap.prefactor(pull)
    arap.release()
    again = arap.prefactor(pull)
    assert again is not solve
    np.testing.assert_array_equal(again(VERTICES), solve(VERTICES))


def test_it_survives_pickling(arap: ArapSolver) -> None:
    pull = Pull(1.0, np.ones(N))
    arap.prefactor(pull)
    copy = pickle.loads(pickle.dumps(arap))
    np.testing.assert_array_equal(copy.prefactor(pull)(VERTICES), arap.prefactor(pull)(VERTICES))


def test_obtuse_triangles_do_not_reward_bending() -> None:
    vertices, faces = icosphere(2)
    flat = vertices * [1, 1, 0.02]
    assert ArapSolver(flat, faces).energy(flat + 0.1 * np.sin(5 * flat[:, [1, 2, 0]])) > 0


def test_flat_triangles_neither_break_it_nor_count() -> None:
    vertices, faces = icosphere(2)
    a, b, c = faces[0]
    n = len(vertices)
    # Face (a, b, c) in two, with a flat third, as converters leave it where a neighbour's edge was split.
    points = np.concatenate([vertices, [(vertices[a] + vertices[b]) / 2]])
    split = np.concatenate([faces[1:], [[a, n, c], [n, b, c], [a, b, n]]])
    pull = Pull("all", np.full(n + 1, 0.1))
    stretched = points * [1.5, 1, 1]
    with_flat = ArapSolver(points, split)
    found = with_flat.iterate(with_flat.prefactor(pull), pull, points, stretched, 0)
    tidy = ArapSolver(vertices, faces)
    pull = Pull("all", np.full(n, 0.1))
    expected = tidy.iterate(tidy.prefactor(pull), pull, vertices, stretched[:n], 0)
    np.testing.assert_allclose(found[:n], expected, atol=0.03)  # of edges .3 long
