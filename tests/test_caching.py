"""The stage cache: keys by content, bounds, disk."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import threading
import time
from collections import OrderedDict
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from scipy import sparse

import qgeo_filters
from qgeo_filters import fingerprint
from qgeo_filters.caching import StageCache
from qgeo_filters.fingerprint import code_digest, content_key, numeric_sources
from qgeo_filters.held_arrays import arrays_of, size_in_bytes


def test_keys_follow_content() -> None:
    a = np.arange(6.0)
    assert content_key("s", a, 1, None) == content_key("s", a.copy(), 1, None)
    different = {content_key("s", a, 1), content_key("t", a, 1), content_key("s", a + 1e-12, 1), content_key("s", a, 2)}
    assert len(different) == 4


def test_each_key_is_computed_once() -> None:
    cache, calls = StageCache(), []
    for _ in range(3):
        value = cache.get("k", lambda: calls.append(1) or np.ones(3))
    assert calls == [1]
    assert (cache.hits, cache.misses) == (2, 1)
    assert not value.flags.writeable  # shared results cannot be changed by accident


def test_the_least_recently_used_goes_first() -> None:
    cache = StageCache(max_bytes=2 * 800)
    for name in ("a", "b"):
        cache.get(name, lambda: np.zeros(100))
    cache.get("a", lambda: pytest.fail("kept"))
    cache.get("c", lambda: np.zeros(100))
    calls = []
    cache.get("a", lambda: pytest.fail("a was used more recently than b"))
    cache.get("b", lambda: calls.append(1) or np.zeros(100))
    assert calls == [1]


def test_nothing_is_dropped_while_held() -> None:
    cache = StageCache(max_bytes=0)
    with cache.held():
        cache.get("a", lambda: np.zeros(100))
        cache.get("a", lambda: pytest.fail("held"))
    calls = []
    cache.get("a", lambda: calls.append(1) or np.zeros(100))
    assert calls == [1]


def test_what_a_caller_still_holds_is_not_computed_again() -> None:
    cache = StageCache(max_bytes=0)
    value = cache.get("a", lambda: np.zeros(100))
    assert cache.get("a", lambda: pytest.fail("it is alive")) is value
    del value
    calls = []
    cache.get("a", lambda: calls.append(1) or np.zeros(100))
    assert calls == [1]


def test_disk_survives_the_process(tmp_path: Path) -> None:
    StageCache(directory=tmp_path).get("stage-1", lambda: np.arange(5))
    found = StageCache(directory=tmp_path).get("stage-1", lambda: pytest.fail("on disk"))
    assert np.array_equal(found, np.arange(5))


def test_disk_is_bounded_and_leaves_no_parts(tmp_path: Path) -> None:
    cache = StageCache(directory=tmp_path, max_disk_bytes=20_000, max_bytes=0)
    for i in range(10):
        cache.get(f"stage-{i}", lambda: np.zeros(1000))
    files = list(tmp_path.iterdir())
    assert 1 <= len(files) <= 2
    for i in (9, 8)[: len(files)]:
        cache.get(f"stage-{i}", lambda: pytest.fail("the last ones are kept"))
    cache.configure(max_disk_bytes=10_000)  # a smaller bound holds at once
    assert len(list(tmp_path.iterdir())) == 1
    cache.clear()
    assert not list(tmp_path.iterdir())


def test_an_error_is_not_kept(tmp_path: Path) -> None:
    cache = StageCache(directory=tmp_path)
    with pytest.raises(ZeroDivisionError):
        cache.get("k-1", lambda: 1 / 0)
    assert cache.get("k-1", lambda: 3) == 3


def test_negative_bound_is_refused() -> None:
    with pytest.raises(ValueError, match="must not be negative, got -1"):
        StageCache(max_bytes=-1)


def test_sizes_count_arrays_in_containers() -> None:
    assert size_in_bytes({"a": np.zeros(10), "b": [np.zeros(5)]}) == 120


@pytest.fixture
def fresh_digest():
    code_digest.cache_clear()
    yield
    code_digest.cache_clear()


@pytest.mark.usefixtures("fresh_digest")
def test_keys_change_with_the_version_and_with_the_code(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Before, a folder kept from an earlier version gave its results."""
    keys = [content_key("s", 1)]
    code_digest.cache_clear()
    assert content_key("s", 1) == keys[0]
    code_digest.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(qgeo_filters, "__version__", "0.0.0")
        keys.append(content_key("s", 1))
    sources = numeric_sources()
    kernel = next(path for path in sources if path.parent.name == "dgg")  # in a folder of a folder
    root = Path(qgeo_filters.__file__).parent
    edited = tmp_path / kernel.relative_to(root)
    edited.parent.mkdir(parents=True)
    edited.write_bytes(kernel.read_bytes() + b"\n")
    code_digest.cache_clear()
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(edited if path == kernel else path))
    keys.append(content_key("s", 1))
    assert len(set(keys)) == 3


