"""Attributes as columns of a PLY file and back, each bit of them.

An attribute is one vertex property per column, so that any reader finds it, and one comment line that says how to
put it together again::

    comment qgeo_attribute {"name": "qgeo eig", "dtype": "<f8", "shape": [20], "first": "attribute_0_0", "count": 20}

Colours in floating point, which no other program shows, stand beside that as bytes: ``"bytes": ["red", ...]``.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from qgeo_filters.errors import MeshError
from qgeo_filters.io.vertex_colors import as_bytes, is_shade

_MARK = "qgeo_attribute "
_NATIVE = {"i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"}
_NORMALS, _COLORS = ["nx", "ny", "nz"], ["red", "green", "blue", "alpha"]


@dataclass(frozen=True)
class _Entry:
    """What a comment says of an attribute."""

    name: str
    dtype: np.dtype
    shape: tuple[int, ...]
    first: str | None
    count: int
    bytes: list[str]


def columns_of_attributes(
    attributes: Mapping[str, np.ndarray], columns: Mapping[str, np.ndarray]
) -> tuple[dict[str, np.ndarray], list[str]]:
    """The columns given and behind them those of the attributes, and the comments that tell of these.

    Raises
    ------
    MeshError
        An attribute that holds no numbers.
    """
    columns, comments = dict(columns), []
    for position, (name, values) in enumerate(attributes.items()):
        table = _stored(name, values)
        properties = _property_names(name, values, table.shape[1], position, set(columns))
        columns.update(zip(properties, table.T, strict=True))
        entry: dict[str, Any] = {
            "name": name,
            "dtype": values.dtype.str,
            "shape": values.shape[1:],
            "first": properties[0] if properties else None,
            "count": len(properties),
        }
        shown = _COLORS[: table.shape[1]]
        if name == "colors" and is_shade(values) and not set(columns) & set(shown):
            columns.update(zip(shown, as_bytes(values).T, strict=True))
            entry["bytes"] = shown
        comments.append(_MARK + json.dumps(entry))
    return columns, comments


def attributes_of_columns(
    columns: Mapping[str, np.ndarray], comments: list[str], n_vertices: int
) -> dict[str, np.ndarray]:
    """Attributes that the comments tell of; of the other columns normals and colours, each rest by itself."""
    attributes: dict[str, np.ndarray] = {}
    order = list(columns)
    used: set[str] = set()
    for comment in comments:
        entry = _entry(comment)
        if entry is None:
            continue
        start = order.index(entry.first) if entry.first in order else 0
        properties = order[start : start + entry.count]
        parts = [columns[p] for p in properties]
        table = np.column_stack(parts) if parts else np.empty((n_vertices, 0))
        if table.shape[1] != entry.count or (parts and properties[0] != entry.first) or not _fits(entry, table.dtype):
            continue  # another program has rewritten the file
        values = _restored(table, entry.dtype, entry.shape)
        used.update(properties)
        if entry.bytes and set(entry.bytes) <= set(columns):
            shown = np.column_stack([columns[p] for p in entry.bytes])
            if not np.array_equal(shown, as_bytes(values)):
                continue  # another program has painted it: its colours are the newer ones
            used.update(entry.bytes)
        attributes[entry.name] = values
    return {**attributes, **_foreign({name: values for name, values in columns.items() if name not in used})}


def _stored(name: str, values: np.ndarray) -> np.ndarray:
    """Values as a table (n, columns) of a type that PLY has, from which every bit can be had back."""
    kind, size = values.dtype.kind, values.dtype.itemsize
    flat = values.reshape(len(values), int(np.prod(values.shape[1:])))
    flat = np.ascontiguousarray(flat, dtype=values.dtype.newbyteorder("<"))
    if f"{kind}{size}" in _NATIVE:
        return flat
    if kind == "b":
        return flat.astype("u1")
    if kind == "f" and size == 2:
        return flat.astype("<f4")
    if kind in "iu" and size == 8:
        narrow = flat.astype(f"<{kind}4")
        return narrow if np.array_equal(narrow, flat) else flat.view("<u4")
    if kind == "c" and size in (8, 16):
        return flat.view(f"<f{size // 2}")
    raise MeshError(f"attribute {name!r} of dtype {values.dtype} cannot be held by a PLY file")


def _restored(table: np.ndarray, dtype: np.dtype, shape: tuple[int, ...]) -> np.ndarray:
    """Inverse of `_stored`."""
    little = dtype.newbyteorder("<")
    one_each = table.shape[1] == math.prod(shape)  # else one value in several columns
    values = table.astype(little) if one_each else np.ascontiguousarray(table).view(little)
    return values.reshape(len(table), *shape).astype(dtype)


def _property_names(name: str, values: np.ndarray, count: int, position: int, taken: set[str]) -> list[str]:
    """Names of the columns: what other programs expect where there is such, else the attribute's own."""
    usual: list[str] = []
    if name == "normals" and values.dtype.kind == "f" and values.shape[1:] == (3,):
        usual = _NORMALS
    elif name == "colors" and values.dtype == np.uint8 and values.shape[1:] in ((3,), (4,)):
        usual = _COLORS[:count]
    if usual and not taken & set(usual):
        return usual
    base = name if re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII) else f"attribute_{position}"
    while True:
        names = [base] if values.ndim == 1 and count == 1 else [f"{base}_{j}" for j in range(count)]
        if not taken & set(names):
            return names
        base = f"{base}_{position}"


def _entry(comment: str) -> _Entry | None:
    """What a comment says, if it is one of ours and has not been changed."""
    if not comment.startswith(_MARK):
        return None
    try:
        match json.loads(comment[len(_MARK) :]):
            case {
                "name": str(name),
                "dtype": str(code),
                "shape": list(shape),
                "first": first,
                "count": int(count),
            } as all_:
                good = re.fullmatch(r"[<>=|]?[biufc]\d{1,2}", code) and all(type(w) is int and w >= 0 for w in shape)
                if good and len(shape) <= 32 and isinstance(first, str | None) and count >= 0:
                    shown = [part for part in all_.get("bytes", []) if part in _COLORS]
                    return _Entry(name, np.dtype(code), tuple(shape), first, count, shown)
    except (ValueError, TypeError, RecursionError):
        pass
    return None


def _fits(entry: _Entry, stored: np.dtype) -> bool:
    """Whether the columns can be what `_stored` made of such an attribute."""
    width, kind, size = math.prod(entry.shape), entry.dtype.kind, entry.dtype.itemsize
    if entry.count == width and (kind != "c" or not width):
        return True
    parts = 8 if kind == "c" and size == 16 else 4
    halves = kind == "c" or (kind in "iu" and size == 8)
    return halves and entry.count == 2 * width and stored.itemsize == parts


def _foreign(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Attributes of another program's file, normals and colours put together."""
    attributes: dict[str, np.ndarray] = {}
    for name, parts in (("normals", _NORMALS), ("colors", _COLORS[:3])):
        if name not in columns and all(part in columns and columns[part].ndim == 1 for part in parts):
            if name == "colors" and "alpha" in columns and columns["alpha"].ndim == 1:
                parts = _COLORS
            attributes[name] = np.column_stack([columns.pop(part) for part in parts])
    return {**attributes, **columns}
