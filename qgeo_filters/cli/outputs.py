"""The folder of a command's results, in which nothing is replaced or removed but what an earlier command left there."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from qgeo_filters.atomic import atomic_path, atomic_write
from qgeo_filters.errors import ParameterError

LISTING = "result.json"

# Stands in the listing for its own digest while that is taken.
_BLANK = b"0" * 64


class OutputFolder:
    """Files of one command in one folder, each listed with its digest in result.json before it appears.

    A file is the package's own if the listing of an earlier command names it, its content is still what was listed,
    and the listing itself is as it was written. All others are the user's, and so is whatever the command reads, by
    whatever name: a command that would have to replace one of them is refused before it computes anything. The first
    file that is written removes what the earlier command left, so that the folder holds no mixture.

    Parameters
    ----------
    folder : Path
        Made when the first file is written.
    names : iterable of str
        All files that the command may write, but for the listing.
    inputs : iterable of Path
        Files that the command reads.
    content : callable
        Gives the content of the listing, in JSON's types.

    Attributes
    ----------
    digests : dict of str to str
        SHA-256 of the files that were written, by name.
    left : list of str
        A sentence for each file of the earlier command that was not removed.

    Raises
    ------
    ParameterError
        A file of the user's stands where one is to be written.
    OSError
        The folder cannot be written to.
    """

    def __init__(
        self, folder: Path, names: Iterable[str], inputs: Iterable[Path], content: Callable[[], Mapping[str, Any]]
    ) -> None:
        self.folder = writable_folder(folder)
        self.digests: dict[str, str] = {}
        self.left: list[str] = []
        self._names = frozenset(names)
        self._inputs = tuple(inputs)
        self._content = content
        self._hashed: dict[tuple[int, ...], str] = {}
        self._own = listed_digests(self.folder / LISTING)  # of the earlier command, then of this one
        self._cleared = False
        self._require_free(LISTING, *sorted(self._names))

    @property
    def files(self) -> list[str]:
        """Names of all files that were written, the listing first."""
        return [LISTING, *self.digests]

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """Temporary path of a file, which appears under its name, listed, when the block ends well."""
        if name not in self._names:
            raise KeyError(f"{name} is not among the files of this command")
        self.folder.mkdir(parents=True, exist_ok=True)
        with atomic_path(self.folder / name) as temporary:
            yield temporary
            digest = self._digest(temporary)
            self._clear()
            self._require_free(name, LISTING)
            self._list({**self.digests, name: digest})
        self.digests[name] = self._own[name] = digest

    def list_files(self) -> None:
        """Write the listing again, with the content as it is now."""
        self._list(self.digests)

    def _list(self, digests: Mapping[str, str]) -> None:
        files = {"files": [LISTING, *digests], "sha256": {**digests, LISTING: _BLANK.decode()}}
        text = json.dumps({**self._content(), **files}, indent=2, ensure_ascii=False) + "\n"
        # Bytes of a file name that are no text come as lone surrogates, for which JSON has an escape.
        before, _, after = text.encode("utf-8", errors="backslashreplace").rpartition(_BLANK)
        own = hashlib.sha256(before + _BLANK + after).hexdigest()
        self._require_free(LISTING)
        with atomic_write(self.folder / LISTING) as file:
            file.write(before + own.encode() + after)
        self._own[LISTING] = own

    def _clear(self) -> None:
        """Remove the files of the earlier command, once, but for its listing, which the new one replaces."""
        if self._cleared:
            return
        self._own = listed_digests(self.folder / LISTING)  # another command may have ended here meanwhile
        self._require_free(LISTING)
        for name in sorted(self._own.keys() - {LISTING}):
            path = self.folder / name
            if why := self._objection(name):
                self.left.append(f"{path} {why}: it is left as it is")
            else:
                path.unlink(missing_ok=True)
            del self._own[name]
        self._cleared = True

    def _require_free(self, *names: str) -> None:
        """Raise where one of these names is that of a file of the user's."""
        taken = [(name, why) for name in names if (why := self._objection(name))]
        if taken:
            name, why = taken[0]
            more = f" (and {len(taken) - 1} more such files)" if len(taken) > 1 else ""
            raise ParameterError(
                f"{self.folder / name} {why}, and would be written over{more}: choose another folder with -o, or move "
                f"{'them' if more else 'it'} away"
            )

    def _objection(self, name: str) -> str:
        """Why a file of this name is the user's; nothing if it is the package's own, or not there."""
        path = self.folder / name
        if any(same_file(path, read) for read in self._inputs):
            return "is read by this command"
        try:
            path.lstat()
        except (FileNotFoundError, NotADirectoryError):
            return ""
        if name not in self._own:
            return "is not listed as a file that qgeo made"
        return "" if self._digest(path) == self._own[name] else "was changed since qgeo made it"

    def _digest(self, path: Path) -> str:
        """SHA-256 of a file's content, or the digest that a listing holds of itself; nothing for what is no file."""
        if path.is_symlink() or not path.is_file():
            return ""
        if path.name == LISTING:
            return listed_digests(path).get(LISTING, "")
        status = path.stat()
        key = (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
        if key not in self._hashed:  # files of gigabytes are read once
            with path.open("rb") as file:
                self._hashed[key] = hashlib.file_digest(file, "sha256").hexdigest()
        return self._hashed[key]


def listed_digests(listing: Path) -> dict[str, str]:
    """Digests of the files of a folder, by name, from its listing; empty where that is not as it was written."""
    try:
        written = listing.read_bytes()
        digests = {str(name): str(digest) for name, digest in json.loads(written)["sha256"].items()}
        before, found, after = written.rpartition(digests[LISTING].encode())
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return {}  # none, another program's, or one of an earlier version, which listed no digests
    intact = found and hashlib.sha256(before + _BLANK + after).hexdigest() == digests[LISTING]
    # A listing says nothing of files elsewhere.
    return {name: digest for name, digest in digests.items() if Path(name).name == name} if intact else {}


def same_file(one: Path, other: Path) -> bool:
    """Whether two paths lead to one file: through links, by a second name, or to a file that is yet to be made."""
    if os.path.realpath(one) == os.path.realpath(other):
        return True
    try:
        return os.path.samefile(one, other)
    except OSError:  # one of them is not there
        return False


def writable_folder(folder: Path) -> Path:
    """The folder, if it can be made and written to; said before hours of computing, not after."""
    place = folder.absolute()
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir():
        raise NotADirectoryError(f"cannot write into {folder}: {place} is not a folder")
    if not os.access(place, os.W_OK | os.X_OK):
        raise PermissionError(f"cannot write into {folder}: {place} is read-only")
    return folder
