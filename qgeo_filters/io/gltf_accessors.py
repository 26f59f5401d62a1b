"""Numbers of a glTF file: accessors of every layout, and Draco's primitives.

Read here because none of the libraries at hand reads them all: trimesh takes sparse and normalised accessors for plain
ones, VTK knows no sparse ones, and Open3D's assimp no normalised positions.
"""

from __future__ import annotations

import reprlib
from typing import Any

import numpy as np

from qgeo_filters.errors import MeshError, reason, require_package
from qgeo_filters.io.gltf_document import Document, extensions, mapping, whole

DRACO = "KHR_draco_mesh_compression"
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def accessor_values(document: Document, index: Any, who: str) -> np.ndarray:
    """Values of an accessor, shape (count, width): sparse ones put in, normalised integers divided.

    Raises
    ------
    MeshError
        Where it does not lie within the bytes that are there.
    """
    entry, name = document.element("accessors", index, who), f"accessors[{index}]"
    dtype, width, count = _layout(entry, name)
    if "bufferView" in entry:
        start = whole(entry, "byteOffset", name, 0)
        values = _viewed(document, entry["bufferView"], start, (count, width), dtype, name)
    elif "sparse" in entry:
        most = sum(map(len, (document.binary, *document.buffers.values()))) + 1_000_000
        if count > most:  # zeros take no bytes of the file
            raise MeshError(f"{name} has {count} values, all but a few of them zeros that are not in the file")
        values = np.zeros((count, width), dtype)
    else:
        raise MeshError(f"{name} has no data (neither bufferView nor sparse)")
    if "sparse" in entry:
        values = _with_sparse(document, mapping(entry["sparse"], f"sparse of {name}"), values, name)
    return _scaled(values, entry)


def is_draco(document: Document, primitive: dict[str, Any], who: str) -> bool:
    """Whether a primitive is compressed by Draco, and not stored uncompressed beside that."""
    if DRACO not in extensions(primitive, who):
        return False
    stored = [mapping(primitive["attributes"], who)["POSITION"], primitive.get("indices")]
    elements = [document.element("accessors", index, who) for index in stored if index is not None]
    return not all("bufferView" in element for element in elements)


def draco_primitive(
    document: Document, primitive: dict[str, Any], who: str
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Attributes, each of shape (n, width), and triangles (m, 3) of a primitive that Draco has compressed."""
    package = require_package("DracoPy", "files", f"reading {document.path.name}, compressed by {DRACO},")
    entry = mapping(extensions(primitive, who)[DRACO], f"{DRACO} of {who}")
    data, _ = document.view(entry.get("bufferView"), who)
    try:
        decoded = package.decode(data)
        faces = np.asarray(decoded.faces, dtype=np.int64).reshape(-1, 3)
        stored = {one["unique_id"]: np.asarray(one["data"]) for one in decoded.attributes}
        attributes = {name: stored[number] for name, number in entry["attributes"].items()}
        count = len(attributes["POSITION"])
        attributes = {name: values.reshape(count, -1) for name, values in attributes.items()}
    except Exception as error:  # of the package's own, which have no root in common
        raise MeshError(f"{who} holds Draco data ({DRACO}) that cannot be decoded ({reason(error)})") from error
    accessors = {
        name: document.element("accessors", index, who)
        for name, index in primitive["attributes"].items()
        if name in attributes
    }
    announced = whole(accessors["POSITION"], "count", who)
    if count != announced:
        raise MeshError(f"{who} announces {announced} vertices, but Draco decodes {count}")
    return {name: _scaled(attributes[name], accessor) for name, accessor in accessors.items()}, faces


def _layout(entry: dict[str, Any], name: str) -> tuple[np.dtype, int, int]:
    code, kind = entry.get("componentType"), entry.get("type")
    if not isinstance(code, int) or code not in _COMPONENTS or not isinstance(kind, str) or kind not in _WIDTHS:
        raise MeshError(f"{name} is of {reprlib.repr(kind)} and component type {reprlib.repr(code)}, which is not read")
    return np.dtype(_COMPONENTS[code]), _WIDTHS[kind], whole(entry, "count", name)


def _viewed(
    document: Document, view: Any, start: int, shape: tuple[int, int], dtype: np.dtype, name: str
) -> np.ndarray:
    """Copy of an array inside a buffer view, its rows as far apart as the view says."""
    data, stride = document.view(view, name)
    item = dtype.itemsize * shape[1]
    stride = stride or item
    end = start + (shape[0] - 1) * stride + item if shape[0] else start
    if stride < item:
        raise MeshError(f"bufferViews[{view}] has a stride of {stride} bytes, less than the {item} of {name}")
    if end > len(data):
        raise MeshError(
            f"{name} with {shape[0]} values ends at byte {end} of bufferViews[{view}], which has {len(data)}"
        )
    return np.ndarray(shape, dtype, data, start if shape[0] else 0, (stride, dtype.itemsize)).copy()


def _with_sparse(document: Document, sparse: dict[str, Any], values: np.ndarray, name: str) -> np.ndarray:
    """The values with those put in that a sparse accessor stores apart."""
    name = f"sparse of {name}"
    count = whole(sparse, "count", name)
    where, what = (mapping(sparse.get(key), f"{key} of {name}") for key in ("indices", "values"))
    dtype, _, _ = _layout({**where, "type": "SCALAR", "count": count}, f"indices of {name}")
    at = _viewed(document, where.get("bufferView"), whole(where, "byteOffset", name, 0), (count, 1), dtype, name)
    shape = (count, values.shape[1])
    new = _viewed(document, what.get("bufferView"), whole(what, "byteOffset", name, 0), shape, values.dtype, name)
    if dtype.kind != "u" or (at >= len(values)).any():
        raise MeshError(f"{name} refers to value {at.max()}, but there are {len(values)}, numbered from 0")
    values[at.ravel()] = new
    return values


def _scaled(values: np.ndarray, accessor: dict[str, Any]) -> np.ndarray:
    """Normalised integers as numbers from -1 or 0 to 1, others as they are."""
    if accessor.get("normalized") is not True or values.dtype.kind not in "iu":
        return values
    return np.maximum(values / np.float64(np.iinfo(values.dtype).max), -1.0)
