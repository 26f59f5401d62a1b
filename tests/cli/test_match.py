"""``qgeo match``: a shape against itself with its vertices shuffled, where the truth is known."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from shapes import creature
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.caching import cache
from qgeo_filters.errors import ParameterError
from qgeo_filters.filters import stages
from qgeo_filters.io.hint_files import read_hints
from qgeo_filters.matching import reflection_search
from qgeo_filters.matching.hints import Hints

Qgeo = Callable[..., Result]
Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]


@pytest.fixture
def truth(meshes: Path) -> np.ndarray:
    """Vertex of other/blob.off for each of blob.off: larger, turned, somewhere else, in another order."""
    blob = qg.Surface.read(meshes / "blob.off")
    order = np.random.default_rng(3).permutation(blob.n_vertices)
    image = np.argsort(order)
    (meshes / "other").mkdir()
    vertices = 3.0 * blob.vertices[order] @ np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]) + 5.0
    qg.Surface(vertices, image[blob.faces]).write(meshes / "other/blob.off")
    return image


def test_match(qgeo: Qgeo, loaded: Loaded, truth: np.ndarray) -> None:
    np.savetxt("truth.txt", truth, fmt="%d")
    result = qgeo("match", "blob.off", "other/blob.off", "--truth", "truth.txt")
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out/match-blob-blob"))
    assert [mesh["path"] for mesh in content["meshes"]] == ["blob.off", "other/blob.off"]
    found = content["results"]
    np.testing.assert_array_equal(arrays["p2p"], truth)
    assert arrays["p2p"].dtype.kind == "i"
    assert arrays["score"] == found["score"] < 1e-5
    assert arrays["runner_up"] > arrays["score"]
    assert arrays["functional_map"].shape == (20, 20)
    assert found["confident"] is True
    assert found["explanation"]
    assert found["c_xy"] < 1e-3
    assert found["mean_error"] == 0.0
    assert found["percent_within_0.05"] == 100.0
    x, y = (qg.Surface.read(f"qgeo-out/match-blob-blob/blob-{number}.ply") for number in (1, 2))
    np.testing.assert_array_equal(x.attributes["qgeo_correspondence"], truth)
    np.testing.assert_array_equal(x.attributes["qgeo_region"], arrays["regions_x"])
    np.testing.assert_array_equal(y.attributes["qgeo_region"], arrays["regions_y"])
    np.testing.assert_array_equal(arrays["regions_x"], arrays["regions_y"][truth])
    np.testing.assert_allclose(y.vertices, qg.Surface.read("other/blob.off").vertices)
    pictures = {
        "match.png",
        "regions.png",
        "distortion.png",
        "distortion_histogram.png",
        "errors.png",
        "error_curve.png",
        "match_log.png",
        "match_log.md",
    }
    assert pictures <= set(content["files"])
    rows = Path("qgeo-out/match-blob-blob/match_log.md").read_text().splitlines()
    assert rows[2].endswith("| chosen |")
    assert len(rows) > 4


MARKS = {"nose": 3, "left, ear": 40, "tip": 101}


def placed(points: np.ndarray) -> np.ndarray:
    """Points of blob.off as they are on other/blob.off."""
    return 3.0 * points @ np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]) + 5.0


def test_landmarks_tables_and_scenes(qgeo: Qgeo, loaded: Loaded, truth: np.ndarray) -> None:
    """From a file of Slicer's to one of its kind, on the other shape; the map as a table; both shapes as a scene."""
    x, y = qg.Surface.read("blob.off"), qg.Surface.read("other/blob.off")
    vertices = np.array([*MARKS.values()])
    points = x.vertices[vertices].copy()
    points[2] = x.vertices[x.faces[7]].mean(axis=0)
    qg.write_landmarks("marks.fcsv", qg.Landmarks(list(MARKS), points, frame="RAS"))
    result = qgeo("match", "blob.off", "other/blob.off", "--landmarks", "marks.fcsv", "--csv", "--no-pictures")
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out/match-blob-blob"))
    assert {"landmarks_Y.fcsv", "landmarks.csv", "map.csv", "match.glb"} <= set(content["files"])
    assert content["parameters"]["landmarks"] == "marks.fcsv"
    found = qg.read_landmarks("qgeo-out/match-blob-blob/landmarks_Y.fcsv")
    assert (found.names, found.frame) == (tuple(MARKS), "RAS")
    np.testing.assert_allclose(found.points, placed(points), atol=1e-3)
    with Path("qgeo-out/match-blob-blob/landmarks.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == list(MARKS)
    assert [int(row["x_vertex"]) for row in rows[:2]] == vertices[:2].tolist()
    assert [int(row["y_vertex"]) for row in rows[:2]] == truth[vertices[:2]].tolist()
    assert [float(row["y_z"]) for row in rows] == found.points[:, 2].tolist()
    with Path("qgeo-out/match-blob-blob/map.csv").open(newline="") as file:
        assert [int(row["y_vertex"]) for row in csv.DictReader(file)] == truth.tolist()
    page = Path("qgeo-out/match-blob-blob/report.html").read_text()
    for said in ("left, ear", "match.glb", "landmarks_Y.fcsv"):
        assert said in page
    # The whole result comes back, and the scene shows both shapes where they do not touch, in equal colours.
    again = qg.MatchResult.from_npz("qgeo-out/match-blob-blob/result.npz")
    np.testing.assert_array_equal(again.p2p, arrays["p2p"])
    np.testing.assert_array_equal(again.landmarks(again.x.vertices[vertices]).vertices, truth[vertices])
    scene = trimesh.load("qgeo-out/match-blob-blob/match.glb", process=False)
    meshes = {name: scene.geometry[f"{name} mesh"] for name in "XY"}
    np.testing.assert_allclose(meshes["X"].vertices, x.vertices, atol=1e-6)
    np.testing.assert_allclose(meshes["Y"].vertices, y.vertices, atol=1e-5)
    colors = {name: mesh.visual.vertex_attributes["color"] for name, mesh in meshes.items()}
    assert np.abs(colors["X"].astype(int) - colors["Y"][truth]).max() <= 2
    assert len(np.unique(colors["Y"], axis=0)) > 100
    for name, shape, marks in (("X", x, points), ("Y", y, found.points)):
        for label, point in zip(MARKS, marks, strict=True):
            ball = scene.geometry[f"{name} {label}"]
            np.testing.assert_allclose(ball.vertices.mean(axis=0), point, atol=1e-3 * np.ptp(shape.vertices))
    bounds = {name: scene.geometry[f"{name} mesh"].copy().apply_transform(scene.graph[name][0]).bounds for name in "XY"}
    assert bounds["X"][1, 0] < bounds["Y"][0, 0]
    np.testing.assert_allclose(np.ptp(bounds["X"], axis=0), np.ptp(bounds["Y"], axis=0), rtol=0.3)  # seen alike


def test_landmarks_of_vertices_in_a_table(qgeo: Qgeo, truth: np.ndarray) -> None:
    Path("marks.csv").write_text("".join(f'"{name}",{vertex}\n' for name, vertex in MARKS.items()))
    command = (
        "match",
        "blob.off",
        "other/blob.off",
        "--landmarks",
        "marks.csv",
        "--no-pictures",
        "--no-glb",
        "--quiet",
    )
    assert qgeo(*command).exit_code == 0
    found = qg.read_landmarks("qgeo-out/match-blob-blob/landmarks_Y.csv")
    assert found.names == tuple(MARKS)
    assert found.vertices.tolist() == truth[list(MARKS.values())].tolist()
    assert not Path("qgeo-out/match-blob-blob/match.glb").exists()


@pytest.mark.parametrize(
    ("name", "text", "options", "expected"),
    [
        ("a.csv", "9 9 9\n", (), "a.csv: landmark 0 ('1') is"),
        ("a.csv", "tip,999\n", (), "landmarks of X[0] is vertex 999"),
        ("a.csv", "tip,x\n", (), "a.csv: line 1: 'x' is no number"),
        ("a.tps", "LM3=1\n0 0 1\nID=p\nLM3=1\n0 0 1\nID=q\n", (), "say which by --specimen: p, q"),
        ("a.csv", "0 0 1\n", ("--frame", "LPS"), "do not say whether they are RAS or LPS"),
        ("a.doc", "", (), "unknown suffix '.doc' of landmarks"),
    ],
)
def test_bad_landmarks_are_refused_before_the_match(
    qgeo: Qgeo, name: str, text: str, options: tuple[str, ...], expected: str
) -> None:
    Path(name).write_text(text)
    result = qgeo("match", "blob.off", "blob.off", "--landmarks", name, *options)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert name in result.stderr
    assert expected in result.stderr
    assert not Path("qgeo-out").exists()


def test_errors_are_measured_on_y(qgeo: Qgeo, loaded: Loaded, truth: np.ndarray) -> None:
    y = qg.Surface.read("other/blob.off")
    wrong = truth.copy()
    wrong[7] = truth[90]
    np.savez("truth.npz", truth=wrong, something_else=np.zeros(3))
    command = ("match", "blob.off", "other/blob.off", "--truth", "truth.npz", "--no-pictures")
    assert qgeo(*command).exit_code == 0
    _, arrays = loaded(Path("qgeo-out/match-blob-blob"))
    expected = qg.distances(y, [truth[7]])[0, truth[90]] / np.sqrt(y.area)
    assert arrays["errors"][7] == pytest.approx(expected, rel=1e-3)
    assert np.flatnonzero(arrays["errors"]).tolist() == [7]


def test_size_may_matter(qgeo: Qgeo, truth: np.ndarray) -> None:
    result = qgeo("match", "blob.off", "other/blob.off", "--no-normalize")
    assert result.exit_code == 2
    assert "--normalize" in result.stderr


@pytest.mark.parametrize(
    ("content", "expected"),
    [("0\n1\n", "each of the 162"), ("x\n", "not a list of vertices"), ("\n".join(["162"] * 162), "162")],
)
def test_bad_truth(qgeo: Qgeo, content: str, expected: str) -> None:
    Path("truth.txt").write_text(content)
    result = qgeo("match", "blob.off", "blob.off", "--truth", "truth.txt")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "truth.txt" in result.stderr
    assert expected in result.stderr
    assert not Path("qgeo-out").exists()


def test_truth_in_an_archive_of_unnamed_arrays(qgeo: Qgeo) -> None:
    np.savez("truth.npz", a=np.arange(162), b=np.arange(162))
    result = qgeo("match", "blob.off", "blob.off", "--truth", "truth.npz")
    assert result.exit_code == 2
    assert "a, b" in result.stderr


@pytest.mark.parametrize("max_bytes", [2 << 30, 0])
def test_what_belongs_to_a_shape_is_computed_once(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch, max_bytes: int) -> None:
    """A symmetric shape against itself: one descriptor, whatever the cache holds; no symmetry, as it is clear."""
    searched, measured = [], []
    search, measure = reflection_search.candidates, stages.distance_matrix
    monkeypatch.setattr(
        reflection_search, "candidates", lambda *args, **options: searched.append(1) or search(*args, **options)
    )
    monkeypatch.setattr(
        stages, "distance_matrix", lambda *args, **options: measured.append(1) or measure(*args, **options)
    )
    cache.clear()
    before = cache.max_bytes
    cache.configure(max_bytes=max_bytes)
    try:
        result = qgeo("match", "mirror.off", "mirror.off", "--no-pictures")
    finally:
        cache.configure(max_bytes=before)
    assert result.exit_code == 0, result.stderr
    assert not searched
    assert len(measured) == 1  # that of the metric that proposes maps first


def test_hints_from_a_file(qgeo: Qgeo, loaded: Loaded, truth: np.ndarray) -> None:
    """Pairs of vertices; one that contradicts the others is named."""
    pairs = np.array([[3, truth[3]], [50, truth[50]], [110, truth[110]], [7, truth[90]]])
    lines = ["x_vertex,y_vertex", *(f"{i},{j}" for i, j in pairs), "# that was all"]
    Path("hints.csv").write_text("\n".join(lines))
    command = ("match", "blob.off", "other/blob.off", "--hints", "hints.csv", "--no-pictures")
    result = qgeo(*command)
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out/match-blob-blob"))
    np.testing.assert_array_equal(arrays["landmarks"], pairs)
    assert arrays["landmark_errors"][:3].max() < 0.05 < 0.1 < arrays["landmark_errors"][3]
    assert (arrays["p2p"] == truth).mean() > 0.95
    said = f"landmark 3 (vertex 7 of X, vertex {truth[90]} of Y) contradicts the rest"
    assert content["results"]["explanation"].startswith(said)
    assert content["parameters"]["hints"] == ["hints.csv"]


def test_hints_from_two_files_of_landmarks(meshes: Path, truth: np.ndarray) -> None:
    """Of any format and in any order; those of equal names belong together, and a frame is that of the meshes."""
    x, y = (qg.Surface.read(meshes / path) for path in ("blob.off", "other/blob.off"))
    here, there = np.array([3, 50, 110]), truth[[110, 3, 50]]
    qg.write_landmarks(meshes / "x.csv", qg.Landmarks("abc", x.vertices[here]))
    qg.write_landmarks(meshes / "y.fcsv", qg.Landmarks("cab", y.vertices[there] * [-1, -1, 1], frame="RAS"))
    found = Hints.of(x, y, read_hints([meshes / "x.csv", meshes / "y.fcsv"], "LPS"))
    np.testing.assert_array_equal(found.landmarks, np.column_stack([here, truth[here]]))
    with pytest.raises(ParameterError, match="one of landmarks for X and one for Y, got 3"):
        read_hints([meshes / "x.csv"] * 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "hints.csv holds no pair of vertices"),
        ("x,y\n1,2\nnose,3", "line 3 is no pair of vertices: 'nose,3'"),
        ("1 2\n1 2 3", "line 2 has 3 numbers, expected a vertex of X and one of Y"),
        ("1.5 2", r"hints.csv: pairs[0, 0] is 1.5, not a whole number"),
        ("1 2\n1 3", "landmarks contradict each other: vertex 1 of X belongs to vertices 2, 3 of Y"),
        ("1 99999", "landmark 0 is vertex 99999 of Y"),
    ],
)
def test_hints_that_cannot_be_are_one_line(qgeo: Qgeo, truth: np.ndarray, text: str, message: str) -> None:
    Path("hints.csv").write_text(text)
    result = qgeo("match", "blob.off", "other/blob.off", "--hints", "hints.csv")
    assert result.exit_code == 2
    assert message in " ".join(result.stderr.split())
    assert not Path("qgeo-out").exists()


@pytest.mark.slow
@pytest.mark.parametrize("how", ["--partial", "--no-normalize"])
def test_a_part(qgeo: Qgeo, loaded: Loaded, how: str) -> None:
    """Half of the body: said to be a part, or of the size of one where sizes count."""
    body = qg.Surface(*creature())
    part, numbers = body.submesh(body.vertices[:, 1] > -0.25)
    part.write("part.off")
    body.write("body.off")
    np.savetxt("truth.txt", numbers, fmt="%d")
    result = qgeo("match", "part.off", "body.off", how, "--truth", "truth.txt")
    assert result.exit_code == 0, result.stderr
    content, arrays = loaded(Path("qgeo-out/match-part-body"))
    found = content["results"]
    assert found["confident"], found["explanation"]
    assert found["mean_error"] < 0.03
    assert found["overlap_x"] == 1.0
    assert found["overlap_y"] == pytest.approx(part.area / body.area, abs=0.05)
    assert (arrays["inverse"] < 0).mean() == pytest.approx(1 - found["overlap_y"], abs=0.1)
    assert found["vertices_of_y_reached"] <= part.n_vertices
    assert {"match.png", "distortion_histogram.png", "error_curve.png"} <= set(content["files"])
