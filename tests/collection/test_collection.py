"""Many shapes in a store: names, tables and distances, and that nothing is computed twice."""

from __future__ import annotations

import gc
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapes import icosphere
from small_collection import QUICK, by_number, poses, written

import qgeo_filters as qg
from qgeo_filters.collection import runs, tasks
from qgeo_filters.collection.pairs import MOST, chunks_of_pairs
from qgeo_filters.collection.settings import Settings, surface_key
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.evaluation import geodesic_error
from qgeo_filters.matching.prepared_shape import PreparedShape

pandas = pytest.importorskip("pandas")
zarr = pytest.importorskip("zarr")

NAMES = ("p0", "p1", "p2", "p3")
Build = Callable[..., qg.Collection]


@pytest.fixture(scope="module")
def matched(tmp_path_factory: pytest.TempPathFactory) -> qg.Collection:
    """Four poses from files, all pairs matched, in a store."""
    folder = tmp_path_factory.mktemp("poses")
    collection = qg.Collection(
        written(folder / "meshes", 4), folder / "shapes.zarr", groups=by_number, parameters=QUICK
    )
    return collection.match(workers=1)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> dict[str, int]:
    """How often a shape is prepared, and a pair matched, in this process."""
    counts = {"prepared": 0, "matched": 0}

    def spied(key: str, function: Callable) -> Callable:
        def spy(*args: object, **kwargs: object) -> object:
            counts[key] += 1
            return function(*args, **kwargs)

        return spy

    monkeypatch.setattr(tasks, "arrays_of_shape", spied("prepared", tasks.arrays_of_shape))
    monkeypatch.setattr(tasks, "match", spied("matched", tasks.match))
    return counts


def files_of(folder: Path) -> dict[str, int]:
    return {str(path): path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}


def test_the_table_has_a_row_for_each_pair(matched: qg.Collection) -> None:
    table = matched.table()
    assert list(zip(table["x"], table["y"], strict=True)) == [
        (x, y) for i, x in enumerate(NAMES) for y in NAMES[i + 1 :]
    ]
    assert list(table["group_x"]) == ["low"] * 5 + ["high"]
    assert list(table["group_y"]) == ["low", "high", "high", "high", "high", "high"]
    assert table["confident"].dtype == bool
    assert all(table[name].dtype == np.float64 for name in ("c_xy", "d_s", "distortion", "margin"))
    assert "seconds" not in table
    assert (matched.table(seconds=True)["seconds"] > 0).all()
    assert (table["problem"] == "").all()
    assert matched.problems == ()
    status = matched.status()
    assert (status.shapes, status.prepared, status.pairs, status.matched, status.failed) == (4, 4, 6, 6, 0)
    assert repr(matched).startswith("Collection(4 shapes in 2 groups")


def test_maps_are_those_of_match_bit_for_bit(matched: qg.Collection) -> None:
    surfaces = poses(4)
    expected = qg.match(*(PreparedShape(surfaces[name], parameters=QUICK) for name in ("p0", "p2")))
    found = matched.map("p0", "p2")
    for name in ("p2p", "inverse", "functional_map", "distortion", "regions_x", "regions_y", "positions"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), strict=True)
    for name in ("faces", "corners", "coordinates"):
        np.testing.assert_array_equal(
            getattr(found.barycentric, name), getattr(expected.barycentric, name), strict=True
        )
    assert (found.c_xy, found.score, found.margin, found.confident, found.explanation) == (
        expected.c_xy, expected.score, expected.margin, expected.confident, expected.explanation,
    )  # fmt: skip
    assert str(found.log) == str(expected.log)
    np.testing.assert_array_equal(found.transfer(np.arange(162)), expected.transfer(np.arange(162)))
    row = matched.table().set_index(["x", "y"]).loc[("p0", "p2")]
    assert (row["c_xy"], row["distortion"], row["margin"]) == (found.c_xy, found.score, found.margin)


