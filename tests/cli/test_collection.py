"""``qgeo collection``: a folder of meshes to a store, tables and a report; ``qgeo run`` over a folder."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import grid
from small_collection import QUICK, written
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.collection import collection as module
from qgeo_filters.errors import ParameterError
from qgeo_filters.report import html

pandas = pytest.importorskip("pandas")
pytest.importorskip("zarr")

Qgeo = Callable[..., Result]
Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Collections go by quick parameters where none are given; the store keeps them."""
    monkeypatch.setattr(module, "MatchingParameters", lambda: QUICK)


def test_from_a_folder_to_tables_and_a_report(qgeo: Qgeo, loaded: Loaded, quick: None) -> None:
    folder = written(Path("poses"), 3)
    (folder / "p10.off").write_text("OFF\n3 1 0\n0 0")
    run = partial(qgeo, "collection")
    result = run("build", "poses", "-o", "s.zarr", "--group-by", "^p[01]", "--workers", 1)
    assert (result.exit_code, result.stderr.count("\n")) == (1, 1)
    assert re.match(r"qgeo: p10: poses.p10.off: ", result.stderr)
    assert "3 of 3 shapes prepared, 0 of 3 pairs matched" in result.stdout
    status = json.loads(run("status", "s.zarr", "--json").stdout)
    assert (status["prepared"], status["matched"], status["pairs"]) == (3, 0, 3)
    assert [one["subject"] for one in status["problems"]] == ["p10"]
    # In parts, as a job array would, then all of it, which is there already.
    for part in ("1/2", "2/2", "1/1"):
        run("match", "s.zarr", "--part", part, "--workers", 1)
    assert run("match", "s.zarr", "--part", "3/2").exit_code == 2
    collection = qg.Collection.open("s.zarr")
    assert collection.groups == {"p0": "p0", "p1": "p1", "p2": ""}
    assert collection.settings.parameters == QUICK
    table = collection.table()
    assert len(table) == 3

    assert run("export", "s.zarr", "-o", "tables", "-q").exit_code == 0
    read = pandas.read_csv("tables/table.csv", keep_default_na=False)
    for name in ("x", "y", "c_xy", "d_s", "distortion", "explanation"):
        assert list(read[name]) == list(table[name]), name  # every bit
    square = pandas.read_csv("tables/c_xy.csv", index_col=0)
    np.testing.assert_array_equal(square, collection.distances("c_xy"))
    assert list(square.columns) == list(square.index) == ["p0", "p1", "p2"]

    assert run("report", "s.zarr", "-o", "report", "--pages", 2).exit_code == 0
    content, arrays = loaded(Path("report"))
    assert content["results"]["matched"] == 3
    np.testing.assert_array_equal(arrays["distortion"], collection.distances("distortion"))
    assert list(arrays["names"]) == ["p0", "p1", "p2"]
    page = Path("report/report.html").read_text(encoding="utf-8")
    links = re.findall(r'<a href="(pair_[^"]*)">([^<]*)</a>', page)
    assert len(links) == 2
    assert "1 pairs have no page" in page
    assert "poses/p10.off" in page
    assert {path.stem for path in Path("report").glob("*.png")} == {"c_xy", "dendrogram", "embedding"}
    for file, title in links:
        x, y = title.replace("\u00a0", " ").split(" - ")
        own = Path("report", file).read_text(encoding="utf-8")
        assert f"<h1>{x} - {y}</h1>" in own
        assert own.count("data:image/png;base64,") == 2
        assert '<a href="report.html">' in own
        assert html.formatted(collection.map(x, y).c_xy) in own


