"""Results of expensive stages, kept by content: same arrays, parameters and code, same key, one computation."""

from __future__ import annotations

import contextlib
import enum
import hashlib
import logging
import os
import re
import threading
import time
import types
import weakref
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Set
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, TypeVar

import joblib
import numpy as np

from qgeo_filters._log import timed
from qgeo_filters.atomic import ABANDONED, atomic_path
from qgeo_filters.errors import ParameterError

T = TypeVar("T")

_log = logging.getLogger(__name__)

# Names of the files that are this cache's, and those of files that a writer was killed over.
_OWN = re.compile(r"\w+-[0-9a-f]{32}\.joblib")
_BEGUN = re.compile(r"\.\w+-[0-9a-f]{32}-\w+\.joblib")
_DIGEST = 32  # bytes of SHA-256 before the pickle


class _Keep(enum.Enum):
    KEEP = "as it is"

    def __repr__(self) -> str:
        return "as it is"


KEEP: Literal[_Keep.KEEP] = _Keep.KEEP
"""Stands for an argument that is not given: what is set stays."""


def arrays_of(value: Any) -> Iterator[np.ndarray]:
    """Each array that a result holds, once: in sequences, mappings, dataclasses, sparse matrices and other objects."""
    seen: dict[int, Any] = {}
    waiting = [value]
    while waiting:
        one = waiting.pop()
        if id(one) in seen or isinstance(one, (str, bytes, int, float, np.generic, type, types.ModuleType, type(None))):
            continue
        seen[id(one)] = one
        if isinstance(one, np.ndarray):
            yield one
        elif isinstance(one, Mapping):
            waiting += one.values()
        elif isinstance(one, (list, tuple, Set)):
            waiting += one
        elif not isinstance(one, types.FunctionType):
            waiting += vars(one).values() if hasattr(one, "__dict__") else ()
            slots = (getattr(kind, "__slots__", ()) for kind in type(one).__mro__)
            names = [name for some in slots for name in ([some] if isinstance(some, str) else some)]
            waiting += [getattr(one, name) for name in names if name != "__dict__" and hasattr(one, name)]


def size_in_bytes(value: Any) -> int:
    """Bytes of the arrays that a result holds, memory that two of them share counted once; at least 64."""
    held = {}
    for array in arrays_of(value):
        while isinstance(array.base, np.ndarray):
            array = array.base
        held[id(array)] = array.nbytes
    return max(64, sum(held.values()))


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
            self._shrink()
        self._shrink_folder()

    def clear(self) -> None:
        """Forget everything, on disk too; files of others in the folder stay."""
        with self._lock:
            self._entries.clear()
            self._alive.clear()
        for path, _, _ in self._files():
            _remove(path)

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
        value, loaded = self._load(key)
        if not loaded:
            with timed(_log, "%s: computed", key):
                value = compute()
            self._save(key, value)
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

    def _file(self, key: str) -> Path | None:
        if self.directory is None:
            return None
        name = f"{key}.joblib"
        return self.directory / (name if _OWN.fullmatch(name) else f"stage-{joblib.hash(key)}.joblib")

    def _files(self) -> list[tuple[Path, int, float]]:
        """Files of this cache with their sizes and times of last use; another process may remove them meanwhile."""
        folder, found = self.directory, []
        for path in folder.iterdir() if folder is not None and folder.is_dir() else ():
            with contextlib.suppress(FileNotFoundError):
                status = path.stat()
                if _OWN.fullmatch(path.name):
                    found.append((path, status.st_size, status.st_mtime))
                elif _BEGUN.fullmatch(path.name) and time.time() - status.st_mtime > ABANDONED:
                    _remove(path)
        return found

    def _load(self, key: str) -> tuple[Any, bool]:
        path = self._file(key)
        if path is None:
            return None, False
        try:
            value = _read(path)
        except FileNotFoundError:
            return None, False
        except Exception as error:  # what is whole, but of another version of a library, raises any kind of error
            _log.warning("%s cannot be read (%s: %s): computed again", path, type(error).__name__, error)
            return None, False
        with contextlib.suppress(OSError):  # another process may have removed it
            os.utime(path)  # recently used
        _log.debug("%s: on disk", key)
        return value, True

    def _save(self, key: str, value: Any) -> None:
        path = self._file(key)
        if path is None:
            return
        if size_in_bytes(value) > self.max_disk_bytes:
            _log.debug("%s: larger than the bound of the folder, not kept there", key)
            return
        try:
            with atomic_path(path) as temporary:
                _write(temporary, value)
        except OSError as error:  # a full disk, a folder that went away: the result itself is there
            _log.warning("%s cannot be kept in %s: %s", key.partition("-")[0], self.directory, error)
            return
        self._shrink_folder(path)

    def _shrink_folder(self, newest: Path | None = None) -> None:
        files = sorted(self._files(), key=lambda file: file[2])
        total = sum(size for _, size, _ in files)
        for path, size, _ in files:
            if total <= self.max_disk_bytes:
                break
            if path != newest:  # larger than the bound on its own: it stays until the next one comes
                _remove(path)
                total -= size
                _log.debug("%s: removed, %d bytes", path, size)


def _write(path: Path, value: Any) -> None:
    with path.open("w+b") as file:
        file.write(bytes(_DIGEST))
        joblib.dump(value, file)
        file.seek(_DIGEST)
        digest = hashlib.file_digest(file, "sha256").digest()
        file.seek(0)
        file.write(digest)


def _read(path: Path) -> Any:
    """Value of a file that is as it was written: unpickling any other can end the process, or give other numbers."""
    with path.open("rb") as file:
        digest = file.read(_DIGEST)
        if hashlib.file_digest(file, "sha256").digest() != digest:
            raise ValueError("it is damaged")
        file.seek(_DIGEST)
        return joblib.load(file)


def _remove(path: Path) -> None:
    # Another process may have removed it, or (on Windows) have it open: then it goes another time.
    with contextlib.suppress(FileNotFoundError, PermissionError):
        path.unlink()


cache = StageCache()
"""The cache that all filters share; ``qg.cache.configure(directory=...)`` keeps it on disk."""
