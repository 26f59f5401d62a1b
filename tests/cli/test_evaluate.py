"""``qgeo evaluate``: a data set in TOSCA's layout, made of one bilateral shape whose maps are known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree
from typer.testing import Result

import qgeo_filters as qg

Qgeo = Callable[..., Result]
Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]


@pytest.fixture
def dataset(meshes: Path) -> Path:
    """tosca/ with egg0, egg1 and egg2: the bilateral shape with its vertices in three orders."""
    shape = qg.Surface.read(meshes / "mirror.off")
    root = meshes / "tosca"
    for folder in ("remeshed", "ground_truth", "symmetry"):
        (root / folder).mkdir(parents=True)
    for number in range(3):
        order = np.random.default_rng(number).permutation(shape.n_vertices)
        faces = np.argsort(order)[shape.faces]
        qg.Surface((1 + number) * shape.vertices[order], faces).write(root / f"remeshed/egg{number}.off")
        tables = {"full_of_vertex": order, "vertex_of_full": np.argsort(order)}
        np.savez(root / f"ground_truth/egg{number}.npz", **tables)
    image = cKDTree(shape.vertices).query(shape.vertices * [-1, 1, 1])[1]
    np.savetxt(root / "symmetry/egg.sym", image + 1, fmt="%d")
    return root


def test_matches(qgeo: Qgeo, loaded: Loaded, dataset: Path) -> None:
    result = qgeo("evaluate", "tosca", "--root", dataset, "--pairs", 2)
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out"))
    found = content["results"]
    assert (found["pairs"], found["failed"], found["mirrored"]) == (2, 0, 0)
    assert found["mean_error"] == arrays["errors"].mean() < 0.01
    assert len(arrays["errors"]) == len(arrays["pair"]) == 2 * 162
    table = Path("qgeo-out/table.md").read_text(encoding="utf-8")
    assert [line.split("|")[1].strip() for line in table.splitlines()[2:]] == ["egg", "all"]
    assert qgeo("evaluate", "tosca", "--root", dataset, "--pairs", 2, "--no-pictures", "-o", "again").exit_code == 0
    again, _ = loaded(Path("again"))
    assert [row["name"] for row in again["results"]["rows"]] == [row["name"] for row in found["rows"]]


def test_symmetries(qgeo: Qgeo, loaded: Loaded, dataset: Path) -> None:
    result = qgeo("evaluate", "tosca", "--root", dataset, "--what", "symmetry", "--pairs", 1, "--no-pictures")
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out"))
    assert content["results"]["pairs"] == 1
    assert arrays["errors"].mean() < 0.01


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("tosca", "--root", "nowhere"), "nowhere is not a folder"),
        (("tosca", "--root", "."), "no meshes of ToscaRemeshed"),
        (("tosca", "--root", "tosca", "--category", "cow"), "no category 'cow'"),
        (("tosca", "--root", "tosca", "--pairs", "0"), "--pairs must be at least 1"),
        (("shapes", "--root", "tosca"), "shapes"),
    ],
)
def test_bad_input(qgeo: Qgeo, dataset: Path, options: tuple[str, ...], expected: str) -> None:
    result = qgeo("evaluate", *options)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert expected in result.stderr


def test_a_missing_truth_is_named(qgeo: Qgeo, dataset: Path) -> None:
    (dataset / "ground_truth/egg1.npz").unlink()
    result = qgeo("evaluate", "tosca", "--root", dataset)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "no ground truth for egg1" in result.stderr
