"""Poses of one shape on another: right ones, refused ones, and what is said of doubtful ones."""

from __future__ import annotations

import dataclasses
import warnings
from typing import Any

import numpy as np
import pytest
from in_pieces import in_pieces
from scipy.spatial.transform import Rotation
from shapes import arched, creature

import qgeo_filters as qg
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.closest_points import closest_points
from qgeo_filters.surface import Surface

TURN = Rotation.from_rotvec([0.4, 2.0, -1.0]).as_matrix()
# A sample that is nearest to an edge of X may count to either of its triangles, by rounding.
TIES = 1e-3
SIDEWAYS = np.array([1.0, 0.0, 0.0])


def placed(points: np.ndarray) -> np.ndarray:
    """Turned, moved and twice as large."""
    return 2 * points @ TURN.T + np.array([5.0, -3.0, 1.0])


def mean_error(found: np.ndarray, truth: np.ndarray, surface: Surface) -> float:
    return float(np.linalg.norm(found - truth, axis=1).mean() / np.sqrt(surface.area))


@pytest.fixture(scope="module")
def found(fine: Surface, coarse: Surface) -> qg.MatchResult:
    """Match of the fine creature with the coarse one, which stands elsewhere and is twice as large."""
    return qg.match(fine, coarse.with_vertices(placed(coarse.vertices)))


def test_poses_go_over_with_no_markers(
    fine: Surface, coarse: Surface, poses: list[np.ndarray], found: qg.MatchResult
) -> None:
    y = coarse.with_vertices(placed(coarse.vertices))
    result = qg.transfer_deformation(fine, poses, y, found)
    place = closest_points(coarse.vertices, fine)
    for pose, moved in zip(poses, result.positions, strict=True):
        assert mean_error(moved, placed(place.pulled_back(pose)), y) < 0.01
    assert len(result) == 2
    assert result.correspondence is found
    assert result.source is not None
    assert mean_error(result.source.positions[1], placed(poses[1]), y) < 0.02
    assert result.apart < 0.03


@pytest.mark.slow
def test_the_match_may_be_one_of_y_and_x(
    fine: Surface, coarse: Surface, poses: list[np.ndarray], found: qg.MatchResult
) -> None:
    """Poses of Y carried to X along the match of X and Y."""
    place = closest_points(fine.vertices, coarse)
    back = qg.transfer_deformation(found.y, [placed(arched(coarse.vertices, 0.5))], fine, found)
    assert mean_error(back.positions[0], arched(place.pulled_back(coarse.vertices), 0.5), fine) < 0.03


def test_which_way_a_match_goes_is_told_for_shapes_of_equal_counts(fine: Surface, poses: list[np.ndarray]) -> None:
    """X and Y with as many vertices and faces, in another order: found.x is Y."""
    order = np.random.default_rng(0).permutation(fine.n_vertices)
    y = Surface(fine.vertices[order], np.argsort(order)[fine.faces])
    back = qg.match(y, fine)
    result = qg.transfer_deformation(fine, poses, y, back)
    for pose, moved in zip(poses, result.positions, strict=True):
        assert mean_error(moved, pose[order], y) < 0.01


def test_at_rest_it_stays_as_it_is(fine: Surface, coarse: Surface) -> None:
    place = closest_points(coarse.vertices, fine)
    result = qg.transfer_deformation(fine, [fine.vertices], coarse, place)
    np.testing.assert_allclose(result.positions[0], coarse.vertices, atol=1e-6)


def test_neither_size_nor_place_of_x_matters(fine: Surface, coarse: Surface, poses: list[np.ndarray]) -> None:
    place = closest_points(coarse.vertices, fine)
    here = qg.transfer_deformation(fine, poses, coarse, place)
    there = qg.transfer_deformation(
        fine.with_vertices(placed(fine.vertices)), [placed(pose) for pose in poses], coarse, place
    )
    np.testing.assert_allclose(here.positions, there.positions, atol=TIES)


def test_without_aligning_the_poses_are_taken_where_they_are(fine: Surface, poses: list[np.ndarray]) -> None:
    result = qg.transfer_deformation(fine, poses, fine, np.arange(fine.n_vertices), align=False)
    np.testing.assert_allclose(result.positions, poses, atol=1e-8)


