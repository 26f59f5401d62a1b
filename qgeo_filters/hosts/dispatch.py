"""Meshes of other libraries and files to `Surface` and back, with their named attributes.

A host library is imported only when one of its objects is met, and recognised by the module of its type.
Each host is one module, see `hosts.protocol.Host`.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, TypeAlias, Union

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import RepairOption
from qgeo_filters.array_likes import as_array, is_array
from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.arrays import is_pair, is_pair_of_arrays, is_path, raw_mesh
from qgeo_filters.hosts.protocol import host_of
from qgeo_filters.hosts.repair import Repair, needs_repair, repaired_within
from qgeo_filters.hosts.wrap import wrap_surface
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.io.raw_mesh import RawMesh
from qgeo_filters.repair.sound import sound_mesh
from qgeo_filters.repair.triangle_soup import Pieces, most_lost
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_attributes, checked_repair

__all__ = [
    "SurfaceLike",
    "as_surface",
    "is_host_mesh",
    "is_mesh",
    "layers_of",
    "raw_mesh",
    "repaired_by",
    "surface_and_repair",
    "with_positions",
    "write_back",
]

#: What `as_surface` takes; meshes of other libraries have no type in common.
SurfaceLike: TypeAlias = Union[Surface, tuple[npt.ArrayLike, npt.ArrayLike], str, "os.PathLike[str]", Any]


def as_surface(obj: SurfaceLike, *, repair: RepairOption = False) -> Surface:
    """Surface of a mesh object of any host.

    Parameters
    ----------
    obj : mesh object
        Surface, open3d.t.geometry.TriangleMesh or the legacy open3d.geometry.TriangleMesh,
        pymeshlab.MeshSet (its current mesh, in the mesh's own coordinates) or Mesh, pyvista.PolyData,
        trimesh.Trimesh, vedo.Mesh, meshio.Mesh, a ``(V, F)`` pair of arrays or tensors (of PyTorch too, on any device),
        a path, a `Repair` (what it made), or any object with ``vertices`` and ``faces``. What is computed from tensors
        are NumPy arrays, through which no gradient goes: ``torch.tensor(found.p2p)``.
        Never changed. Per-vertex attributes come along: ``mesh.vertex[...]`` of Open3D (positions apart;
        normals and colours under their names), custom scalar and point attributes of PyMeshLab,
        ``point_data`` of PyVista and meshio, ``pointdata`` of vedo, ``vertex_attributes`` of trimesh and its
        colours.
    repair : bool, "auto", "force" or "wrap"
        Make the mesh manifold and one piece; polygons are triangulated. More than a hundredth of the area is removed
        only with "force". With "auto" only where something is wrong, see `surface_and_repair`. To learn what was
        changed and to carry values back, call `repair_surface` instead.

    Raises
    ------
    MeshError
        What is no mesh, or a mesh that cannot be held; the message says what, where and how often.

    Examples
    --------
    >>> vertices, faces = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]
    >>> qg.as_surface((vertices, faces))
    Surface(3 vertices, 1 faces)
    >>> import trimesh
    >>> qg.as_surface(trimesh.creation.icosphere(1))
    Surface(42 vertices, 80 faces)
    """
    if isinstance(obj, Repair):
        return obj.surface
    if checked_repair(repair):
        given, repaired = surface_and_repair(obj, repair)
        return given if repaired is None else repaired.surface
    if isinstance(obj, Surface):
        return obj
    if is_path(obj):
        return Surface.read(obj)
    return Surface.from_raw(raw_mesh(obj))


def surface_and_repair(
    obj: SurfaceLike, repair: RepairOption, pieces: Pieces = "largest"
) -> tuple[Surface, Repair | None]:
    """Surface of a mesh object on its own vertices, and its repair, None where nothing was changed.

    Parameters
    ----------
    obj : see `as_surface`
        A `Repair` stands as it is.
    repair : bool, "auto", "force" or "wrap"
        With "auto" a mesh is repaired that no `Surface` can hold, that is not manifold, not in one piece, not welded,
        that has edges of length zero, or neighbouring faces that disagree on which side is out. Pieces
        of up to a tenth of the area together are taken for crumbs and removed; what has more is refused. With "wrap"
        it is wrapped in a closed surface, see `wrap_surface`.
    pieces : {"largest", "all"}
        Whether one piece is needed, or any number of them will do.

    Raises
    ------
    MeshError
        What is no mesh, or cannot be repaired.
    """
    if isinstance(obj, Repair):
        return obj.given, obj
    if not checked_repair(repair):
        return as_surface(obj), None
    if repair == "auto":
        try:
            surface = as_surface(obj)
        except MeshError:
            pass  # whoever repairs it says what cannot be repaired
        else:
            if not needs_repair(surface, pieces):
                return surface, None
            obj = surface
    found = repaired_by(obj, repair, pieces)
    return found.given, found if found.changed else None


def repaired_by(obj: SurfaceLike, repair: RepairOption, pieces: Pieces = "largest") -> Repair:
    """Repair of a mesh object in the way that the option asks for."""
    return wrap_surface(obj) if repair == "wrap" else repaired_within(obj, most_lost(repair), pieces)


def as_given(obj: SurfaceLike, repair: RepairOption) -> tuple[Surface, tuple[str, ...]]:
    """Surface of a mesh object on its own vertices, before any repair, and what was left out to hold it.

    Without ``repair`` nothing is left out, and a mesh that no `Surface` can hold is refused.
    """
    try:
        return as_surface(obj), ()
    except MeshError:
        if not checked_repair(repair):
            raise
    raw = raw_mesh(obj, repair=True)  # which names its file itself
    with path_in_errors(obj if is_path(obj) else None):
        sound = sound_mesh(raw)
        return Surface.from_raw(sound.raw), sound.notes


def write_back(host: Any, surface: Surface | None, attributes: Mapping[str, npt.ArrayLike]) -> Any:
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
    library = host_of(host)
    if library is not None:
        return library.write(host, checked)
    return (as_surface(host) if surface is None else surface).with_attributes(checked)


def is_host_mesh(obj: Any) -> bool:
    """Whether the object is a mesh of another library, which `write_back` copies in kind."""
    return host_of(obj) is not None


def is_mesh(obj: Any) -> bool:
    """Whether the object names or is one mesh, as far as can be told without reading it, rather than several."""
    if is_array(obj):  # those of the libraries, too
        return False
    if isinstance(obj, (Surface, RawMesh)) or is_path(obj) or is_host_mesh(obj) or is_pair_of_arrays(obj):
        return True
    return hasattr(obj, "vertices") and hasattr(obj, "faces")


def layers_of(obj: Any) -> list[Any]:
    """The meshes that an object holds which `as_surface` takes one of: the layers of a MeshSet; any other alone."""
    layers = getattr(host_of(obj), "layers", None)
    return [obj] if layers is None else list(layers(obj))


def with_positions(host: Any, vertices: npt.ArrayLike) -> Any:
    """Copy of the host object in another pose: same faces and attributes, other positions.

    Normals that the host holds are computed anew. A pair comes back as a pair, a path as a `Surface`.
    """
    if isinstance(host, Surface):
        return host.with_vertices(vertices)
    library = host_of(host)
    posed = np.array(as_array(vertices), dtype=np.float64)
    expected = np.shape(raw_mesh(host).vertices)
    if posed.shape != expected:
        raise MeshError(f"the pose has shape {posed.shape}, expected {expected}")
    if library is not None:
        return library.with_positions(host, posed)
    return (posed, host[1]) if is_pair(host) else as_surface(host).with_vertices(posed)
