"""Nearest rotations of many matrices, against the singular value decomposition."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from qgeo_filters.deformation.fit_rotations import fit_rotations


def by_decomposition(matrices: np.ndarray) -> np.ndarray:
    u, _, v = np.linalg.svd(matrices)
    u[..., 2] *= np.linalg.det(u @ v)[:, None]
    return u @ v


def matrices(kind: str) -> np.ndarray:
    rng = np.random.default_rng(0)
    found = rng.normal(size=(500, 3, 3))
    if kind == "flat":  # as of the edges around a vertex in a plane
        found[:, :, 2] = 0
    if kind == "nearly flat":
        found[:, :, 2] *= 1e-6
    if kind == "reflecting":
        found *= -np.sign(np.linalg.det(found))[:, None, None]
    if kind == "of all sizes":
        found *= 10.0 ** rng.uniform(-20, 20, size=(500, 1, 1))
    return found


@pytest.mark.parametrize("kind", ["any", "flat", "nearly flat", "reflecting", "of all sizes"])
def test_rotations_are_those_of_the_decomposition(kind: str) -> None:
    given = matrices(kind)
    found = fit_rotations(given)
    np.testing.assert_allclose(np.linalg.det(found), 1, rtol=1e-12)
    np.testing.assert_allclose(found, by_decomposition(given), atol=1e-8)


def test_a_rotation_is_its_own_nearest_one_half_turns_included() -> None:
    turns = np.concatenate([Rotation.random(200, rng=0).as_matrix(), Rotation.create_group("O").as_matrix()])
    np.testing.assert_allclose(fit_rotations(3.7 * turns), turns, atol=1e-12)


def test_what_singles_out_no_rotation_still_gives_one_that_is_as_near_as_any() -> None:
    """A point, a line, and reflections with an axis to choose: a rotation, and no other has a larger trace."""
    given = np.array([np.zeros((3, 3)), np.diag([2.0, 0, 0]), np.diag([0, -1.0, 0]), np.diag([1.0, 1, -1]), -np.eye(3)])
    found = fit_rotations(given)
    np.testing.assert_allclose(found @ found.transpose(0, 2, 1), np.tile(np.eye(3), (5, 1, 1)), atol=1e-12)
    best = np.einsum("nij,nij->n", by_decomposition(given), given)
    np.testing.assert_allclose(np.einsum("nij,nij->n", found, given), best, atol=1e-12)