def test_neither_numbering_nor_order_of_faces_matters(fine: Surface, coarse: Surface, poses: list[np.ndarray]) -> None:
    random = np.random.default_rng(0)
    order = random.permutation(coarse.n_vertices)
    mixed = Surface(coarse.vertices[order], np.argsort(order)[random.permutation(coarse.faces)])
    a, b = (qg.transfer_deformation(fine, poses, y, closest_points(y.vertices, fine)) for y in (coarse, mixed))
    np.testing.assert_allclose(a.positions[:, order], b.positions, atol=TIES)


def test_poses_may_be_meshes_and_files(fine: Surface, poses: list[np.ndarray], tmp_path: Any) -> None:
    fine.with_vertices(poses[0]).write(tmp_path / "pose.ply")
    vertices = np.arange(fine.n_vertices)
    given = [tmp_path / "pose.ply", (poses[1], fine.faces), fine.with_vertices(poses[0])]
    result = qg.transfer_deformation(fine, given, fine, vertices, align=False)
    np.testing.assert_allclose(result.positions, [poses[0], poses[1], poses[0]], atol=1e-6)


def test_where_references_stand_in_different_poses_the_pose_is_taken_over(
    fine: Surface, coarse: Surface, poses: list[np.ndarray]
) -> None:
    place = closest_points(coarse.vertices, fine)
    other = coarse.with_vertices(arched(coarse.vertices, -1.2))
    truth = place.pulled_back(poses[1])
    result = qg.transfer_deformation(fine, [poses[1]], other, place, same_pose=False, same_body=True)
    with pytest.warns(UserWarning, match="same_pose=False"):
        doubtful = qg.transfer_deformation(fine, [poses[1]], other, place)
    assert any("same_pose=False" in note for note in doubtful.notes)
    errors = []
    for positions in (result.positions[0], doubtful.positions[0]):
        moved = Rotation.align_vectors(truth - truth.mean(0), positions - positions.mean(0))[0]
        errors.append(mean_error(moved.apply(positions - positions.mean(0)), truth - truth.mean(0), coarse))
    assert errors[0] < 0.03
    assert errors[1] > 3 * errors[0]


@pytest.mark.parametrize("same_body", [True, False])
def test_a_pose_is_taken_over_without_a_reference(fine: Surface, coarse: Surface, same_body: bool) -> None:
    place = closest_points(coarse.vertices, fine)
    x = fine.with_vertices(placed(arched(fine.vertices, 0.6)))
    result = qg.transfer_pose(x, coarse, place, same_body=same_body)
    assert result.area == pytest.approx(coarse.area, rel=0.08)
    truth = arched(coarse.vertices, 0.6) @ TURN.T
    centred = result.vertices - result.vertices.mean(axis=0)
    assert mean_error(centred, truth - truth.mean(axis=0), coarse) < 0.04


def test_one_pose_after_the_other_as_they_are_finished(fine: Surface, poses: list[np.ndarray]) -> None:
    asked = []

    class Poses(list):  # type: ignore[type-arg]
        def __iter__(self) -> Any:
            for number, pose in enumerate(poses):
                asked.append(number)
                yield pose

    frames = qg.transferred_poses(fine, Poses(), fine, np.arange(fine.n_vertices), align=False)
    assert asked == []
    np.testing.assert_allclose(next(frames), poses[0], atol=1e-8)
    assert asked == [0]
    np.testing.assert_allclose(next(frames), poses[1], atol=1e-8)


@pytest.mark.slow
def test_scans_in_any_triangulation_are_matched_first(fine: Surface, coarse: Surface, poses: list[np.ndarray]) -> None:
    place = closest_points(coarse.vertices, fine)
    # The second of another size: what is taken from it is its pose and place.
    scans = [coarse.with_vertices(place.pulled_back(pose)) for pose in (poses[0], 3 * poses[1])]
    result = qg.transfer_deformation(fine, scans, fine, np.arange(fine.n_vertices), scans=True, align=False)
    for size, pose, moved in zip((1, 3), poses, result.positions, strict=True):
        assert mean_error(moved, size * pose, fine) < 0.03 * size


