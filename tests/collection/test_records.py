"""Records of a store: whole or not there, told when damaged, readable with Zarr alone."""

from __future__ import annotations

import errno
import logging
import os
import time
from pathlib import Path

import numpy as np
import pytest

from qgeo_filters.collection import records
from qgeo_filters.collection.records import DamagedRecord, read_record, read_values, set_aside, write_group
from qgeo_filters.collection.settings import Settings
from qgeo_filters.collection.store import Entry, Store
from qgeo_filters.errors import ParameterError

zarr = pytest.importorskip("zarr")

ARRAYS = {
    "rows": np.arange(12.0).reshape(4, 3),
    "columns": np.asfortranarray(np.linspace(0, 1, 6).reshape(2, 3).astype(np.float32)),
    "whole": np.array([3, -1, 2]),
    "flags": np.array([True, False]),
    "nothing": np.zeros(0),
    "not_finite": np.array([np.nan, np.inf, -0.0]),
}
VALUES = {
    "score": 0.1 + 0.2,
    "margin": np.inf,
    "c_xy": np.float64("nan"),
    "confident": True,
    "why": "é",
    "n": [1, None],
}


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return Store(tmp_path / "shapes.zarr").root


def test_a_record_comes_back_bit_for_bit(root: Path) -> None:
    assert read_record(root, "pairs/a/b") is None
    assert records.write_record(root, "pairs/a/b", ARRAYS, VALUES)
    found = read_record(root, "pairs/a/b")
    assert found is not None
    assert found.arrays.keys() == ARRAYS.keys()
    for name, array in ARRAYS.items():
        assert found.arrays[name].tobytes() == array.tobytes(), name
        assert found.arrays[name].dtype == array.dtype
        assert found.arrays[name].flags.f_contiguous == array.flags.f_contiguous
        assert not found.arrays[name].flags.writeable
    assert repr(found.values) == repr({**VALUES, "c_xy": float("nan")})
    some = read_record(root, "pairs/a/b", ["whole", "unheard of"])
    assert some is not None
    assert list(some.arrays) == ["whole"]


def test_zarr_alone_reads_all_of_it(root: Path, recwarn: pytest.WarningsRecorder) -> None:
    records.write_record(root, "pairs/how/a/b", ARRAYS, VALUES)
    group = zarr.open_group(str(root), mode="r")
    assert {name for name, _ in group.members()} == {"surfaces", "shapes", "pairs", "mended", "matrices", "unfinished"}
    pair = group["pairs/how/a/b"]
    assert pair.attrs["score"] == VALUES["score"]
    assert pair.attrs["margin"] == "inf"
    np.testing.assert_array_equal(pair["columns"][...], ARRAYS["columns"])
    assert len(list(group["unfinished"].members())) == 0
    assert not recwarn.list


