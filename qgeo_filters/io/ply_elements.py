"""Data of a PLY file: named columns of numbers and of lists, whatever the header claims to be there.

plyfile refuses comments that are not ASCII, byte-order marks and data that is not one item a line, allocates what a
header announces before it looks whether that is there, and takes mixed polygons item by item; trimesh, meshio and
Open3D drop properties that they do not know. So reading is here, and plyfile writes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError
from qgeo_filters.io.ply_header import Element, Lists, Property, parsed_header
from qgeo_filters.io.text_numbers import Numbers, numbers_of, plain_text, whole

_HEADER_END = re.compile(rb"(?:^|(?<=[\r\n]))[ \t]*end_header[ \t]*(\r\n|\r|\n|$)")
_NAMES = {
    "i1": "char",
    "u1": "uchar",
    "i2": "short",
    "u2": "ushort",
    "i4": "int",
    "u4": "uint",
    "i8": "long",
    "u8": "ulong",
}


@dataclass(frozen=True)
class PlyFile:
    """Elements by name in the file's order, and the comments of its header."""

    elements: dict[str, Element]
    comments: list[str]


def read_elements(path: Path) -> PlyFile:
    """All elements of a PLY file, ascii or binary.

    Raises
    ------
    MeshError
        Where it is none, or announces what is not there.
    """
    content = path.read_bytes().removeprefix(b"\xef\xbb\xbf")
    end = _HEADER_END.search(content)
    if not content.startswith(b"ply") or end is None:
        raise MeshError(
            f"not a PLY file: it {'has no end_header' if content.startswith(b'ply') else 'begins with no ply'}"
        )
    order, elements, comments = parsed_header(content[: end.start()])
    if order:
        # What follows a lone carriage return is data, even where it looks like a line feed.
        carriage_returns = re.match(rb"ply[ \t]*\r(?!\n)", content) is not None
        data, start = _Bytes(content, order), end.start(1) + 1 if carriage_returns else end.end()
        for element in elements:
            _, start = _filled(element, data, start)
    else:
        _fill_from_text(elements, plain_text(content[end.end() :]))
    return PlyFile({element.name: element for element in elements}, comments)


def _fill_from_text(elements: list[Element], text: bytes) -> None:
    """Read the columns of all elements from words, wherever the lines break."""
    numbers = numbers_of(text)
    data, start, rows = _Words(numbers), 0, []
    try:
        for element in elements:
            begins, start = _filled(element, data, start)
            rows.append(begins)
    except MeshError:
        numbers.require_all()  # what the next word is says more than that numbers are missing
        raise
    starts = np.concatenate(rows) if rows else np.empty(0, np.int64)
    if start < data.size and not np.array_equal(numbers.starts[: len(starts) + 1], np.append(starts, start)):
        # Lines behind the data are nobody's; numbers too many within it have moved all that follow.
        raise MeshError(f"the data has {data.size} numbers, {data.size - start} more than the header announces")


class _Bytes:
    """Binary data, counted in bytes."""

    unit = "bytes"

    def __init__(self, content: bytes, order: str) -> None:
        self._content = content
        self._codes = np.frombuffer(content, np.uint8)
        self._order = order
        self.size = len(content)

    def width(self, kind: str) -> int:
        return np.dtype(kind).itemsize

    def number(self, place: int, kind: str) -> int:
        """A whole number."""
        order: Literal["little", "big"] = "little" if self._order == "<" else "big"
        return int.from_bytes(self._content[place : place + self.width(kind)], order, signed=kind[0] == "i")

    def table(self, start: int, kind: str, shape: tuple[int, int], stride: int) -> np.ndarray:
        """Values that stand side by side at regular places, shape (rows, values)."""
        dtype = np.dtype(self._order + kind)
        found: np.ndarray = np.ndarray(shape, dtype, self._codes.data, start, (stride, dtype.itemsize))
        return found.astype(kind)

    def gathered(self, places: IndexArray, kind: str) -> np.ndarray:
        """Values at any places."""
        dtype = np.dtype(self._order + kind)
        found: np.ndarray = self._codes[places[:, None] + np.arange(dtype.itemsize)].view(dtype).ravel()
        return found.astype(kind)


