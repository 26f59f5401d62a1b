"""Where results go that are not told so: results of other files are never replaced."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

from qgeo_filters.cli.default_folder import default_folder

Qgeo = Callable[..., Result]


def paths(folder: str) -> str:
    """File of the mesh whose results a folder holds."""
    return json.loads(Path("qgeo-out", folder, "result.json").read_text())["mesh"]["path"]


def test_meshes_of_one_name_have_folders_of_their_own(qgeo: Qgeo) -> None:
    Path("other").mkdir()
    Path("other/blob.off").write_bytes(Path("sphere.ply").with_name("blob.off").read_bytes())
    for mesh in ("blob.off", "other/blob.off", "blob.off", "./other/blob.off"):
        assert qgeo("info", mesh, "--no-pictures", "-q").exit_code == 0
    assert {path.name for path in Path("qgeo-out").iterdir()} == {"info-blob", "info-blob-2"}
    assert (paths("info-blob"), paths("info-blob-2")) == ("blob.off", "other/blob.off")


def test_batches_do_not_replace_each_other(qgeo: Qgeo) -> None:
    for folder in ("a", "b"):
        Path(folder, "scans").mkdir(parents=True)
        Path(folder, "scans", "blob.off").write_bytes(Path("blob.off").read_bytes())
    for folder in ("a/scans", "b/scans", "a/scans"):
        assert qgeo("info", folder, "--no-pictures", "-q").exit_code == 0
    assert {path.name for path in Path("qgeo-out/info-scans").iterdir()} == {"blob", "blob-2"}
    assert paths("info-scans/blob-2") == "b/scans/blob.off"


@pytest.mark.parametrize(
    ("command", "names", "expected"),
    [
        ("match", ["cat0", "cat3"], "match-cat0-cat3"),
        ("demo", [], "demo"),
        ("collection report", ["teeth"], "collection-report-teeth"),
        ("compatibility", ["a", "b", "c"], "compatibility-a-b-c"),
        ("compatibility", list("abcdef"), "compatibility-a-b-and-4-more"),
        ("info", ["x" * 300], f"info-{'x' * 60}"),
        ("info", ["é" * 300], f"info-{'é' * 30}"),
        ("info", ["caf\udce9"], "info-caf"),
    ],
)
def test_names_of_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, names: list[str], expected: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert default_folder(command, names) == Path("qgeo-out", expected)


def test_a_folder_of_something_else_is_not_taken_for_results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for content in ("", "[]", "{}", '{"mesh": 3}', '{"meshes": [1]}', "["):
        folder = tmp_path / "qgeo-out" / "info-x"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "result.json").write_text(content)
        assert default_folder("info", ["x"], [Path("x.off")]) == Path("qgeo-out/info-x")