def test_the_first_record_stays(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whether it is seen before the second is begun, or appears while that is written."""
    assert records.write_record(root, "shapes/a", {"x": np.zeros(1)}, {"by": "first"})
    assert not records.write_record(root, "shapes/a", {"x": np.ones(1)}, {"by": "second"})
    rename, others = os.rename, []

    def late(source: Path, target: Path) -> None:
        if not others:
            others.append(1)
            assert records.write_record(root, "shapes/b", {"x": np.zeros(1)}, {"by": "quicker"})
        rename(source, target)

    monkeypatch.setattr(os, "rename", late)
    assert not records.write_record(root, "shapes/b", {"x": np.ones(1)}, {"by": "slower"})
    assert (read_values(root, "shapes/b") or {})["by"] == "quicker"
    assert [path.name for path in (root / "unfinished").iterdir()] == ["zarr.json"]


def damages(folder: Path) -> list[tuple[str, Path, bytes | None]]:
    """What may happen to a record: its file, and the content that it then has; None: it is gone."""
    chunk, metadata = folder / "rows" / "c" / "0" / "0", folder / "zarr.json"
    content = metadata.read_bytes()
    return [
        ("rows", chunk, None),
        ("rows", chunk, chunk.read_bytes()[:-3]),
        ("rows", chunk, b""),
        ("rows", folder / "rows" / "zarr.json", None),
        ("rows", folder / "rows" / "zarr.json", (folder / "rows" / "zarr.json").read_bytes().replace(b"4", b"3")),
        ("zarr.json", metadata, content[: len(content) // 2]),
        ("zarr.json", metadata, b"[1]"),
        ("attributes", metadata, content.replace(b'"confident": true', b'"confident": false')),
    ]


@pytest.mark.parametrize("number", range(8))
def test_a_damaged_record_is_named_and_computed_again(
    root: Path, number: int, caplog: pytest.LogCaptureFixture
) -> None:
    records.write_record(root, "shapes/a", ARRAYS, VALUES)
    word, file, content = damages(root / "shapes" / "a")[number]
    file.unlink() if content is None else file.write_bytes(content)
    with pytest.raises(DamagedRecord, match=rf"shapes.a is damaged: .*{word}"):
        read_record(root, "shapes/a")
    with caplog.at_level(logging.WARNING):
        assert Store(root).read("shapes/a") is None
    assert "computed again" in caplog.text
    assert not (root / "shapes" / "a").exists()
    assert records.write_record(root, "shapes/a", ARRAYS, VALUES)
    assert Store(root).read("shapes/a") is not None


def test_another_process_may_have_set_it_aside(root: Path) -> None:
    set_aside(root, "shapes/never", "gone")
    assert [path.name for path in (root / "unfinished").iterdir()] == ["zarr.json"]


def test_a_full_disk_names_the_record_and_keeps_the_others(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    records.write_record(root, "shapes/a", ARRAYS, VALUES)
    write, written = Path.open, []

    def full(path: Path, mode: str = "r", *args: object, **kwargs: object) -> object:
        if "w" in mode and "unfinished" in path.parts:
            written.append(path)
            if len(written) > 5:
                raise OSError(errno.ENOSPC, "No space left on device", str(path))
        return write(path, mode, *args, **kwargs)  # type: ignore[arg-type]

    monkeypatch.setattr(Path, "open", full)
    with pytest.raises(OSError, match="No space left") as caught:
        records.write_record(root, "shapes/b", ARRAYS, VALUES)
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, str(root / "shapes" / "b"))
    assert [path.name for path in (root / "unfinished").iterdir()] == ["zarr.json"]
    assert not (root / "shapes" / "b").exists()
    assert read_record(root, "shapes/a") is not None


def test_what_was_left_unfinished_goes_after_a_day(root: Path) -> None:
    for name, age in (("old", 90_000), ("new", 80_000)):
        (root / "unfinished" / name / "record").mkdir(parents=True)
        os.utime(root / "unfinished" / name, (time.time() - age,) * 2)
    Store(root)
    assert {path.name for path in (root / "unfinished").iterdir()} == {"new", "zarr.json"}


def test_the_index_is_written_when_it_changes(root: Path) -> None:
    settings = Settings(mirror="no", repair=False)
    entries = [Entry("a", "g", "0" * 32, "/a.ply", ("a face was left out",)), Entry("inf", "", "1" * 32)]
    Store(root).write_index(entries, settings, {"c": "no such file"})
    before = (root / "zarr.json").stat().st_mtime_ns
    Store(root).write_index(entries, settings, {"c": "no such file"})
    assert (root / "zarr.json").stat().st_mtime_ns == before
    assert Store(root, create=False).read_index() == (entries, settings, {"c": "no such file"})


def test_folders_that_are_no_store_are_refused(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("")
    write_group(tmp_path / "foreign", {"a": 1})
    zarr.create_array(str(tmp_path / "array"), shape=(3,), dtype="float64")
    (tmp_path / "file").write_text("")
    for name in ("mine", "foreign", "array", "file"):
        with pytest.raises(ParameterError, match=rf"{name} is there and is no collection of shapes: choose another"):
            Store(tmp_path / name)
    assert sorted(path.name for path in (tmp_path / "mine").iterdir()) == ["thesis.tex"]
    with pytest.raises(FileNotFoundError, match="no such collection"):
        Store(tmp_path / "none", create=False)
    with pytest.raises(FileNotFoundError, match="is not a folder"):
        Store(tmp_path / "none" / "deeper")
    with pytest.raises(ParameterError, match="has no shapes yet"):
        Store(tmp_path / "fresh").read_index()


def test_a_store_of_another_format_is_refused(root: Path) -> None:
    write_group(root, {"qgeo_collection": {"format": 99}})
    with pytest.raises(ParameterError, match=r"is a collection of format 99, and this version .* reads format 1"):
        Store(root)
