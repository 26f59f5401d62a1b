"""Shapes between poses, in the triangles of the first."""

from __future__ import annotations

import numpy as np
import pytest
from in_pieces import in_pieces
from shapes import arched, creature

import qgeo_filters as qg
from qgeo_filters.closest_points import closest_points
from qgeo_filters.surface import Surface


def test_a_way_through_several_poses(fine: Surface, poses: list[np.ndarray]) -> None:
    way = qg.interpolate(fine, [fine.with_vertices(pose) for pose in poses], [0, 0.5, 1, 1.5, 2])
    assert way.times.tolist() == [0, 0.5, 1, 1.5, 2]
    for frame, pose in ((0, fine.vertices), (2, poses[0]), (4, poses[1])):
        np.testing.assert_allclose(way.positions[frame], pose, atol=1e-8)
    gap = np.linalg.norm(way.positions[3] - arched(fine.vertices, 0.35), axis=1).mean()
    assert gap < 0.03 * np.sqrt(fine.area)


def test_a_pose_in_other_triangles_is_reached_along_the_map(fine: Surface, coarse: Surface) -> None:
    end = coarse.with_vertices(arched(coarse.vertices, 0.5))
    place = closest_points(fine.vertices, coarse)
    found = qg.interpolate(fine, end, 1.0, place).positions[0]
    gaps = np.linalg.norm(found - place.pulled_back(end.vertices), axis=1)
    assert gaps.mean() < 0.01 * np.sqrt(fine.area)


@pytest.mark.slow
def test_between_meshes_in_pieces_the_way_goes_along_the_map_between_wraps() -> None:
    whole = Surface(*creature(level=3))
    x = Surface(*in_pieces(creature(level=3)))
    y = Surface(*in_pieces((arched(whole.vertices, 0.4), whole.faces), seed=1))
    with pytest.raises(qg.MeshError, match=r"pose 0: .*repair='wrap'"):
        qg.interpolate(x, y, 1)
    way = qg.interpolate(x, y, [0, 1], repair="wrap")
    np.testing.assert_allclose(way.positions[0], x.vertices, atol=1e-6)
    off = np.linalg.norm(way.positions[1] - arched(x.vertices, 0.4), axis=1) / np.sqrt(whole.area)
    assert off.mean() < 0.03
    assert off[-4:].max() < 0.1  # the sheet inside, which has no place on the wrap


def test_a_map_is_heeded_where_the_triangles_are_the_same(fine: Surface) -> None:
    """A creature onto its own mirror image: the identity would turn it inside out."""
    images = np.arange(fine.n_vertices)
    images[:1] = 1
    direct = qg.interpolate(fine, fine, 1.0).positions[0]
    assert np.array_equal(direct, fine.vertices) or np.abs(direct - fine.vertices).max() < 1e-9
    assert np.abs(qg.interpolate(fine, fine, 1.0, images).positions[0] - fine.vertices).max() > 1e-4


def test_what_cannot_be_is_refused(fine: Surface, coarse: Surface) -> None:
    for t, said in [
        (1.5, "t must be from 0 to 1"),
        (-0.1, "t must be from 0 to 1"),
        ([], "growing numbers"),
        ([0.5, 0.5], "growing numbers"),
        (np.nan, "growing numbers"),
    ]:
        with pytest.raises(qg.ParameterError, match=said):
            qg.interpolate(fine, fine, t)
    lost = fine.vertices.copy()
    lost[7] = np.nan
    with pytest.raises(qg.ParameterError, match="pose 1: 1 of 642 vertices are not finite, the first is 7"):
        qg.interpolate(fine, [fine, (lost, fine.faces)], 0.5)
    with pytest.raises(qg.ParameterError, match="pose 0: inside out, as a mirror image"):
        qg.interpolate(fine, fine.with_vertices(fine.vertices * [-1, 1, 1]), 0.5)
    with pytest.raises(qg.ParameterError, match="y must be a pose or several, got none"):
        qg.interpolate(fine, [], 0.5)
    with pytest.raises(qg.ParameterError, match="one correspondence for each of the 2 poses, got 1"):
        qg.interpolate(fine, [fine, fine], 0.5, [np.arange(fine.n_vertices)])
    with pytest.raises(qg.ParameterError, match="pose 0: correspondence must hold a vertex of X for each of the 642"):
        qg.interpolate(fine, coarse, 0.5, np.arange(5))


def test_attributes_stay(fine: Surface, poses: list[np.ndarray]) -> None:
    named = fine.with_attributes({"height": fine.vertices[:, 2]})
    half = qg.interpolate(named, named.with_vertices(poses[0]), 0.5)[0]
    assert np.array_equal(half.attributes["height"], fine.vertices[:, 2])
