"""Bad input gives exit code 2 and one line; what is written is whole; Ctrl-C keeps what was finished."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import Result

from qgeo_filters.surface import Surface

Qgeo = Callable[..., Result]

BAD = [
    (["info", "nowhere.off"], "nowhere.off"),
    (["info", "pipe.yaml"], "unknown suffix '.yaml'"),
    (["info", "broken.off"], "broken.off"),
    (["info"], "Missing argument 'MESH...'"),
    (["info", "sphere.ply", "--bogus"], "No such option: --bogus"),
    (["bogus"], "No such command 'bogus'"),
    (["distances", "fan.off", "--no-repair"], "edge (0, 1) has 3 faces"),
    (["distances", "fan.off", "--no-repair"], "--repair splits or removes them"),
    (["distances", "sphere.ply", "-s", "162"], "vertex 162, but there are 162 vertices"),
    (["distances", "sphere.ply", "-s", "-1"], "-1"),
    (["distances", "sphere.ply", "-s", "0,x"], "got '0,x'"),
    (["distances", "sphere.ply", "--method", "magic"], "magic"),
    (["distances", "sphere.ply", "--accuracy", "0"], "accuracy"),
    (["distances", "sphere.ply", "-s", "1", "--matrix", "d.zarr"], "leave out --sources"),
    (["distances", "sphere.ply", "--matrix", "d.zarr", "--method", "exact"], "graph method only"),
    (["distances", "sphere.ply", "--matrix", "blob.off"], "blob.off is there and is not a Zarr array"),
    (["distances", "sphere.ply", "--matrix", "."], "is there and is not a Zarr array"),
    (["distances", "sphere.ply", "--matrix", "nowhere/d.zarr"], "nowhere is not a folder"),
    (["distances", "fan.off", "--matrix", "d.zarr", "--no-repair"], "--repair splits or removes them"),
    (["distances", "sphere.ply", "--scalar", "nonsense", "-w", "1"], "unknown scalar 'nonsense'"),
    (["spectrum", "sphere.ply", "-k", "0"], "k must be between 1 and the number of vertices, 162, got 0"),
    (["spectrum", "sphere.ply", "-k", "163"], "got 163"),
    (["spectrum", "sphere.ply", "-w", "-1"], "-1"),
    (["symmetry", "sphere.ply", "--epsilon", "-1"], "epsilon must be positive, got -1.0"),
    (["symmetry", "sphere.ply", "--epsilon", "1", "--regions", "3"], "not both"),
    (["symmetry", "sphere.ply", "-k", "0"], "got 0"),
    (["path", "sphere.ply", "0", "162"], "J is vertex 162, but there are 162 vertices"),
    (["path", "sphere.ply", "0", "-1"], "No such option: -1"),
    (["path", "sphere.ply", "0"], "Missing argument 'J'"),
    (["path", "two.off", "0", "200"], "piece"),
    (["run", "nowhere.yaml", "sphere.ply"], "nowhere.yaml"),
    (["run", "pipe.yaml", "sphere.ply"], "pipe.yaml: steps[0]: unknown filter 'Magic'"),
    (["run", "sphere.ply", "sphere.ply"], "sphere.ply"),
    (["info", "sphere.ply", "-o", "blob.off"], "not a folder"),
]


@pytest.mark.parametrize(
    ("command", "expected"), BAD, ids=[f"{' '.join(command)}: {expected}" for command, expected in BAD]
)
def test_bad_input(qgeo: Qgeo, command: list[str], expected: str) -> None:
    Path("pipe.yaml").write_text("qgeo_pipeline: 1\nsteps: [{Magic: {}}]\n")
    sphere = Surface.read("sphere.ply")
    vertices, faces = (
        np.concatenate([sphere.vertices, sphere.vertices + 5]),
        np.concatenate([sphere.faces, sphere.faces + 162]),
    )
    Surface(vertices, faces).write("two.off")
    result = qgeo(*command)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.startswith("qgeo: ")
    assert result.stderr.count("\n") == 1
    assert expected in result.stderr
    assert not Path("qgeo-out").exists()
    assert not Path("d.zarr").exists()


def test_a_matrix_on_disk_that_is_not_this_one(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("zarr")
    from qgeo_filters.geodesics import storage

    assert qgeo("distances", "sphere.ply", "--matrix", "d.zarr", "-o", "first", "--no-pictures").exit_code == 0

    def refused(*command: object) -> str:
        result = qgeo("distances", *command, "--matrix", "d.zarr")
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
        assert not Path("qgeo-out").exists()
        return result.stderr

    assert "float32 array of shape (162, 162), not float32 (49, 49); choose another path" in refused("square.obj")
    assert "another mesh, metric or accuracy; choose another path, or delete it" in refused("blob.off")
    assert "another mesh, metric or accuracy" in refused("sphere.ply", "--accuracy", 1e-2)
    assert "another mesh, metric or accuracy" in refused("sphere.ply", "-w", 0.1, "--scalar", "differential_norm")
    Path("d.zarr").rename("other.zarr")
    read_only = SimpleNamespace(W_OK=os.W_OK, X_OK=os.X_OK, access=lambda *_: False)  # root may write anywhere
    monkeypatch.setattr(storage, "os", read_only)
    assert "read-only" in refused("sphere.ply")


def test_bad_meshes_among_several_are_named_and_the_rest_goes_on(qgeo: Qgeo) -> None:
    Path("pipe.yaml").write_text("qgeo_pipeline: 1\nsteps: [DifferentialCoordinates]\n")
    Path("few").mkdir()
    for name in ("sphere.ply", "broken.off"):
        Path(name).rename(f"few/{name}")
    Path("few/gone.off").symlink_to("elsewhere.off")
    for command in (["run", "pipe.yaml"], ["info"], ["distances"], ["spectrum", "-k", 3], ["symmetry", "--no-map"]):
        result = qgeo(*command, "few", "nowhere.off", "blob.off", "--no-pictures", "-q", "-o", "out")
        assert result.exit_code == 1
        said = result.stderr.splitlines()
        assert len(said) == 4
        assert said.pop(2) == "qgeo: no such file: few/gone.off"
        assert said[0] == "qgeo: no such file: nowhere.off"
        assert said[1].startswith("qgeo: few/broken.off: ")
        assert said[2] == "qgeo: 3 of 5 meshes have no results"
        assert {path.name for path in Path("out").iterdir()} == {"sphere", "blob"}
        for name in ("sphere", "blob"):
            assert json.loads(Path("out", name, "result.json").read_text())["command"] == command[0]


def test_a_full_disk_ends_a_batch(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    from qgeo_filters.cli.job import Job

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", "result.npz")

    monkeypatch.setattr(Job, "save", full)
    result = qgeo("info", "sphere.ply", "blob.off", "-q")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "No space left" in result.stderr


def test_one_matrix_file_is_of_one_mesh(qgeo: Qgeo) -> None:
    result = qgeo("distances", "sphere.ply", "blob.off", "--matrix", "d.zarr")
    assert result.exit_code == 2
    assert "--matrix is the file of one mesh" in result.stderr


def test_bad_input_leaves_an_earlier_result_alone(qgeo: Qgeo) -> None:
    assert qgeo("info", "sphere.ply").exit_code == 0
    before = {path.name: path.read_bytes() for path in Path("qgeo-out/info-sphere").iterdir()}
    assert qgeo("spectrum", "sphere.ply", "-k", 0).exit_code == 2
    assert {path.name: path.read_bytes() for path in Path("qgeo-out/info-sphere").iterdir()} == before


def test_too_large_a_matrix_is_refused_before_it_is_tried(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    from qgeo_filters.cli import geodesics

    monkeypatch.setattr(geodesics, "LARGEST_MATRIX", 1000)
    result = qgeo("distances", "sphere.ply")
    assert result.exit_code == 2
    assert "--sources" in result.stderr
    assert "--matrix FILE.zarr" in result.stderr


def test_debug_shows_the_traceback(qgeo: Qgeo) -> None:
    result = qgeo("--debug", "info", "nowhere.off")
    assert isinstance(result.exception, FileNotFoundError)


@pytest.mark.parametrize("kind", [ValueError, LookupError, KeyError, TypeError, ImportError, NotImplementedError])
def test_a_bug_is_not_taken_for_bad_input(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch, kind: type[Exception]) -> None:
    from qgeo_filters.cli import mesh

    def planted(surface: Surface) -> None:
        raise kind("a bug of ours")

    monkeypatch.setattr(mesh, "details", planted)
    result = qgeo("info", "sphere.ply")
    assert type(result.exception) is kind
    assert (result.exit_code, result.stderr) == (1, "")


def test_a_failing_write_leaves_no_part_of_a_file(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    def half(file, **arrays):  # type: ignore[no-untyped-def]
        file.write(b"half of it")
        raise OSError(28, "No space left on device", "result.npz")

    monkeypatch.setattr(np, "savez", half)
    result = qgeo("info", "sphere.ply")
    assert result.exit_code == 2
    assert result.stderr == "qgeo: result.npz: No space left on device: make room, or write elsewhere\n"
    assert list(Path("qgeo-out/info-sphere").iterdir()) == []


def test_interruption_keeps_what_is_finished(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    from qgeo_filters.report import figures

    def interrupted(*args: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(figures, "plot_spectrum", interrupted)
    result = qgeo("spectrum", "sphere.ply", "-k", 3)
    assert result.exit_code == 130
    assert result.stderr == "qgeo: interrupted; what was finished is kept\n"
    names = {path.name for path in Path("qgeo-out/spectrum-sphere").iterdir()}
    assert names == {"result.json", "result.npz", "sphere.ply", "eigenfunctions.png"}
    assert len(np.load("qgeo-out/spectrum-sphere/result.npz")["eigenvalues"]) == 3


# -- as a process -----------------------------------------------------------------------------------

QGEO = [sys.executable, "-c", "from qgeo_filters.cli import main; main()"]


def process(*command: object, cwd: Path, code: str = "") -> subprocess.CompletedProcess[str]:
    program = QGEO if not code else [sys.executable, "-c", code]
    return subprocess.run([*program, *map(str, command)], cwd=cwd, capture_output=True, text=True, check=False)


def test_process_succeeds(meshes: Path) -> None:
    done = process("info", "sphere.ply", "-q", cwd=meshes)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert (meshes / "qgeo-out/info-sphere/report.html").exists()


def test_process_needs_no_display(meshes: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if "DISPLAY" not in name}
    command = [*QGEO, "info", "sphere.ply", "-q"]
    done = subprocess.run(
        command, cwd=meshes, env={**environment, "MPLBACKEND": "QtAgg"}, capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")


def test_process_fails_in_one_line(meshes: Path) -> None:
    done = process("distances", "fan.off", "--no-repair", cwd=meshes)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "edge (0, 1) has 3 faces" in done.stderr


def test_process_shows_the_traceback_of_a_bug(meshes: Path) -> None:
    code = (
        "from qgeo_filters.report import figures\n"
        "def planted(*args):\n"
        "    raise ValueError('a bug of ours')\n"
        "figures.plot_surface = planted\n"
        "from qgeo_filters.cli import main\n"
        "main()\n"
    )
    done = process("info", "sphere.ply", cwd=meshes, code=code)
    assert done.returncode == 1
    assert done.stderr.startswith("Traceback")
    assert done.stderr.endswith("ValueError: a bug of ours\n")


def test_process_interrupted_by_a_signal(meshes: Path) -> None:
    """SIGINT in the middle of a picture."""
    code = (
        "import os, signal, time\n"
        # A shell starts what runs in the background with this signal ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from qgeo_filters.report import figures\n"
        "def wait(*args):\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "    time.sleep(60)\n"
        "figures.plot_surface = wait\n"
        "from qgeo_filters.cli import main\n"
        "main()\n"
    )
    done = process("info", "sphere.ply", cwd=meshes, code=code)
    assert done.returncode == 130
    assert done.stderr == "qgeo: interrupted; what was finished is kept\n"
    assert {path.name for path in (meshes / "qgeo-out/info-sphere").iterdir()} == {
        "result.json",
        "result.npz",
        "sphere.ply",
    }
