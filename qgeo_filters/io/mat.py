"""Meshes in MATLAB files, as TOSCA and the codes for functional maps keep them; vertices count from 1."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_path
from qgeo_filters.errors import MeshError
from qgeo_filters.io.matlab import Value, variables
from qgeo_filters.io.number_files import whole_numbers
from qgeo_filters.io.raw_mesh import RawMesh, counted

_VERTICES = ("VERT", "VERTICES", "VERTEX", "POINTS", "V")
_FACES = ("TRIV", "TRI", "FACES", "FACE", "TRIANGLES", "F", "T")


def read(path: Path, repair: bool) -> RawMesh:
    """Arrays of the mesh of a file: variables or fields of a struct, that of the outermost struct if there are several.

    Read are X, Y, Z (or VERT, vertices, ...) with TRIV (or faces, ...), one vertex a row or a column.
    """
    content = variables(path.read_bytes())
    level: list[tuple[str, Mapping[str, Value]]] = [("the file itself", content)]
    while level:
        meshes = {place: mesh for place, fields in level if (mesh := _mesh(fields)) is not None}
        if meshes:
            return _the_one(meshes)
        level = [inner for place, fields in level for name, value in fields.items() for inner in _structs(name, value)]
    names = ", ".join(filter(None, content)) or "nothing"
    raise MeshError(f"no mesh with fields X, Y, Z, TRIV (or VERT, TRIV) found; the file holds {names}")


def write(path: Path, vertices: FloatArray, faces: IntArray) -> None:
    """Write the variable ``surface`` with fields X, Y, Z, TRIV."""
    import scipy.io  # not before it is needed: each command loads all formats

    x, y, z = vertices.T[:, :, None]
    fields: dict[str, Any] = {"X": x, "Y": y, "Z": z, "TRIV": faces.astype(np.float64) + 1}
    with atomic_path(path) as temporary:
        scipy.io.savemat(temporary, {"surface": fields}, appendmat=False)


def _structs(name: str, value: Value) -> Iterator[tuple[str, Mapping[str, Value]]]:
    """Structs in a value, those of a struct array or cell numbered as MATLAB does."""
    if isinstance(value, dict):
        yield name, value
    elif isinstance(value, list):
        for number, one in enumerate(value, start=1):
            yield from _structs(f"{name}({number})", one)


def _the_one(meshes: Mapping[str, RawMesh]) -> RawMesh:
    (place, first), *others = meshes.items()
    for other, mesh in others:
        if not (np.array_equal(mesh.vertices, first.vertices) and np.array_equal(mesh.faces, first.faces)):
            raise MeshError(f"{len(meshes)} meshes found, such as {place} and {other}; save each in a file of its own")
    return first


def _mesh(fields: Mapping[str, Value]) -> RawMesh | None:
    """The mesh that these fields make, if they are those of one."""
    upper = {name.upper(): value for name, value in fields.items() if isinstance(value, np.ndarray) and value.size}
    corners = _first(upper, _FACES)
    if corners is None:
        return None
    points = _first(upper, _VERTICES)
    if points is not None:
        vertices, faces = _rows({name: upper[name] for name in (points, corners)})
    elif {"X", "Y", "Z"} <= set(upper):
        sizes = [upper[axis].size for axis in "XYZ"]
        if len(set(sizes)) > 1:
            raise MeshError(f"X, Y and Z have {sizes[0]}, {sizes[1]} and {sizes[2]} numbers, expected as many")
        vertices = np.column_stack([upper[axis].ravel(order="F") for axis in "XYZ"])
        (faces,) = _rows({corners: upper[corners]})
    else:
        return None
    return RawMesh(vertices, _from_zero(corners, faces))


def _first(fields: Mapping[str, np.ndarray], names: tuple[str, ...]) -> str | None:
    """The first of these names that is there; one of a single letter, which may be anything, must fit."""
    return next((name for name in names if name in fields and (len(name) > 1 or _fits(fields[name]))), None)


def _fits(table: np.ndarray) -> bool:
    return table.ndim == 2 and 3 in table.shape


def _rows(tables: Mapping[str, np.ndarray]) -> list[np.ndarray]:
    """The tables with one vertex or face a row; where three by three leaves it open, as it is in the others."""
    for name, table in tables.items():
        if not _fits(table):
            raise MeshError(f"{name} has shape {table.shape}, expected three columns or rows")
    as_columns = any(table.shape[1] != 3 for table in tables.values())
    return [table.T if as_columns and table.shape[0] == 3 else table for table in tables.values()]


def _from_zero(name: str, corners: np.ndarray) -> np.ndarray:
    """Vertices counted from 0."""
    whole = whole_numbers(corners, name)
    zero = np.flatnonzero((whole == 0).any(axis=1))
    if zero.size:
        raise MeshError(
            f"{name}({zero[0] + 1}, :) = {whole[zero[0]].tolist()} names vertex 0, but MATLAB counts from 1 "
            f"({counted(zero.size, 'such face')})"
        )
    return whole - 1
