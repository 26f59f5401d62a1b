"""Shapes, maps and times that cannot be, in every function that moves a shape: one error that says which and why."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from shapes import arched, creature

import qgeo_filters as qg

X = qg.Surface(*creature(1.0, 2))
N = X.n_vertices
POSE = X.with_vertices(arched(X.vertices, 0.4))
SAME = np.arange(N)

# Of x, y and the map: the shape that is moved is the last of a transfer, the first of an interpolation.
WAYS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "transfer": lambda x, y, place: qg.transfer_deformation(x, POSE, y, place).positions,
    "one by one": lambda x, y, place: list(qg.transferred_poses(x, POSE, y, place)),
    "pose": lambda x, y, place: qg.transfer_pose(x, y, place).vertices,
    "filter": lambda x, y, place: qg.DeformationTransfer(source=x, poses=POSE, correspondence=place)(y).vertices,
    "interpolation": lambda x, y, place: qg.interpolate(x, y, 0.5, place).positions,
    "interpolation filter": lambda x, y, place: qg.Interpolate(target=y, correspondence=place)(x).vertices,
}
each_way = pytest.mark.parametrize("way", WAYS)


def changed(array: np.ndarray, at: int, value: float) -> np.ndarray:
    """A copy with one row replaced."""
    array = array.copy()
    array[at] = value
    return array


@each_way
@pytest.mark.parametrize(
    ("place", "said"),
    [
        (SAME.astype(float), "vertex indices in one dimension, got float64"),
        (SAME + 0.5, "vertex indices in one dimension, got float64"),
        (changed(SAME.astype(float), 3, np.nan), "vertex indices in one dimension, got float64"),
        (np.ones(N, dtype=bool), "vertex indices in one dimension, got bool"),
        (SAME[:, None], r"vertex indices in one dimension, got int64 of shape \(162, 1\)"),
        (changed(SAME, 5, -2), r"correspondence\[5\] is vertex -2, but there are 162 vertices"),
        (changed(SAME, 5, N), r"correspondence\[5\] is vertex 162, but there are 162 vertices"),
        (SAME[:-1], "a vertex of X for each of the 162 of Y, got 161"),
        (SAME[:0], "a vertex of X for each of the 162 of Y, got 0"),
        (np.full(N, -1), "no vertex of Y has a partner on X"),
        ("map", "vertex indices in one dimension"),
    ],
)
def test_maps_that_are_none(way: str, place: Any, said: str) -> None:
    with pytest.raises(qg.QgeoError, match=said):
        WAYS[way](X, X, place)


@each_way
@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        ((np.zeros((0, 3)), np.zeros((0, 3), dtype=int)), "no vertices"),
        ((X.vertices, np.zeros((0, 3), dtype=int)), "no faces"),
        ((X.vertices[:, :2], X.faces), r"must have shape \(n, 3\)"),
        ((np.full((N, 3), np.nan), X.faces), "not finite"),
        (
            (np.zeros((N, 3)), X.faces),
            "the surface has no area: all of its triangles are flat|nothing is left of the mesh",
        ),
    ],
    ids=["empty", "no faces", "flat land", "NaN", "a point"],
)
def test_shapes_that_are_none(way: str, which: int, mesh: Any, said: str) -> None:
    shapes = [X, X]
    shapes[which] = mesh
    with pytest.raises(qg.QgeoError, match=said):
        WAYS[way](*shapes, SAME)


@each_way
def test_a_map_may_leave_vertices_out(way: str) -> None:
    """Every other one: what has no partner goes with its neighbours, near to where the whole map takes it."""
    known = WAYS[way](X, POSE, SAME)
    partly = WAYS[way](X, POSE, np.where(SAME % 2, SAME, -1))
    np.testing.assert_allclose(np.squeeze(partly), np.squeeze(known), atol=0.2 * np.sqrt(X.area))
    assert np.isfinite(partly).all()


@each_way
def test_arrays_of_any_kind_do_and_stay_as_they_were(way: str) -> None:
    vertices, faces = np.asfortranarray(X.vertices, dtype=np.float32), np.asfortranarray(X.faces, dtype=np.uint16)
    place = np.repeat(SAME, 2)[::2].astype(np.int16)
    for array in (vertices, faces, place):
        array.setflags(write=False)
    before = [array.copy() for array in (vertices, faces, place)]
    found = WAYS[way]((vertices, faces), (POSE.vertices, POSE.faces.astype(float)), place)
    # Half way, rotations are put together along a tree, and rounding decides between branches that are alike.
    near = 2e-3 if "interpolation" in way else 1e-4
    np.testing.assert_allclose(np.squeeze(found), np.squeeze(WAYS[way](X, POSE, SAME)), atol=near)
    for array, copy in zip((vertices, faces, place), before, strict=True):
        np.testing.assert_array_equal(array, copy)


@pytest.mark.parametrize(
    ("t", "said"),
    [
        (np.nan, "a number, or growing numbers"),
        (np.inf, "a number, or growing numbers"),
        (-0.1, "t must be from 0 to 1, got -0.1"),
        (1.1, "t must be from 0 to 1, got 1.1"),
        ("half", "t must be real numbers"),
        (None, "t must be real numbers"),
        (True, "t must be real numbers"),
        (1j, "t must be real numbers"),
        ([0.2, np.nan], "growing numbers|one number"),
        ([0.5, 0.5], "growing numbers|one number"),
        ([0.5, 0.2], "growing numbers|one number"),
        ([[0.5]], "growing numbers|one number"),
        ([], "growing numbers|one number"),
    ],
)
def test_times_that_are_none(t: Any, said: str) -> None:
    with pytest.raises(qg.ParameterError, match=said):
        qg.interpolate(X, POSE, t)
    with pytest.raises(qg.ParameterError, match=said):
        qg.Interpolate(target=POSE, t=t)(X)


def test_a_filter_takes_one_time_and_not_the_first_of_several() -> None:
    with pytest.raises(qg.ParameterError, match="t must be one number"):
        qg.Interpolate(target=POSE, t=[0.0, 1.0])(X)


def test_a_list_of_maps_is_one_for_each_pose() -> None:
    turned = X.with_vertices(POSE.vertices[::-1])
    shuffled = qg.Surface(POSE.vertices[::-1], N - 1 - X.faces)
    way = qg.interpolate(X, [POSE, shuffled], [1, 2], (None, N - 1 - SAME))
    np.testing.assert_allclose(way.positions[0], POSE.vertices, atol=1e-8)
    np.testing.assert_allclose(way.positions[1], POSE.vertices, atol=0.02 * np.sqrt(X.area))
    for maps in ([None], [None] * 3, [SAME]):
        with pytest.raises(qg.ParameterError, match=f"one correspondence for each of the 2 poses, got {len(maps)}"):
            qg.interpolate(X, [POSE, turned], 0.5, maps)


def test_what_is_left_out_of_a_shape_to_pose_it_is_said() -> None:
    lost = changed(X.vertices, 3, np.nan)
    with pytest.warns(UserWarning, match="Y: 1 vertex with coordinates that are not finite"):
        qg.transfer_pose(POSE, (lost, X.faces), SAME)
