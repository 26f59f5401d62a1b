"""glTF, text or binary: equal positions, which it repeats at seams, become one vertex."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import MeshError
from qgeo_filters.io.gltf_accessors import accessor_values, draco_primitive, is_draco
from qgeo_filters.io.gltf_attributes import joined_attributes, vertex_attributes
from qgeo_filters.io.gltf_document import Document, mapping, opened
from qgeo_filters.io.gltf_scene import PlacedMesh, placed_meshes
from qgeo_filters.io.polygons import strip_triangles
from qgeo_filters.io.raw_mesh import RawMesh, counted, weld

_POINTS_AND_LINES, _TRIANGLES, _STRIP, _FAN = (0, 1, 2, 3), 4, 5, 6
# What a file may require though nothing is done about it: how a surface looks, not where it is. Compression and
# instances are named where they are met.
_HARMLESS = re.compile(
    r"_(materials|techniques|texture|lights|animation|xmp|audio)_"
    r"|_(mesh_quantization|draco_mesh_compression|meshopt_compression|mesh_gpu_instancing)$"
)
_FEW = 4_000_000


@dataclass
class _Parts:
    """Positions with their attributes and triangles gathered so far, and what was passed over."""

    points: list[np.ndarray] = field(default_factory=list)
    attributes: list[dict[str, np.ndarray]] = field(default_factory=list)
    faces: list[np.ndarray] = field(default_factory=list)
    n_points: int = 0
    n_numbers: int = 0
    without: Counter[str] = field(default_factory=Counter)


def read(path: Path, repair: bool) -> RawMesh:
    """Arrays of all triangles of a glTF scene, strips and fans too, placed as the scene places them.

    Colours and attributes of one's own come along where all parts have them. Points and lines are passed over and
    skins and morph targets are left at rest, which the notes say.
    """
    document = opened(path)
    for extension in document.elements("extensionsRequired"):
        if not _HARMLESS.search(str(extension)):
            raise MeshError(f"the file requires the extension {str(extension)[:60]}, which is not read")
    parts = _Parts()
    with np.errstate(all="ignore"):  # what overflows is found as not finite
        for mesh in placed_meshes(document):
            _add(document, mesh, parts, repair)
    notes = tuple(f"{counted(count, 'part')} of the scene with {what}" for what, count in parts.without.items())
    if not parts.faces:
        raise MeshError(f"the scene has no triangles{''.join(f'; {note}' for note in notes)}")
    points, index = weld(np.concatenate(parts.points))
    attributes, dropped = joined_attributes(parts.attributes, index)
    faces = np.append(index, -1)[np.concatenate(parts.faces)]
    return RawMesh(points, faces, attributes, (*notes, *dropped))


def _add(document: Document, mesh: PlacedMesh, parts: _Parts, repair: bool) -> None:
    """Gather the triangles of a mesh; primitives that share their positions go on sharing them."""
    if mesh.pose:
        parts.without[f"a pose of its own ({mesh.pose}), left at rest"] += 1
    primitives = mesh.entry.get("primitives")
    if not isinstance(primitives, list):
        raise MeshError(f"{mesh.name} has no list of primitives")
    mirrored = bool(np.linalg.det(mesh.placement[:3, :3]) < 0)
    known: dict[str, tuple[int, int]] = {}
    for number, entry in enumerate(primitives):
        name = f"primitive {number} of {mesh.name}"
        primitive = mapping(entry, name)
        mode = primitive.get("mode", _TRIANGLES)
        accessors = mapping(primitive.get("attributes"), f"attributes of {name}")
        if mode in _POINTS_AND_LINES or "POSITION" not in accessors:
            what = "no positions" if "POSITION" not in accessors else "points or lines"
            parts.without[f"{what}, passed over"] += 1
            continue
        if is_draco(document, primitive, name):
            values, faces = draco_primitive(document, primitive, name)
            place = _placed(document, values, accessors, mesh.placement, name, parts)
        else:
            key = repr(sorted(accessors.items()))
            if key not in known:
                values = {"POSITION": accessor_values(document, accessors["POSITION"], name)}
                known[key] = _placed(document, values, accessors, mesh.placement, name, parts)
            place = known[key]
            faces = _triangles(_corners(document, primitive, place[1], name), mode, name, repair, parts)
        start, count = place
        _bounded(document, parts, faces.size)
        faces = _in_range(faces, count, name if len(primitives) > 1 else "", repair)
        parts.faces.append(np.where(faces < 0, -1, start + (faces[:, ::-1] if mirrored else faces)))


def _placed(
    document: Document,
    values: dict[str, np.ndarray],
    accessors: dict[str, Any],
    placement: FloatArray,
    name: str,
    parts: _Parts,
) -> tuple[int, int]:
    """Keep positions, at their place in the scene, and their attributes; index of the first, and their number."""
    points = values["POSITION"]
    if points.shape[1] != 3:
        raise MeshError(f"the positions of {name} have {points.shape[1]} coordinates, expected 3")
    _bounded(document, parts, points.size)
    attributes, unread = vertex_attributes(document, accessors, values, len(points), name)
    for attribute in unread:
        parts.without[f"an attribute {attribute!r} that cannot be read, passed over"] += 1
    _bounded(document, parts, sum(array.size for array in attributes.values()))
    start = parts.n_points
    points = points.astype(np.float64)
    if not np.array_equal(placement, np.eye(4)):
        points = points @ placement[:3, :3].T + placement[:3, 3]
    parts.points.append(points)
    parts.attributes.append(attributes)
    parts.n_points += len(points)
    return start, len(points)


def _bounded(document: Document, parts: _Parts, count: int) -> None:
    """Refuse a scene that repeats its meshes until they are far larger than the file."""
    parts.n_numbers += count
    size = len(document.binary) + sum(map(len, document.buffers.values()))
    if parts.n_numbers > max(_FEW, 32 * size):
        raise MeshError(f"the scene repeats its meshes so often that they are 32 times larger than its {size} bytes")


def _corners(document: Document, primitive: dict[str, Any], count: int, name: str) -> npt.NDArray[np.int64]:
    """Vertices of a primitive in their order, which without indices is that of the positions."""
    if primitive.get("indices") is None:
        return np.arange(count)
    values = accessor_values(document, primitive["indices"], name)
    if values.shape[1] != 1 or values.dtype.kind != "u":
        raise MeshError(f"the indices of {name} are of type {values.dtype}, expected whole numbers from 0")
    return values.ravel().astype(np.int64)


def _triangles(corners: npt.NDArray[np.int64], mode: Any, name: str, repair: bool, parts: _Parts) -> np.ndarray:
    """Triangles of a list, a strip or a fan; strips turn by triangles without area, which are left out."""
    if mode == _TRIANGLES:
        if len(corners) % 3 and not repair:
            raise MeshError(f"{name} has {len(corners)} corners, which make no triangles; repair=True drops the last")
        if len(corners) % 3:
            parts.without["corners left over, dropped"] += 1
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if mode == _STRIP:
        return strip_triangles(corners)
    if mode != _FAN:
        raise MeshError(f"{name} is of mode {str(mode)[:20]}, which glTF does not have")
    second, third = corners[1:-1], corners[2:]
    faces = np.column_stack([second, third, np.full_like(second, corners[0] if len(corners) else 0)])
    return faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]


def _in_range(faces: np.ndarray, count: int, name: str, repair: bool) -> np.ndarray:
    """The faces, those with a vertex that is not there as -1 throughout, for repair to remove."""
    outside: np.ndarray = np.any(faces >= count, axis=1)
    if not outside.any():
        return faces
    if not repair:
        at = int(np.argmax(outside))
        raise MeshError(
            f"faces[{at}] {f'of {name} ' if name else ''}refers to vertex {faces[at].max()}, but there are {count} "
            f"vertices, numbered from 0 ({counted(outside.sum(), 'such face')})"
        )
    return np.where(outside[:, None], -1, faces)
