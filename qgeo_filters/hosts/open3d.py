"""Open3D triangle meshes: tensor meshes with named attributes, legacy ones as tensor meshes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MeshError, require_package
from qgeo_filters.hosts.segments import segments
from qgeo_filters.io.raw_mesh import RawMesh
from qgeo_filters.surface import Surface


def read(mesh: Any, repair: bool) -> RawMesh:
    """Arrays of a mesh; every key of ``mesh.vertex`` but the positions is an attribute, (n, 1) becomes (n,)."""
    mesh = _tensor(mesh)
    if "positions" not in mesh.vertex or "indices" not in mesh.triangle:
        return RawMesh(np.empty((0, 3)), np.empty((0, 3), dtype=np.int32))
    attributes = {name: _array(name, values) for name, values in mesh.vertex.items() if name != "positions"}
    return RawMesh(mesh.vertex.positions.cpu().numpy(), mesh.triangle.indices.cpu().numpy(), attributes)


def write(mesh: Any, attributes: Mapping[str, np.ndarray]) -> Any:
    """Copy of the mesh with attributes in ``mesh.vertex``, scalars as (n, 1), booleans and short integers as int32."""
    copy = _copy(mesh)
    for name, values in attributes.items():
        copy.vertex[name] = _to_tensor(name, values, copy.device)
    return copy


def with_positions(mesh: Any, vertices: npt.NDArray[np.float64]) -> Any:
    """Copy of the mesh at other positions, in the precision of the old ones."""
    copy = _copy(mesh)
    positions = _to_tensor("positions", vertices, copy.device)
    copy.vertex.positions = positions.to(copy.vertex.positions.dtype)
    if "normals" in copy.triangle:
        copy.compute_triangle_normals()
    if "normals" in copy.vertex:
        copy.compute_vertex_normals()
    return copy


def make(surface: Surface) -> Any:
    """Tensor mesh with the vertices, faces and attributes of a surface."""
    open3d = require_package("open3d", "open3d", "an Open3D mesh")
    mesh = open3d.t.geometry.TriangleMesh()
    mesh.vertex.positions = open3d.core.Tensor(np.array(surface.vertices))
    mesh.triangle.indices = open3d.core.Tensor(np.array(surface.faces))
    return write(mesh, surface.attributes)


def lines(curves: Sequence[npt.NDArray[np.float64]]) -> Any:
    """LineSet of the curves, of the legacy kind, which all windows of Open3D draw."""
    open3d = require_package("open3d", "open3d", "an Open3D LineSet")
    points, ends = segments(curves)
    return open3d.geometry.LineSet(
        open3d.utility.Vector3dVector(points), open3d.utility.Vector2iVector(ends.astype(np.int32))
    )


def _tensor(mesh: Any) -> Any:
    open3d = require_package("open3d", "open3d", "an Open3D mesh")
    if isinstance(mesh, open3d.t.geometry.TriangleMesh):
        return mesh
    if isinstance(mesh, open3d.geometry.TriangleMesh):
        core = open3d.core
        return open3d.t.geometry.TriangleMesh.from_legacy(mesh, core.float64, core.int64)
    raise MeshError(f"an Open3D {type(mesh).__qualname__} is no triangle mesh")


def _copy(mesh: Any) -> Any:
    tensor = _tensor(mesh)
    if tensor is not mesh:
        return tensor
    copy = mesh.clone()
    copy.material = mesh.material  # clone() forgets it
    return copy


def _array(name: str, values: Any) -> np.ndarray:
    try:
        array: np.ndarray = values.cpu().numpy()
    except RuntimeError as error:
        raise MeshError(
            f"attribute {name!r} of the Open3D mesh has no data; clip_plane and fill_holes lose short integers: "
            f"del mesh.vertex[{name!r}]"
        ) from error
    return array[:, 0] if array.ndim == 2 and array.shape[1] == 1 else array


def _to_tensor(name: str, values: np.ndarray, device: Any) -> Any:
    open3d = require_package("open3d", "open3d", "an Open3D mesh")
    if values.dtype.kind not in "biuf" or values.dtype.itemsize > 8:
        raise MeshError(f"attribute {name!r} of dtype {values.dtype} cannot be held by an Open3D mesh")
    values = values.astype(_held_dtype(values))
    # One-dimensional attributes are accepted but dropped by clip_plane and fill_holes.
    columns = values.reshape(-1, 1) if values.ndim == 1 else values
    return open3d.core.Tensor(np.ascontiguousarray(columns), device=device)


def _held_dtype(values: np.ndarray) -> Any:
    """Smallest type that clip_plane and fill_holes do not fail on or lose, and that holds the values."""
    kind, size = values.dtype.kind, values.dtype.itemsize
    if kind == "f":
        return np.float64 if size == 8 else np.float32
    if kind == "u" and size == 4:
        return np.uint32
    too_large = kind == "u" and size == 8 and values.size and values.max() > np.iinfo(np.int64).max
    return np.uint64 if too_large else np.int64 if size == 8 else np.int32