@pytest.mark.slow
def test_landmarks_and_one_connectivity_from_a_folder(qgeo: Qgeo, loaded: Loaded, quick: None) -> None:
    """The table of a folder by one command; the second goes on with the store that the first one made."""
    folder, marks = written(Path("poses"), 3), [3, 70]
    own = qg.Surface.read(folder / "p1.ply")
    qg.write_landmarks("marks.csv", qg.Landmarks(("head", "tail"), own.vertices[marks]))
    result = qgeo("collection", "landmarks", "poses", "marks.csv", "--on", "p1", "-o", "carried", "--workers", 1)
    assert result.exit_code == 0, result.output
    table = pandas.read_csv("carried/landmarks.csv")
    assert list(table.columns) == ["shape", "landmark", "x", "y", "z"]
    assert list(table["landmark"]) == 3 * ["head", "tail"]
    for name, rows in table.groupby("shape"):
        shape = qg.Surface.read(folder / f"{name}.ply")
        gaps = np.linalg.norm(rows[["x", "y", "z"]].to_numpy() - shape.vertices[marks], axis=1)
        assert (gaps < (1e-6 if name == "p1" else 0.1 * np.sqrt(shape.area))).all()
    content, arrays = loaded(Path("carried"))
    assert (content["results"]["shapes"], content["results"]["without_image"]) == (3, 0)
    assert arrays["points"].shape == (3, 2, 3)
    assert Path("carried/landmarks.png").is_file()
    assert json.loads(qgeo("collection", "status", "shapes.zarr", "--json").stdout)["matched"] == 2

    # Where a pair is not matched, the tree goes by what needs no map.
    assert qgeo("collection", "report", "shapes.zarr", "-o", "report", "--pages", 0, "-q").exit_code == 0
    assert "eigenvalues of the Laplacian (not all pairs are matched)" in Path("report/report.html").read_text("utf-8")
    assert Path("report/dendrogram.png").is_file()

    asked = ("collection", "common", "shapes.zarr", "--template", "p0", "--maps", "all ways", "--workers", 1)
    assert qgeo(*asked, "-o", "same", "-q").exit_code == 0
    _, arrays = loaded(Path("same"))
    for name, positions in zip(arrays["shapes"], arrays["positions"], strict=True):
        mesh = qg.Surface.read(f"same/{name}.ply")
        np.testing.assert_array_equal(mesh.faces, qg.Surface.read(folder / "p0.ply").faces)
        np.testing.assert_allclose(mesh.vertices, positions, atol=1e-6)
    assert arrays["modes"].shape == (2, len(positions), 3)
    assert {path.stem for path in Path("same").glob("*.png")} == {"shapes", "modes"}
    mean, low, high = (qg.Surface.read(f"same/{name}.ply").vertices for name in ("mean", "mode0-", "mode0+"))
    np.testing.assert_allclose((low + high) / 2, mean, atol=1e-5)
    result = qgeo("collection", "landmarks", "shapes.zarr", "marks.csv", "--on", "p9")
    assert (result.exit_code, result.stderr) == (2, "qgeo: no shape is called 'p9'; there are p0, p1, p2\n")


@pytest.mark.slow
@pytest.mark.parametrize("maps", ["matched", "tree"])
def test_shapes_without_a_map_are_named_and_the_rest_goes_on(
    qgeo: Qgeo, loaded: Loaded, quick: None, maps: str
) -> None:
    """One that cannot be read and one that cannot be matched; what is found of the others is what is found without."""
    written(Path("good"), 3)
    own = qg.Surface.read("good/p1.ply")
    qg.write_landmarks("marks.csv", qg.Landmarks(("head",), own.vertices[[3]]))
    commands = {"landmarks": ["marks.csv", "--on", "p1"], "common": ["--template", "p1", "--accept-unsure"]}

    def run(folder: str, store: str) -> dict[str, tuple[Result, Path]]:
        found = {}
        for command, options in commands.items():
            out = Path(f"{folder}-{command}")
            place = ["--store", store, "--workers", 1, "--no-pictures", "-o", out, "--maps", maps]
            found[command] = qgeo("collection", command, folder, *options, *place), out
        return found

    expected = run("good", "good.zarr")
    assert [one.exit_code for one, _ in expected.values()] == [0, 0]
    written(Path("some"), 3)
    Path("some/gone.off").write_text("no mesh")
    qg.Surface(*grid(2)).write("some/few.off")
    for command, (result, out) in run("some", "some.zarr").items():
        assert result.exit_code == 1
        few, gone, count = (line for line in result.stderr.splitlines() if "warning" not in line)
        assert few == "qgeo: few: matching needs at least 60 vertices, got 9"
        assert gone.startswith("qgeo: gone: some/gone.off: ")
        assert count == "qgeo: 2 of 5 shapes were left out"
        content, arrays = loaded(out)
        assert [one["path"] for one in content["results"]["left_out"]] == ["few", "gone"]
        for name, values in loaded(expected[command][1])[1].items():
            np.testing.assert_array_equal(arrays[name], values)
    result = qgeo("collection", "common", "some.zarr", "--template", "few", "--workers", 1)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert result.stderr.startswith("qgeo: few - p0: matching needs at least 60 vertices")