def test_squares_agree_with_the_table_and_with_formulas(matched: qg.Collection) -> None:
    table = matched.table().set_index(["x", "y"])
    for measure in ("c_xy", "d_s", "distortion"):
        square = matched.distances(measure)
        assert list(square.index) == list(square.columns) == list(NAMES)
        np.testing.assert_array_equal(square, square.T)
        np.testing.assert_array_equal(np.diag(square), 0)
        assert all(square.loc[x, y] == table.loc[(x, y), measure] for x, y in table.index)
    shapes = [matched.shape(name) for name in NAMES]
    dna = [shape.laplacian_spectrum.eigenvalues[1:21] / np.arange(1, 21) for shape in shapes]
    unit = [shape.spectrum.eigenvalues / np.linalg.norm(shape.spectrum.eigenvalues) for shape in shapes]
    # Twenty places for each sign, zeros in those that are free.
    signed = [np.sort(np.concatenate([values, np.zeros(20)])) for values in unit]
    for measure, rows in (("shape_dna", dna), ("eigenvalues", signed)):
        expected = [[np.linalg.norm(a - b) for a in rows] for b in rows]
        np.testing.assert_allclose(matched.distances(measure), expected, rtol=1e-12, atol=1e-15)
    # Poses of one mesh: the paper's equal vertex order, as `compatibility` has it.
    by_order = matched.distances(by_vertex_order=True)
    functions = [shape.full_spectrum for shape in shapes]
    assert by_order.loc["p0", "p1"] == qg.commutative_eigenspectra(functions[0], functions[1], np.arange(162)).c_xy


def test_the_map_free_measures_need_no_maps(tmp_path: Path, counted: dict[str, int]) -> None:
    collection = qg.Collection(poses(3), tmp_path / "s.zarr", parameters=QUICK)
    with pytest.raises(ParameterError, match=r"p0 is not prepared yet: call prepare\(\)"):
        collection.distances("shape_dna")
    collection.prepare(workers=1)
    for measure in ("eigenvalues", "shape_dna"):
        assert np.isfinite(collection.distances(measure)).all(axis=None)
    assert np.isfinite(collection.distances(by_vertex_order=True)).all(axis=None)
    assert counted == {"prepared": 3, "matched": 0}
    assert np.isnan(collection.distances("c_xy").loc["p0", "p1"])
    with pytest.raises(ParameterError, match=r"measure must be one of 'c_xy', .*, got 'beauty'"):
        collection.distances("beauty")


def test_compatibility_along_the_maps(matched: qg.Collection) -> None:
    found = matched.compatibility(["p0", "p1", "p2"], k=10)
    maps = [np.arange(162), matched.map("p0", "p1").p2p, matched.map("p0", "p2").p2p]
    surfaces = [matched.surface(name) for name in ("p0", "p1", "p2")]
    expected = qg.compatibility(surfaces, k=10, maps=maps)
    np.testing.assert_array_equal(found.c_xy, expected.c_xy)


def test_errors_against_the_truth(matched: qg.Collection) -> None:
    same = np.arange(162)
    table = matched.table(lambda x, y: same if y != "p3" else None).set_index(["x", "y"])
    found = matched.map("p0", "p1")
    assert table.loc[("p0", "p1"), "error"] == pytest.approx(geodesic_error(found.p2p, same, found.y).mean())
    assert np.isnan(table.loc[("p0", "p3"), "error"])
    np.testing.assert_array_equal(
        matched.table({("p0", "p1"): same}).set_index(["x", "y"]).loc[("p0", "p1")],
        table.loc[("p0", "p1")],
    )


def test_a_second_run_computes_and_writes_nothing(matched: qg.Collection, counted: dict[str, int]) -> None:
    before = files_of(matched.store.root)
    again = qg.Collection(
        [matched.store.root.parent / "meshes" / f"{name}.ply" for name in NAMES],
        matched.store.root,
        groups=dict(matched.groups),
        parameters=QUICK,
    ).match(workers=1)
    again.map("p0", "p1")
    pandas.testing.assert_frame_equal(again.table(), matched.table(), check_exact=True)
    reopened = qg.Collection.open(matched.store.root)
    assert (reopened.names, reopened.groups, reopened.settings) == (again.names, again.groups, again.settings)
    pandas.testing.assert_frame_equal(reopened.match(workers=1).table(), matched.table(), check_exact=True)
    assert counted == {"prepared": 0, "matched": 0}
    assert files_of(matched.store.root) == before


