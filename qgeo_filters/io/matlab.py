"""Variables of a MATLAB file of versions 4 to 7, every size in it held against the bytes that are there.

SciPy's reader trusts what a file says of itself: a damaged one ends the interpreter (SIGSEGV, SIGBUS), keeps it busy
for ever or asks for gigabytes. SciPy writes; what is read here are arrays of numbers, structs and cells. Text, sparse
matrices, objects and functions are stepped over.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np

from qgeo_filters.errors import MeshError, reason
from qgeo_filters.io.inflation import most_inflated

Value: TypeAlias = "np.ndarray | dict[str, Value] | list[Value] | None"
"""Numbers, a struct, a struct array or cell (its elements in MATLAB's order), or what is stepped over."""

_HEADER = 128
_CELL, _STRUCT, _DOUBLE, _UINT64, _OPAQUE = 1, 2, 6, 15, 17  # classes; those of numbers run from double to uint64
_MATRIX, _COMPRESSED = 14, 15  # types of elements
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_VERSION_4_NUMBERS = ("f8", "f4", "i4", "i2", "u2", "u1")
_COMPLEX = 0x800
_DEEPEST = 32  # structs in structs

_Element = tuple[int, memoryview]


def variables(content: bytes) -> dict[str, Value]:
    """Variables by name, in the order of the file.

    Raises
    ------
    MeshError
        For a file that is damaged, no MATLAB file, or one of version 7.3.
    """
    if content[:4] == b"\x89HDF" or content[124:128] in (b"\x00\x02IM", b"\x02\x00MI"):
        raise MeshError("MATLAB 7.3 files are not read, they are HDF5; save with -v7")
    view = memoryview(content)
    if content[124:128] in (b"\x00\x01IM", b"\x01\x00MI"):
        return _version_5(view, "<" if content[126:127] == b"I" else ">")
    if len(content) >= 20 and 0 in content[:4]:
        return _version_4(view)
    raise _damaged("no header of one" if content else "it is empty")


def _damaged(why: str) -> MeshError:
    return MeshError(f"not a readable MATLAB file ({why})")


# -- versions 5 to 7 ----------------------------------------------------------------------------------


def _version_5(view: memoryview, order: str) -> dict[str, Value]:
    left = most_inflated(len(view))
    found = {}
    for kind, data in _elements(view[_HEADER:], order):
        if kind == _COMPRESSED:
            data = _inflated(data, left)
            left -= len(data)
            kind, data = next(_elements(data, order), (0, data))
        if kind != _MATRIX:
            raise _damaged(f"a variable of type {kind}")
        name, value = _matrix(data, order)
        found[name] = value
    return found


def _inflated(data: memoryview, limit: int) -> memoryview:
    try:
        content = zlib.decompressobj().decompress(data, limit + 1)
    except zlib.error as error:
        raise _damaged(reason(error)) from error
    if len(content) > limit:
        raise _damaged("it unpacks to more than a hundred times its size")
    return memoryview(content)


def _elements(data: memoryview, order: str) -> Iterator[_Element]:
    """Type and bytes of each element that lies one behind the other."""
    place = 0
    while place < len(data):
        if len(data) - place < 8:
            if any(data[place:]):
                raise _damaged(f"{len(data) - place} bytes too many at an end")
            return
        kind, size = np.frombuffer(data, f"{order}u4", 2, place).tolist()
        start = place + 8
        if kind >> 16:  # at most four bytes, in the tag itself
            kind, size, start = kind & 0xFFFF, kind >> 16, place + 4
            if size > 4:
                raise _damaged(f"a short element of {size} bytes")
        if size > len(data) - start:
            raise _damaged(f"{size} bytes announced, {len(data) - start} there")
        yield kind, data[start : start + size]
        place = start + size
        if kind != _COMPRESSED:
            place += -place % 8


def _matrix(data: memoryview, order: str, depth: int = 0) -> tuple[str, Value]:
    """Name and value of a variable, field or cell."""
    if not len(data):
        return "", np.zeros((0, 0))
    if depth > _DEEPEST:
        raise _damaged(f"structs more than {_DEEPEST} deep")
    parts = _elements(data, order)
    flags = _numbers(_next(parts), order)
    kind = int(flags[0]) & 0xFF if flags.size else 0
    if kind not in (_CELL, _STRUCT) and not _DOUBLE <= kind <= _UINT64:
        rest = [part for _, part in parts]  # dimensions, unless it is opaque, and the name
        return _text(b"".join(rest[:1] if kind == _OPAQUE else rest[1:2])), None
    dimensions = _numbers(_next(parts), order)
    if dimensions.dtype.kind not in "iu" or dimensions.size < 2 or dimensions.min() < 0:
        raise _damaged(f"an array with the dimensions {dimensions[:5].tolist()}")
    shape, name = dimensions.tolist(), _text(_next(parts)[1])
    if kind == _CELL:
        return name, [_child(parts, order, depth) for _ in range(math.prod(shape))]
    if kind == _STRUCT:
        fields = _field_names(parts, order)
        elements: list[Value] = [
            {field: _child(parts, order, depth) for field in fields} for _ in range(math.prod(shape) if fields else 0)
        ]
        return name, elements[0] if len(elements) == 1 else elements
    values = _numbers(_next(parts), order)
    if int(flags[0]) & _COMPLEX:
        values = _complex(values, _same_size(_numbers(_next(parts), order), values.size))
    return name, _shaped(values, shape)


def _child(parts: Iterator[_Element], order: str, depth: int) -> Value:
    kind, data = _next(parts)
    if kind != _MATRIX:
        raise _damaged(f"a field or cell of type {kind}")
    return _matrix(data, order, depth + 1)[1]


def _field_names(parts: Iterator[_Element], order: str) -> list[str]:
    length, names = _numbers(_next(parts), order), bytes(_next(parts)[1])
    width = int(length[0]) if length.size else 0
    if width < 1 or len(names) % width:
        raise _damaged(f"{len(names)} bytes of field names, each of {width}")
    return [_text(names[start : start + width]) for start in range(0, len(names), width)]


def _next(parts: Iterator[_Element]) -> _Element:
    try:
        return next(parts)
    except StopIteration:
        raise _damaged("it ends within a variable") from None


def _numbers(element: _Element, order: str) -> np.ndarray:
    kind, data = element
    if kind not in _NUMBERS:
        raise _damaged(f"numbers of type {kind}")
    dtype = np.dtype(order + _NUMBERS[kind])
    if len(data) % dtype.itemsize:
        raise _damaged(f"{len(data)} bytes of numbers of {dtype.itemsize} bytes each")
    return np.frombuffer(data, dtype)


# -- version 4 ----------------------------------------------------------------------------------------


def _version_4(view: memoryview) -> dict[str, Value]:
    found: dict[str, Value] = {}
    place = 0
    while place < len(view):
        if len(view) - place < 20:
            raise _damaged("it ends within a header")
        order = "<" if int(np.frombuffer(view, "<u4", 1, place)[0]) < 5000 else ">"
        code, rows, columns, is_complex, length = np.frombuffer(view, f"{order}u4", 5, place).tolist()
        order_code, precision, kind = code // 1000, code // 10 % 10, code % 10
        if order_code > 1 or code // 100 % 10 or precision >= len(_VERSION_4_NUMBERS) or kind > 2 or is_complex > 1:
            raise _damaged(f"a variable of type {code}")
        dtype = np.dtype(order + _VERSION_4_NUMBERS[precision])
        start = place + 20 + length
        size = rows * columns * (1 + is_complex)
        place = start + size * dtype.itemsize
        if place > len(view):
            raise _damaged(f"a variable of {rows} x {columns} numbers announced, {len(view)} bytes there")
        name = _text(view[start - length : start])
        values = np.frombuffer(view, dtype, size, start)
        if is_complex:
            values = _complex(values[: size // 2], values[size // 2 :])
        found[name] = _shaped(values, [rows, columns]) if kind == 0 else None
    return found


# -- both ---------------------------------------------------------------------------------------------


def _text(data: memoryview | bytes) -> str:
    return bytes(data).split(b"\0")[0].decode("latin-1")


def _complex(real: np.ndarray, imaginary: np.ndarray) -> np.ndarray:
    values = np.empty(real.size, complex)
    values.real, values.imag = real, imaginary
    return values


def _same_size(values: np.ndarray, size: int) -> np.ndarray:
    if values.size != size:
        raise _damaged(f"{values.size} numbers, where {size} are announced")
    return values


def _shaped(values: np.ndarray, shape: Sequence[int]) -> np.ndarray:
    _same_size(values, math.prod(shape))
    if not values.size or len(shape) > 32:  # NumPy holds no more dimensions, nor products that overflow beside a zero
        shape = (values.size, 1)
    return values.reshape(shape, order="F")
