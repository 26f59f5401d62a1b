"""meshio meshes: point data both ways."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MeshError, require_package
from qgeo_filters.hosts.segments import segments
from qgeo_filters.io.cells import cell_triangles
from qgeo_filters.io.grid_process import MESHIO_CODES
from qgeo_filters.io.raw_mesh import RawMesh, counted
from qgeo_filters.surface import Surface


def read(mesh: Any, repair: bool) -> RawMesh:
    """Arrays of the triangles of all blocks; ``point_data`` are the attributes, a plane mesh lies at z = 0.

    Raises
    ------
    MeshError
        Polygons or solid cells (`repair` splits the ones and takes the boundary of the others); curved cells.
    """
    if not hasattr(mesh, "points") or not hasattr(mesh, "cells"):
        raise MeshError(f"a meshio {type(mesh).__qualname__} is no mesh")
    curved = sorted({block.type for block in mesh.cells} - set(MESHIO_CODES))
    if curved:
        raise MeshError(f"the mesh has cells of kind {', '.join(curved)}: make it a mesh of order 1")
    rows = [(MESHIO_CODES[block.type], np.asarray(row)) for block in mesh.cells for row in _rows(block)]
    kinds = np.concatenate([np.full(len(row), code) for code, row in rows] or [np.empty(0)]).astype(np.int64)
    sizes = np.concatenate([np.full(len(row), row.shape[1]) for _, row in rows] or [np.empty(0)]).astype(np.int64)
    corners = np.concatenate([row.ravel() for _, row in rows] or [np.empty(0)]).astype(np.int64)
    points = _in_space(np.asarray(mesh.points))
    faces, notes = cell_triangles(points, kinds, sizes, corners, repair)
    return RawMesh(points, faces, dict(mesh.point_data), notes)


def write(mesh: Any, attributes: Mapping[str, np.ndarray]) -> Any:
    """Deep copy of the mesh with arrays added to its ``point_data``; booleans as int8, which meshio can save."""
    copy = mesh.copy()
    for name, values in attributes.items():
        if values.dtype.kind not in "biuf":
            raise MeshError(f"attribute {name!r} of dtype {values.dtype} cannot be held by a meshio mesh")
        copy.point_data[name] = values.astype(np.int8) if values.dtype.kind == "b" else values.copy()
    return copy


def with_positions(mesh: Any, vertices: npt.NDArray[np.float64]) -> Any:
    """Deep copy of the mesh at other positions, in the precision of the old ones."""
    copy = mesh.copy()
    copy.points = vertices.astype(np.asarray(mesh.points).dtype)
    return copy


def make(surface: Surface) -> Any:
    """Mesh of one block of triangles with the vertices, faces and attributes of a surface."""
    meshio = require_package("meshio", "files", "a meshio mesh")
    return write(meshio.Mesh(np.array(surface.vertices), [("triangle", np.array(surface.faces))]), surface.attributes)


def lines(curves: Sequence[npt.NDArray[np.float64]]) -> Any:
    """Mesh of one block of lines, the pieces of the curves."""
    meshio = require_package("meshio", "files", "a meshio mesh")
    points, ends = segments(curves)
    return meshio.Mesh(points, [("line", ends)])


def _rows(block: Any) -> list[Any]:
    """The cells of a block as tables; those of a block of polygons may have any numbers of corners."""
    if not len(block.data):
        return []
    if isinstance(block.data, np.ndarray) and block.data.dtype != object:
        return [block.data]
    return [np.asarray(cell)[None] for cell in block.data]


def _in_space(points: np.ndarray) -> np.ndarray:
    if points.ndim == 2 and points.shape[1] == 2:
        return np.column_stack([points, np.zeros(len(points))])
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError(f"the meshio mesh has points of shape {points.shape}, expected {counted(3, 'coordinate')} each")
    return points