def test_a_changed_file_is_computed_anew_and_nothing_else(tmp_path: Path, counted: dict[str, int]) -> None:
    folder = written(tmp_path / "meshes", 3)
    qg.Collection(folder, tmp_path / "s.zarr", parameters=QUICK).match(workers=1)
    assert counted == {"prepared": 3, "matched": 3}
    poses(4)["p3"].write(folder / "p1.ply")
    changed = qg.Collection(folder, tmp_path / "s.zarr", parameters=QUICK).match(workers=1)
    assert counted == {"prepared": 4, "matched": 5}
    assert len(changed.table()) == 3
    # Other options of the match: shapes stay.
    qg.Collection(folder, tmp_path / "s.zarr", parameters=QUICK, mirror="no").match([("p0", "p1")], workers=1)
    assert counted == {"prepared": 4, "matched": 6}
    # Other parameters: all of it.
    other = replace(QUICK, sign_beam=8)
    qg.Collection(folder, tmp_path / "s.zarr", parameters=other).match([("p0", "p1")], workers=1)
    assert counted == {"prepared": 6, "matched": 7}
    pandas.testing.assert_frame_equal(
        qg.Collection(folder, tmp_path / "s.zarr", parameters=QUICK).table(), changed.table(), check_exact=True
    )


def test_a_map_is_found_when_it_is_asked_for(tmp_path: Path, counted: dict[str, int]) -> None:
    collection = qg.Collection(poses(2), tmp_path / "s.zarr", parameters=QUICK)
    there, back = collection.map("p0", "p1"), collection.map("p1", "p0")
    assert there.x.vertices.tobytes() == back.y.vertices.tobytes()
    assert counted == {"prepared": 2, "matched": 2}
    square = collection.distances("distortion")
    assert square.loc["p0", "p1"] == square.loc["p1", "p0"] == there.score


def test_a_damaged_record_is_computed_again(tmp_path: Path, counted: dict[str, int]) -> None:
    collection = qg.Collection(poses(2), tmp_path / "s.zarr", parameters=QUICK).match(workers=1)
    expected, found = collection.table(), collection.map("p0", "p1")
    (record,) = (tmp_path / "s.zarr" / "pairs").glob("*/*/*/p2p/c/0")
    record.write_bytes(b"damaged")
    np.testing.assert_array_equal(collection.map("p0", "p1").p2p, found.p2p)
    assert counted == {"prepared": 2, "matched": 2}
    (metadata,) = (tmp_path / "s.zarr" / "pairs").glob("*/*/*/zarr.json")
    metadata.write_text("{")
    for chunk in (tmp_path / "s.zarr" / "shapes").glob("*/fps/c/0"):
        chunk.unlink()
    tasks.forget()
    pandas.testing.assert_frame_equal(collection.match(workers=1).table(), expected, check_exact=True)
    assert counted == {"prepared": 4, "matched": 3}


def test_bad_files_and_shapes_are_named_and_the_rest_goes_on(tmp_path: Path) -> None:
    folder = written(tmp_path / "meshes", 2)
    (folder / "broken.off").write_text("OFF\n3 1 0\n0 0 0\n")
    (folder / "notes.txt").write_text("no mesh")
    qg.Surface(*icosphere(1)).write(folder / "small.off")
    poses(1)["p0"].write(folder / "copy.ply")
    with pytest.warns(UserWarning, match=r"p0: holds the same mesh as copy \(1 such shapes\)"):
        collection = qg.Collection(folder, tmp_path / "s.zarr", parameters=QUICK)
    assert collection.names == ("copy", "p0", "p1", "small")
    collection.match(workers=1)
    told = {problem.subject: problem for problem in collection.problems}
    assert told.keys() == {"broken", "small", "p0"}
    assert told["broken"].reason.count(str(folder / "broken.off")) == 1
    assert qg.Collection.open(tmp_path / "s.zarr").problems == collection.problems
    assert "at least 60 vertices" in told["small"].reason
    assert (told["small"].lost, told["p0"].lost) == (True, False)
    table = collection.table()
    assert set(zip(table["x"], table["y"], strict=True)) == {("copy", "p0"), ("copy", "p1"), ("p0", "p1")}
    assert table.loc[1, "c_xy"] == table.loc[2, "c_xy"]  # of one mesh
    assert np.isnan(collection.distances("shape_dna").loc["small", "p0"])
    with pytest.raises(ParameterError, match=r"p0 - small: .*at least 60 vertices"):
        collection.map("p0", "small")


