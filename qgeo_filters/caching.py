"""Results of expensive stages, kept by content: same arrays, parameters and code, same key, one computation."""

from __future__ import annotations

import contextlib
import enum
import logging
import os
import threading
import weakref
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, TypeVar

from qgeo_filters._log import timed
from qgeo_filters.errors import ParameterError
from qgeo_filters.held_arrays import arrays_of, size_in_bytes
from qgeo_filters.result_folder import ResultFolder

T = TypeVar("T")

_log = logging.getLogger(__name__)


class _Keep(enum.Enum):
    KEEP = "as it is"

    def __repr__(self) -> str:
        return "as it is"


KEEP: Literal[_Keep.KEEP] = _Keep.KEEP
"""Stands for an argument that is not given: what is set stays."""


class _Computation:
    """A result that one thread computes and others wait for."""

    def __init__(self) -> None:
        self.thread = threading.get_ident()
        self.ended = threading.Event()
        self.result: list[Any] = []  # empty: not yet, or it failed


class StageCache:
    """Results by key, the least recently used dropped first, on disk too when asked.

    Threads that ask for one key at the same time compute it once. Processes may share a folder.

    Parameters
    ----------
    max_bytes : int, default 2 GiB
        Bound of what is kept in memory between calls; 0 keeps nothing. What a caller still holds is found all the same.
    directory : path, optional
        Folder in which results are kept as well, as joblib files, written atomically. Loading a joblib file can run
        code that is in it: use folders that only you write to.
    max_disk_bytes : int, default 20 GiB
        Bound of the folder; a result that is larger on its own is not kept there, nor one for which there is no room,
        which is logged.
    """

    def __init__(
        self,
        max_bytes: int = 2 << 30,
        directory: str | os.PathLike[str] | None = None,
        max_disk_bytes: int = 20 << 30,
    ) -> None:
        self._lock = threading.RLock()
        self._entries: OrderedDict[str, Any] = OrderedDict()
        self._begun: dict[str, _Computation] = {}
        # Results that were dropped, but that somebody still holds: finding them costs nothing.
        self._alive: weakref.WeakValueDictionary[str, Any] = weakref.WeakValueDictionary()
        self._holders = 0
        self.hits = 0
        self.misses = 0
        self.max_bytes, self.max_disk_bytes = 0, 0
        self.directory: Path | None = None
        self._folder: ResultFolder | None = None
        self.configure(max_bytes=max_bytes, directory=directory, max_disk_bytes=max_disk_bytes)

    def configure(
        self,
        *,
        max_bytes: int | Literal[_Keep.KEEP] = KEEP,
        directory: str | os.PathLike[str] | Literal[_Keep.KEEP] | None = KEEP,
        max_disk_bytes: int | Literal[_Keep.KEEP] = KEEP,
    ) -> None:
        """Set bounds and folder (None: memory only); what is not given stays, what no longer fits is dropped."""
        bounds = [self.max_bytes if max_bytes is KEEP else max_bytes]
        bounds += [self.max_disk_bytes if max_disk_bytes is KEEP else max_disk_bytes]
        if min(bounds) < 0:
            raise ParameterError(f"cache bounds must not be negative, got {min(bounds)} bytes")
        folder = self.directory
        if directory is not KEEP:
            folder = None if directory is None else Path(directory)
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
        with self._lock:
            (self.max_bytes, self.max_disk_bytes), self.directory = bounds, folder
            self._folder = None if folder is None else ResultFolder(folder, self.max_disk_bytes)
            self._shrink()
        if self._folder is not None:
            self._folder.shrink()

    def clear(self) -> None:
        """Forget everything, on disk too; files of others in the folder stay."""
        with self._lock:
            self._entries.clear()
            self._alive.clear()
        if self._folder is not None:
            self._folder.clear()

    def get(self, key: str, compute: Callable[[], T]) -> T:
        """Kept result of this key, or the computed one, which is then kept.

        Results are shared: they must not be changed (arrays are made read-only). An error is not kept: who waited
        for the result of another thread that failed computes it itself.
        """
        while True:
            with self._lock:
                if key in self._entries:
                    self._entries.move_to_end(key)
                    self.hits += 1
                    _log.debug("%s: in memory", key)
                    return self._entries[key]
                held = self._alive.get(key)
                if held is not None:
                    self.hits += 1
                    _log.debug("%s: still held by a caller", key)
                    return held
                other = self._begun.get(key)
                if other is None:
                    own = self._begun[key] = _Computation()
                    break
            if other.thread == threading.get_ident():
                raise RuntimeError(f"the computation of {key} asks for its own result")
            other.ended.wait()
            if other.result:
                with self._lock:
                    self.hits += 1
                return other.result[0]
        try:
            value = self._loaded_or_computed(key, compute)
            own.result.append(value)
            with self._lock:
                self._entries[key] = value
                with contextlib.suppress(TypeError):  # numbers, tuples and dictionaries cannot be referred to weakly
                    self._alive[key] = value
                self._shrink()
            return value
        finally:
            with self._lock:
                del self._begun[key]
            own.ended.set()

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

    def _loaded_or_computed(self, key: str, compute: Callable[[], T]) -> T:
        folder = self._folder
        found: tuple[Any, bool] = (None, False) if folder is None else folder.load(key)
        value, loaded = found
        if not loaded:
            with timed(_log, "%s: computed", key):
                value = compute()
            if folder is not None:
                folder.save(key, value)
        for array in arrays_of(value):
            array.setflags(write=False)
        with self._lock:
            self.hits += loaded
            self.misses += not loaded
        return value

    def _shrink(self) -> None:
        if self._holders:
            return
        sizes = {key: size_in_bytes(value) for key, value in self._entries.items()}
        total = sum(sizes.values())
        while self._entries and total > self.max_bytes:
            key, _ = self._entries.popitem(last=False)
            total -= sizes[key]
            _log.debug("%s: dropped from memory, %d bytes", key, sizes[key])


cache = StageCache()
"""The cache that all filters share; ``qg.cache.configure(directory=...)`` keeps it on disk."""
