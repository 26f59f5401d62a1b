"""Animations as scenes and films, read back by other programs."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation
from shapes import arched, creature, icosphere

import qgeo_filters as qg
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.report.film import checked_seconds, plot_film_strip
from qgeo_filters.report.reel import reels


@pytest.fixture(scope="module")
def transfer() -> qg.Transfer:
    x = qg.Surface(*creature(1.0, 2))
    poses = [arched(x.vertices, curvature) for curvature in (0.2, 0.4, 0.6)]
    return qg.transfer_deformation(x, poses, x, np.arange(x.n_vertices), align=False)


def document(path: Path) -> tuple[dict[str, Any], bytes]:
    """JSON and buffer of a binary glTF."""
    content = path.read_bytes()
    length = struct.unpack("<I", content[12:16])[0]
    return json.loads(content[20 : 20 + length]), content[28 + length :]


def numbers(tree: dict[str, Any], buffer: bytes, accessor: int) -> np.ndarray:
    one = tree["accessors"][accessor]
    view = tree["bufferViews"][one["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3}[one["type"]]
    start = view.get("byteOffset", 0)
    return np.frombuffer(buffer, "<f4", one["count"] * width, start).reshape(one["count"], -1)


def test_morph_targets_are_the_frames(transfer: qg.Transfer, tmp_path: Path) -> None:
    qg.write_animation(tmp_path / "film.glb", transfer, seconds=2.0, names=("horse", "camel"))
    tree, buffer = document(tmp_path / "film.glb")
    assert tree["buffers"][0]["byteLength"] == len(buffer)
    assert transfer.source is not None
    for name, animation in (("horse", transfer.source), ("camel", transfer)):
        node = next(k for k, node in enumerate(tree["nodes"]) if node.get("name") == name)
        mesh = tree["meshes"][tree["nodes"][node]["mesh"]]
        part = mesh["primitives"][0]
        first = numbers(tree, buffer, part["attributes"]["POSITION"])
        for frame, target in enumerate(part["targets"], start=1):
            moved = first + numbers(tree, buffer, target["POSITION"])
            np.testing.assert_allclose(moved, animation.positions[frame], atol=1e-5)
            normals = numbers(tree, buffer, part["attributes"]["NORMAL"]) + numbers(tree, buffer, target["NORMAL"])
            np.testing.assert_allclose(normals, animation[frame].vertex_normals, atol=1e-5)
        channel = next(c for c in tree["animations"][0]["channels"] if c["target"]["node"] == node)
        sampler = tree["animations"][0]["samplers"][channel["sampler"]]
        assert numbers(tree, buffer, sampler["input"]).ravel().tolist() == [0.0, 1.0, 2.0]
        weights = numbers(tree, buffer, sampler["output"]).reshape(3, 2)
        assert weights.tolist() == [[0, 0], [1, 0], [0, 1]]
        assert mesh["weights"] == [0, 0]


def test_another_library_opens_the_scene(transfer: qg.Transfer, tmp_path: Path) -> None:
    import trimesh

    qg.write_animation(tmp_path / "film.glb", transfer)
    scene = trimesh.load(tmp_path / "film.glb")
    assert {len(mesh.vertices) for mesh in scene.geometry.values()} == {transfer.surface.n_vertices}


def test_a_single_frame_is_a_scene_without_a_track(transfer: qg.Transfer, tmp_path: Path) -> None:
    qg.write_animation(tmp_path / "one.glb", qg.Animation(transfer.surface, transfer.positions[:1]))
    assert "animations" not in document(tmp_path / "one.glb")[0]


def test_a_gif_has_the_frames_and_the_time(transfer: qg.Transfer, tmp_path: Path) -> None:
    qg.write_animation(tmp_path / "film.gif", transfer, seconds=0.9)
    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == 3
        assert film.info["duration"] == 300
        pictures = []
        for frame in range(3):
            film.seek(frame)
            pictures.append(np.asarray(film.convert("RGB")).astype(int))
    assert np.abs(pictures[0] - pictures[2]).max() > 50
    assert pictures[0].shape[1] > pictures[0].shape[0]  # two shapes side by side


@pytest.mark.parametrize(("frames", "seconds"), [(1, 2.0), (3, 2.0), (24, 2.0), (48, 4.0)])
def test_few_frames_do_not_flicker_by(frames: int, seconds: float) -> None:
    assert checked_seconds(None, frames) == pytest.approx(seconds)


def test_an_mp4_has_the_frames(transfer: qg.Transfer, tmp_path: Path) -> None:
    encoder = pytest.importorskip("imageio_ffmpeg")
    qg.write_animation(tmp_path / "film.mp4", transfer, seconds=1.0)
    assert encoder.count_frames_and_secs(str(tmp_path / "film.mp4"))[0] == 3


def test_arrays_are_written_as_well(transfer: qg.Transfer, tmp_path: Path) -> None:
    qg.write_animation(tmp_path / "film.npz", transfer)
    assert np.array_equal(qg.Animation.from_npz(tmp_path / "film.npz").positions, transfer.positions)


@pytest.mark.parametrize(
    ("name", "seconds", "said"),
    [
        ("film.avi", None, ".glb, .gif, .mp4 or .npz"),
        ("film.gif", 0.0, "positive"),
        ("film.glb", np.nan, "positive"),
        ("film.glb", "2", "positive"),
        ("film.glb", True, "positive"),
        ("film.gif", 1e9, "a frame of a film lasts from 0.001 to 60 s: 3 frames do not fit 1e\\+09 s"),
        ("film.mp4", 1e-9, "a frame of a film lasts"),
    ],
)
def test_what_cannot_be_written_is_refused(
    transfer: qg.Transfer, tmp_path: Path, name: str, seconds: float | None, said: str
) -> None:
    with pytest.raises(qg.ParameterError, match=said):
        qg.write_animation(tmp_path / name, transfer, seconds=seconds)
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_animation_is_not_written(transfer: qg.Transfer, tmp_path: Path) -> None:
    for name in ("film.glb", "film.gif", "film.npz"):
        for given in (transfer.surface, list(transfer), None):
            with pytest.raises(qg.ParameterError, match="an Animation is written, or a Transfer, got"):
                qg.write_animation(tmp_path / name, given)
    for names in ("XY", ("X",), ("X", "Y", "Z")):
        with pytest.raises(qg.ParameterError, match="names must be two"):
            qg.write_animation(tmp_path / "film.glb", transfer, names=names)
    assert list(tmp_path.iterdir()) == []


def test_two_shapes_of_one_name_both_move(transfer: qg.Transfer, tmp_path: Path) -> None:
    """As of horse.obj in two folders: the nodes of a scene are known by their names."""
    qg.write_animation(tmp_path / "film.glb", transfer, names=("horse", "horse"))
    tree, _ = document(tmp_path / "film.glb")
    moving = {channel["target"]["node"] for channel in tree["animations"][0]["channels"]}
    assert {tree["nodes"][node]["name"] for node in moving} == {"horse X", "horse Y"}
    assert all("targets" in mesh["primitives"][0] for mesh in tree["meshes"])


def test_what_is_up_is_told_by_y_at_rest_and_not_by_a_pose_that_lies() -> None:
    ball, faces = icosphere(2)
    height = (ball[:, 2] + 1) / 2
    top = qg.Surface(np.c_[ball[:, :2] * (1 - 0.9 * height)[:, None], height], faces)  # it stands along z
    lying = top.vertices @ Rotation.from_rotvec([np.pi / 2, 0, 0]).as_matrix()
    place = BarycentricMap.at_vertices(np.arange(top.n_vertices), top.faces, top.n_vertices)
    moved = qg.Transfer(top, [lying], source=qg.Animation(top.with_vertices(lying), [lying]), place=place)
    for reel in reels(moved):
        assert reel.view.vertical.tolist() == [0, 0, 1]
    assert reels(qg.Animation(top, [lying]))[0].view.vertical.tolist() == [0, 1, 0]


def test_a_film_strip_shows_both_shapes_in_one_scale(transfer: qg.Transfer) -> None:
    figure = plot_film_strip(transfer, 3)
    assert len(figure.axes) == 6
    content = io.BytesIO()
    figure.savefig(content)
    shown = [axes.images[0].get_array() for axes in figure.axes]
    assert all(np.array_equal(a.shape, b.shape) for a, b in zip(shown[:3], shown[3:], strict=True))
    # The same poses of the same shape, in the same colours.
    assert np.abs(shown[0].astype(int) - shown[3].astype(int)).mean() < 3
    assert len(plot_film_strip(transfer, 99).axes) == 6
