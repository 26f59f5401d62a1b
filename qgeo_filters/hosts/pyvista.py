"""PyVista surfaces: point data both ways."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MeshError, require_package
from qgeo_filters.hosts.segments import segments
from qgeo_filters.io.raw_mesh import RawMesh, counted
from qgeo_filters.surface import Surface


def read(mesh: Any, repair: bool) -> RawMesh:
    """Arrays of a PolyData of triangles; every array of ``point_data`` is an attribute.

    Raises
    ------
    MeshError
        No PolyData, or one with polygons or strips (`repair` triangulates them).
    """
    if not hasattr(mesh, "GetPolys"):
        raise MeshError(
            f"a PyVista {type(mesh).__qualname__} is no surface: pass mesh.extract_surface().triangulate() instead"
        )
    notes: tuple[str, ...] = ()
    corners, n_strips = _corners(mesh), mesh.GetNumberOfStrips()
    n_polygons = int((corners != 3).sum())
    if n_polygons or n_strips:
        if not repair:
            raise MeshError(
                f"the PolyData has {counted(n_polygons, 'polygon')} and {counted(n_strips, 'strip')} beside its "
                f"{counted(len(corners) - n_polygons, 'triangle')}: pass mesh.triangulate(), or repair=True"
            )
        mesh = mesh.triangulate()
        notes = (f"{counted(n_polygons, 'polygon')} and {counted(n_strips, 'strip')} split into triangles",)
    attributes = {name: np.asarray(values) for name, values in mesh.point_data.items()}
    return RawMesh(np.asarray(mesh.points), np.asarray(mesh.faces).reshape(-1, 4)[:, 1:], attributes, notes)


def write(mesh: Any, attributes: Mapping[str, np.ndarray]) -> Any:
    """Deep copy of the mesh with arrays added to its ``point_data``; the active scalars stay what they were."""
    copy = mesh.copy(deep=True)
    for name, values in attributes.items():
        if values.ndim > 2 or values.dtype.kind not in "biuf" or values.dtype.itemsize > 8:
            raise MeshError(
                f"attribute {name!r} of dtype {values.dtype} and shape {values.shape} cannot be held by a PyVista mesh"
            )
        copy.point_data.set_array(values.copy(), name)
    return copy


def with_positions(mesh: Any, vertices: npt.NDArray[np.float64]) -> Any:
    """Deep copy of the mesh at other positions, in the precision of the old ones."""
    copy = mesh.copy(deep=True)
    copy.points = vertices.astype(np.asarray(mesh.points).dtype)
    per_point, per_cell = "Normals" in copy.point_data, "Normals" in copy.cell_data
    if per_point or per_cell:
        for data in (copy.point_data, copy.cell_data):
            data.pop("Normals", None)  # else VTK takes them for good
        # Only the values are wanted: splitting or re-orienting would change the mesh itself.
        normals = copy.compute_normals(
            cell_normals=per_cell,
            point_normals=per_point,
            split_vertices=False,
            consistent_normals=False,
            auto_orient_normals=False,
            non_manifold_traversal=False,
        )
        if per_point:
            copy.point_data.set_array(np.array(normals.point_data["Normals"]), "Normals")
        if per_cell:
            copy.cell_data.set_array(np.array(normals.cell_data["Normals"]), "Normals")
    return copy


def make(surface: Surface) -> Any:
    """PolyData with the vertices, faces and attributes of a surface."""
    pyvista = require_package("pyvista", "pyvista", "a PyVista mesh")
    mesh = pyvista.PolyData.from_regular_faces(np.array(surface.vertices), np.array(surface.faces))
    return write(mesh, surface.attributes)


def lines(curves: Sequence[npt.NDArray[np.float64]]) -> Any:
    """PolyData with a line for each curve."""
    pyvista = require_package("pyvista", "pyvista", "lines of PyVista")
    points, _ = segments(curves)
    starts = np.cumsum([0, *map(len, curves)])
    cells = [np.append(len(curve), np.arange(len(curve)) + start) for curve, start in zip(curves, starts, strict=False)]
    return pyvista.PolyData(points, lines=np.concatenate(cells)) if cells else pyvista.PolyData()


def _corners(mesh: Any) -> np.ndarray:
    """Number of corners of each face, strips apart."""
    return np.diff(np.asarray(mesh.GetPolys().GetOffsetsArray()))
