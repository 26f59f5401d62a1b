"""Deformations as rigid as possible."""

from __future__ import annotations

import itertools
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import blob, icosphere

from qgeo_filters.deformation.arap import Rigidity

# libigl fits rotations in single precision.
SINGLE = 2e-5

VERTICES, FACES = blob(3, 0)
N = len(VERTICES)


@pytest.fixture
def rigidity() -> Rigidity:
    return Rigidity(VERTICES, FACES)


def moved(seed: int = 0) -> np.ndarray:
    turn = Rotation.from_rotvec(np.random.default_rng(seed).normal(size=3))
    return turn.apply(VERTICES) + np.array([1.0, -2.0, 3.0])


def test_a_rigid_motion_has_no_strain_and_a_reflection_has(rigidity: Rigidity) -> None:
    assert rigidity.strain(moved()) < 1e-6
    assert rigidity.strain(VERTICES * [-1, 1, 1]) > 1
    assert rigidity.strain(1.1 * VERTICES) > 0.01


def test_strain_does_not_change_with_the_place(rigidity: Rigidity) -> None:
    bent = VERTICES + 0.1 * np.sin(3 * VERTICES[:, [1, 2, 0]])
    turn = Rotation.from_rotvec([1, 2, 3]).as_matrix()
    assert rigidity.strain(bent) == pytest.approx(rigidity.strain(bent @ turn.T + 5), rel=SINGLE)


@pytest.mark.parametrize("smooth", [0, 3, 30])
def test_targets_that_are_a_rigid_motion_are_reached_and_stay(rigidity: Rigidity, smooth: int) -> None:
    pull = np.full(N, 2.0)
    targets = moved()
    there = rigidity.step(rigidity.pulled(pull), pull, targets, targets, smooth)
    np.testing.assert_allclose(there, targets, atol=SINGLE)


def test_the_energy_never_grows(rigidity: Rigidity) -> None:
    """Each step minimises over rotations, then over positions: the energy never grows."""
    pull = np.random.default_rng(0).uniform(0.1, 1, N)
    targets = VERTICES + 0.2 * np.random.default_rng(1).normal(size=(N, 3))
    before, after = VERTICES, VERTICES
    energies = []
    for _ in range(5):
        after = rigidity.step(rigidity.pulled(pull), pull, before, targets, 0)
        energies.append(rigidity.strain(after) + 2 * (pull[:, None] * (after - targets) ** 2).sum())
        before = after
    # Each pair of neighbours counts twice in the strain.
    assert all(later <= earlier * (1 + 1e-6) for earlier, later in itertools.pairwise(energies))


def test_wide_averages_turn_a_twisted_neighbourhood_as_a_whole(rigidity: Rigidity) -> None:
    noisy = moved() + 0.02 * np.random.default_rng(3).normal(size=(N, 3))
    narrow, wide = (rigidity._rotations(noisy, smooth) for smooth in (0, 30))
    whole = Rotation.from_rotvec(np.random.default_rng(0).normal(size=3)).as_matrix()
    assert np.linalg.norm(wide - whole, axis=(1, 2)).mean() < 0.3 * np.linalg.norm(narrow - whole, axis=(1, 2)).mean()
    np.testing.assert_allclose(np.linalg.det(narrow), 1, atol=SINGLE)
    np.testing.assert_allclose(
        narrow @ narrow.transpose(0, 2, 1), np.broadcast_to(np.eye(3), narrow.shape), atol=SINGLE
    )


def test_factorisations_are_kept_for_equal_pulls_only_and_not_for_ever(rigidity: Rigidity) -> None:
    one, other = np.ones(N), np.full(N, 2.0)
    solve = rigidity.pulled(one)
    assert rigidity.pulled(one.copy()) is solve
    assert rigidity.pulled(other) is not solve
    right = np.random.default_rng(0).normal(size=(N, 3))
    assert not np.allclose(solve(right), rigidity.pulled(other)(right))
    for k in range(40):
        rigidity.pulled(np.full(N, 3.0 + k))
    assert len(rigidity._factors) <= 32
    np.testing.assert_allclose(rigidity.pulled(one)(right), solve(right))


def test_released_factorisations_are_made_again(rigidity: Rigidity) -> None:
    pull = np.ones(N)
    solve = rigidity.pulled(pull)
    rigidity.release()
    again = rigidity.pulled(pull)
    assert again is not solve
    np.testing.assert_array_equal(again(VERTICES), solve(VERTICES))


def test_it_survives_pickling(rigidity: Rigidity) -> None:
    pull = np.ones(N)
    rigidity.pulled(pull)
    copy = pickle.loads(pickle.dumps(rigidity))
    np.testing.assert_array_equal(copy.pulled(pull)(VERTICES), rigidity.pulled(pull)(VERTICES))


def test_obtuse_triangles_do_not_reward_bending() -> None:
    vertices, faces = icosphere(2)
    flat = vertices * [1, 1, 0.02]
    assert Rigidity(flat, faces).strain(flat + 0.1 * np.sin(5 * flat[:, [1, 2, 0]])) > 0