def test_run_is_build_and_match(qgeo: Qgeo, quick: None) -> None:
    written(Path("poses"), 2)
    result = qgeo("collection", "run", "poses/p0.ply", "poses/p1.ply", "-o", "s.zarr", "--workers", 1, "--json")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["matched"] == 1


def test_bad_input_is_a_line(qgeo: Qgeo, quick: None) -> None:
    written(Path("poses"), 2)
    Path("mine").mkdir()
    Path("mine/thesis.tex").write_text("")
    for arguments, message in (
        (("build", "nowhere"), "nowhere"),
        (("build", "mine", "-o", "s.zarr"), "a folder without mesh files"),
        (("build", "poses", "-o", "mine"), "mine is there and is no collection of shapes"),
        (("build", "poses", "--group-by", "("), "--group-by: '(' is no regular expression"),
        (("build", "poses", "--part", "3"), "--part must be K/N, such as 3/40, got '3'"),
        (("status", "nowhere.zarr"), "no such collection: nowhere.zarr"),
        (("match", "mine"), "mine is there and is no collection of shapes"),
        (("report", "nowhere.zarr"), "no such collection"),
        (("match",), "Missing argument 'STORE'"),
        (("polish",), "No such command 'polish'"),
    ):
        result = qgeo("collection", *arguments)
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1), arguments
        assert message in result.stderr
    result = qgeo("collection", "run", "poses", "-o", "t.zarr", "--within-groups")
    assert (result.exit_code, "the shapes have no groups" in result.stderr) == (2, True)


def test_links_are_escaped() -> None:
    page = html.report_page("t", tables=[html.Table("T", [(html.Link('<"a">', 'b "c".html'), 1)])])
    assert '<a href="b%20%22c%22.html">&lt;&quot;a&quot;&gt;</a>' in page


def test_run_over_a_folder_goes_on_after_a_bad_file(qgeo: Qgeo, loaded: Loaded) -> None:
    """broken.off cannot be read, fan.off has no distances; the others are computed."""
    qg.Pipeline([qg.QuasiGeodesicDistances()]).save("pipe.yaml")
    result = qgeo("run", "pipe.yaml", ".", "--no-pictures", "--no-repair", "-q")
    assert result.exit_code == 1
    said = result.stderr.splitlines()
    assert [line.split(":")[1].strip() for line in said[:-1]] == ["broken.off", "fan.off"]
    assert said[-1] == "qgeo: 2 of 6 meshes have no results"
    (below,) = Path("qgeo-out").glob("run-pipe-*")  # the folder's own name is that of the test
    folders = {path.name for path in below.iterdir()}
    assert folders == {"blob", "mirror", "sphere", "square"}
    for name in folders:
        assert "qgeo_distance" in loaded(below / name)[1]


def test_parts_are_two_numbers() -> None:
    from qgeo_filters.cli.collection import checked_text, grouped_by

    assert checked_text("3/40") == (3, 40)
    for text in ("3", "a/b", "3/40/5", "-1/2", ""):
        with pytest.raises(ParameterError, match="--part must be K/N"):
            checked_text(text)
    assert grouped_by("^([a-z]+)[0-9]")("cat10") == "cat"
    assert grouped_by("^[a-z]+")("cat10") == "cat"
    assert grouped_by("^([a-z]+)[0-9]")("10") == ""
