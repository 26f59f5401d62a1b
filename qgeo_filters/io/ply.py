"""PLY: every named attribute, whatever its width, type and name, and whatever other programs write."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import plyfile

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError
from qgeo_filters.io.ply_attributes import attributes_of_columns, columns_of_attributes
from qgeo_filters.io.ply_elements import Element, Lists, read_elements
from qgeo_filters.io.polygons import Polygons, strip_triangles, triangulated
from qgeo_filters.io.raw_mesh import RawMesh

_CORNER_NAMES = ("vertex_indices", "vertex_index")


def read(path: Path, repair: bool) -> RawMesh:
    """Arrays of a PLY file; every vertex property apart from the position is an attribute.

    In files of other programs nx, ny, nz are ``normals`` (n, 3) and red, green, blue (alpha) are ``colors``. Triangle
    strips follow the faces. Lists of different lengths are no attribute, as the notes say.
    """
    ply = read_elements(path)
    if "vertex" not in ply.elements:
        raise MeshError(f"the PLY file has no vertices, only {', '.join(ply.elements) or 'nothing'}")
    vertex = ply.elements["vertex"]
    columns: dict[str, np.ndarray] = {}
    dropped: tuple[str, ...] = ()
    for name, column in vertex.columns.items():
        if not isinstance(column, Lists):
            columns[name] = column
        elif np.all(column.sizes == column.sizes[:1]):
            columns[name] = column.values.reshape(vertex.n_rows, -1) if vertex.n_rows else np.empty((0, 0))
        else:
            dropped += (f"the lists {name!r} of the vertices have different lengths, dropped",)
    positions = [columns.pop(axis, np.empty((0, 0))) for axis in "xyz"]
    if any(values.shape != (vertex.n_rows,) for values in positions):
        raise MeshError(f"the vertices have no x, y, z, only {', '.join(vertex.columns) or 'nothing'}")
    vertices = np.column_stack(positions)
    faces, notes = triangulated(vertices, _corners(ply.elements.get("face")), repair)
    strips = _corners(ply.elements.get("tristrips"))
    if len(strips.sizes):
        ends = np.cumsum(strips.sizes)[:-1]
        faces = np.concatenate([faces, strip_triangles(np.insert(strips.corners, ends, -1))])
    return RawMesh(vertices, faces, attributes_of_columns(columns, ply.comments, vertex.n_rows), dropped + notes)


def write(path: Path, vertices: FloatArray, faces: IntArray, attributes: Mapping[str, np.ndarray]) -> None:
    """Write as binary PLY with every attribute.

    Raises
    ------
    MeshError
        An attribute that holds no numbers.
    """
    columns, comments = columns_of_attributes(attributes, dict(zip("xyz", vertices.T.astype("<f8"), strict=True)))
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


def _corners(element: Element | None) -> Polygons:
    """The corner lists of faces or strips."""
    if element is None:
        return Polygons.of_rows([])
    for name in _CORNER_NAMES:
        column = element.columns.get(name)
        if isinstance(column, Lists):
            return Polygons.of_flat(column.values, column.sizes)
    raise MeshError(
        f"the {element.name} rows have no list vertex_indices, only {', '.join(element.columns) or 'nothing'}"
    )
