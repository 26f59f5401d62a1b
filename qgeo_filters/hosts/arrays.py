"""Unchecked arrays of whatever holds a mesh: files, other libraries, pairs, objects with vertices and faces."""

from __future__ import annotations

import os
from typing import Any, TypeGuard

import numpy as np

from qgeo_filters.array_likes import as_array, is_array_like
from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.protocol import host_of, registered_hosts
from qgeo_filters.io.formats import read_raw
from qgeo_filters.io.polygons import Polygons, triangulated
from qgeo_filters.io.raw_mesh import RawMesh
from qgeo_filters.surface import Surface


def raw_mesh(obj: Any, *, repair: bool = False) -> RawMesh:
    """Arrays of a mesh object of any host, not checked; ``repair`` triangulates polygons."""
    if isinstance(obj, RawMesh):
        return obj
    if isinstance(obj, Surface):
        return RawMesh(obj.vertices, obj.faces, obj.attributes)
    if is_path(obj):
        return read_raw(obj, repair=repair)
    host = host_of(obj)
    if host is not None:
        return host.read(obj, repair)
    if is_pair(obj):
        return _split(obj[0], obj[1], repair)
    if hasattr(obj, "vertices") and hasattr(obj, "faces"):
        return _split(obj.vertices, obj.faces, repair)
    raise MeshError(
        f"cannot take a mesh from {type(obj).__module__}.{type(obj).__qualname__}: expected a mesh of "
        f"{', '.join(registered_hosts())}, a (vertices, faces) pair, a path or a Surface"
    )


def is_path(obj: object) -> TypeGuard[str | os.PathLike[str]]:
    """Whether the object names a file."""
    return isinstance(obj, (str, os.PathLike))


def is_pair(obj: object) -> TypeGuard[tuple[Any, Any] | list[Any]]:
    """Whether the object may be a (vertices, faces) pair."""
    return isinstance(obj, (tuple, list)) and len(obj) == 2


def is_pair_of_arrays(obj: object) -> bool:
    """Whether the object is a (vertices, faces) pair for sure, rather than two meshes, or two arrays of positions."""
    if not is_pair(obj) or not all(is_array_like(part) for part in obj):
        return False
    try:
        vertices = as_array(obj[0])
    except ValueError:  # rows of different lengths
        return False
    if vertices.ndim != 2:
        return False
    try:
        faces = as_array(obj[1])
    except ValueError:
        return True
    if faces.ndim != 2 or faces.dtype.kind not in "iuf":
        return False
    if len(faces) != len(vertices):
        return bool(faces.dtype.kind in "iu" or np.all(faces == np.floor(faces)))
    return isinstance(obj, tuple) and faces.dtype.kind in "iu"


def _split(vertices: Any, faces: Any, repair: bool) -> RawMesh:
    """Arrays of a pair; with ``repair`` the faces may have any numbers of corners, also different ones."""
    if not isinstance(vertices, (list, tuple)):  # whoever checks the arrays says what is wrong with a list
        vertices = as_array(vertices)
    try:
        corners = as_array(faces)
    except ValueError:  # rows of different lengths
        if not repair:
            return RawMesh(vertices, faces)  # whoever checks the arrays says so
        corners = None
    if corners is None or (repair and corners.ndim == 2 and corners.shape[1] > 3):
        corners, notes = triangulated(vertices, Polygons.of_rows(faces if corners is None else corners), repair)
        return RawMesh(vertices, corners, notes=notes)
    return RawMesh(vertices, corners)