class _Words:
    """Numbers of a text, counted in words."""

    unit = "numbers"

    def __init__(self, numbers: Numbers) -> None:
        self._values = numbers.values
        self.size = len(numbers.values)

    def width(self, kind: str) -> int:
        return 1

    def number(self, place: int, kind: str) -> int:
        """A whole number."""
        value = self._values.item(place)
        if not value.is_integer():
            raise MeshError(f"{value:g} stands where the header announces the length of a list")
        return int(value)

    def table(self, start: int, kind: str, shape: tuple[int, int], stride: int) -> np.ndarray:
        """Values that stand side by side at regular places, shape (rows, values)."""
        step = self._values.itemsize
        return self._typed(np.ndarray(shape, np.float64, self._values.data, start * step, (stride * step, step)), kind)

    def gathered(self, places: IndexArray, kind: str) -> np.ndarray:
        """Values at any places."""
        return self._typed(self._values[places], kind)

    def _typed(self, values: np.ndarray, kind: str) -> np.ndarray:
        if kind[0] in "iu":
            limits = np.iinfo(kind)
            bad = ~(whole(values) & (values >= limits.min) & (values <= limits.max))
            if bad.any():
                raise MeshError(f"{values[bad][0]:g} stands where the header announces {_NAMES[kind]}")
        with np.errstate(over="ignore"):  # infinite is found where positions are checked
            return values.astype(kind)


def _filled(element: Element, data: _Bytes | _Words, start: int) -> tuple[IndexArray, int]:
    """Read the columns of an element; where its rows start, and where the next element does."""
    n, properties = element.n_rows, element.properties
    least = sum(data.width(p.count or p.type) for p in properties)
    if n * least > data.size - start:
        raise MeshError(
            f"{n} rows of {element.name!r} announced, which take {n * least} {data.unit} or more, but "
            f"{max(data.size - start, 0)} are left"
        )
    if n == 0 or not properties:
        for p in properties:
            empty = np.empty(0, p.type)
            element.columns[p.name] = Lists(empty, np.empty(0, np.int64)) if p.count else empty
        return np.empty(0, np.int64), start
    return _regular_rows(element, data, start) or _any_rows(element, data, start)


def _regular_rows(element: Element, data: _Bytes | _Words, start: int) -> tuple[IndexArray, int] | None:
    """`_filled` where every list of a column is as long as its first, as in meshes of triangles; else None."""
    n, end, places = element.n_rows, start, []
    for p in element.properties:
        length = 1
        if p.count:
            length = _length(element, data, p, end, 0)
            end += data.width(p.count)
        places.append((p, end - start, length))
        end += length * data.width(p.type)
    stride = end - start
    if n * stride > data.size - start:
        return None
    for p, offset, length in places:
        if p.count:
            lengths = data.table(start + offset - data.width(p.count), p.count, (n, 1), stride)
            if (lengths != length).any():
                return None
    for p, offset, length in places:
        table = data.table(start + offset, p.type, (n, length), stride)
        element.columns[p.name] = Lists(table.ravel(), np.full(n, length)) if p.count else table[:, 0]
    return start + stride * np.arange(n), start + n * stride


def _any_rows(element: Element, data: _Bytes | _Words, start: int) -> tuple[IndexArray, int]:
    """`_filled` row by row."""
    places: dict[str, list[int]] = {p.name: [] for p in element.properties}
    sizes: dict[str, list[int]] = {p.name: [] for p in element.properties}
    rows, end = [], start
    for row in range(element.n_rows):
        rows.append(end)
        for p in element.properties:
            length = 1
            if p.count:
                length = _length(element, data, p, end, row)
                end += data.width(p.count)
            places[p.name].append(end)
            sizes[p.name].append(length)
            end += length * data.width(p.type)
        if end > data.size:
            raise MeshError(f"the file ends within row {row} of {element.n_rows} of {element.name!r}")
    for p in element.properties:
        first, lengths = np.array(places[p.name], dtype=np.int64), np.array(sizes[p.name], dtype=np.int64)
        within = np.arange(lengths.sum()) - np.repeat(np.cumsum(lengths) - lengths, lengths)
        values = data.gathered(np.repeat(first, lengths) + within * data.width(p.type), p.type)
        element.columns[p.name] = Lists(values, lengths) if p.count else values
    return np.array(rows, dtype=np.int64), end


def _length(element: Element, data: _Bytes | _Words, p: Property, place: int, row: int) -> int:
    """Length of the list at a place."""
    if place + data.width(p.count) > data.size:
        raise MeshError(f"the file ends within row {row} of {element.n_rows} of {element.name!r}")
    length = data.number(place, p.count)
    if length < 0 or length * data.width(p.type) > data.size - place:
        raise MeshError(
            f"the list {p.name!r} in row {row} of {element.name!r} has a length of {length}, which the file has not"
        )
    return length