@pytest.mark.slow
def test_what_is_refused_is_moved_by_the_map_between_wraps() -> None:
    """In pieces, with a sheet inside that has no place on the wrap, and comes along."""
    x, y = (Surface(*in_pieces(creature(level=3), seed)) for seed in (0, 1))
    pose = arched(x.vertices, 0.4) + SIDEWAYS
    with pytest.raises(qg.MeshError, match="repair='wrap'"):
        qg.transfer_deformation(x, pose, y)
    moved = qg.transfer_deformation(x, pose, y, repair="wrap")
    truth, unit = arched(y.vertices, 0.4) + SIDEWAYS, Surface(*creature(level=3))
    assert mean_error(moved.positions[0], truth, unit) < 0.01
    assert mean_error(moved.positions[0][-4:], truth[-4:], unit) < 0.02
    assert any("wrapped in a closed surface" in note for note in moved.notes)
    (first,) = qg.transferred_poses(x, pose, y, repair="wrap")
    np.testing.assert_array_equal(first, moved.positions[0])
    again = qg.transfer_deformation(x, pose, y, qg.match(x, y, repair="wrap"))
    np.testing.assert_array_equal(again.positions, moved.positions)


@pytest.mark.slow
def test_the_size_of_a_scan_with_walls_inside_is_that_of_its_wrap() -> None:
    """Twice the area, most of it inside: a pose is taken over in the size of what can be seen."""
    whole = Surface(*creature(level=3))
    inner = whole.vertices * 0.9
    walls = Surface(
        np.concatenate([whole.vertices, inner]), np.concatenate([whole.faces, whole.faces[:, ::-1] + whole.n_vertices])
    )
    assert walls.area > 1.7 * whole.area
    posed = qg.transfer_pose(walls, whole, repair="wrap", same_body=True)
    assert posed.area == pytest.approx(whole.area, rel=0.05)
    assert mean_error(posed.vertices - posed.vertices.mean(0), whole.vertices - whole.vertices.mean(0), whole) < 0.02


@pytest.mark.slow
def test_scans_are_wrapped_too() -> None:
    x = Surface(*creature(level=3))
    pose = arched(x.vertices, 0.2)
    scan = in_pieces((pose, x.faces))
    with pytest.raises(qg.MeshError, match="repair='wrap'"):
        qg.transfer_deformation(x, [scan], x, np.arange(x.n_vertices), scans=True)
    moved = qg.transfer_deformation(x, [scan, scan], x, np.arange(x.n_vertices), scans=True, repair="wrap", align=False)
    for positions in moved.positions:
        assert mean_error(positions, pose, x) < 0.03


def test_poses_that_do_not_fit_are_refused(fine: Surface, coarse: Surface, poses: list[np.ndarray]) -> None:
    shuffled = np.random.default_rng(0).permutation(fine.n_vertices)
    other = Surface(poses[0][shuffled], np.argsort(shuffled)[fine.faces])
    lost = poses[0].copy()
    lost[[7, 9]] = np.nan
    for given, said in [
        ([poses[0], poses[0][:-1]], r"pose 1: positions of shape \(641, 3\).*642 vertices"),
        ([coarse], "pose 0: .*642 vertices; scans=True"),
        ([other], "pose 0: as many vertices as the reference, but other triangles"),
        ([lost], "pose 0: 2 of 642 vertices are not finite, the first is 7"),
        ([(lost, fine.faces)], "pose 0: 2 of 642 vertices are not finite, the first is 7"),
        ([poses[0], poses[0] * [-1, 1, 1]], "pose 1: inside out, as a mirror image"),
        ([fine.with_vertices(-placed(poses[0]))], "pose 0: inside out, as a mirror image"),
        ([np.zeros_like(poses[0])], "pose 0: all vertices are in one place"),
        ([], "no poses"),
        (None, "sequence of meshes, paths and arrays, got NoneType"),
    ]:
        with pytest.raises(qg.ParameterError, match=said):
            qg.transfer_deformation(fine, given, fine, np.arange(fine.n_vertices))


