"""The distance matrix in memory, on disk, and as an operator."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapes
from graph_cases import exact_rows, relative_error

from qgeo_filters.errors import DisconnectedError, ParameterError
from qgeo_filters.geodesics import matrix as matrix_module
from qgeo_filters.geodesics import storage
from qgeo_filters.geodesics.dgg.graph import GeodesicGraph
from qgeo_filters.geodesics.matrix import distance_matrix, distances
from qgeo_filters.geodesics.operator import DistanceOperator
from qgeo_filters.surface import Surface


@pytest.fixture(scope="module")
def surface() -> Surface:
    return Surface(*shapes.blob(3))


@pytest.fixture(scope="module")
def matrix(surface: Surface) -> np.ndarray:
    return distance_matrix(surface)


def test_symmetric_with_zero_diagonal_and_triangle_inequality(surface: Surface, matrix: np.ndarray) -> None:
    assert matrix.dtype == np.float32
    assert np.array_equal(matrix, matrix.T)
    assert not np.diag(matrix).any()
    assert (matrix[~np.eye(len(matrix), dtype=bool)] > 0).all()
    some = matrix[::9, ::9].astype(float)
    detour = some[:, :, None] + some[None]
    assert (some[:, None] <= detour.transpose(0, 2, 1) * (1 + 1e-6)).all()  # shortest paths: up to float32's rounding


def test_same_bits_for_any_number_of_workers(surface: Surface, matrix: np.ndarray) -> None:
    for workers in (1, 2, 5):
        again = Surface(surface.vertices, surface.faces)  # no graph kept from before
        assert np.array_equal(distance_matrix(again, workers=workers), matrix)


def test_rows_are_rows_of_the_matrix(surface: Surface, matrix: np.ndarray) -> None:
    sources = [5, 400, 5, 0]
    assert np.array_equal(distances(surface, sources).astype(np.float32), matrix[sources])
    assert distances(surface, []).shape == (0, surface.n_vertices)


def test_sources_alone_give_the_bits_of_sources_together(surface: Surface, matrix: np.ndarray) -> None:
    sources = np.arange(0, surface.n_vertices, 9)  # more than a few go together, whatever their number is
    together = distances(surface, sources)
    alone = np.concatenate([distances(surface, [source]) for source in sources])
    assert np.array_equal(together, alone)


def test_methods_are_in_order(surface: Surface) -> None:
    some = np.arange(0, surface.n_vertices, 100)
    exact, graph, edges = (distances(surface, some, method=method) for method in ("exact", "graph", "edges"))
    assert np.abs(relative_error(exact, exact_rows(surface.vertices, surface.faces, some))).max() < 1e-9
    assert (graph >= exact * (1 - 1e-9)).all()
    assert (edges >= graph * (1 - 1e-6)).all()  # the graph's lengths are rounded up to ticks
    assert relative_error(edges, exact).mean() > 0.02


@pytest.mark.parametrize("method", ["exact", "edges"])
def test_matrix_by_other_methods(method: str) -> None:
    small = Surface(*shapes.torus(12, 6))
    result = distance_matrix(small, method=method)
    assert np.array_equal(result, result.T)
    assert np.allclose(result, distances(small, np.arange(72), method=method), rtol=1e-6)


def test_real_mesh() -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"))
    vertices, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
    sources = np.arange(0, len(vertices), 400)
    result = distance_matrix(Surface(vertices, faces))
    error = relative_error(result[sources].astype(float), exact_rows(vertices, faces, sources))
    assert error.min() > -1e-6
    assert error.max() < 1e-3
    assert error.mean() < 1.5e-4


def test_evaluation_meshes(data_dir: Path) -> None:
    for name in ("wolf0", "centaur0"):
        surface = Surface.read(data_dir / "tosca" / "remeshed" / f"{name}.off")
        sources = np.arange(0, surface.n_vertices, 300)
        exact = exact_rows(surface.vertices, surface.faces, sources)
        error = relative_error(distances(surface, sources), exact)
        assert error.min() > -1e-9
        assert error.max() < 1e-3
        assert error.mean() < 3e-4


# -- on disk ------------------------------------------------------------------------------------------


def test_disk_holds_the_same_bits(surface: Surface, matrix: np.ndarray, tmp_path: Path) -> None:
    zarr = pytest.importorskip("zarr")
    stored = distance_matrix(surface, out=tmp_path / "d.zarr")
    assert isinstance(stored, zarr.Array)
    assert stored.metadata.zarr_format == 3
    assert np.array_equal(zarr.open_array(str(tmp_path / "d.zarr"), mode="r")[:], matrix)


def test_interrupted_and_continued(
    surface: Surface, matrix: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing that was finished before the interruption is computed again."""
    computed: list[int] = []
    whole = GeodesicGraph.distances_into

    def counted(self: GeodesicGraph, out: np.ndarray, rows: np.ndarray, sources: np.ndarray) -> None:
        if len(computed) == 4:
            raise KeyboardInterrupt
        whole(self, out, rows, sources)
        computed.append(int(sources[0]))

    monkeypatch.setattr(GeodesicGraph, "distances_into", counted)
    with pytest.raises(KeyboardInterrupt):
        distance_matrix(surface, out=tmp_path / "d.zarr", workers=1)
    monkeypatch.setattr(GeodesicGraph, "distances_into", whole)
    first = set(computed)
    assert len(first) == 4

    def noted(self: GeodesicGraph, out: np.ndarray, rows: np.ndarray, sources: np.ndarray) -> None:
        computed.append(int(sources[0]))
        whole(self, out, rows, sources)

    monkeypatch.setattr(GeodesicGraph, "distances_into", noted)
    stored = distance_matrix(surface, out=tmp_path / "d.zarr")
    assert len(computed) == len(set(computed)) == -(-surface.n_vertices // 64)
    assert np.array_equal(stored[:], matrix)
    distance_matrix(surface, out=tmp_path / "d.zarr")
    assert len(computed) == -(-surface.n_vertices // 64)


def test_killed_and_continued(tmp_path: Path) -> None:
    program = (
        "import sys, shapes; from qgeo_filters.surface import Surface; "
        "from qgeo_filters.geodesics.matrix import distance_matrix; "
        "distance_matrix(Surface(*shapes.blob(4)), out=sys.argv[1], workers=1)"
    )
    target = tmp_path / "d.zarr"
    environment = {**os.environ, "PYTHONPATH": str(Path(shapes.__file__).parent)}
    process = subprocess.Popen([sys.executable, "-c", program, str(target)], env=environment)
    deadline = time.monotonic() + 120
    while len(list(target.glob("c/*/0"))) < 300 and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    process.wait()
    surface = Surface(*shapes.blob(4))
    assert np.array_equal(distance_matrix(surface, out=target)[:], distance_matrix(surface))
    assert not list(target.rglob("*.partial"))


def test_other_mesh_metric_or_accuracy_is_refused(surface: Surface, tmp_path: Path) -> None:
    target = tmp_path / "d.zarr"
    distance_matrix(surface, out=target)
    moved = Surface(surface.vertices * [1, 1, 2], surface.faces)
    for other, accuracy in ((moved, 1e-3), (surface, 1e-2)):
        with pytest.raises(ValueError, match="holds the distances of another mesh, metric or accuracy; choose"):
            distance_matrix(other, out=target, accuracy=accuracy)
    with pytest.raises(ValueError, match=r"of shape \(642, 642\), not float32 \(162, 162\)"):
        distance_matrix(Surface(*shapes.blob(2)), out=target)
    (tmp_path / "text").write_text("hello")
    with pytest.raises(ValueError, match="is there and is not a Zarr array"):
        distance_matrix(surface, out=tmp_path / "text")
    with pytest.raises(ValueError, match="graph method only"):
        distance_matrix(surface, method="exact", out=tmp_path / "e.zarr")


def test_targets_that_cannot_be_written(surface: Surface, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(FileNotFoundError, match="is not a folder"):
        distance_matrix(surface, out=tmp_path / "nowhere" / "d.zarr")
    with monkeypatch.context() as patch:
        patch.setattr(storage.os, "access", lambda *_: False)  # root may write anywhere
        with pytest.raises(PermissionError, match="is read-only"):
            distance_matrix(surface, out=tmp_path / "d.zarr")
    with monkeypatch.context() as patch:
        patch.setattr(storage.shutil, "disk_usage", lambda _: storage.shutil._ntuple_diskusage(10**6, 10**6, 10))
        with pytest.raises(OSError, match=r"needs 0.00181 GB more, the disk has 1e-08 GB free"):
            distance_matrix(surface, out=tmp_path / "d.zarr")


def test_disk_that_fills_up(
    surface: Surface, matrix: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = storage.write_chunk
    written = []

    def full(path: Path, row: np.ndarray) -> None:
        if len(written) == 200:
            raise OSError(28, "No space left on device")
        written.append(path)
        whole(path, row)

    with monkeypatch.context() as patch:
        patch.setattr(storage, "write_chunk", full)
        with pytest.raises(OSError, match=r"the disk is full: 3 of 11 groups of rows are written .* call again"):
            distance_matrix(surface, out=tmp_path / "d.zarr", workers=1)
    assert np.array_equal(distance_matrix(surface, out=tmp_path / "d.zarr")[:], matrix)


def test_rows_that_were_lost_are_computed_again(
    surface: Surface, matrix: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Zarr takes a missing row for NaN, and stumbles over one that was cut short only when it is looked at."""
    target, n = tmp_path / "d.zarr", surface.n_vertices
    distance_matrix(surface, out=target)
    (target / "c" / "3" / "0").unlink()
    (target / "c" / str(n - 1) / "0").write_bytes(b"half")
    whole, computed = GeodesicGraph.distances_into, []

    def noted(self: GeodesicGraph, out: np.ndarray, rows: np.ndarray, sources: np.ndarray) -> None:
        computed.append(sources)
        whole(self, out, rows, sources)

    monkeypatch.setattr(GeodesicGraph, "distances_into", noted)
    assert np.array_equal(distance_matrix(surface, out=target, workers=1)[:], matrix)
    assert 1 <= len(computed) <= 2  # the groups of these rows, no others
    assert {3, n - 1} <= set(np.concatenate(computed).tolist())


def changed(document: dict[str, Any], *path: str, value: Any) -> dict[str, Any]:
    """The document with another value at a place, taken away where it is None."""
    document = json.loads(json.dumps(document))
    holder = document
    for key in path[:-1]:
        holder = holder[key]
    if value is None:
        del holder[path[-1]]
    else:
        holder[path[-1]] = value
    return document


KEY = ("attributes", "qgeo_distance_matrix")


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ((*KEY, "done"), None),
        ((*KEY, "done"), "xx"),
        ((*KEY, "done"), 3),
        ((*KEY, "done"), "f"),
        ((*KEY, "fingerprint"), None),
        ((*KEY, "group"), 3),
        (KEY, None),
        (KEY, [1]),
        (("attributes",), [1]),
        (("chunk_grid", "configuration", "chunk_shape"), [2, 162]),
        (("chunk_key_encoding", "configuration", "separator"), "."),
        (("codecs",), [{"name": "bytes", "configuration": {"endian": "big"}}]),
        (("codecs",), [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "gzip"}]),
        (("fill_value",), 0),
        (("zarr_format",), 2),
    ],
    ids=str,
)
def test_a_description_that_is_not_ours_is_refused(
    surface: Surface, begun: dict[str, bytes], tmp_path: Path, path: tuple[str, ...], value: Any
) -> None:
    """Rows are written past Zarr: it would read them otherwise than they were meant."""
    pytest.importorskip("zarr")
    target = tmp_path / "d.zarr"
    target.mkdir()
    document = changed(json.loads(begun["zarr.json"]), *path, value=value)
    (target / "zarr.json").write_text(json.dumps(document))
    with pytest.raises(ParameterError, match=r"d\.zarr .*; choose another path, or delete it"):
        distance_matrix(surface, out=target)
    assert json.loads((target / "zarr.json").read_text()) == document


@pytest.fixture(scope="module")
def begun(surface: Surface, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of an array on disk, but for its rows."""
    target = tmp_path_factory.mktemp("begun") / "d.zarr"
    distance_matrix(surface, out=target)
    return {path.name: path.read_bytes() for path in target.iterdir() if path.is_file()}


# -- operator -----------------------------------------------------------------------------------------


def test_operator_is_the_matrix(surface: Surface, matrix: np.ndarray) -> None:
    operator = DistanceOperator(surface, workers=2)
    x = np.random.default_rng(0).normal(size=(surface.n_vertices, 3))
    full = distances(surface, np.arange(surface.n_vertices))
    assert operator.shape == full.shape
    assert np.allclose(operator @ x, full @ x, rtol=1e-12, atol=1e-10)
    assert np.allclose(operator @ x[:, 0], full @ x[:, 0], rtol=1e-12, atol=1e-10)
    assert np.array_equal(operator.T @ x, operator @ x)
    assert np.array_equal(operator.rmatvec(x[:, 1]), operator @ x[:, 1])
    assert np.array_equal(DistanceOperator(surface, workers=1) @ x, operator @ x)
    single = operator @ x.astype(np.float32)
    assert single.dtype == np.float64
    assert np.allclose(single, full @ x, rtol=1e-4, atol=1e-4 * np.abs(full @ x).max())


def test_operator_refuses_infinite_distances() -> None:
    vertices, faces = shapes.grid(4)
    with pytest.raises(DisconnectedError, match="the distance operator needs a mesh in one piece"):
        DistanceOperator(Surface(np.vstack([vertices, [[5.0, 5, 5]]]), faces))


# -- conduct ------------------------------------------------------------------------------------------


def test_interruption_leaves_the_library_usable(
    surface: Surface, matrix: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(GeodesicGraph, "distances_into", interrupted)
        with pytest.raises(KeyboardInterrupt):
            matrix_module.distance_matrix(surface)
    assert np.array_equal(distance_matrix(surface), matrix)


def test_progress_bar(surface: Surface, capsys: pytest.CaptureFixture[str]) -> None:
    distance_matrix(surface, progress=True)
    assert "11/11" in capsys.readouterr().err
    distance_matrix(surface)
    assert capsys.readouterr().err == ""
