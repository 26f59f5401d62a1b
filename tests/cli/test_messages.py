"""What is said: which file, which of two meshes, what to do; names as they are; disk, memory, warnings in a line."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.cli import mesh as info_command
from qgeo_filters.errors import MeshError, QgeoError, concerning, one_line, reason
from qgeo_filters.evaluation import runner
from qgeo_filters.filters import stages
from qgeo_filters.matching import compatibility
from qgeo_filters.report import html

Qgeo = Callable[..., Result]
QGEO = [sys.executable, "-c", "from qgeo_filters.cli import main; main()"]

NAMES = [
    "a [bold]name",
    "[red]",
    "[-]",
    "two  spaces ",
    ":star:",
    "$x$ and $",
    r"\frac",
    "<b>&amp;",
    "-dash",
    ".hidden",
    "%s {0}",
    "名前 é",
    "😀",
]


@pytest.mark.parametrize("name", NAMES)
def test_names_are_printed_as_they_are(qgeo: Qgeo, name: str) -> None:
    Path("blob.off").rename(f"{name}.off")
    result = qgeo("info", "--no-pictures", "--", f"{name}.off")
    assert result.exit_code == 0, result.output
    assert f"info  {name}.off" in result.stdout
    assert f"result.json, result.npz, {name}.ply, report.html in qgeo-out/info-{name}" in result.stdout
    listed = json.loads(Path(f"qgeo-out/info-{name}/result.json").read_text(encoding="utf-8"))
    assert listed["mesh"]["path"] == f"{name}.off"
    escaped = name.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    assert f"<h1>qgeo info: {escaped}.off</h1>" in Path(f"qgeo-out/info-{name}/report.html").read_text(encoding="utf-8")
    Path(f"{name}.off").write_text("OFF\n1 1 0\n")
    result = qgeo("info", "--", f"{name}.off")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert result.stderr.startswith(f"qgeo: {name}.off: ")


def test_names_in_pictures_are_no_formulas(qgeo: Qgeo) -> None:
    for name in ("$x^$_$.off", "名前.off"):
        qg.Surface.read("blob.off").write(name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = qgeo("compatibility", "$x^$_$.off", "名前.off")
    assert (result.exit_code, result.stderr) == (0, "")
    assert "$x^$_$" in result.stdout


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="names that are no text are Linux's")
def test_a_name_that_is_no_text(meshes: Path) -> None:
    name = b"caf\xe9"
    os.rename(meshes / "blob.off", os.path.join(os.fsencode(meshes), name + b".off"))
    for code, expected in ((0, ""), (2, "is read by this command")):
        output = [] if code == 0 else ["-o", "."]
        if code == 2:
            os.rename(
                os.path.join(os.fsencode(meshes), b"qgeo-out/info-caf/" + name + b".ply"),
                os.path.join(os.fsencode(meshes), name + b".ply"),
            )
        mesh = os.fsdecode(name) + (".off" if code == 0 else ".ply")
        done = subprocess.run(
            [*QGEO, "info", mesh, *output], cwd=meshes, capture_output=True, text=True, errors="replace", check=False
        )
        assert done.returncode == code, done.stderr
        assert expected in done.stderr
    assert r'"path": "caf\udce9.off"' in (meshes / "qgeo-out/info-caf/result.json").read_text(encoding="utf-8")


# -- which mesh ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        (("distances", "fan.off", "--no-repair"), "fan.off: "),
        (("spectrum", "two.off"), "two.off: "),
        (("symmetry", "square.obj"), "square.obj: matching needs at least"),
        (("path", "two.off", 0, 200), "two.off: "),
        (("run", "pipe.yaml", "fan.off", "--no-repair"), "fan.off: "),
        (("match", "square.obj", "blob.off"), "X (square.obj): matching needs at least 60 vertices, got 49"),
        (("match", "blob.off", "square.obj"), "Y (square.obj): matching needs at least 60 vertices, got 49"),
        (("match", "blob.off", "broken.off"), "Y (broken.off): "),
        (("match", "broken.off", "blob.off"), "X (broken.off): "),
        (("compatibility", "blob.off", "square.obj"), "surfaces[1] (square.obj): matching needs"),
        (("compatibility", "blob.off", "broken.off", "blob.off"), "surfaces[1] (broken.off): "),
        (("match", "blob.off", "nowhere.off"), "nowhere.off"),
    ],
)
def test_the_mesh_is_named(qgeo: Qgeo, command: tuple[object, ...], expected: str) -> None:
    qg.Pipeline([qg.QuasiGeodesicDistances()]).save("pipe.yaml")
    sphere = qg.Surface.read("sphere.ply")
    vertices = np.concatenate([sphere.vertices, sphere.vertices + 5])
    qg.Surface(vertices, np.concatenate([sphere.faces, sphere.faces + 162])).write("two.off")
    result = qgeo(*command, "--no-pictures")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert expected in result.stderr
    for path in ("square.obj", "broken.off"):
        assert result.stderr.count(path) <= 1


def test_the_library_says_which_shape() -> None:
    good, bad = qg.testing.sample_surface(), qg.Surface(np.eye(3), [[0, 1, 2]])
    for pair, name in (((bad, good), "X"), ((good, bad), "Y")):
        with pytest.raises(MeshError, match=rf"^{name}: matching needs at least"):
            qg.match(*pair)
        with pytest.raises(QgeoError, match=rf"^{name}: vertices must be"):
            qg.match(*[shape if shape is good else ("no", "mesh") for shape in pair])
    for poses, number in (((bad, good), 0), ((good, bad), 1)):
        with pytest.raises(QgeoError, match=rf"^surfaces\[{number}\]: "):
            compatibility.compatibility(poses)


def test_an_error_keeps_its_kind_and_its_cause() -> None:
    first = MeshError("no mesh")
    with pytest.raises(MeshError, match=r"^X: no mesh$") as caught, concerning("X"):
        raise first
    assert caught.value.__cause__ is first


# -- disk, memory, warnings ---------------------------------------------------------------------------


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EROFS, errno.EACCES])
@pytest.mark.parametrize("name", ["result.npz", "blob.ply", "surface.png", "report.html", "result.json"])
def test_what_the_disk_refuses_is_a_line_that_names_the_file(
    qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch, number: int, name: str
) -> None:
    replace = os.replace

    def failing(source: str, target: Path) -> None:
        if Path(target).name == name:
            raise OSError(number, os.strerror(number), source, None, str(target))
        replace(source, target)

    monkeypatch.setattr(os, "replace", failing)
    result = qgeo("info", "blob.off", "-o", "out")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"qgeo: out/{name}: {os.strerror(number)}")
    assert result.stderr.count("\n") == 1
    assert not [path.name for path in Path("out").iterdir() if path.name.startswith(".")]


def test_a_mesh_that_the_disk_cannot_give_is_named(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*arguments: object) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(qg.Surface, "read", failing)
    result = qgeo("info", "blob.off")
    assert (result.exit_code, result.stderr) == (2, f"qgeo: blob.off: {os.strerror(errno.EIO)}\n")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="an output that is always full is Linux's")
@pytest.mark.parametrize("options", [("--json",), ()])
def test_an_output_that_is_full(meshes: Path, options: tuple[str, ...]) -> None:
    with Path("/dev/full").open("wb") as full:
        command = [*QGEO, "info", "blob.off", "--no-pictures", *options]
        done = subprocess.run(command, cwd=meshes, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == "qgeo: standard output: No space left on device: make room, or write elsewhere\n"


def too_large(*arguments: object, **options: object) -> None:
    """Asks for more than any machine has."""
    np.empty((10**9, 10**9))


def test_too_little_memory_is_a_line(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stages, "matrix_of", too_large)
    monkeypatch.setattr("qgeo_filters.filters.spectral.QuasiGeodesicSpectrum.apply", too_large)
    monkeypatch.setattr(stages, "prepared_shape_of", too_large)
    asked = "nable to allocate 6.94 EiB for an array with shape (1000000000, 1000000000) and data type float64"
    for command, mesh, ways in (
        (("distances", "blob.off"), "blob.off", ("--matrix", "--sources")),
        (("spectrum", "blob.off"), "blob.off", ("--landmarks 1000",)),
        (("match", "sphere.ply", "blob.off"), "X (sphere.ply)", ()),
    ):
        result = qgeo(*command)
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
        assert result.stderr.startswith(f"qgeo: not enough memory: {mesh} of 162 vertices: ")
        for word in (asked, "use a mesh of fewer vertices", *ways):
            assert word in result.stderr
        assert ("--landmarks" in result.stderr) == (command[0] == "spectrum")


def test_too_little_memory_without_a_word(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*arguments: object) -> None:
        raise MemoryError

    monkeypatch.setattr(info_command, "details", failing)
    result = qgeo("info", "blob.off")
    assert result.exit_code == 2
    assert result.stderr == (
        "qgeo: not enough memory: blob.off of 162 vertices: MemoryError; use a mesh of fewer vertices\n"
    )
    assert isinstance(qgeo("--debug", "info", "blob.off").exception, MemoryError)


def test_a_warning_is_a_line(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    true = info_command.details

    def warning(surface: qg.Surface) -> dict[str, object]:
        warnings.warn("mind\nthe [gap]  here", stacklevel=2)
        return true(surface)

    monkeypatch.setattr(info_command, "details", warning)
    result = qgeo("info", "blob.off", "--no-pictures")
    assert (result.exit_code, result.stderr) == (0, "qgeo: warning: mind the [gap]  here\n")
    assert qgeo("info", "blob.off", "--no-pictures", "-q").stderr == ""


def test_no_reason_is_empty() -> None:
    assert reason(ValueError(" one\n  two  three\r\n")) == "one two  three"
    assert one_line("\n a  b \n\n c ") == "a  b c"
    for error in (EOFError(), MemoryError(), ValueError("\n"), OSError()):
        assert reason(error) == type(error).__name__
    for error in (qg.QgeoError(), OSError(), MemoryError()):
        assert runner.PairFailure("a", "b", error).reason


def test_a_report_of_names_that_are_no_text(tmp_path: Path) -> None:
    html.write_report(tmp_path / "report.html", "caf\udce9")
    assert r"<h1>caf\udce9</h1>" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_landmarks_are_auto_all_or_a_number(qgeo: Qgeo) -> None:
    result = qgeo("spectrum", "blob.off", "--landmarks", "many")
    assert (result.exit_code, result.stderr) == (2, "qgeo: --landmarks must be auto, all or a number, got 'many'\n")
    for said, source in (("auto", "all distances"), ("all", "all distances"), ("60", "60 landmarks")):
        result = qgeo("spectrum", "blob.off", "-k", "4", "--no-pictures", "--json", "--landmarks", said)
        assert json.loads(result.stdout)["results"]["from"] == source


def test_a_matrix_that_does_not_fit_names_the_options(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qgeo_filters.memory.available_memory", lambda: 1000)
    qg.cache.clear()
    result = qgeo("distances", "blob.off")
    assert result.exit_code == 2
    assert result.stderr.startswith("qgeo: not enough memory: ")
    assert "the distances between all 162 vertices would take 0.000105 GB, and 1e-06 GB of memory" in result.stderr
    assert "--matrix" in result.stderr
    assert "out=" not in result.stderr
