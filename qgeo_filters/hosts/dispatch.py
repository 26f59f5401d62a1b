"""Meshes of other libraries and files to `Surface` and back, with their named attributes.

A host library is imported only when one of its objects is met, and recognised by the module of its type.
Each host has one module here with three functions: ``read(mesh, repair)`` gives a `RawMesh`,
``write(mesh, attributes)`` and ``pose(mesh, vertices)`` give a changed copy.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Mapping
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MeshError
from qgeo_filters.io.raw_mesh import RawMesh, triangles
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_attributes

__all__ = ["RawMesh", "as_surface", "has_adapter", "like_host", "raw_mesh", "with_vertices"]

_ADAPTERS = {"open3d": "open3d", "pymeshlab": "meshlab", "pyvista": "pyvista", "trimesh": "trimesh"}


def as_surface(obj: Any, *, repair: bool = False) -> Surface:
    """Surface of a mesh object of any host.

    Parameters
    ----------
    obj : mesh object
        Surface, open3d.t.geometry.TriangleMesh or the legacy open3d.geometry.TriangleMesh,
        pymeshlab.MeshSet (its current mesh, in the mesh's own coordinates) or Mesh, pyvista.PolyData,
        trimesh.Trimesh, a ``(V, F)`` pair, a path, or any object with ``vertices`` and ``faces``.
        Never changed. Per-vertex attributes come along: ``mesh.vertex[...]`` of Open3D (positions apart;
        normals and colours under their names), custom scalar and point attributes of PyMeshLab,
        ``point_data`` of PyVista, ``vertex_attributes`` of trimesh.
    repair : bool
        Make the mesh manifold and one piece; polygons are triangulated. To learn what was changed and to carry
        values back, call `repair.repair_surface` instead.

    Raises
    ------
    MeshError
        What is no mesh, or a mesh that cannot be held; the message says what, where and how often.
    """
    if isinstance(obj, Surface) and not repair:
        return obj
    if repair:
        from qgeo_filters.hosts.repair import repair_surface

        return repair_surface(obj).surface
    if _is_path(obj):
        from qgeo_filters.io.formats import read_surface

        return read_surface(obj)
    return raw_mesh(obj).surface()


def raw_mesh(obj: Any, *, repair: bool = False) -> RawMesh:
    """Arrays of a mesh object of any host, not checked; ``repair`` triangulates polygons."""
    if isinstance(obj, RawMesh):
        return obj
    if isinstance(obj, Surface):
        return RawMesh(obj.vertices, obj.faces, obj.attributes)
    if _is_path(obj):
        from qgeo_filters.io.formats import read_raw

        return read_raw(obj, repair=repair)
    adapter = _adapter(obj)
    if adapter is not None:
        mesh: RawMesh = adapter.read(obj, repair)
        return mesh
    if _is_pair(obj):
        return _arrays(obj[0], obj[1], repair)
    if hasattr(obj, "vertices") and hasattr(obj, "faces"):
        return _arrays(obj.vertices, obj.faces, repair)
    raise MeshError(
        f"cannot take a mesh from {type(obj).__module__}.{type(obj).__qualname__}: expected an Open3D, PyMeshLab, "
        "PyVista or trimesh mesh, a (vertices, faces) pair, a path or a Surface"
    )


def like_host(host: Any, surface: Surface | None, attributes: Mapping[str, npt.ArrayLike]) -> Any:
    """Copy of the host object with per-vertex attributes added, equal names replaced.

    Parameters
    ----------
    host : see `as_surface`
        Not changed; all that it holds itself (attributes per vertex and per face, colours, texture
        coordinates, materials, other layers) is in the copy.
    surface : Surface or None
        ``as_surface(host)``, or None for a mesh of another library that no `Surface` can hold.
    attributes : mapping of str to array-like, shape (n,) or (n, ...)

    Returns
    -------
    host object
        Of the same kind. A legacy Open3D mesh, which holds no attributes, comes back as the tensor kind; a
        bare pymeshlab.Mesh as a MeshSet; a pair, a path and an unknown object as a `Surface`.
    """
    n_vertices = len(np.asarray(raw_mesh(host, repair=True).vertices)) if surface is None else surface.n_vertices
    checked = checked_attributes(attributes, n_vertices)
    adapter = _adapter(host)
    if adapter is not None:
        return adapter.write(host, checked)
    return (as_surface(host) if surface is None else surface).with_attributes(checked)


def has_adapter(obj: Any) -> bool:
    """Whether the object is a mesh of another library, which `like_host` copies in kind."""
    return _adapter(obj) is not None


def with_vertices(host: Any, vertices: npt.ArrayLike) -> Any:
    """Copy of the host object in another pose: same faces and attributes, other positions.

    Normals that the host holds are computed anew. A pair comes back as a pair, a path as a `Surface`.
    """
    if isinstance(host, Surface):
        return host.with_vertices(vertices)
    adapter = _adapter(host)
    posed = np.array(vertices, dtype=np.float64)
    expected = np.shape(raw_mesh(host).vertices)
    if posed.shape != expected:
        raise MeshError(f"the pose has shape {posed.shape}, expected {expected}")
    if adapter is not None:
        return adapter.pose(host, posed)
    return (posed, host[1]) if _is_pair(host) else as_surface(host).with_vertices(posed)


def _adapter(obj: Any) -> ModuleType | None:
    for cls in type(obj).__mro__:
        name = _ADAPTERS.get(cls.__module__.partition(".")[0])
        if name is not None:
            return importlib.import_module(f"qgeo_filters.hosts.{name}")
    return None


def _is_path(obj: Any) -> bool:
    return isinstance(obj, (str, os.PathLike))


def _is_pair(obj: Any) -> bool:
    return isinstance(obj, (tuple, list)) and len(obj) == 2


def _arrays(vertices: Any, faces: Any, repair: bool) -> RawMesh:
    faces = np.asarray(faces)
    if repair and faces.ndim == 2 and faces.shape[1] > 3:
        faces, notes = triangles(faces, repair)
        return RawMesh(vertices, faces, notes=notes)
    return RawMesh(vertices, faces)
