"""Results in a folder, a file for each key, written atomically; what is damaged is seen, processes may share it."""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import re
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import joblib

from qgeo_filters.atomic import ABANDONED, atomic_path
from qgeo_filters.held_arrays import size_in_bytes

_log = logging.getLogger(__name__)

# Names of the files that are this folder's, and those of files that a writer was killed over.
_OWN = re.compile(r"\w+-[0-9a-f]{32}\.joblib")
_BEGUN = re.compile(r"\.\w+-[0-9a-f]{32}-\w+\.joblib")
_DIGEST = 32  # bytes of SHA-256 before the pickle


@dataclass(frozen=True)
class ResultFolder:
    """The least recently used are removed first; files of others stay.

    Attributes
    ----------
    directory : Path
    max_bytes : int
        Bound of the folder.
    """

    directory: Path
    max_bytes: int

    def load(self, key: str) -> tuple[Any, bool]:
        """The result of this key, and whether there is one that can be read."""
        path = self._file(key)
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

    def save(self, key: str, value: Any) -> None:
        """Keep a result, unless it is larger than the folder may be or there is no room, which is logged."""
        path = self._file(key)
        if size_in_bytes(value) > self.max_bytes:
            _log.debug("%s: larger than the bound of the folder, not kept there", key)
            return
        try:
            with atomic_path(path) as temporary:
                _write(temporary, value)
        except OSError as error:  # a full disk, a folder that went away: the result itself is there
            _log.warning("%s cannot be kept in %s: %s", key.partition("-")[0], self.directory, error)
            return
        self.shrink(path)

    def shrink(self, newest: Path | None = None) -> None:
        """Remove the least recently used until the bound is kept."""
        files = sorted(self._files(), key=lambda file: file[2])
        total = sum(size for _, size, _ in files)
        for path, size, _ in files:
            if total <= self.max_bytes:
                break
            if path != newest:  # larger than the bound on its own: it stays until the next one comes
                _remove(path)
                total -= size
                _log.debug("%s: removed, %d bytes", path, size)

    def clear(self) -> None:
        """Remove all of them."""
        for path, _, _ in self._files():
            _remove(path)

    def _file(self, key: str) -> Path:
        name = f"{key}.joblib"
        return self.directory / (name if _OWN.fullmatch(name) else f"stage-{joblib.hash(key)}.joblib")

    def _files(self) -> list[tuple[Path, int, float]]:
        """Files of this cache with their sizes and times of last use; another process may remove them meanwhile."""
        found = []
        for path in self.directory.iterdir() if self.directory.is_dir() else ():
            with contextlib.suppress(FileNotFoundError):
                status = path.stat()
                if _OWN.fullmatch(path.name):
                    found.append((path, status.st_size, status.st_mtime))
                elif _BEGUN.fullmatch(path.name) and time.time() - status.st_mtime > ABANDONED:
                    _remove(path)
        return found


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
