"""The stage cache: keys by content, bounds, disk."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from qgeo_filters.caching import StageCache, content_key, size_in_bytes


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
    assert {path.name for path in files} <= {f"stage-{i}.joblib" for i in (8, 9)}
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
