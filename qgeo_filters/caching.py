"""Results of expensive stages, kept by content: same arrays and parameters, same key, one computation."""

from __future__ import annotations

import os
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import joblib
import numpy as np

from qgeo_filters.atomic import atomic_path
from qgeo_filters.errors import ParameterError

T = TypeVar("T")


def content_key(stage: str, *parts: Any) -> str:
    """Key of a stage from the content of what it depends on (arrays, numbers, strings, None)."""
    return f"{stage}-{joblib.hash((stage, parts))}"


def size_in_bytes(value: Any) -> int:
    """Bytes of the arrays that a result holds (array, dataclass, mapping or sequence of them)."""
    if isinstance(value, np.ndarray):
        return value.nbytes
    if isinstance(value, dict):
        return sum(map(size_in_bytes, value.values()))
    if isinstance(value, (list, tuple)):
        return sum(map(size_in_bytes, value))
    return size_in_bytes(vars(value)) if hasattr(value, "__dict__") else 64


class StageCache:
    """Results by key, the least recently used dropped first, on disk too when asked.

    Parameters
    ----------
    max_bytes : int, default 2 GiB
        Bound of what is kept in memory between calls. 0 keeps nothing.
    directory : path, optional
        Folder in which results are kept as well, as joblib files, written atomically.
    max_disk_bytes : int, default 20 GiB
        Bound of the folder.
    """

    def __init__(
        self,
        max_bytes: int = 2 << 30,
        directory: str | os.PathLike[str] | None = None,
        max_disk_bytes: int = 20 << 30,
    ) -> None:
        self._lock = threading.RLock()
        self._entries: OrderedDict[str, Any] = OrderedDict()
        self._holders = 0
        self.hits = 0
        self.misses = 0
        self.configure(max_bytes=max_bytes, directory=directory, max_disk_bytes=max_disk_bytes)

    def configure(
        self,
        *,
        max_bytes: int = 2 << 30,
        directory: str | os.PathLike[str] | None = None,
        max_disk_bytes: int = 20 << 30,
    ) -> None:
        """Set the bounds and the folder (None: memory only); what no longer fits is dropped."""
        if max_bytes < 0 or max_disk_bytes < 0:
            raise ParameterError(f"cache bounds must not be negative, got {min(max_bytes, max_disk_bytes)} bytes")
        folder = None if directory is None else Path(directory)
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
        with self._lock:
            self.max_bytes, self.directory, self.max_disk_bytes = max_bytes, folder, max_disk_bytes
            self._shrink()

    def clear(self) -> None:
        """Forget everything, on disk too."""
        with self._lock:
            self._entries.clear()
            for path in self._files():
                path.unlink(missing_ok=True)

    def get(self, key: str, compute: Callable[[], T]) -> T:
        """Kept result of this key, or the computed one, which is then kept.

        Results are shared: they must not be changed (arrays are made read-only).
        """
        with self._lock:
            if key in self._entries:
                self._entries.move_to_end(key)
                self.hits += 1
                return self._entries[key]
        value, loaded = self._load(key)
        if not loaded:
            value = compute()
            self._save(key, value)
        _freeze(value)
        with self._lock:
            self.hits += loaded
            self.misses += not loaded
            self._entries[key] = value
            self._shrink()
        return value

    @contextmanager
    def held(self) -> Iterator[None]:
        """Context in which nothing is dropped from memory, whatever the bound: one run of a pipeline."""
        with self._lock:
            self._holders += 1
        try:
            yield
        finally:
            with self._lock:
                self._holders -= 1
                self._shrink()

    def _shrink(self) -> None:
        if self._holders:
            return
        total = sum(map(size_in_bytes, self._entries.values()))
        while self._entries and total > self.max_bytes:
            _, dropped = self._entries.popitem(last=False)
            total -= size_in_bytes(dropped)

    def _files(self) -> list[Path]:
        return [] if self.directory is None else sorted(self.directory.glob("*-*.joblib"))

    def _load(self, key: str) -> tuple[Any, bool]:
        if self.directory is None:
            return None, False
        path = self.directory / f"{key}.joblib"
        try:
            value = joblib.load(path)
            os.utime(path)  # recently used
        except FileNotFoundError:
            return None, False
        return value, True

    def _save(self, key: str, value: Any) -> None:
        if self.directory is None:
            return
        with atomic_path(self.directory / f"{key}.joblib") as temporary:
            joblib.dump(value, temporary)
        files = sorted(self._files(), key=lambda path: path.stat().st_mtime)
        total = sum(path.stat().st_size for path in files)
        for path in files[:-1]:
            if total <= self.max_disk_bytes:
                break
            total -= path.stat().st_size
            path.unlink(missing_ok=True)


def _freeze(value: Any) -> None:
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    elif isinstance(value, (list, tuple)):
        for item in value:
            _freeze(item)
    elif hasattr(value, "__dict__"):
        for item in vars(value).values():
            _freeze(item)


cache = StageCache()
"""The cache that all filters share; ``qg.cache.configure(directory=...)`` keeps it on disk."""
