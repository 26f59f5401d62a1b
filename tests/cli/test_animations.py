"""``qgeo transfer`` and ``qgeo interpolate``: what the functions say, in files."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from in_pieces import in_pieces
from shapes import arched, creature
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.filters import stages

Qgeo = Callable[..., Result]
Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]

X = qg.Surface(*creature(1.0, 2))


@pytest.fixture
def folder(meshes: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder ``walk`` with the creature at rest and two poses, and a match of it with itself that is known."""
    (meshes / "walk").mkdir()
    X.write(meshes / "walk" / "0.ply")
    for number, curvature in ((2, 0.2), (10, 0.5)):
        X.with_vertices(arched(X.vertices, curvature)).write(meshes / "walk" / f"{number}.ply")
    X.write(meshes / "other.ply")
    return meshes


def test_a_folder_of_poses_becomes_poses_of_the_other(qgeo: Qgeo, loaded: Loaded, folder: Path) -> None:
    result = qgeo("transfer", "walk", "--onto", "other.ply", "--no-align", "--animate", "walk.glb")
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out/transfer-0-other"))
    files = {"other_2.ply", "other_10.ply", "walk.glb", "film_strip.png", "0.ply", "other.ply"}
    assert files <= set(content["files"])
    assert arrays["positions"].shape == (2, X.n_vertices, 3)
    for frame, curvature in enumerate((0.2, 0.5)):  # 2 comes before 10
        gaps = np.linalg.norm(arrays["positions"][frame] - arched(X.vertices, curvature), axis=1)
        assert gaps.mean() < 0.01 * np.sqrt(X.area)
    np.testing.assert_allclose(
        qg.Surface.read("qgeo-out/transfer-0-other/other_10.ply").vertices, arrays["positions"][1], atol=1e-5
    )
    assert content["results"]["frames"] == 2
    assert content["results"]["confident"] is True
    assert content["results"]["mean_edge_change"] == pytest.approx(
        content["results"]["mean_edge_change_of_x"], abs=0.02
    )


@pytest.mark.slow
@pytest.mark.parametrize("scans", [[], ["--scans", "--accept-unsure"]])
def test_poses_that_cannot_be_used_are_named_and_the_rest_goes_on(
    qgeo: Qgeo, loaded: Loaded, folder: Path, scans: list[str]
) -> None:
    """The others are what they are without the bad ones, bit for bit."""
    alone = qgeo("transfer", "walk", "--onto", "other.ply", "--no-pictures", "-o", "alone", "-q", *scans)
    assert alone.exit_code == 0, alone.stderr
    (folder / "walk" / "1.ply").write_text("no mesh")
    qg.Surface(X.vertices[:4], [[0, 1, 2], [0, 2, 3]]).write(folder / "walk" / "11.ply")
    result = qgeo("transfer", "walk", "--onto", "other.ply", "--no-pictures", "-q", *scans)
    first, second, last = (line for line in result.stderr.splitlines() if "warning" not in line)
    assert result.exit_code == 1
    assert "walk/1.ply" in first
    assert second.startswith("qgeo: walk/11.ply: ")
    assert last == "qgeo: 2 of 4 poses have no results"
    content, arrays = loaded(Path("qgeo-out/transfer-0-other"))
    assert [Path(one["path"]).name for one in content["results"]["left_out"]] == ["1.ply", "11.ply"]
    assert {"other_2.ply", "other_10.ply", "animation.glb"} <= set(content["files"])
    assert not {"other_1.ply", "other_11.ply"} & set(content["files"])
    np.testing.assert_array_equal(arrays["positions"], loaded(Path("alone"))[1]["positions"])


