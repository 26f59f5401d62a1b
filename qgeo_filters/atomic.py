"""Files that are either whole or not there."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Temporary path beside the target, moved onto it when the block ends well, removed when it does not.

    For writers that want a file name; the suffix is the target's own.

    Raises
    ------
    FileNotFoundError, NotADirectoryError, PermissionError
        Where the folder does not exist or cannot be written to, naming it.
    """
    target = Path(path)
    folder = target.parent
    if not folder.is_dir():
        kind = NotADirectoryError if folder.exists() else FileNotFoundError
        raise kind(f"cannot write {target}: {folder} is not a folder")
    try:
        handle, name = tempfile.mkstemp(dir=folder, prefix=f".{target.stem}-", suffix=target.suffix)
    except PermissionError as error:
        raise PermissionError(f"cannot write {target}: the folder {folder} is read-only") from error
    os.close(handle)
    umask = os.umask(0)
    os.umask(umask)
    os.chmod(name, 0o666 & ~umask)  # mkstemp makes files that only their owner can read
    try:
        yield Path(name)
        os.replace(name, target)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


@contextmanager
def atomic_write(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open binary file that appears under its name only when the block ends well."""
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        yield file