def test_maps_of_other_shapes_are_refused(
    fine: Surface, coarse: Surface, poses: list[np.ndarray], found: qg.MatchResult
) -> None:
    for given, said in [
        (np.arange(5), "vertex of X for each of the 321 of Y, got 5"),
        (np.full(coarse.n_vertices, 9999), "correspondence"),
        (np.full(coarse.n_vertices, -1), "no vertex of Y has a partner"),
        (closest_points(fine.vertices, fine), "642 points"),
        (dataclasses.replace(found, x=coarse), "the match is one of 321 and 321 vertices"),
        (dataclasses.replace(found, orientation=-0.8), "reflect one of the shapes"),
        (
            dataclasses.replace(found, orientation=-0.8, confident=False, explanation="too alike"),
            "reflect one of the shapes first; and the correspondence is not sure: too alike",
        ),
        (
            dataclasses.replace(found, confident=False, explanation="too alike"),
            r"not sure: too alike. Look at it, give landmarks \(correspondence=match\(x, y, landmarks=...\)\), "
            "or say accept_unsure=True",
        ),
        (
            dataclasses.replace(found, confident=False, explanation="too alike", landmark_errors=np.zeros(3)),
            "give more landmarks",
        ),
    ]:
        with pytest.raises(qg.QgeoError, match=said):
            qg.transfer_deformation(fine, poses, coarse, given)


@pytest.mark.parametrize("turned_over", [False, True])
def test_a_mirrored_map_that_is_given_is_refused(fine: Surface, poses: list[np.ndarray], turned_over: bool) -> None:
    """Onto the mirror image, whichever side its triangles take for out; the same map of unmirrored shapes is taken."""
    faces = fine.faces[:, ::-1] if turned_over else fine.faces
    same = np.arange(fine.n_vertices)
    mirrored = Surface(fine.vertices * [-1, 1, 1], faces)
    for place in (same, BarycentricMap.at_vertices(same, fine.faces, fine.n_vertices)):
        for call in (
            lambda place=place: qg.transfer_deformation(fine, poses, mirrored, place),
            lambda place=place: qg.transfer_pose(fine, mirrored, place),
            lambda place=place: qg.interpolate(mirrored, fine, 0.5, place),
        ):
            with pytest.raises(qg.ParameterError, match="reverses the orientation"):
                call()
    other = Surface(placed(fine.vertices), faces)
    moved = qg.transfer_deformation(fine, poses, other, same)
    np.testing.assert_allclose(moved.positions, [placed(pose) for pose in poses], atol=1e-3)


def test_an_open_sheet_may_bend_the_other_way() -> None:
    """It has no inside: its pose is no mirror image of it."""
    grid = np.stack(np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij"), axis=-1).reshape(-1, 2)
    corner = np.arange(81).reshape(9, 9)
    a, b, c, d = corner[:-1, :-1].ravel(), corner[1:, :-1].ravel(), corner[1:, 1:].ravel(), corner[:-1, 1:].ravel()
    bowl = Surface(np.c_[grid, 0.3 * (grid**2).sum(axis=1)], np.r_[np.c_[a, b, c], np.c_[a, c, d]])
    moved = qg.transfer_deformation(bowl, [bowl.vertices * [1, 1, -1]], bowl, np.arange(81), align=False)
    np.testing.assert_allclose(moved.positions[0], bowl.vertices * [1, 1, -1], atol=1e-6)


def test_a_doubtful_map_is_taken_if_one_is_told_so_and_warned_of(
    fine: Surface, poses: list[np.ndarray], found: qg.MatchResult
) -> None:
    doubtful = dataclasses.replace(found, confident=False, explanation="too alike")
    with pytest.warns(UserWarning, match="too alike") as caught:
        result = qg.transfer_deformation(fine, poses, found.y, doubtful, accept_unsure=True)
    assert caught[0].filename == __file__  # the caller's line, not one of the package
    assert any("too alike" in note for note in result.notes)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert qg.transfer_deformation(fine, poses, found.y, found).notes == ()


def test_inputs_are_not_changed_and_may_be_of_any_kind(fine: Surface, poses: list[np.ndarray]) -> None:
    single = np.asfortranarray(poses[0].astype(np.float32))
    single.setflags(write=False)
    before = single.copy()
    expected = qg.transfer_deformation(fine, [poses[0]], fine, np.arange(fine.n_vertices), align=False).positions
    result = qg.transfer_deformation(fine, [single], fine, np.arange(fine.n_vertices, dtype=np.int16), align=False)
    np.testing.assert_allclose(result.positions, expected, atol=1e-5)
    assert np.array_equal(single, before)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_neither_tiny_nor_huge_shapes_lose_anything(fine: Surface, poses: list[np.ndarray], scale: float) -> None:
    tiny = fine.with_vertices(scale * fine.vertices)
    result = qg.transfer_deformation(tiny, [scale * poses[0]], tiny, np.arange(fine.n_vertices))
    np.testing.assert_allclose(result.positions[0] / scale, poses[0], atol=1e-6)
