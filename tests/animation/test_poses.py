"""What may be given as poses: one or several, of any kind, in anything that can be gone through."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import arched, creature

import qgeo_filters as qg
from qgeo_filters.animation.poses import listed_poses
from qgeo_filters.hosts.protocol import load_host

X = qg.Surface(*creature(1.0, 2))
POSES = np.stack([arched(X.vertices, curvature) for curvature in (0.2, 0.5)])
SAME = np.arange(X.n_vertices)
MESHES = [X.with_vertices(pose) for pose in POSES]


def frame(array: np.ndarray) -> Any:
    """As a data frame: an object that becomes an array by itself."""
    return type("Frame", (), {"__array__": lambda self, dtype=None, copy=None: np.array(array, dtype)})()


def objects(meshes: list[qg.Surface]) -> np.ndarray:
    """An array of Python objects."""
    array = np.empty(len(meshes), dtype=object)
    array[:] = meshes
    return array


SEVERAL = {
    "list": lambda: list(POSES),
    "tuple": lambda: tuple(POSES),
    "generator": lambda: (pose for pose in POSES),
    "array": lambda: POSES,
    "in single precision, column by column, read-only": lambda: read_only(np.asfortranarray(POSES, dtype=np.float32)),
    "every other column": lambda: np.repeat(POSES, 2, axis=2)[:, :, ::2],
    "lists of lists": lambda: POSES.tolist(),
    "tuples of tuples": lambda: tuple(tuple(tuple(point) for point in pose) for pose in POSES),
    "frames": lambda: (frame(POSES[0]), frame(POSES[1])),
    "list of meshes": lambda: list(MESHES),
    "tuple of meshes": lambda: tuple(MESHES),
    "generator of meshes": lambda: iter(MESHES),
    "array of meshes": lambda: objects(MESHES),
    "animation": lambda: qg.Animation(X, POSES),
    "tuple of pairs": lambda: tuple((mesh.vertices, mesh.faces) for mesh in MESHES),
    "list of pairs in lists": lambda: [[mesh.vertices, mesh.faces] for mesh in MESHES],
    "pairs in lists of lists": lambda: tuple((mesh.vertices.tolist(), mesh.faces.tolist()) for mesh in MESHES),
    "mesh and array": lambda: (MESHES[0], POSES[1]),
}
ONE = {
    "mesh": lambda: MESHES[0],
    "array": lambda: POSES[0],
    "lists": lambda: POSES[0].tolist(),
    "tuples": lambda: tuple(map(tuple, POSES[0])),
    "frame": lambda: frame(POSES[0]),
    "pair": lambda: (MESHES[0].vertices, MESHES[0].faces),
    "pair in a list": lambda: [MESHES[0].vertices, MESHES[0].faces],
    "pair in lists": lambda: (MESHES[0].vertices.tolist(), MESHES[0].faces.tolist()),
}
NEITHER = {
    "number": (lambda: 3, "must be a mesh, or a sequence of meshes, paths and arrays, got int"),
    "mapping": (lambda: {"a": MESHES[0]}, "got dict"),
    "set, which has no order": (lambda: set(MESHES), "got set"),
    "bytes": (lambda: b"pose.ply", "got bytes"),
    "four dimensions": (lambda: POSES[None], r"must have shape \(k, n, 3\) or \(n, 3\), got \(1, 2, 162, 3\)"),
    "numbers in a row": (lambda: POSES.ravel(), r"got \(972,\)"),
    "text": (lambda: [[["a"] * 3] * X.n_vertices] * 3, "pose 0: positions must be real numbers, got an array of <U1"),
    "complex": (lambda: [POSES[0] + 0j], "pose 0: positions must be real numbers, got an array of complex128"),
    "rows of different lengths": (lambda: [[[0, 1, 2], [0, 1], [0]]], "pose 0: positions must be numbers in an array"),
    "too wide": (lambda: [1e200 * POSES[0]], "pose 0: .*units wide"),
    "one that is empty": (lambda: [np.empty((0, 3))], r"pose 0: positions of shape \(0, 3\)"),
    "triangles of other vertices": (lambda: [(POSES[0], X.faces + 1)], "pose 0: "),
}


def read_only(array: np.ndarray) -> np.ndarray:
    array.setflags(write=False)
    return array


def by_transfer(given: Any, count: int = 2) -> np.ndarray:
    return qg.transfer_deformation(X, given, X, SAME, align=False).positions


def one_by_one(given: Any, count: int = 2) -> np.ndarray:
    return np.stack(list(qg.transferred_poses(X, given, X, SAME, align=False)))


def by_filter(given: Any, count: int = 2) -> np.ndarray:
    step = qg.DeformationTransfer(source=X, poses=given, correspondence=SAME, align=False)
    last = [step(X).vertices for _ in range(2)][1]  # a filter may be applied again
    np.testing.assert_allclose(last, step.transfer_.positions[-1], atol=1e-12)
    return step.transfer_.positions


def by_interpolation(given: Any, count: int = 2) -> np.ndarray:
    return qg.interpolate(X, given, range(1, count + 1)).positions


def by_interpolation_filter(given: Any, count: int = 2) -> np.ndarray:
    step = qg.Interpolate(target=given)
    return np.stack([step.set_params(t=t)(X).vertices for t in range(1, count + 1)])


WAYS = [by_transfer, one_by_one, by_filter, by_interpolation, by_interpolation_filter]
Way = Callable[..., np.ndarray]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", SEVERAL)
def test_several_poses_are_several_whatever_holds_them(way: Way, kind: str) -> None:
    np.testing.assert_allclose(way(SEVERAL[kind]()), POSES, atol=1e-5)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", ONE)
def test_one_pose_needs_no_list(way: Way, kind: str) -> None:
    np.testing.assert_allclose(way(ONE[kind](), 1), POSES[:1], atol=1e-6)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", NEITHER)
def test_what_is_no_pose_is_one_error(way: Way, kind: str) -> None:
    given, said = NEITHER[kind]
    with pytest.raises(qg.QgeoError, match=said):
        way(given(), 1)


@pytest.mark.parametrize("host", ["open3d", "pymeshlab", "pyvista", "trimesh"])
def test_meshes_of_other_libraries_and_their_points(host: str) -> None:
    pytest.importorskip(host)
    meshes = tuple(load_host(host).make(mesh) for mesh in MESHES)  # type: ignore[attr-defined]
    points = {
        "open3d": lambda mesh: mesh.vertex.positions,
        "pymeshlab": lambda mesh: mesh.current_mesh().vertex_matrix(),
        "pyvista": lambda mesh: mesh.points,
        "trimesh": lambda mesh: mesh.vertices,
    }[host]
    for way in (by_transfer, by_interpolation):
        for given in (meshes, list(meshes), tuple(map(points, meshes))):
            np.testing.assert_allclose(way(given), POSES, atol=1e-5)
        for single in (meshes[0], points(meshes[0])):
            np.testing.assert_allclose(way(single, 1), POSES[:1], atol=1e-5)


def test_points_of_a_legacy_mesh_of_open3d_are_positions() -> None:
    open3d = pytest.importorskip("open3d")
    points = [open3d.utility.Vector3dVector(pose) for pose in POSES]
    np.testing.assert_allclose(by_transfer(tuple(points)), POSES, atol=1e-9)
    np.testing.assert_allclose(by_transfer(points[0]), POSES[:1], atol=1e-9)


def test_paths_are_poses(tmp_path: Path) -> None:
    files = [tmp_path / f"{k}.ply" for k in range(2)]
    for mesh, file in zip(MESHES, files, strict=True):
        mesh.write(file)
    for way in (by_transfer, by_interpolation):
        for given in (files, tuple(files), tuple(map(str, files))):
            np.testing.assert_allclose(way(given), POSES, atol=1e-5)
        np.testing.assert_allclose(way(files[0], 1), POSES[:1], atol=1e-5)


def test_two_poses_of_whole_numbers_in_a_list_are_two_poses() -> None:
    """As voxels have: the second is no list of triangles, although it could be one."""
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    assert len(list(listed_poses([cube, 2 * cube]))) == 2
    assert len(list(listed_poses((cube, cube)))) == 1  # a tuple is the pair that `as_surface` takes


def test_inputs_are_as_they_were() -> None:
    given = POSES.copy()
    by_transfer(given)
    by_interpolation(given)
    np.testing.assert_array_equal(given, POSES)


def test_each_layer_of_a_meshset_is_a_pose_and_of_several_their_current_meshes() -> None:
    """The reference is the current mesh; layers out of sight count, and a deleted one does not."""
    pymeshlab = pytest.importorskip("pymeshlab")
    layers = pymeshlab.MeshSet()
    for positions in (POSES[0], X.vertices, 2 * X.vertices, POSES[1]):
        layers.add_mesh(pymeshlab.Mesh(positions, X.faces))
    layers.set_current_mesh(2)
    layers.delete_current_mesh()
    layers.set_current_mesh(1)
    layers.set_mesh_visibility(3, False)
    expected = np.stack([POSES[0], X.vertices, POSES[1]])
    np.testing.assert_array_equal([mesh.vertex_matrix() for mesh in listed_poses(layers)], expected)
    moved = qg.transfer_deformation(layers, layers, X, SAME)
    np.testing.assert_allclose(moved.positions, expected, atol=1e-9)
    np.testing.assert_allclose(qg.interpolate(layers, layers, [1, 2, 3]).positions, expected, atol=1e-9)
    assert len(list(qg.transferred_poses(layers, [layers, layers], X, SAME))) == 2
    np.testing.assert_allclose(by_transfer([layers, layers]), [X.vertices, X.vertices], atol=1e-9)
    one = pymeshlab.MeshSet()
    one.add_mesh(pymeshlab.Mesh(POSES[1], X.faces))
    np.testing.assert_allclose(by_transfer(one, 1), POSES[1:], atol=1e-9)
    with pytest.raises(qg.MeshError, match="the MeshSet has no meshes"):
        qg.transfer_deformation(X, pymeshlab.MeshSet(), X, SAME)