def test_lost_coordinates_and_mirror_images_are_named(qgeo: Qgeo, loaded: Loaded, folder: Path) -> None:
    """One NaN in an OBJ file, and a pose that was exported with an axis turned."""
    X.write(folder / "walk" / "3.obj")
    lines = (folder / "walk" / "3.obj").read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("v "))
    lines[first + 5] = "v nan 0 0"
    (folder / "walk" / "3.obj").write_text("\n".join(lines) + "\n")
    X.with_vertices(X.vertices * [1, -1, 1]).write(folder / "walk" / "4.ply")
    result = qgeo("transfer", "walk", "--onto", "other.ply", "--no-pictures", "-q")
    assert result.exit_code == 1
    assert result.stderr.splitlines() == [
        "qgeo: walk/3.obj: 1 of 162 vertices are not finite, the first is 5",
        "qgeo: walk/4.ply: inside out, as a mirror image of the reference is: reflect one of the two first",
        "qgeo: 2 of 4 poses have no results",
    ]
    assert loaded(Path("qgeo-out/transfer-0-other"))[0]["results"]["frames"] == 2


@pytest.mark.parametrize("command", [("transfer", "walk", "--onto"), ("interpolate", "walk/0.ply")])
def test_an_unsure_map_is_refused_with_what_to_do_and_hints_reach_the_search(
    qgeo: Qgeo, loaded: Loaded, folder: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...]
) -> None:
    """A search that is sure of what it is told, and of nothing else."""
    order = np.random.default_rng(0).permutation(X.n_vertices)
    shuffled = qg.Surface(X.vertices[order], np.argsort(order)[X.faces])
    shuffled.write(folder / "shuffled.ply")
    found = qg.match(X, shuffled)
    told = []

    def search(x: qg.Surface, y: qg.Surface, *args: Any, landmarks: Any = None, **options: Any) -> qg.MatchResult:
        told.append(None if landmarks is None else landmarks.tolist())
        return dataclasses.replace(found, confident=landmarks is not None, explanation="the tail may be a leg")

    monkeypatch.setattr(stages, "correspondence_of", search)
    refused = qgeo(*command, "shuffled.ply", "--no-pictures")
    assert refused.exit_code == 2
    about = "pose 0 (shuffled.ply): " if command[0] == "interpolate" else ""
    assert refused.stderr.splitlines()[-1] == (
        f"qgeo: {about}the correspondence is not sure: the tail may be a leg. Look at it with qgeo match, give "
        "landmarks with --hints, or say --accept-unsure"
    )
    (folder / "hints.csv").write_text("x,y\n3,5\n10,12 # a foot\n")
    for name, vertices in (("x", X.vertices), ("y", shuffled.vertices)):
        rows = "\n".join(f"{part},{','.join(map(str, vertices[v]))}" for part, v in (("tail", 7), ("nose", 9)))
        (folder / f"{name}.csv").write_text(f"name,x,y,z\n{rows}\n")
    for hints in (["hints.csv"], ["x.csv", "y.csv"]):
        options = [word for file in hints for word in ("--hints", file)]
        result = qgeo(*command, "shuffled.ply", "--no-pictures", *options, "-o", hints[0].removesuffix(".csv"))
        assert result.exit_code == 0, result.stderr
        content, _ = loaded(Path(hints[0].removesuffix(".csv")))
        assert content["parameters"]["hints"] == hints
    assert told == [None, [[3, 5], [10, 12]], [[7, 7], [9, 9]]]


def test_without_a_good_pose_there_is_no_result(qgeo: Qgeo, folder: Path) -> None:
    for number in (2, 10):
        (folder / "walk" / f"{number}.ply").write_text("no mesh")
    result = qgeo("transfer", "walk", "--onto", "other.ply", "--no-pictures")
    assert (result.exit_code, result.stderr.splitlines()[-1]) == (1, "qgeo: 2 of 2 poses have no results")
    assert not Path("qgeo-out").exists()


