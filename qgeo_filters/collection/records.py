"""Records of a store: Zarr groups of arrays and attributes, each whole or not there, and known by their digests."""

from __future__ import annotations

import contextlib
import hashlib
import json
import logging
import math
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from qgeo_filters.atomic import ABANDONED, atomic_write
from qgeo_filters.errors import MeshError, require_package
from qgeo_filters.validation import frozen

_log = logging.getLogger(__name__)

#: Group in which records are written before they are moved into place.
UNFINISHED = "unfinished"
METADATA = "zarr.json"
_NOT_FINITE = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}


class DamagedRecord(MeshError):
    """A record that is not as it was written."""


@dataclass(frozen=True, eq=False)
class Record:
    """What one group of a store holds.

    Attributes
    ----------
    arrays : dict of str to array
        Read-only.
    values : dict of str to what JSON holds
    """

    arrays: dict[str, np.ndarray]
    values: dict[str, Any]


def zarr_package() -> Any:
    """The module zarr, or `MissingPackageError`."""
    return require_package("zarr", "collections", "a collection")


def write_group(path: Path, attributes: Mapping[str, Any]) -> None:
    """Write the metadata of a Zarr group, whole or not at all; its folder is made where it is missing."""
    path.mkdir(parents=True, exist_ok=True)
    with atomic_write(path / METADATA) as file:
        file.write(_json({"attributes": attributes, "zarr_format": 3, "node_type": "group"}))


def write_record(root: Path, place: str, arrays: Mapping[str, np.ndarray], values: Mapping[str, Any]) -> bool:
    """Write a record into a store, and move it into place once it is whole.

    Parameters
    ----------
    root : Path
        Folder of the store.
    place : str
        Path of the record below it.
    arrays : mapping of str to array
        Each is a Zarr array of one chunk.
    values : mapping of str to what JSON holds
        Attributes of the group; numbers that are not finite become text.

    Returns
    -------
    bool
        False where the record was there already: another process was quicker, and its record stays.

    Raises
    ------
    OSError
        No space, or whatever else the system says, naming the record. Records that were there stay.
    """
    target = root / place
    if (target / METADATA).exists():
        return False
    temporary = Path(_of_record(target, lambda: tempfile.mkdtemp(dir=root / UNFINISHED)))
    try:
        _of_record(target, lambda: _write(temporary / "record", arrays, values))
        return _of_record(target, lambda: _moved(temporary / "record", target))
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _write(folder: Path, arrays: Mapping[str, np.ndarray], values: Mapping[str, Any]) -> None:
    zarr = zarr_package()
    plain = encoded(dict(values))
    digests = {name: _digest(array) for name, array in arrays.items()}
    # Products of matrices round differently for rows and for columns that lie together.
    columns = [name for name, a in arrays.items() if a.ndim > 1 and a.flags.f_contiguous and not a.flags.c_contiguous]
    content = {**plain, "column_major": columns, "digests": digests}
    group = zarr.create_group(str(folder), attributes={**content, "digest": _digest_of_values(content)})
    for name, array in arrays.items():
        group.create_array(name, data=array, chunks=tuple(max(1, size) for size in array.shape))


def _moved(folder: Path, target: Path) -> bool:
    _ensure_groups(target.parent)
    try:
        os.rename(folder, target)
    except OSError:
        if (target / METADATA).exists():
            return False
        raise
    return True


def _ensure_groups(folder: Path) -> None:
    """Make a folder of records a Zarr group, and those above it as far as they are none."""
    if not (folder / METADATA).exists():
        _ensure_groups(folder.parent)
        write_group(folder, {})


def _of_record(target: Path, action: Callable[[], Any]) -> Any:
    try:
        return action()
    except OSError as error:
        said = error.strerror or str(error)
        raise OSError(error.errno, said, str(target)) from error


def read_values(root: Path, place: str) -> dict[str, Any] | None:
    """Attributes of a record, without its arrays; None where there is none.

    Raises
    ------
    DamagedRecord
        Attributes that are not as they were written.
    """
    file = root / place / METADATA
    try:
        text = file.read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        return None
    try:
        content = json.loads(text)["attributes"]
        digest = content.pop("digest")
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise DamagedRecord(f"{file.parent} is damaged: {METADATA} is not as it was written") from error
    if digest != _digest_of_values(content):
        raise DamagedRecord(f"{file.parent} is damaged: its attributes are not those that were written")
    return {name: decoded(value) for name, value in content.items()}


def read_record(root: Path, place: str, only: Collection[str] | None = None) -> Record | None:
    """A record, checked; None where there is none. ``only`` names the arrays that are wanted; all by default.

    Raises
    ------
    DamagedRecord
        An array that is missing, cut short or changed, named with its record.
    """
    values = read_values(root, place)
    if values is None:
        return None
    columns, digests = set(values.pop("column_major")), values.pop("digests")
    wanted = digests if only is None else {name: digests[name] for name in only if name in digests}
    arrays = {name: _read(root / place, name, digest, name in columns) for name, digest in wanted.items()}
    return Record(arrays, values)


def _read(folder: Path, name: str, digest: str, by_columns: bool) -> np.ndarray:
    try:
        array = np.asarray(zarr_package().open_array(str(folder / name), mode="r")[...])
    except Exception as error:  # of any kind, from the decompressor as well
        raise DamagedRecord(f"{folder} is damaged: the array {name} cannot be read") from error
    if _digest(array) != digest:
        raise DamagedRecord(f"{folder} is damaged: the array {name} is not as it was written")
    return frozen(np.asfortranarray(array) if by_columns else array)


def set_aside(root: Path, place: str, why: str) -> None:
    """Take a damaged record out of the store, so that it is computed again."""
    _log.warning("%s: it is computed again", why)
    # Moved before it is removed: a record that is half removed would be taken for another damaged one.
    temporary = Path(tempfile.mkdtemp(dir=root / UNFINISHED))
    with contextlib.suppress(FileNotFoundError):  # another process was quicker
        os.replace(root / place, temporary / "record")
    shutil.rmtree(temporary, ignore_errors=True)


def sweep(root: Path) -> None:
    """Remove what killed processes left unfinished a day ago or longer."""
    for left in (root / UNFINISHED).glob("*/"):
        with contextlib.suppress(FileNotFoundError):
            if time.time() - left.stat().st_mtime > ABANDONED:
                shutil.rmtree(left, ignore_errors=True)


def encoded(value: Any) -> Any:
    """A value in JSON's own types; numbers that are not finite as text."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, Mapping):
        return {str(name): encoded(one) for name, one in value.items()}
    return [encoded(one) for one in value] if isinstance(value, (list, tuple)) else value


def decoded(value: Any) -> Any:
    """The value that `encoded` was given, tuples as lists."""
    if isinstance(value, str):
        return _NOT_FINITE.get(value, value)
    if isinstance(value, dict):
        return {name: decoded(one) for name, one in value.items()}
    return [decoded(one) for one in value] if isinstance(value, list) else value


def _json(content: Any) -> bytes:
    return json.dumps(content, indent=2, allow_nan=False).encode()


def _digest(array: np.ndarray) -> str:
    digest = hashlib.sha256(f"{array.dtype.str} {array.shape}".encode())
    digest.update(np.ascontiguousarray(array).data if array.size else b"")
    return digest.hexdigest()


def _digest_of_values(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
