"""Files that are either whole or not there."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from qgeo_filters.errors import reason

#: Seconds after which nobody writes any more to a file or folder that was begun.
ABANDONED = 86_400.0
# Characters of the target's name in that of its temporary file, which must not be longer than a name may be.
_SHORT = 20


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Temporary path beside the target, moved onto it when the block ends well, removed when it does not.

    For writers that want a file name; the suffix is the target's own.

    Raises
    ------
    FileNotFoundError, NotADirectoryError, PermissionError
        Where the folder does not exist or cannot be written to, naming it.
    OSError
        What the system says of the write (no space, a quota, a failing disk), naming the target.
    """
    target = Path(path)
    folder = target.parent
    if not folder.is_dir():
        kind = NotADirectoryError if folder.exists() else FileNotFoundError
        raise kind(f"cannot write {target}: {folder} is not a folder")
    try:
        handle, name = tempfile.mkstemp(dir=folder, prefix=f".{target.stem[:_SHORT]}-", suffix=target.suffix)
    except PermissionError as error:
        raise PermissionError(f"cannot write {target}: the folder {folder} is read-only") from error
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(target)) from error
    os.close(handle)
    umask = os.umask(0)
    os.umask(umask)
    try:
        os.chmod(name, 0o666 & ~umask)  # mkstemp makes files that only their owner can read
        yield Path(name)
        os.replace(name, target)
    except BaseException as error:
        with contextlib.suppress(OSError):  # a failing disk: what failed first is told
            os.unlink(name)
        if isinstance(error, OSError):
            raise _of_target(error, name, target) from error.__cause__
        raise


@contextmanager
def atomic_write(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open binary file that appears under its name only when the block ends well."""
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        yield file


def _of_target(error: OSError, temporary: str, target: Path) -> OSError:
    """The error with the target's name, where it has none or the temporary file's."""
    if error.errno is not None and (error.filename is None or str(error.filename) == temporary):
        error.filename = str(target)
        del error.filename2
    elif type(error) is OSError and error.errno is None and str(target) not in str(error):  # NumPy's short writes
        return OSError(f"cannot write {target}: {reason(error)}")
    return error
