"""``qgeo compatibility``: D(S) is 0 for one shape moved about, and what the function layer says for poses."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import grid, moebius
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.matching.compatibility import compatibility

Qgeo = Callable[..., Result]
Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]


@pytest.fixture
def poses(meshes: Path) -> list[str]:
    """The blob, the blob elsewhere, and the blob stretched."""
    blob = qg.Surface.read(meshes / "blob.off")
    qg.Surface(blob.vertices[:, [1, 2, 0]] + 4, blob.faces).write(meshes / "moved.off")
    qg.Surface(blob.vertices * [1.0, 1.0, 1.3], blob.faces).write(meshes / "stretched.off")
    return ["blob.off", "moved.off", "stretched.off"]


def test_compatibility(qgeo: Qgeo, loaded: Loaded, poses: list[str]) -> None:
    result = qgeo("compatibility", *poses, "-k", 8)
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out/compatibility-blob-moved-stretched"))
    expected = compatibility([qg.Surface.read(name) for name in poses], k=8)
    np.testing.assert_allclose(arrays["c_xy"], expected.c_xy, atol=1e-6)
    assert arrays["d_s"] == content["results"]["d_s"] == pytest.approx(expected.d_s)
    assert content["results"]["c_xy_of_the_baselines"] < 1e-3 < content["results"]["largest_c_xy"]
    assert arrays["maps"].shape == (3, 162)
    assert len(content["meshes"]) == 3
    assert {"poses.png", "c_xy.png", "blob.ply", "moved.ply", "stretched.ply"} <= set(content["files"])


def test_a_pose_that_cannot_be_read_is_named_and_the_rest_goes_on(qgeo: Qgeo, loaded: Loaded, poses: list[str]) -> None:
    """What is found of the others is what is found without it, their places among the results included."""
    assert qgeo("compatibility", *poses, "-k", 5, "--baselines", 1, 2, "--no-pictures", "-o", "all").exit_code == 0
    Path("bad").mkdir()
    Path("bad/moved.off").write_text("no mesh")
    options = ["-k", 5, "--baselines", 2, 3, "-o", "out", "-q"]
    result = qgeo("compatibility", "blob.off", "bad/moved.off", *poses[1:], *options)
    assert (result.exit_code, result.stderr.count("\n")) == (1, 2)
    first, last = result.stderr.splitlines()
    assert "bad/moved.off" in first
    assert last == "qgeo: 1 of 4 poses were left out"
    content, arrays = loaded(Path("out"))
    assert [one["path"] for one in content["results"]["left_out"]] == ["bad/moved.off"]
    assert [mesh["path"] for mesh in content["meshes"]] == poses
    for name, expected in loaded(Path("all"))[1].items():
        np.testing.assert_array_equal(arrays[name], expected)


def test_a_pose_that_cannot_be_matched_is_named_and_the_rest_goes_on(
    qgeo: Qgeo, loaded: Loaded, poses: list[str]
) -> None:
    """One too small to be matched, one of too few vertices for k, and a one-sided one, among poses of one mesh."""
    assert qgeo("compatibility", *poses, "-k", 8, "--no-pictures", "-o", "all").exit_code == 0
    qg.Surface(*grid(1)).write("few.off")
    qg.Surface(*moebius()).write("band.off")
    names = [*poses[:2], "square.obj", "few.off", "band.off", poses[2]]
    result = qgeo("compatibility", *names, "-k", 8, "-o", "out")
    assert result.exit_code == 1
    few, band, square, count = result.stderr.splitlines()
    assert few.startswith("qgeo: few.off: k must be between 1 and the number of vertices, 4")
    assert square.startswith("qgeo: square.obj: matching needs at least 60 vertices")
    assert band.startswith("qgeo: band.off: the sign of the mean curvature needs neighbouring faces that agree")
    assert "--repair" in band  # not repair=True, which is of the function
    assert count == "qgeo: 3 of 6 poses were left out"
    assert re.search("Left out.*few.off.*band.off.*square.obj", result.stdout, re.DOTALL)
    content, arrays = loaded(Path("out"))
    assert [one["path"] for one in content["results"]["left_out"]] == ["few.off", "band.off", "square.obj"]
    assert [mesh["path"] for mesh in content["meshes"]] == poses
    assert content["results"]["maps"] == "equal vertex numbers"
    assert "band.off" in Path("out/report.html").read_text(encoding="utf-8").partition("Left out")[2]
    for name, expected in loaded(Path("all"))[1].items():
        np.testing.assert_array_equal(arrays[name], expected)


def test_a_baseline_that_cannot_be_matched_is_refused_by_its_own_name(qgeo: Qgeo, poses: list[str]) -> None:
    """The square is the third pose that there is."""
    result = qgeo("compatibility", *poses[:2], "broken.off", "square.obj", poses[2], "--baselines", 0, 3)
    assert result.exit_code == 2
    first, last = result.stderr.splitlines()
    assert "broken.off" in first
    assert last.startswith("qgeo: surfaces[2] (square.obj): matching needs")
    assert not Path("qgeo-out").exists()


@pytest.mark.slow
def test_maps_between_different_meshes_are_found_as_by_the_function(
    qgeo: Qgeo, loaded: Loaded, poses: list[str]
) -> None:
    """Beside one that cannot be matched."""
    blob = qg.Surface.read("blob.off")
    order = np.random.default_rng(0).permutation(blob.n_vertices)
    qg.Surface(blob.vertices[order], np.argsort(order)[blob.faces]).write("shuffled.off")
    names = [poses[0], poses[2], "shuffled.off"]
    assert (
        qgeo("compatibility", *names[:2], "square.obj", names[2], "-k", 6, "--no-pictures", "-o", "out").exit_code == 1
    )
    content, arrays = loaded(Path("out"))
    expected = compatibility(names, k=6)
    assert content["results"]["maps"] == "found by match"
    np.testing.assert_array_equal(arrays["maps"], expected.maps)
    np.testing.assert_allclose(arrays["c_xy"], expected.c_xy, atol=1e-6)
    # Most vertices go to where they truly are in the new order.
    assert (order[arrays["maps"][2]] == np.arange(blob.n_vertices)).mean() > 0.9


def test_a_baseline_that_cannot_be_read_is_refused(qgeo: Qgeo, poses: list[str]) -> None:
    Path("moved.off").write_text("no mesh")
    for names in (poses, poses[:2], [*poses, "blob.off"]):
        result = qgeo("compatibility", *names)
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
        assert "moved.off" in result.stderr
        assert not Path("qgeo-out").exists()


def test_baselines(qgeo: Qgeo, loaded: Loaded, poses: list[str]) -> None:
    assert qgeo("compatibility", *poses, "-k", 5, "--baselines", 1, 2, "--no-pictures").exit_code == 0
    content, arrays = loaded(Path("qgeo-out/compatibility-blob-moved-stretched"))
    assert content["results"]["c_xy_of_the_baselines"] == arrays["c_xy"][1, 2]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ((), "two poses or more, got 1"),
        (("blob.off", "--baselines", "0", "5"), "baselines"),
        (("blob.off", "-k", "0"), "0"),
    ],
)
def test_bad_input(qgeo: Qgeo, options: tuple[str, ...], expected: str) -> None:
    result = qgeo("compatibility", "blob.off", *options)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert expected in result.stderr
    assert not Path("qgeo-out").exists()
