"""``qgeo evaluate``: a data set in TOSCA's layout, made of one bilateral shape whose maps are known."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from known_match import known
from scipy.spatial import cKDTree
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters import fingerprint
from qgeo_filters.errors import ParameterError
from qgeo_filters.evaluation import BENCHMARKS, runner
from qgeo_filters.evaluation.errors import SymmetricErrors
from qgeo_filters.evaluation.tables import PairResult
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.prepared_shape import PreparedShape

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


def matched(x: PreparedShape, y: PreparedShape, **options: Any) -> MatchResult:
    """What `match` finds of two eggs, without a search: they lie alike and differ in size."""
    return known(x.given, y.given, np.sqrt(y.given.area / x.given.area) * x.given.vertices)


def test_matches(qgeo: Qgeo, loaded: Loaded, dataset: Path) -> None:
    result = qgeo("evaluate", "tosca", "--root", dataset, "--pairs", 2)
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out/evaluate-tosca"))
    found = content["results"]
    assert (found["pairs"], found["failed"], found["mirrored"]) == (2, 0, 0)
    assert found["mean_error"] == arrays["errors"].mean() < 0.01
    assert len(arrays["errors"]) == len(arrays["pair"]) == 2 * 162
    table = Path("qgeo-out/evaluate-tosca/table.md").read_text(encoding="utf-8")
    assert [line.split("|")[1].strip() for line in table.splitlines()[2:]] == ["egg", "all"]
    again = qgeo("evaluate", "tosca", "--root", dataset, "--pairs", 2, "--no-pictures")
    assert "2 of 2 results are those of an earlier run" in again.stderr, "the same pairs are chosen"
    chosen, _ = loaded(Path("qgeo-out/evaluate-tosca"))
    assert [row["name"] for row in chosen["results"]["rows"]] == [row["name"] for row in found["rows"]]


@pytest.mark.slow
def test_a_public_benchmark_in_two_processes(qgeo: Qgeo, loaded: Loaded, dataset: Path) -> None:
    """The same errors as in one, beside published ones; what the processes have kept is taken afterwards."""
    folder = dataset.parent / "faust"
    (folder / "corres").mkdir(parents=True)
    for number, file in enumerate(sorted((dataset / "remeshed").glob("*.off"))):
        qg.Surface.read(file).write(folder / f"tr_reg_{number:03}.off")
        with np.load(dataset / "ground_truth" / f"{file.stem}.npz") as tables:
            np.savetxt(folder / "corres" / f"tr_reg_{number:03}.vts", tables["vertex_of_full"] + 1, fmt="%d")
    command = ("evaluate", "faust_r", "--root", folder, "--pairs", 3, "--no-pictures")
    assert qgeo(*command, "-o", "one").exit_code == 0
    result = qgeo(*command, "-o", "two", "--processes", 2)
    assert result.exit_code == 0, result.stderr
    (one, errors), (two, same) = loaded(Path("one")), loaded(Path("two"))
    assert one["results"]["pairs"] == two["results"]["pairs"] == 3
    assert one["results"]["mirrored"] is None  # no left/right map is known
    np.testing.assert_array_equal(np.sort(errors["errors"]), np.sort(same["errors"]))
    assert {row["name"] for row in one["results"]["rows"]} == {row["name"] for row in two["results"]["rows"]}
    assert "Smooth Shells" in Path("two/report.html").read_text(encoding="utf-8")
    assert two["results"]["published"][-1]["error"] == 1.4
    result = qgeo(*command, "-o", "two")
    assert result.exit_code == 0, result.stderr
    assert "3 of 3 results are those of an earlier run" in result.stderr


def test_names_are_those_of_the_benchmarks() -> None:
    names = importlib.import_module("qgeo_filters.cli.evaluate").Name
    assert set(get_args(names)) == set(BENCHMARKS)


def test_symmetries(qgeo: Qgeo, loaded: Loaded, dataset: Path) -> None:
    result = qgeo("evaluate", "tosca", "--root", dataset, "--what", "symmetry", "--pairs", 1, "--no-pictures")
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out/evaluate-tosca-symmetry"))
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


def test_a_pair_that_cannot_be_measured_is_named_and_the_rest_goes_on(
    qgeo: Qgeo, loaded: Loaded, dataset: Path
) -> None:
    (dataset / "ground_truth/egg1.npz").unlink()
    (dataset / "remeshed/egg3.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 nan\n3 0 1 9\n")
    result = qgeo("evaluate", "tosca", "--root", dataset)
    assert (result.exit_code, result.stderr.count("\n")) == (1, 5)
    assert "egg0 - egg1: no ground truth for egg1" in result.stderr
    assert "egg2 - egg3: " in result.stderr
    content, _ = loaded(Path("qgeo-out/evaluate-tosca"))
    assert (content["results"]["pairs"], content["results"]["not_measured"]) == (1, 5)
    assert [row["name"] for row in content["results"]["rows"]] == ["egg0 - egg2"]
    assert content["results"]["reasons"][0]["name"] == "egg0 - egg1"
    assert "Not measured" in Path("qgeo-out/evaluate-tosca/report.html").read_text(encoding="utf-8")


def test_where_nothing_can_be_measured_the_first_reason_is_the_error(qgeo: Qgeo, dataset: Path) -> None:
    for number in range(3):
        (dataset / f"ground_truth/egg{number}.npz").unlink()
    result = qgeo("evaluate", "tosca", "--root", dataset)
    assert result.exit_code == 2
    assert result.stderr.splitlines()[-1].startswith("qgeo: no ground truth for egg0")


def test_an_interrupted_run_goes_on(qgeo: Qgeo, loaded: Loaded, dataset: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C in the second of three pairs: the first is not matched again, nor after that any."""
    turns: list[int] = []

    def counted(*args: Any, **options: Any) -> MatchResult:
        turns.append(len(turns))
        if len(turns) == 2:
            raise KeyboardInterrupt
        return matched(*args)

    monkeypatch.setattr(runner, "match", counted)
    command = ("evaluate", "tosca", "--root", dataset, "--no-pictures")
    assert qgeo(*command).exit_code == 130
    assert [file.name for file in Path("qgeo-out/evaluate-tosca/pairs").iterdir()] == ["egg0-egg1.npz"]
    result = qgeo(*command)
    assert result.exit_code == 0, result.stderr
    assert len(turns) == 4
    assert "1 of 3 results are those of an earlier run" in result.stderr
    first, arrays = loaded(Path("qgeo-out/evaluate-tosca"))
    assert qgeo(*command).exit_code == 0
    assert len(turns) == 4
    second, again = loaded(Path("qgeo-out/evaluate-tosca"))
    assert first["results"] == second["results"]
    np.testing.assert_array_equal(arrays["errors"], again["errors"])