def test_the_way_through_poses(qgeo: Qgeo, loaded: Loaded, folder: Path) -> None:
    result = qgeo("interpolate", "walk/0.ply", "walk/2.ply", "walk/10.ply", "--frames", 5)
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out/interpolate-0-2-10"))
    assert arrays["times"].tolist() == [0, 0.5, 1, 1.5, 2]
    expected = qg.interpolate(X, [X.with_vertices(arched(X.vertices, c)) for c in (0.2, 0.5)], arrays["times"])
    np.testing.assert_allclose(arrays["positions"], expected.positions, atol=1e-4)
    assert {"animation.glb", "film_strip.png"} <= set(content["files"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("transfer", "walk/0.ply", "--onto", "other.ply"), "no poses"),
        (("transfer", "walk", "--onto", "other.ply", "--animate", "a.avi"), ".glb, .gif, .mp4 or .npz"),
        (("transfer", "walk", "--onto", "other.ply", "--animate", "a/b.glb"), "-o says in which folder"),
        (("transfer", "walk", "--onto", "walk-empty"), "a folder without mesh files"),
        (("transfer", "walk", "missing.ply", "--onto", "other.ply"), "missing.ply"),
        (("interpolate", "walk/0.ply", "missing.ply"), "missing.ply"),
        (("interpolate", "walk/0.ply", "walk/2.ply", "--frames", "1"), "frames"),
        (("interpolate", "walk/0.ply", "walk/2.ply", "--frames", "0"), "frames"),
        (("transfer", "walk", "--onto", "other.ply", "--hints", "bad.csv"), "bad.csv"),
        (("transfer", "walk", "--onto", "other.ply", "--hints", "far.csv"), "999999"),
        (("interpolate", "walk/0.ply", "walk/2.ply", "--hints", "far.csv"), "999999"),
        (("interpolate", "walk/0.ply", "walk/2.ply", "--hints", "good.csv"), "vertex by vertex"),
        (("interpolate", "walk/0.ply", "walk/2.ply", "walk/10.ply", "--hints", "good.csv"), "of one pose"),
        (("transfer", "walk", "--onto", "other.ply", *(3 * ["--hints", "good.csv"])), "hints are one file"),
    ],
)
def test_bad_input(
    qgeo: Qgeo, folder: Path, arguments: tuple[str, ...], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "walk-empty").mkdir()
    for name, text in (("bad", "tail,17\n"), ("far", "3,999999\n"), ("good", "3,3\n")):
        (folder / f"{name}.csv").write_text(text)
    monkeypatch.setattr(stages, "correspondence_of", lambda *args, **options: pytest.fail("searched before that"))
    result = qgeo(*arguments)
    assert result.exit_code == 2, result.stderr
    assert said in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.slow
def test_the_advice_to_wrap_is_taken(qgeo: Qgeo, loaded: Loaded, meshes: Path) -> None:
    """What --wrap does is what the functions do with repair="wrap", on the vertices of the files."""
    whole = creature(level=3)
    pieces = {name: qg.Surface(*in_pieces(whole, seed)) for seed, name in enumerate("xy")}
    pieces["pose"] = pieces["x"].with_vertices(arched(pieces["x"].vertices, 0.4))
    for name, surface in pieces.items():
        surface.write(meshes / f"{name}.off")
    x, pose, y = (qg.Surface.read(f"{name}.off") for name in ("x", "pose", "y"))
    for command, *arguments in (
        ("transfer", "x.off", "pose.off", "--onto", "y.off"),
        ("interpolate", "x.off", "y.off", "--frames", 2),
    ):
        refused = qgeo(command, *arguments, "--no-pictures")
        assert refused.exit_code == 2
        assert "--wrap for a closed surface around all of it" in refused.stderr
        taken = qgeo(command, *arguments, "--no-pictures", "--wrap", "-o", command)
        assert taken.exit_code == 0, taken.stderr
        assert "wrapped in a closed surface" in taken.stdout
    content, arrays = loaded(Path("transfer"))
    assert content["parameters"]["repair"] == "wrap"
    np.testing.assert_allclose(
        arrays["positions"], qg.transfer_deformation(x, [pose], y, repair="wrap").positions, atol=1e-9
    )
    _, arrays = loaded(Path("interpolate"))
    way = qg.interpolate(x, y, [0, 1], qg.match(x, y, repair="wrap"))
    np.testing.assert_allclose(arrays["positions"], way.positions, atol=1e-9)
