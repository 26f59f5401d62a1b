"""A folder with small mesh files, and the command line in this process."""

from __future__ import annotations

import functools
import importlib.resources
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from shapes import blob, fan, grid, icosphere
from typer.testing import CliRunner, Result

from qgeo_filters.cli import app
from qgeo_filters.report import panels
from qgeo_filters.report.glossary import meaning
from qgeo_filters.surface import Surface


def bilateral() -> tuple[np.ndarray, np.ndarray]:
    """A closed shape of 162 vertices with one symmetry, the reflection in the plane x = 0."""
    vertices, faces = icosphere(2)
    x, y, z = vertices.T
    radius = 1 + 0.3 * y + 0.2 * z * y + 0.25 * x**2 * y - 0.15 * z**3
    return np.column_stack([0.8 * x, 1.4 * y, z]) * radius[:, None], faces


@pytest.fixture
def meshes(tmp_path: Path) -> Path:
    """Folder with sphere.ply, blob.off, square.obj, mirror.off, fan.off (three faces on an edge) and broken.off."""
    for name, shape in (
        ("sphere.ply", icosphere(2)),
        ("blob.off", blob(2)),
        ("square.obj", grid(6)),
        ("mirror.off", bilateral()),
        ("fan.off", fan()),
    ):
        Surface(*shape).write(tmp_path / name)
    (tmp_path / "broken.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 nan\n3 0 1 9\n")
    return tmp_path


@pytest.fixture
def qgeo(meshes: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    """Runs ``qgeo`` in the folder of the meshes, with pictures of few pixels."""
    monkeypatch.chdir(meshes)
    monkeypatch.setattr(panels, "DPI", 40)
    return lambda *args: CliRunner().invoke(app, [str(arg) for arg in args])


@pytest.fixture
def loaded() -> Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]:
    """Loads the numbers and arrays of a result folder, after the checks that hold for every command."""
    return _loaded


@functools.cache
def validator() -> jsonschema.Draft202012Validator:
    """What says whether a result.json is as the schema in the package has it."""
    schema = json.loads((importlib.resources.files("qgeo_filters.cli") / "result.schema.json").read_text("utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def _loaded(folder: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The numbers and arrays of a result folder, after the checks that hold for every command."""
    content = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert sorted(content["files"]) == sorted(path.name for path in folder.iterdir() if path.is_file())
    assert {"command", "qgeo_filters", "parameters", "results", "seconds"} <= set(content)
    assert ("mesh" in content) != ("meshes" in content)
    validator().validate(content)
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "http:" not in page
    assert "https:" not in page
    if content["command"] != "run":  # whose results are named by the filters
        assert not [name for name in content["results"] if not meaning(name, content["command"])]
    for name in content["files"]:
        if name.endswith(".png"):
            assert (folder / name).read_bytes().startswith(b"\x89PNG")
    assert page.count("data:image/png;base64,") == sum(name.endswith(".png") for name in content["files"])
    with np.load(folder / "result.npz", allow_pickle=False) as arrays:
        return content, dict(arrays)
