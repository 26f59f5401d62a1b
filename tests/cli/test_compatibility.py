"""``qgeo compatibility``: D(S) is 0 for one shape moved about, and what the function layer says for poses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
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