def test_some_of_the_shapes_share_what_is_found(matched: qg.Collection, counted: dict[str, int]) -> None:
    some = matched.only(["p0", "p2"])
    assert some.names == ("p0", "p2")
    assert some.groups == {name: matched.groups[name] for name in some.names}
    np.testing.assert_array_equal(some.match(workers=1).map("p0", "p2").p2p, matched.map("p0", "p2").p2p)
    assert len(some.table()) == 1
    assert counted == {"prepared": 0, "matched": 0}
    with pytest.raises(ParameterError, match="no shape is called 'p9'"):
        matched.only(["p9"])
    with pytest.raises(ParameterError, match="'p0' is named twice"):
        matched.only(["p0", "p0"])


def test_part_of_a_collection_keeps_its_temporary_store() -> None:
    some = qg.Collection(poses(2), parameters=QUICK).only(["p1"])
    gc.collect()
    assert some.surface("p1").n_vertices == 162


def test_pairs_that_cannot_be_matched_are_rows(tmp_path: Path, counted: dict[str, int]) -> None:
    """Asked for without regard of size, shapes of different size are refused."""
    shapes = poses(2)
    shapes["large"] = qg.Surface(3 * shapes["p1"].vertices, shapes["p1"].faces)
    collection = qg.Collection(shapes, tmp_path / "s.zarr", parameters=QUICK, normalize=False)
    table = collection.match(workers=1).match(workers=1).table().set_index(["x", "y"])
    assert counted == {"prepared": 3, "matched": 3}  # what cannot be is not tried again
    assert "different size" in table.loc[("p0", "large"), "problem"]
    assert np.isnan(table.loc[("p0", "large"), "c_xy"])
    assert not table.loc[("p0", "large"), "confident"]
    assert {problem.subject for problem in collection.problems} == {"p0 - large", "p1 - large"}
    assert (collection.status().matched, collection.status().failed) == (1, 2)


def test_a_shape_that_matches_nothing_is_named(tmp_path: Path) -> None:
    shapes = {**poses(2), "ball": qg.Surface(*icosphere(2))}
    collection = qg.Collection(shapes, tmp_path / "s.zarr", parameters=QUICK).match(workers=1)
    assert [(one.subject, one.lost) for one in collection.problems] == [("ball", False)]
    assert "none of its 2 maps is sure" in str(collection.problems[0])


def test_a_failure_of_ours_is_told_and_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    collection = qg.Collection(poses(2), tmp_path / "s.zarr", parameters=QUICK)
    with monkeypatch.context() as patch:
        patch.setattr(tasks, "match", lambda *_, **__: 1 / 0)
        collection.match(workers=1)
    assert [str(problem) for problem in collection.problems] == ["p0 - p1: ZeroDivisionError('division by zero')"]
    assert collection.match(workers=1).problems == ()
    assert len(collection.table()) == 1


def test_without_a_store_nothing_is_left(counted: dict[str, int]) -> None:
    collection = qg.Collection(poses(2), parameters=QUICK).match(workers=1)
    folder = collection.store.root
    assert len(collection.table()) == 1
    assert folder.is_dir()
    del collection
    assert not folder.exists()


def test_names_and_groups_that_do_not_fit(tmp_path: Path) -> None:
    folder, mesh = written(tmp_path / "a", 2), poses(1)["p0"]
    other = written(tmp_path / "b", 1)
    store = tmp_path / "s.zarr"
    for shapes, options, message in (
        ([folder / "p0.ply", other / "p0.ply"], {}, r"two shapes are called 'p0', .*a.p0.ply and .*b.p0.ply"),
        ([mesh], {}, r"shapes\[0\] comes from memory and has no name"),
        ([mesh], {"names": ["a", "b"]}, "names must hold one for each of the 1 shapes, got 2"),
        ([mesh], {"names": [""]}, "the name of a shape must be a text"),
        ({"a": mesh}, {"names": ["a"]}, "leave out names="),
        ({"a": mesh}, {"groups": ["g", "h"]}, "groups must hold one for each of the 1 shapes, got 2"),
        ({"a": mesh}, {"groups": "g"}, "groups must hold one for each"),
        ({"a": mesh}, {"groups": {"b": "g"}}, "groups has none for 'a'"),
        ({"a": mesh}, {"mirror": "maybe"}, "mirror must be"),
        ({"a": mesh}, {"partial": "maybe"}, "partial must be"),
        ({}, {}, "an empty mapping"),
        ([], {}, "an empty list"),
        (tmp_path, {}, "a folder without mesh files"),
    ):
        with pytest.raises((ParameterError, MeshError), match=message):
            qg.Collection(shapes, store, **options)
        assert not store.exists()
    with pytest.raises(FileNotFoundError, match="is not a folder of meshes"):
        qg.Collection(tmp_path / "none", store)
    with pytest.raises(MeshError, match=r"none of the 1 shapes can be read; the first, none: .*no such file"):
        qg.Collection([tmp_path / "none.ply"], store)