def test_results_of_other_shapes_or_code_are_not_taken(
    qgeo: Qgeo, dataset: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runner, "match", matched)
    command = ("evaluate", "tosca", "--root", dataset, "--no-pictures", "--pairs", 1)
    assert qgeo(*command).exit_code == 0
    for mesh in (dataset / "remeshed").iterdir():
        shape = qg.Surface.read(mesh)
        shape.with_vertices(1.5 * shape.vertices).write(mesh)
    assert "earlier run" not in qgeo(*command).stderr
    assert "1 of 1 results" in qgeo(*command).stderr
    monkeypatch.setattr(fingerprint, "code_digest", lambda: "another version")
    assert "earlier run" not in qgeo(*command).stderr
    assert "1 of 1 results" in qgeo(*command).stderr


def test_a_file_of_the_users_among_the_pairs_is_met_before_anything_is_matched(
    qgeo: Qgeo, dataset: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runner, "match", None)
    folder = Path("qgeo-out/evaluate-tosca/pairs")
    folder.mkdir(parents=True)
    for name in ("egg0-egg1", "egg0-egg2", "egg1-egg2"):
        (folder / f"{name}.npz").write_bytes(b"PK mine")
    result = qgeo("evaluate", "tosca", "--root", dataset)
    assert result.exit_code == 2
    assert f"qgeo: egg0 - egg1: {folder}/egg0-egg1.npz is no" in result.stderr
    assert {file.read_bytes() for file in folder.iterdir()} == {b"PK mine"}


@pytest.mark.parametrize("foreign", ["nothing", "text", "array", "archive", "one array more", "link"])
def test_only_files_that_were_kept_are_taken_for_kept_pairs(tmp_path: Path, foreign: str) -> None:
    store = runner.PairStore(tmp_path / "pairs")
    errors = SymmetricErrors(np.zeros(3), np.ones(3))
    assert store.load("a - b", "a", "key") is None
    store.save(PairResult("a - b", "a", errors, True, 1.0, np.arange(3)), "key")
    kept = store.load("a - b", "a", "key")
    assert kept is not None
    np.testing.assert_array_equal(kept.p2p, np.arange(3))
    assert store.load("a - b", "a", "another key") is None
    (file,) = store.folder.iterdir()
    if foreign in ("nothing", "text"):
        file.write_bytes(b"" if foreign == "nothing" else b"PK not an archive")
    elif foreign == "array":
        with file.open("wb") as stream:
            np.save(stream, np.arange(3))
    elif foreign == "archive":
        np.savez(file, truth=np.arange(3))
    elif foreign == "one array more":
        with np.load(file) as arrays:
            np.savez(file, mine=np.arange(3), **arrays)
    else:
        file.rename(tmp_path / "kept.npz")
        file.symlink_to(tmp_path / "kept.npz")
    with pytest.raises(ParameterError, match=r"a-b\.npz is no"):
        store.load("a - b", "a", "key")