def test_the_numeric_sources_are_all_but_those_that_show_results() -> None:
    root = Path(qgeo_filters.__file__).parent
    names = {path.relative_to(root).as_posix() for path in numeric_sources()}
    everything = {path.relative_to(root).as_posix() for path in root.rglob("*.py")}
    assert {name.split("/")[0] for name in everything - names} == {"cli", "report", "evaluation", "collection"}
    assert {"__init__.py", "surface.py", "filters/stages.py", "geodesics/dgg/graph.py"} <= names


def test_the_code_is_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    before = content_key("s")
    monkeypatch.setattr(fingerprint, "numeric_sources", lambda: pytest.fail("read again"))
    assert content_key("s") == before
    assert content_key("s", 1) != before


def test_what_is_not_given_stays(tmp_path: Path) -> None:
    cache = StageCache(max_bytes=1000, directory=tmp_path, max_disk_bytes=2000)
    cache.configure(max_bytes=500)
    assert (cache.max_bytes, cache.directory, cache.max_disk_bytes) == (500, tmp_path, 2000)
    cache.configure(max_disk_bytes=100)
    assert (cache.max_bytes, cache.directory, cache.max_disk_bytes) == (500, tmp_path, 100)
    cache.configure(directory=str(tmp_path / "a" / "b"))
    assert (cache.max_bytes, cache.directory, cache.max_disk_bytes) == (500, tmp_path / "a" / "b", 100)
    with pytest.raises(ValueError, match="must not be negative, got -3"):
        cache.configure(max_disk_bytes=-3, directory=None)
    assert cache.directory == tmp_path / "a" / "b"
    cache.configure(directory=None)
    assert (cache.max_bytes, cache.directory, cache.max_disk_bytes) == (500, None, 100)
    cache.configure()
    assert (cache.max_bytes, cache.directory, cache.max_disk_bytes) == (500, None, 100)


@dataclass(frozen=True, slots=True)
class Slotted:
    """A result without ``__dict__``."""

    values: np.ndarray


class Plain:
    """An object that refers to itself."""

    def __init__(self, values: np.ndarray) -> None:
        self.values, self.kept, self.itself = values, {"a": np.zeros(2)}, self


def test_no_array_of_a_result_can_be_changed(tmp_path: Path) -> None:
    matrix = sparse.csr_matrix(np.eye(3))
    result = {
        "array": np.zeros(3),
        "tuple": (np.zeros(2), [np.zeros(1), {"deep": np.zeros(4)}]),
        "ordered": OrderedDict(a=np.zeros(2)),
        "slots": Slotted(np.zeros(2)),
        "object": Plain(np.zeros(2)),
        "sparse": matrix,
    }
    cache = StageCache(directory=tmp_path)
    for value in (cache.get("k", lambda: result), StageCache(directory=tmp_path).get("k", lambda: pytest.fail("disk"))):
        found = list(arrays_of(value))
        assert len(found) == 11
        assert not any(array.flags.writeable for array in found)
        with pytest.raises(ValueError, match="read-only"):
            value["tuple"][1][1]["deep"][0] = 1
        with pytest.raises(ValueError, match="read-only"):
            value["sparse"].data[0] = 2
        assert np.array_equal((value["sparse"] @ value["sparse"]).toarray(), np.eye(3))
    proxy = StageCache().get("k", lambda: MappingProxyType({"a": np.zeros(2)}))
    assert not proxy["a"].flags.writeable


def test_sizes_count_shared_memory_once() -> None:
    values = np.zeros(100)
    assert size_in_bytes([values, values[:50], values.reshape(10, 10).T]) == 800
    assert size_in_bytes(Plain(values)) == 816
    assert size_in_bytes("text") == 64


