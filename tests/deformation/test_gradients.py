"""Deformation gradients and the surfaces that are put together from them."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation
from shapes import bent, blob, fan, grid, icosphere

from qgeo_filters.deformation.gradients import TriangleFrames
from qgeo_filters.deformation.poisson import PoissonSolver, half_cotangents
from qgeo_filters.deformation.similarity import Similarity

LINEAR = arrays(np.float64, (3, 3), elements=st.floats(-2, 2)).filter(lambda a: abs(np.linalg.det(a)) > 0.05)


def moved(vertices: np.ndarray, by: list[float]) -> np.ndarray:
    return vertices + np.array(by)


@settings(max_examples=30)
@given(LINEAR)
def test_the_gradient_of_a_linear_map_moves_edges_as_the_map_does(linear: np.ndarray) -> None:
    vertices, faces = blob(2)
    found = TriangleFrames(vertices, faces).gradients(vertices @ linear.T)
    for k in (1, 2):
        edges = vertices[faces[:, k]] - vertices[faces[:, 0]]
        np.testing.assert_allclose(np.einsum("tij,tj->ti", found, edges), edges @ linear.T, atol=1e-10)


def test_the_gradient_of_a_turn_is_the_turn() -> None:
    vertices, faces = blob(2)
    turn = Rotation.from_rotvec([0.3, -2.0, 1.0]).as_matrix()
    found = TriangleFrames(vertices, faces).gradients(vertices @ turn.T + [5, 6, 7])
    np.testing.assert_allclose(found, np.broadcast_to(turn, found.shape), atol=1e-10)


def test_growth_is_felt_across_the_surface_as_well() -> None:
    vertices, faces = blob(2)
    found = TriangleFrames(vertices, faces).gradients(3 * vertices)
    np.testing.assert_allclose(found, np.broadcast_to(3 * np.eye(3), found.shape), atol=1e-9)


def test_a_triangle_without_area_has_no_gradient_of_its_own() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]])
    frames = TriangleFrames(vertices, np.array([[0, 1, 2], [0, 1, 3]]))
    assert frames.flat.tolist() == [True, False]
    assert np.array_equal(frames.gradients(2 * vertices)[0], np.eye(3))


def test_the_weights_are_those_of_libigl() -> None:
    vertices, faces = blob(2)
    np.testing.assert_allclose(
        half_cotangents(vertices, faces), igl.cotmatrix_entries(vertices, faces.astype(np.int64)), rtol=1e-9
    )


@pytest.mark.parametrize("mesh", [blob(2), grid(6, 0.2), fan()], ids=["closed", "open", "three faces on an edge"])
@pytest.mark.parametrize("pull", [1e-8, 10.0])
def test_a_surface_is_put_together_again_from_its_own_gradients(mesh: tuple, pull: float) -> None:
    vertices, faces = mesh
    pose = bent(vertices, 1.3) + 0.1 * np.random.default_rng(0).normal(size=vertices.shape)
    solver = PoissonSolver(vertices, faces, np.full(len(vertices), pull))
    np.testing.assert_allclose(solver(TriangleFrames(vertices, faces).gradients(pose), pose), pose, atol=1e-6)


def test_pieces_are_each_put_where_they_are_drawn_to() -> None:
    vertices, faces = icosphere(1)
    two = np.concatenate([vertices, moved(vertices, [5, 0, 0])]), np.concatenate([faces, faces + len(vertices)])
    targets = np.concatenate([vertices, moved(vertices, [5, 9, 0])])
    found = PoissonSolver(*two, np.full(len(two[0]), 1e-6))(np.tile(np.eye(3), (len(two[1]), 1, 1)), targets)
    np.testing.assert_allclose(found, targets, atol=1e-6)


@settings(max_examples=30)
@given(st.floats(0.01, 100), arrays(np.float64, 3, elements=st.floats(-3, 3)), st.booleans())
def test_a_similarity_is_found_from_what_it_did(scale: float, turn: np.ndarray, given_size: bool) -> None:
    points = np.random.default_rng(1).normal(size=(20, 3))
    rotation = Rotation.from_rotvec(turn).as_matrix()
    targets = scale * points @ rotation.T + [1, 2, 3]
    found = Similarity.between(points, targets, np.arange(1.0, 21.0), scale if given_size else None)
    np.testing.assert_allclose(found(points), targets, atol=1e-9 * max(scale, 1))
    np.testing.assert_allclose(found.rotation, rotation, atol=1e-8)


def test_a_similarity_never_mirrors() -> None:
    points = np.random.default_rng(1).normal(size=(20, 3))
    found = Similarity.between(points, points * [-1, 1, 1], np.ones(20))
    assert np.linalg.det(found.rotation) == pytest.approx(1.0)
