"""PLY: every named attribute, whatever its width, type and name, and whatever other programs write.

Our own files are binary. An attribute is one vertex property per column, so that any reader finds it, and one
comment line that says how to put it together again::

    comment qgeo_attribute {"name": "qgeo eig", "dtype": "<f8", "shape": [20], "first": "attribute_0_0", "count": 20}
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import plyfile

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError
from qgeo_filters.io.damage import DAMAGED_FILE
from qgeo_filters.io.polygons import Polygons, triangulated
from qgeo_filters.io.raw_mesh import RawMesh

_MARK = "qgeo_attribute "
_NATIVE = {"i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"}
_CORNER_NAMES = ("vertex_indices", "vertex_index")
_USUAL = {"normals": ["nx", "ny", "nz"], "colors": ["red", "green", "blue"]}


def read(path: Path, repair: bool) -> RawMesh:
    """Arrays of a PLY file; every vertex property apart from the position is an attribute.

    In files of other programs nx, ny, nz are ``normals`` (n, 3) and red, green, blue (alpha) are ``colors``.
    """
    ply = _parsed(path)
    elements = {element.name: element for element in ply.elements}
    if "vertex" not in elements:
        raise MeshError(f"the PLY file has no vertices, only {', '.join(elements) or 'nothing'}")
    vertex = elements["vertex"].data
    names = list(vertex.dtype.names)
    if not {"x", "y", "z"} <= set(names):
        raise MeshError(f"the vertices have no x, y, z, only {', '.join(names)}")
    positions = np.column_stack([vertex[axis] for axis in "xyz"])
    faces, notes = triangulated(positions, Polygons.of_rows(_polygons(elements)), repair)
    columns = {name: vertex[name] for name in names if name not in ("x", "y", "z")}
    return RawMesh(positions, faces, _attributes(columns, ply.comments, len(vertex)), notes)


def write(path: Path, vertices: FloatArray, faces: IntArray, attributes: Mapping[str, np.ndarray]) -> None:
    """Write as binary PLY with every attribute.

    Raises
    ------
    MeshError
        An attribute that holds no numbers.
    """
    columns = dict(zip("xyz", vertices.T.astype("<f8"), strict=True))
    comments = []
    for position, (name, values) in enumerate(attributes.items()):
        table = _stored(name, values)
        properties = _property_names(name, values, table.shape[1], position, set(columns))
        columns.update(zip(properties, table.T, strict=True))
        entry = {
            "name": name,
            "dtype": values.dtype.str,
            "shape": values.shape[1:],
            "first": properties[0] if properties else None,
            "count": len(properties),
        }
        comments.append(_MARK + json.dumps(entry))
    vertex = np.empty(len(vertices), [(name, values.dtype) for name, values in columns.items()])
    for name, values in columns.items():
        vertex[name] = values
    face = np.empty(len(faces), [("count", "u1"), ("corners", "<i4", (3,))])
    face["count"], face["corners"] = 3, faces
    template = [
        plyfile.PlyElement.describe(vertex, "vertex"),
        plyfile.PlyElement.describe(np.empty(0, [(_CORNER_NAMES[0], "<i4", (3,))]), "face"),
    ]
    header: str = plyfile.PlyData(template, byte_order="<", comments=comments).header
    header = header.replace("element face 0", f"element face {len(faces)}")
    with atomic_write(path) as file:  # plyfile writes lists row by row, 200 times slower
        file.write(header.encode("ascii") + b"\n" + vertex.tobytes() + face.tobytes())


def _parsed(path: Path) -> plyfile.PlyData:
    try:
        try:  # triangles only is the usual case, and 300 times faster when said in advance
            return plyfile.PlyData.read(path, known_list_len={"face": dict.fromkeys(_corner_name(path), 3)})
        except plyfile.PlyElementParseError:
            return plyfile.PlyData.read(path)
    except (plyfile.PlyParseError, *DAMAGED_FILE) as error:
        raise MeshError(f"not a readable PLY file ({error})") from error


def _corner_name(path: Path) -> list[str]:
    """The name of the corner list in the header, if there is one."""
    with path.open("rb") as file:
        for line in file:
            words = line.split()
            if words[:2] == [b"property", b"list"] and words[-1].decode("ascii", "replace") in _CORNER_NAMES:
                return [words[-1].decode("ascii")]
            if words[:1] == [b"end_header"]:
                break
    return []


def _polygons(elements: Mapping[str, Any]) -> Any:
    if "tristrips" in elements:
        raise MeshError("the PLY file has triangle strips; write it as triangles")
    if "face" not in elements:
        return np.empty((0, 3), dtype=np.int64)
    data = elements["face"].data
    for name in _CORNER_NAMES:
        if name in data.dtype.names:
            return data[name]
    raise MeshError(f"the faces have no vertex_indices, only {', '.join(data.dtype.names)}")


# -- attributes as columns ----------------------------------------------------------------------------


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
    width = int(np.prod(shape))
    one_each = table.shape[1] == width  # else one value in several columns
    values = table.astype(little) if one_each else np.ascontiguousarray(table).view(little)
    return values.reshape(len(table), *shape).astype(dtype)


def _property_names(name: str, values: np.ndarray, count: int, position: int, taken: set[str]) -> list[str]:
    """Names of the columns: what other programs expect where there is such, else the attribute's own."""
    is_usual = {"normals": values.dtype.kind == "f", "colors": values.dtype == np.uint8}
    if is_usual.get(name) and values.shape[1:] == (3,) and not taken & set(_USUAL[name]):
        return _USUAL[name]
    base = name if re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII) else f"attribute_{position}"
    while True:
        names = [base] if values.ndim == 1 and count == 1 else [f"{base}_{j}" for j in range(count)]
        if not taken & set(names):
            return names
        base = f"{base}_{position}"


def _attributes(columns: dict[str, np.ndarray], comments: list[str], n_vertices: int) -> dict[str, np.ndarray]:
    attributes: dict[str, np.ndarray] = {}
    order = list(columns)
    used: set[str] = set()
    for comment in comments:
        entry = _entry(comment)
        if entry is None:
            continue
        name, dtype, shape, first, count = entry
        start = order.index(first) if first in order else 0
        properties = order[start : start + count]
        if count and (first not in order or len(properties) < count):
            continue  # another program has rewritten the file
        table = np.column_stack([columns[p] for p in properties]) if count else np.empty((n_vertices, 0))
        attributes[name] = _restored(table, dtype, shape)
        used.update(properties)
    rest = {name: values for name, values in columns.items() if name not in used}
    return {**attributes, **_foreign(rest)}


def _entry(comment: str) -> tuple[str, np.dtype, tuple[int, ...], str | None, int] | None:
    if not comment.startswith(_MARK):
        return None
    try:
        entry = json.loads(comment[len(_MARK) :])
        return entry["name"], np.dtype(entry["dtype"]), tuple(entry["shape"]), entry["first"], int(entry["count"])
    except (ValueError, KeyError, TypeError):
        return None


def _foreign(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Attributes of another program's file, normals and colours put together."""
    attributes: dict[str, np.ndarray] = {}
    for name, parts in _USUAL.items():
        if name not in columns and set(parts) <= set(columns):
            alpha = ["alpha"] if name == "colors" and "alpha" in columns else []
            attributes[name] = np.column_stack([columns.pop(part) for part in parts + alpha])
    for name, values in columns.items():
        if values.dtype == object:  # lists
            if len({len(row) for row in values}) != 1:
                raise MeshError(f"the vertex property {name!r} is a list of different lengths")
            values = np.stack(list(values))
        attributes[name] = values
    return attributes