def test_pairs_that_are_none(matched: qg.Collection) -> None:
    for pairs, message in (
        ("some", "pairs must be 'all', 'within groups' or pairs of names, got 'some'"),
        ([("p0", "x")], r"pairs\[0\] has 'x', and no shape is called so"),
        ([("p0", "p1"), ("p0", "p0")], r"pairs\[1\] is 'p0' with itself"),
        (["p0"], r"pairs\[0\] must be two names, got 'p0'"),
    ):
        with pytest.raises(ParameterError, match=message):
            matched.match(pairs)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="no shape is called 'x'; there are p0, p1, p2, p3"):
        matched.map("p0", "x")
    with pytest.raises(ParameterError, match="no backend of joblib is called 'steam'"):
        qg.Collection(poses(3), parameters=QUICK).match(workers=2, backend="steam")
    for part in ((0, 3), (4, 3), (1, 0), "3/4", 3):
        with pytest.raises(ParameterError, match="part"):
            matched.match(part=part)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="the shapes have no groups"):
        qg.Collection(poses(2), parameters=QUICK).match("within groups")


@pytest.mark.parametrize("n", [1, 2, 3, 7, 40])
def test_parts_are_disjoint_and_the_union_is_all(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also when some of it is finished before the others begin."""
    names = [f"s{number}" for number in range(11)]
    pairs = [(x, y) for i, x in enumerate(names) for y in names[i + 1 :]]
    chunks = chunks_of_pairs(pairs)
    assert all(len({y for _, y in chunk}) == 1 and len(chunk) <= MOST for chunk in chunks)
    assert sorted(pair for chunk in chunks for pair in chunk) == sorted(pairs)
    asked: list[tuple[str, str]] = []
    collection = qg.Collection(poses(4), parameters=QUICK)
    keys = {surface_key(collection.surface(name)): name for name in NAMES}

    def record(task: Callable, chunks: list, **_: object) -> list:
        if task.func is tasks.pair_task:  # type: ignore[attr-defined]
            asked.extend((keys[x], keys[y]) for chunk in chunks for x, y in chunk)
        return []

    monkeypatch.setattr(runs, "run_chunks", record)
    for k in range(1, n + 1):
        collection.match(part=(k, n))
    assert sorted(asked) == [(x, y) for i, x in enumerate(NAMES) for y in NAMES[i + 1 :]]


def test_settings_survive_as_json() -> None:
    settings = Settings(replace(QUICK, curvature_weights=(0.0, 0.2)), False, True, "yes", "force")
    again = Settings.from_json(json.loads(json.dumps(settings.to_json())))
    assert again == settings
    assert again.shape_key("a") == settings.shape_key("a")
    assert len({Settings().how, Settings(mirror="no").how, Settings(normalize=False).how}) == 3
    with pytest.raises(ParameterError, match="does not know"):
        Settings.from_json({**settings.to_json(), "parameters": {"unheard_of": 1}})


def test_a_worker_with_other_code_is_refused(tmp_path: Path) -> None:
    collection = qg.Collection(poses(1), tmp_path / "s.zarr", parameters=QUICK)
    foreign = replace(collection.settings, code="0")
    for task in (tasks.prepare_task, tasks.pair_task):
        with pytest.raises(ParameterError, match="this worker runs another version of qgeo_filters"):
            task(str(tmp_path / "s.zarr"), foreign, [])
