"""Numbers from text tables and from NumPy's .npy and .npz files, read no further than the file goes."""

from __future__ import annotations

import math
import warnings
import zipfile
from pathlib import Path
from typing import IO, BinaryIO

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import MeshError, reason
from qgeo_filters.io.damage import DAMAGED_FILE
from qgeo_filters.io.inflation import most_inflated
from qgeo_filters.io.text_numbers import plain_text

_LARGEST = 2**53  # whole numbers beyond it cannot be told apart in float64
_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
# OSError: not of the disk, but of a place before the file's beginning.
_DAMAGED: tuple[type[Exception], ...] = (zipfile.BadZipFile, OSError, *DAMAGED_FILE)


def number_table(path: Path) -> FloatArray:
    """Table of a text file, one row a line, separated by white space; what follows a ``#`` is passed over.

    Raises
    ------
    MeshError
        For an empty file, rows of different lengths, and what is no number; the message starts with the file's name.
    """
    lines = plain_text(path.read_bytes()).decode("utf-8", errors="replace").split("\n")
    rows = [content for line in lines if (content := line.partition("#")[0].strip())]
    if not rows:
        raise MeshError(f"{path.name} is empty")
    try:
        table: FloatArray = np.loadtxt(rows, dtype=np.float64, ndmin=2, comments=None)
    except ValueError as error:
        raise MeshError(f"{path.name} is no table of numbers ({reason(error)})") from error
    return table


def whole_numbers(values: npt.ArrayLike, what: str) -> npt.NDArray[np.int64]:
    """The values as whole numbers, of any shape, or `MeshError` where one is none."""
    array = np.asarray(values)
    if array.dtype.kind not in "iuf":
        raise MeshError(f"{what} must be whole numbers, got {array.dtype}")
    with np.errstate(invalid="ignore"):
        wide = array.astype(np.float64) if array.dtype.kind == "f" else array
        good = (wide >= -_LARGEST) & (wide <= _LARGEST) & (wide == np.floor(wide))
    bad = np.argwhere(~good)
    if len(bad):
        place = ", ".join(map(str, bad[0].tolist()))
        raise MeshError(f"{what}[{place}] is {array[tuple(bad[0])]}, not a whole number ({len(bad)} such)")
    return array.astype(np.int64)


def saved_arrays(path: Path) -> dict[str, np.ndarray]:
    """Arrays of an .npz file by name; that of an .npy file under the name "".

    Raises
    ------
    MeshError
        For a file that is neither, is damaged, or holds Python objects.
    """
    with path.open("rb") as file:
        beginning = file.read(6)
        file.seek(0)
        if beginning == np.lib.format.MAGIC_PREFIX:
            return {"": _array(file, path.name, path.stat().st_size)}
        if beginning[:4] not in (b"PK\x03\x04", b"PK\x05\x06"):
            raise MeshError(f"{path.name} is neither an .npz nor an .npy file")
        try:
            return _members(file, path)
        except MeshError:
            raise
        except _DAMAGED as error:
            raise MeshError(f"{path.name} is not a readable .npz file ({reason(error)})") from error


def _members(file: BinaryIO, path: Path) -> dict[str, np.ndarray]:
    left = most_inflated(path.stat().st_size)
    found = {}
    with zipfile.ZipFile(file) as archive:
        for entry in archive.infolist():
            if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                raise MeshError(f"{path.name}: {entry.filename} is packed by a method that NumPy does not use")
            name = entry.filename.removesuffix(".npy")
            with archive.open(entry) as member:
                found[name] = _array(member, f"{name} of {path.name}", left)
            left -= found[name].nbytes
    return found


def _array(stream: IO[bytes], name: str, limit: int) -> np.ndarray:
    """Array that begins in a stream, and holds at most so many bytes."""
    try:
        with warnings.catch_warnings():  # Python's of a header that is odd, NumPy's of one by Python 2
            warnings.simplefilter("ignore")
            shape, is_fortran, dtype = _HEADERS[np.lib.format.read_magic(stream)](stream)
    except Exception as error:  # Python's parser reads the header, and raises what it likes
        raise MeshError(f"{name} has no header of an array ({reason(error)})") from error
    if dtype.hasobject:
        raise MeshError(f"{name} holds Python objects, which are not read")
    data = stream.read(limit + 1)
    if len(data) > limit:
        raise MeshError(f"{name} unpacks to more than a hundred times the file's size")
    count = math.prod(shape)
    if min(shape, default=0) < 0 or not dtype.itemsize or count * dtype.itemsize > len(data):
        raise MeshError(f"{name} announces {dtype} numbers of shape {shape}, where {len(data)} bytes follow")
    if not count:  # NumPy holds no shape such as (0, 9999999999999999999)
        return np.zeros(0, dtype)
    return np.frombuffer(data, dtype, count).reshape(shape, order="F" if is_fortran else "C")
