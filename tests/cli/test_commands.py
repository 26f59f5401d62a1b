"""Every command: what it leaves behind, loaded and compared with the function layer."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from rich.text import Text
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.caching import cache
from qgeo_filters.cli import app
from qgeo_filters.filters import stages
from qgeo_filters.geodesics.path.paths import quasi_geodesic
from qgeo_filters.parallel import available_cores, worker_count

Qgeo = Callable[..., Result]
Loaded = Callable[[Path], tuple[dict[str, Any], dict[str, np.ndarray]]]


def test_info(qgeo: Qgeo, loaded: Loaded) -> None:
    result = qgeo("info", "square.obj")
    assert result.exit_code == 0
    assert "boundary_loops" in result.stdout
    content, arrays = loaded(Path("qgeo-out/info-square"))
    found = content["results"]
    assert (found["vertices"], found["faces"], found["boundary_loops"], found["closed"]) == (49, 72, 1, False)
    assert found["area"] == pytest.approx(1.0)
    assert found["euler_characteristic"] == 1
    assert arrays["face_areas"].sum() == pytest.approx(1.0)
    assert Path("qgeo-out/info-square/surface.png").exists()


def test_info_describes_what_is_no_surface(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("info", "fan.off").exit_code == 0
    content, _ = loaded(Path("qgeo-out/info-fan"))
    assert content["results"]["manifold"] is False
    assert content["results"]["nonmanifold_edges"] == 1
    assert content["results"]["genus"] is None


def test_info_says_that_a_mesh_is_inside_out_or_not_welded(qgeo: Qgeo, loaded: Loaded) -> None:
    sphere = qg.Surface.read("sphere.ply")
    sphere.turned_over().write("inside_out.off")
    qg.Surface(sphere.vertices[sphere.faces].reshape(-1, 3), np.arange(960).reshape(-1, 3)).write("loose.off")
    for name, winding, unwelded, pieces in (
        ("sphere.ply", "outward", 0, 1),
        ("inside_out.off", "inward", 0, 1),
        ("loose.off", "outward", 960 - 162, 320),
        ("square.obj", "undetermined", 0, 1),
    ):
        assert qgeo("info", name, "--no-pictures", "-o", f"out-{name}").exit_code == 0
        found = loaded(Path(f"out-{name}"))[0]["results"]
        assert (found["winding"], found["unwelded_vertices"], found["pieces"]) == (winding, unwelded, pieces), name
    for name, said in (
        ("inside_out.off", "the mesh was inside out: 320 faces"),
        ("loose.off", "798 boundary vertices"),
    ):
        assert qgeo("info", name, "--repair", "--no-pictures", "-o", f"mended-{name}").exit_code == 0
        content, _ = loaded(Path(f"mended-{name}"))
        assert content["results"]["winding"] == "outward"
        assert content["results"]["closed"] is True
        assert content["mesh"]["repaired"][0].startswith(said)


def test_repair_is_reported(qgeo: Qgeo, loaded: Loaded) -> None:
    refused = qgeo("info", "fan.off", "--repair")
    assert refused.exit_code == 2
    assert "% of the area" in refused.stderr
    assert "--force-repair to take what is left, or --wrap for" in refused.stderr
    assert qgeo("info", "fan.off", "--force-repair").exit_code == 0
    content, _ = loaded(Path("qgeo-out/info-fan"))
    assert content["results"]["manifold"] is True
    assert content["mesh"]["repaired"]


def test_info_says_which_side_is_out_and_how_to_turn_it(qgeo: Qgeo, loaded: Loaded) -> None:
    blob = qg.Surface.read("blob.off")
    qg.Surface(blob.vertices, blob.faces[:, ::-1]).write("inside.off")
    expected = {
        "blob.off": ("outward", []),
        "square.obj": ("undetermined", []),
        "inside.off": ("inward", ["the faces are wound inwards: --repair turns them"]),
    }
    for mesh, (winding, advice) in expected.items():
        assert qgeo("info", mesh, "--no-pictures").exit_code == 0
        found = loaded(Path(f"qgeo-out/info-{Path(mesh).stem}"))[0]["results"]
        assert (found["winding"], found["advice"]) == (winding, advice)
    assert qgeo("info", "inside.off", "--no-pictures", "--repair").exit_code == 0
    found = loaded(Path("qgeo-out/info-inside"))[0]["results"]
    assert (found["winding"], found["advice"]) == ("outward", [])


def test_distances_of_all_pairs(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("distances", "sphere.ply", "-w", 0).exit_code == 0
    content, arrays = loaded(Path("qgeo-out/distances-sphere"))
    surface = qg.Surface.read("sphere.ply")
    np.testing.assert_array_equal(arrays["distances"], qg.distance_matrix(surface))
    assert content["results"]["shape"] == [162, 162]
    assert content["results"]["max"] == pytest.approx(np.pi, rel=0.03)
    written = qg.Surface.read("qgeo-out/distances-sphere/sphere.ply")
    np.testing.assert_array_equal(written.vertices, surface.vertices)
    np.testing.assert_allclose(written.attributes["qgeo_mean_distance"], arrays["distances"].mean(axis=1), rtol=1e-5)
    assert "distance_matrix.png" in content["files"]


def test_distances_from_sources_in_a_lifted_metric(qgeo: Qgeo, loaded: Loaded) -> None:
    command = ("distances", "blob.off", "-s", "3,7", "-w", 0.1, "--scalar", "curvedness", "--method", "exact")
    assert qgeo(*command, "-o", "out/deep").exit_code == 0
    content, arrays = loaded(Path("out/deep"))
    surface = qg.Surface.read("blob.off")
    expected = qg.distances(surface, [3, 7], qg.lifted_metric(surface, "curvedness", 0.1), "exact")
    np.testing.assert_array_equal(arrays["distances"], expected)
    assert arrays["sources"].tolist() == [3, 7]
    assert content["parameters"]["curvature_weight"] == 0.1
    assert qg.Surface.read("out/deep/blob.ply").attributes["qgeo_distance"].shape == (162, 2)
    assert {"distance_3.png", "distance_7.png"} <= set(content["files"])


def test_distances_on_disk(qgeo: Qgeo, loaded: Loaded, monkeypatch: pytest.MonkeyPatch) -> None:
    zarr = pytest.importorskip("zarr")
    monkeypatch.setattr("qgeo_filters.cli.geodesics.LARGEST_MATRIX", 1000)
    monkeypatch.setattr("qgeo_filters.cli.geodesics.ROWS", 50)
    command = ("distances", "blob.off", "--matrix", "d.zarr", "-w", 0.1)
    assert qgeo(*command).exit_code == 0
    content, arrays = loaded(Path("qgeo-out/distances-blob"))
    surface = qg.Surface.read("blob.off")
    expected = qg.distance_matrix(surface, qg.lifted_metric(surface, curvature_weight=0.1))
    np.testing.assert_array_equal(zarr.open_array("d.zarr", mode="r")[:], expected)
    assert content["parameters"]["matrix"] == "d.zarr"
    assert content["results"]["max"] == expected.max()
    assert content["results"]["mean"] == pytest.approx(expected.mean(dtype=np.float64))
    assert "distances" not in arrays
    np.testing.assert_allclose(arrays["mean_distance"], expected.mean(axis=1, dtype=np.float64))
    np.testing.assert_array_equal(
        qg.Surface.read("qgeo-out/distances-blob/blob.ply").attributes["qgeo_mean_distance"], arrays["mean_distance"]
    )


def test_distances_on_disk_continue_where_they_were_interrupted(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    zarr = pytest.importorskip("zarr")
    from qgeo_filters.geodesics import storage

    written: list[str] = []
    whole = storage.write_chunk

    def interrupted(path: Path, row: np.ndarray) -> None:
        written.append(path.parent.name)
        if len(written) == 140:  # of 162, in groups of 64
            raise KeyboardInterrupt
        whole(path, row)

    def noted(path: Path, row: np.ndarray) -> None:
        written.append(path.parent.name)
        whole(path, row)

    command = ("distances", "sphere.ply", "-w", 0, "--matrix", "d.zarr", "--workers", 1, "--no-pictures")
    monkeypatch.setattr(storage, "write_chunk", interrupted)
    assert qgeo(*command).exit_code == 130
    assert not Path("qgeo-out").exists()
    first = written.copy()
    written.clear()
    monkeypatch.setattr(storage, "write_chunk", noted)
    assert qgeo(*command).exit_code == 0
    assert len(written) == 162 - 2 * 64
    assert set(first) | set(written) == set(map(str, range(162)))
    expected = qg.distance_matrix(qg.Surface.read("sphere.ply"))
    np.testing.assert_array_equal(zarr.open_array("d.zarr", mode="r")[:], expected)
    written.clear()
    assert qgeo(*command).exit_code == 0
    assert written == []


def test_distances_between_pieces_are_counted_and_legible_json(qgeo: Qgeo, loaded: Loaded) -> None:
    sphere = qg.Surface.read("sphere.ply")
    vertices = np.concatenate([sphere.vertices, sphere.vertices + 5])
    qg.Surface(vertices, np.concatenate([sphere.faces, sphere.faces + 162])).write("two.off")
    assert qgeo("distances", "two.off").exit_code == 0
    content, arrays = loaded(Path("qgeo-out/distances-two"))
    assert content["results"]["unreachable_pairs"] == 2 * 162**2 == np.isinf(arrays["distances"]).sum()


def test_spectrum(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("spectrum", "blob.off", "-k", 7, "-w", 0.05).exit_code == 0
    content, arrays = loaded(Path("qgeo-out/spectrum-blob"))
    surface = qg.Surface.read("blob.off")
    expected = qg.distance_spectrum(surface, 7, qg.lifted_metric(surface, curvature_weight=0.05))
    np.testing.assert_allclose(arrays["eigenvalues"], expected.eigenvalues, rtol=1e-6)
    gram = arrays["eigenfunctions"].T @ (arrays["areas"][:, None] * arrays["eigenfunctions"])
    np.testing.assert_allclose(gram, np.eye(7), atol=1e-6)
    assert content["results"]["eigenvalues"] == arrays["eigenvalues"].tolist()
    assert qg.Surface.read("qgeo-out/spectrum-blob/blob.ply").attributes["qgeo_phi"].shape == (162, 7)
    assert {"eigenfunctions.png", "spectrum.png"} <= set(content["files"])


def test_multiplets_are_numbered_as_in_the_table(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("spectrum", "sphere.ply", "-k", 7, "-w", 0, "--no-pictures").exit_code == 0
    content, arrays = loaded(Path("qgeo-out/spectrum-sphere"))
    # Odd spherical harmonics only: constant, the three of degree 1, then degree 3.
    assert content["results"]["multiplets"][0] == [2, 3, 4]
    np.testing.assert_allclose(arrays["eigenvalues"][1:4], arrays["eigenvalues"][1], rtol=0.01)


def test_path(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("path", "blob.off", 3, 100, "-w", 0.05).exit_code == 0
    content, arrays = loaded(Path("qgeo-out/path-blob-3-100"))
    surface = qg.Surface.read("blob.off")
    metric = qg.lifted_metric(surface, curvature_weight=0.05)
    expected = quasi_geodesic(surface, 3, 100, metric)
    np.testing.assert_array_equal(arrays["points"], expected.points)
    np.testing.assert_array_equal(arrays["kappa_g"], expected.kappa_g)
    assert arrays["length"] == content["results"]["length"] == expected.length
    assert arrays["length"] == pytest.approx(qg.distances(surface, [3], metric, "exact")[0, 100], rel=1e-9)
    np.testing.assert_allclose(arrays["points"][[0, -1]], surface.vertices[[3, 100]])
    beside = qg.Surface.read("qgeo-out/path-blob-3-100/blob.ply").attributes["qgeo_path"]
    np.testing.assert_array_equal(np.flatnonzero(beside), np.unique(surface.faces[expected.faces]))
    assert {"path.png", "path_curvature.png"} <= set(content["files"])


def test_path_from_a_vertex_to_itself(qgeo: Qgeo, loaded: Loaded) -> None:
    result = qgeo("path", "sphere.ply", 5, 5)
    assert result.exit_code == 0
    assert loaded(Path("qgeo-out/path-sphere-5-5"))[1]["length"] == 0.0


def test_warmup(qgeo: Qgeo) -> None:
    result = qgeo("warmup")
    assert result.exit_code == 0
    assert "kernels compiled in" in result.stdout
    assert qgeo("warmup", "-q").stdout == ""


@pytest.fixture
def pipeline() -> qg.Pipeline:
    """Differential coordinates and distances: qgeo_delta and qgeo_distance."""
    return qg.DifferentialCoordinates(weights="cotangent") | qg.QuasiGeodesicDistances(sources=4)


def test_run_on_one_mesh(qgeo: Qgeo, loaded: Loaded, pipeline: qg.Pipeline) -> None:
    names = ("qgeo_delta", "qgeo_distance")
    pipeline.save("pipe.yaml")
    assert qgeo("run", "pipe.yaml", "blob.off").exit_code == 0
    content, arrays = loaded(Path("qgeo-out/run-pipe-blob"))
    expected = pipeline(qg.Surface.read("blob.off")).attributes
    assert set(arrays) == set(names)
    for name in names:
        np.testing.assert_array_equal(arrays[name], expected[name])
        np.testing.assert_array_equal(
            qg.Surface.read("qgeo-out/run-pipe-blob/blob.ply").attributes[name], expected[name]
        )
        assert f"{name}.png" in content["files"]
    assert content["parameters"]["2. QuasiGeodesicDistances"]["sources"] == 4


def test_run_on_several_meshes_gives_each_a_folder(qgeo: Qgeo, loaded: Loaded, pipeline: qg.Pipeline) -> None:
    Path("other").mkdir()
    qg.Surface.read("sphere.ply").write("other/blob.off")
    pipeline.save("pipe.yaml")
    assert qgeo("run", "pipe.yaml", "blob.off", "square.obj", "other/blob.off", "--no-pictures").exit_code == 0
    for folder, path in (("blob-1", "blob.off"), ("square", "square.obj"), ("blob-2", "other/blob.off")):
        content, arrays = loaded(Path("qgeo-out/run-pipe-blob-and-2-more") / folder)
        assert content["mesh"]["path"] == path
        assert len(arrays["qgeo_distance"]) == content["mesh"]["vertices"]


def test_run_repairs(qgeo: Qgeo, loaded: Loaded) -> None:
    qg.Pipeline([qg.QuasiGeodesicDistances()]).save("pipe.yaml")
    assert qgeo("run", "pipe.yaml", "fan.off", "--no-repair").exit_code == 2
    assert qgeo("run", "pipe.yaml", "fan.off", "--force-repair").exit_code == 0
    content, _ = loaded(Path("qgeo-out/run-pipe-fan"))
    assert content["mesh"]["repaired"]


# -- what is common to all --------------------------------------------------------------------------


def test_no_pictures(qgeo: Qgeo, loaded: Loaded) -> None:
    assert qgeo("spectrum", "sphere.ply", "-k", 3, "--no-pictures").exit_code == 0
    content, _ = loaded(Path("qgeo-out/spectrum-sphere"))
    assert not [name for name in content["files"] if name.endswith(".png")]


def test_json_is_printed_and_nothing_else(qgeo: Qgeo) -> None:
    result = qgeo("info", "sphere.ply", "--json")
    assert json.loads(result.stdout) == json.loads(Path("qgeo-out/info-sphere/result.json").read_text(encoding="utf-8"))
    assert result.stderr == ""


def test_quiet_is_silent(qgeo: Qgeo) -> None:
    for command in (("info",), ("distances",), ("spectrum", "-k", 3)):
        result = qgeo(command[0], "sphere.ply", *command[1:], "-q")
        assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")


def test_each_command_has_its_own_folder(qgeo: Qgeo, loaded: Loaded) -> None:
    for command in ("info", "distances"):
        assert qgeo(command, "sphere.ply", "--no-pictures").exit_code == 0
    for command in ("info", "distances"):
        assert loaded(Path("qgeo-out") / f"{command}-sphere")[0]["command"] == command


def test_same_input_same_files(qgeo: Qgeo) -> None:
    for folder in ("one", "two"):
        assert qgeo("spectrum", "blob.off", "-k", 4, "-o", folder).exit_code == 0
    for name in ("result.npz", "blob.ply", "eigenfunctions.png", "spectrum.png"):
        assert Path("one", name).read_bytes() == Path("two", name).read_bytes()


def test_help_and_version(qgeo: Qgeo) -> None:
    assert qgeo("--version").stdout == f"qgeo-filters {qg.__version__}\n"
    bare = qgeo()
    assert bare.exit_code == 0
    for name in (
        "demo",
        "info",
        "distances",
        "spectrum",
        "symmetry",
        "match",
        "compatibility",
        "evaluate",
        "path",
        "run",
    ):
        assert name in bare.stdout
        shown = qgeo(name, "-h")
        assert shown.exit_code == 0
        assert "--output" in shown.stdout


def test_help_is_shown_as_it_is_written() -> None:
    """Typer reads it as Rich's markup, which swallows what stands in brackets, a regular expression's too."""
    groups, shown = [typer.main.get_command(app)], 0
    for group in groups:
        for command in group.commands.values():
            groups += [command] if hasattr(command, "commands") else []
            for text in filter(None, [command.help, *(getattr(one, "help", None) for one in command.params)]):
                assert Text.from_markup(text).plain == text.replace("\\[", "["), command.name
                shown += "[" in text
    assert shown


LONG = ("demo", "distances", "path", "spectrum", "symmetry", "match", "compatibility", "evaluate", "run")


def test_workers_bound_the_threads_and_change_nothing_else(qgeo: Qgeo, monkeypatch: pytest.MonkeyPatch) -> None:
    threads = []
    true = stages.distance_matrix
    monkeypatch.setattr(
        stages, "distance_matrix", lambda *args, **options: threads.append(worker_count()) or true(*args, **options)
    )
    for number in (1, 3):
        cache.clear()
        assert qgeo("spectrum", "blob.off", "-k", 4, "--workers", number, "-o", number, "--no-pictures").exit_code == 0
    assert threads == [1, 3]
    assert Path("1/result.npz").read_bytes() == Path("3/result.npz").read_bytes()
    assert worker_count() == available_cores()  # the bound ends with the command


@pytest.mark.parametrize("command", LONG)
def test_commands_that_take_long_take_threads(qgeo: Qgeo, command: str) -> None:
    assert "--threads" in qgeo(command, "-h").stdout
    arguments = {
        "match": ["blob.off", "blob.off"],
        "run": ["p.yaml", "blob.off"],
        "path": ["blob.off", 0, 1],
        "evaluate": ["tosca", "--root", "."],
    }
    result = qgeo(command, *arguments.get(command, [] if command == "demo" else ["blob.off"]), "--threads", 0)
    assert (result.exit_code, result.stderr) == (2, "qgeo: workers must be at least 1, got 0\n")
