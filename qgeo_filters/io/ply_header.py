"""Header of a PLY file: its elements, what each row of them holds, and its comments."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError
from qgeo_filters.io.text_numbers import plain_text

_TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"long": "i8", "ulong": "u8", "float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2"},
    **{"int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8"},
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class Lists:
    """A property with a list in each row.

    Attributes
    ----------
    values : array, shape (total,)
        The lists, one after the other.
    sizes : (n,) int64
        How long each is.
    """

    values: np.ndarray
    sizes: IndexArray


@dataclass(frozen=True)
class Property:
    """Name and type of a property; ``count`` is the type of a list's length, empty where there is no list."""

    name: str
    type: str
    count: str = ""


@dataclass
class Element:
    """An element: its properties as the header has them, and the columns that were read."""

    name: str
    n_rows: int
    properties: list[Property] = field(default_factory=list)
    columns: dict[str, np.ndarray | Lists] = field(default_factory=dict)


def parsed_header(text: bytes) -> tuple[str, list[Element], list[str]]:
    """Byte order of the data, empty for text, the elements without their columns, and the comments.

    Raises
    ------
    MeshError
        A line that is none of a header.
    """
    order: str | None = None
    elements: list[Element] = []
    comments: list[str] = []
    for number, line in enumerate(_decoded(plain_text(text)).split("\n"), start=1):
        words = line.split()
        match words:
            case [] | ["ply"] | ["obj_info", *_]:
                pass
            case ["comment", *_]:
                comments.append(line.strip()[len("comment ") :])
            case ["format", kind, *_] if kind in _ORDERS:
                order = _ORDERS[kind]
            case ["element", name, count] if re.fullmatch(r"\d{1,18}", count, re.ASCII):
                if any(name == element.name for element in elements):
                    raise MeshError(f"line {number} announces the element {name!r} a second time")
                elements.append(Element(name, int(count)))
            case ["property", *rest] if elements:
                elements[-1].properties.append(_property(rest, number, elements[-1]))
            case _:
                raise MeshError(f"line {number} of the PLY header is not understood: {line.strip()[:80]!r}")
    if order is None:
        raise MeshError("the PLY header does not say which format the data has")
    return order, elements, comments


def _decoded(text: bytes) -> str:
    """UTF-8, or else Latin-1, in which every text is one: comments and names carry no geometry."""
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("latin-1")


def _property(words: list[str], number: int, element: Element) -> Property:
    match words:
        case ["list", count, kind, name] if kind in _TYPES and _TYPES.get(count, "f")[0] in "iu":
            found = Property(name, _TYPES[kind], _TYPES[count])
        case [kind, name] if kind in _TYPES:
            found = Property(name, _TYPES[kind])
        case _:
            raise MeshError(f"line {number} of the PLY header is no property: {' '.join(words)[:80]!r}")
    if any(name == known.name for known in element.properties):
        raise MeshError(f"line {number} gives the element {element.name!r} the property {name!r} a second time")
    return found
