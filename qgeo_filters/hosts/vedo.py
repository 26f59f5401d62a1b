"""vedo meshes: point data both ways."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MeshError, require_package
from qgeo_filters.hosts.segments import segments
from qgeo_filters.io.polygons import Polygons, triangulated
from qgeo_filters.io.raw_mesh import RawMesh, counted
from qgeo_filters.surface import Surface

# Array in which vedo keeps the colours of points, in eight bits a channel.
_SHOWN = "PointsRGBA"


def read(mesh: Any, repair: bool) -> RawMesh:
    """Arrays of a Mesh of triangles, as it is placed in the scene; every array of ``pointdata`` is an attribute.

    Raises
    ------
    MeshError
        No Mesh, or one with polygons or strips (`repair` splits the polygons).
    """
    _require_mesh(mesh)
    data = mesh.dataset
    if data.GetNumberOfStrips():
        raise MeshError(f"the mesh has {counted(data.GetNumberOfStrips(), 'strip')}: pass mesh.clone().triangulate()")
    sizes, corners = _polygons(data)
    points = np.array(mesh.coordinates, dtype=np.float64).reshape(-1, 3)
    attributes = {name: np.array(mesh.pointdata[name]) for name in mesh.pointdata.keys()}  # noqa: SIM118, no mapping
    if "colors" in attributes:
        attributes.pop(_SHOWN, None)
    faces, notes = triangulated(points, Polygons(corners, sizes), repair)
    return RawMesh(points, faces, attributes, notes)


def write(mesh: Any, attributes: Mapping[str, np.ndarray]) -> Any:
    """Copy of the mesh with arrays added to its ``pointdata``; what it is coloured by stays, unless by ``"colors"``."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    copy = _clone(mesh)
    for name, values in attributes.items():
        if values.ndim > 2 or values.dtype.kind not in "biuf" or values.dtype.itemsize > 8:
            raise MeshError(
                f"attribute {name!r} of dtype {values.dtype} and shape {values.shape} cannot be held by a vedo mesh"
            )
        held = values.astype(np.int8) if values.dtype.kind == "b" else values
        # By VTK itself: vedo's own setter makes the new array the one that the mesh is coloured by.
        array = numpy_to_vtk(np.ascontiguousarray(held), deep=True)
        array.SetName(name)
        copy.dataset.GetPointData().AddArray(array)
    colors = attributes.get("colors")
    if colors is not None and colors.shape == (copy.npoints, 3):
        painted = np.full((copy.npoints, 4), 255, dtype=np.uint8)
        painted[:, :3] = np.round(255 * np.clip(colors, 0, 1))
        copy.pointcolors = painted
    return copy


def with_positions(mesh: Any, vertices: npt.NDArray[np.float64]) -> Any:
    """Copy of the mesh at other positions, in the precision of the old ones; normals that it has computed anew."""
    copy = _clone(mesh)
    _place(copy, vertices.astype(np.asarray(mesh.coordinates).dtype))
    data = copy.dataset.GetPointData(), copy.dataset.GetCellData()
    normals = [values.GetNormals() for values in data]
    if any(array is not None for array in normals):
        for values, array in zip(data, normals, strict=True):
            if array is not None:
                values.RemoveArray(array.GetName())  # else VTK takes them for good
        copy.compute_normals(points=normals[0] is not None, cells=normals[1] is not None, feature_angle=None)
    return copy


def make(surface: Surface) -> Any:
    """Mesh with the vertices, faces and attributes of a surface."""
    vedo = require_package("vedo", "vedo", "a vedo mesh")
    mesh = vedo.Mesh([np.array(surface.vertices), np.array(surface.faces)])
    _place(mesh, surface.vertices)  # in double precision, which vedo itself does not keep
    return write(mesh, surface.attributes)


def lines(curves: Sequence[npt.NDArray[np.float64]]) -> Any:
    """One line for each curve, in a `vedo.Lines` of all their pieces."""
    vedo = require_package("vedo", "vedo", "lines of vedo")
    points, ends = segments(curves)
    return vedo.Lines(points[ends[:, 0]], points[ends[:, 1]])


def _require_mesh(mesh: Any) -> None:
    if not hasattr(getattr(mesh, "dataset", None), "GetPolys"):
        raise MeshError(f"a vedo {type(mesh).__qualname__} is no surface: pass a vedo.Mesh")


def _clone(mesh: Any) -> Any:
    _require_mesh(mesh)
    return mesh.clone(deep=True)


def _place(mesh: Any, positions: np.ndarray) -> None:
    """Move the vertices, in place, in the precision of the positions."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints

    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(positions), deep=True))
    mesh.dataset.SetPoints(points)
    mesh.dataset.Modified()


def _polygons(data: Any) -> tuple[np.ndarray, np.ndarray]:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    cells = data.GetPolys()
    if not cells.GetNumberOfCells():
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    sizes = np.diff(vtk_to_numpy(cells.GetOffsetsArray()))
    return sizes.astype(np.int64), vtk_to_numpy(cells.GetConnectivityArray()).astype(np.int64)