def test_one_turned_bit_is_seen(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A damaged pickle can end the process, and a damaged array would be taken for the true one."""
    StageCache(directory=tmp_path).get("k", lambda: np.arange(50.0))
    (file,) = tmp_path.iterdir()
    content = file.read_bytes()
    for place in np.linspace(0, len(content) - 1, 60).astype(int):
        damaged = bytearray(content)
        damaged[place] ^= 4
        file.write_bytes(damaged)
        caplog.clear()
        found = StageCache(directory=tmp_path).get("k", lambda: np.arange(50.0))
        np.testing.assert_array_equal(found, np.arange(50.0))
        assert "it is damaged" in caplog.text
    assert file.read_bytes() == content


@pytest.mark.parametrize("content", [b"", b"no joblib file", None], ids=["empty", "foreign", "cut"])
def test_a_damaged_file_is_computed_again(tmp_path: Path, content: bytes | None, caplog) -> None:
    StageCache(directory=tmp_path).get("k", lambda: np.arange(1000))
    (file,) = tmp_path.iterdir()
    file.write_bytes(file.read_bytes()[:-500] if content is None else content)
    with caplog.at_level(logging.WARNING, "qgeo_filters"):
        value = StageCache(directory=tmp_path).get("k", lambda: np.arange(1000))
    assert np.array_equal(value, np.arange(1000))
    assert str(file) in caplog.text
    StageCache(directory=tmp_path).get("k", lambda: pytest.fail("whole again"))


def test_files_of_others_stay(tmp_path: Path) -> None:
    """Before, every ``*-*.joblib`` was removed, and counted."""
    others = [tmp_path / name for name in ("my-model.joblib", "notes.txt", ".x-y.joblib", "a-b-c.joblib")]
    for path in others:
        path.write_bytes(bytes(5000))
    cache = StageCache(directory=tmp_path, max_disk_bytes=9000, max_bytes=0)
    key = content_key("stage", 1)
    cache.get(key, lambda: np.zeros(1000))
    cache.get("other", lambda: np.zeros(1))
    cache.get(key, lambda: pytest.fail("their files do not count"))
    cache.clear()
    assert sorted(tmp_path.iterdir()) == sorted(others)


def test_what_a_killed_writer_left_goes_after_a_day(tmp_path: Path) -> None:
    name = content_key("stage", 1)
    old, young = (tmp_path / f".{name}-{letters}.joblib" for letters in ("abcd_123", "efgh4567"))
    for path in (old, young):
        path.write_bytes(bytes(10))
    os.utime(old, (time.time() - 100_000,) * 2)
    StageCache(directory=tmp_path).get("k", lambda: 1)
    assert not old.exists()
    assert young.exists()


@pytest.mark.parametrize("max_bytes", [1 << 20, 0])
def test_threads_that_ask_for_one_key_compute_it_once(max_bytes: int) -> None:
    cache, calls, together = StageCache(max_bytes=max_bytes), [], threading.Barrier(4)

    def compute() -> np.ndarray:
        calls.append(1)
        time.sleep(0.2)
        return np.ones(3)

    found = []

    def ask() -> None:
        together.wait()
        found.append(cache.get("k", compute))

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert calls == [1]
    assert len({id(value) for value in found}) == 1
    assert (cache.hits, cache.misses) == (3, 1)


def test_who_waited_for_an_error_computes_itself() -> None:
    cache, begun, found = StageCache(), threading.Event(), []

    def fail() -> int:
        begun.set()
        time.sleep(0.1)
        raise KeyError("first")

    def first() -> None:
        with pytest.raises(KeyError):
            cache.get("k", fail)

    thread = threading.Thread(target=first)
    thread.start()
    begun.wait()
    found.append(cache.get("k", lambda: 7))
    thread.join()
    assert found == [7]
    assert cache.get("k", lambda: pytest.fail("kept")) == 7


def test_different_keys_do_not_wait_for_each_other() -> None:
    cache, inner = StageCache(), []
    assert cache.get("outer", lambda: inner.append(cache.get("inner", lambda: 1)) or 2) == 2
    assert inner == [1]
    with pytest.raises(RuntimeError, match="asks for its own result"):
        cache.get("k", lambda: cache.get("k", lambda: 1))
    assert cache.get("k", lambda: 3) == 3


_PROCESS = """
import sys
import numpy as np
from qgeo_filters.caching import StageCache
cache = StageCache(max_bytes=0, directory=sys.argv[1], max_disk_bytes=30_000)
for turn in range(150):
    i = turn * int(sys.argv[2]) % 7
    value = cache.get(f"stage-{i}", lambda: np.full(1000, i))
    assert (value == i).all(), (i, value)
    if turn % 40 == 39:
        cache.clear()
"""


def test_processes_share_a_folder(tmp_path: Path) -> None:
    """Before, one of them met a file that another had just removed."""
    running = [
        subprocess.Popen([sys.executable, "-c", _PROCESS, str(tmp_path), str(step)], stderr=subprocess.PIPE, text=True)
        for step in (1, 2, 3, 5)
    ]
    for process in running:
        assert process.communicate()[1] == ""
        assert process.returncode == 0
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
