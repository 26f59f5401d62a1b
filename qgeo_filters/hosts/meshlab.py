"""PyMeshLab mesh sets: custom attributes of the current mesh both ways.

PyMeshLab can add a custom attribute but neither list, replace nor remove one, and cannot copy a MeshSet. So a
changed MeshSet is a new one: ``add_mesh`` copies each layer, and the rest (custom attributes, ids, labels, visibility,
transformation, texture image) is carried over by hand.
"""

from __future__ import annotations

import re
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MeshError, require_package
from qgeo_filters.hosts.meshlab_attributes import Key, add_attributes, custom_attributes, joined, split
from qgeo_filters.hosts.segments import segments
from qgeo_filters.io.raw_mesh import RawMesh, counted
from qgeo_filters.surface import Surface

#: Name under which vertex colours, (n, 3) in [0, 1], come and go; the mesh keeps them as its own colours.
COLORS = "colors"


def read(mesh: Any, repair: bool) -> RawMesh:
    """Arrays of the current mesh; custom scalar and point attributes are the attributes, and ``"colors"``.

    Raises
    ------
    MeshError
        An empty MeshSet, or a mesh with deleted elements (``mesh.compact()`` removes them).
    """
    layer = _layer(mesh)
    if not layer.is_compact():
        raise MeshError("the PyMeshLab mesh has deleted elements: call mesh.compact() first")
    attributes = joined(custom_attributes(layer)[0])
    if layer.has_vertex_color():
        colors = layer.vertex_color_matrix()[:, :3]
        if (colors != colors[:1]).any():  # a mesh that was never painted is of one colour
            attributes[COLORS] = colors
    return RawMesh(layer.vertex_matrix(), layer.face_matrix(), attributes)


def layers(mesh: Any) -> list[Any]:
    """All meshes of a MeshSet, visible or not, in their order; a bare Mesh alone."""
    pymeshlab = require_package("pymeshlab", "meshlab", "a PyMeshLab mesh")
    return list(mesh) if isinstance(mesh, pymeshlab.MeshSet) and mesh.mesh_number() else [mesh]


def write(mesh: Any, attributes: Mapping[str, np.ndarray]) -> Any:
    """New MeshSet with all layers of the old one and the attributes on its current mesh.

    Scalars and 3-vectors are custom attributes of these names, wider ones the scalars ``name_0``,
    ``name_1``, ... All are float64, the only type that PyMeshLab has; a bare Mesh comes back in a MeshSet.

    PyMeshLab's function filters take scalars by name. The components ``name_x``, ``name_y``, ``name_z`` of a
    point attribute are offered there too, but PyMeshLab 2025.7 reads freed memory for them: do not use them.
    """
    return _rebuilt(mesh, split(attributes), None)


def with_positions(mesh: Any, vertices: npt.NDArray[np.float64]) -> Any:
    """New MeshSet whose current mesh has other positions; normals are computed anew."""
    return _rebuilt(mesh, {}, vertices)


def make(surface: Surface) -> Any:
    """MeshSet of one mesh with the vertices, faces and attributes of a surface."""
    pymeshlab = require_package("pymeshlab", "meshlab", "a PyMeshLab mesh")
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.array(surface.vertices), np.array(surface.faces)))
    return write(meshes, surface.attributes)


def lines(curves: Sequence[npt.NDArray[np.float64]]) -> Any:
    """MeshSet of one mesh without faces, whose edges are the pieces of the curves."""
    pymeshlab = require_package("pymeshlab", "meshlab", "a PyMeshLab mesh")
    points, ends = segments(curves)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=points, edge_matrix=ends.astype(np.int32)))
    return meshes


def _layer(mesh: Any) -> Any:
    pymeshlab = require_package("pymeshlab", "meshlab", "a PyMeshLab mesh")
    if isinstance(mesh, pymeshlab.Mesh):
        return mesh
    if not isinstance(mesh, pymeshlab.MeshSet):
        raise MeshError(f"a PyMeshLab {type(mesh).__qualname__} is no mesh")
    if mesh.mesh_number() == 0:
        raise MeshError("the MeshSet has no meshes")
    return mesh.current_mesh()


def _rebuilt(mesh: Any, attributes: Mapping[str, np.ndarray], positions: npt.NDArray[np.float64] | None) -> Any:
    pymeshlab = require_package("pymeshlab", "meshlab", "a PyMeshLab mesh")
    current = _layer(mesh)
    is_set = current is not mesh
    layers = list(mesh) if is_set else [mesh]
    rebuilt = pymeshlab.MeshSet()
    if is_set and mesh.raster_number():
        warnings.warn(f"the copy of the MeshSet is without its {mesh.raster_number()} raster layers", stacklevel=5)
    next_id = 0
    for layer in layers:
        while is_set and next_id < layer.id():  # layers keep their ids, also where some were deleted
            rebuilt.add_mesh(pymeshlab.Mesh(np.zeros((1, 3))))
            rebuilt.delete_current_mesh()
            next_id += 1
        next_id += 1
        is_current = layer.id() == current.id()
        new = {("vertex", name): values for name, values in attributes.items()} if is_current else {}
        _add_copy(rebuilt, layer, new, positions if is_current else None)
        _carry_over(rebuilt, layer)
    if is_set:
        rebuilt.set_current_mesh(current.id())
    return rebuilt


def _add_copy(
    rebuilt: Any, layer: Any, new: Mapping[Key, np.ndarray], positions: npt.NDArray[np.float64] | None
) -> None:
    """Add a copy of the layer, with more custom attributes and maybe moved, as the current mesh."""
    pymeshlab = require_package("pymeshlab", "meshlab", "a PyMeshLab mesh")
    own, unnamed = custom_attributes(layer)
    if unnamed:
        warnings.warn(
            f"{counted(len(unnamed), 'custom attribute')} of layer {layer.label()!r} cannot be copied, because the "
            f"name is no identifier (like {unnamed[0]!r})",
            stacklevel=6,
        )
    copy = pymeshlab.MeshSet()
    copy.add_mesh(layer, layer.label())
    if own or unnamed:
        # Function filters crash on custom attributes that add_mesh has copied; this filter leaves them behind.
        copy.generate_copy_of_current_mesh()
    if positions is not None:
        move_current(copy, positions)
    colors = new.get(("vertex", COLORS))
    if colors is not None and colors.shape == (layer.vertex_number(), 3):
        _paint(copy, colors)
    rebuilt.add_mesh(copy.current_mesh(), layer.label())
    added = {key: values for key, values in new.items() if key != ("vertex", COLORS)}
    add_attributes(rebuilt.current_mesh(), {**own, **added})


def move_current(holder: Any, positions: npt.NDArray[np.float64]) -> int:
    """Move the current mesh of a MeshSet, in place, with its normals; number of the layer that helped and stays."""
    pymeshlab = require_package("pymeshlab", "meshlab", "a PyMeshLab mesh")
    moved = holder.current_mesh_id()
    holder.add_mesh(pymeshlab.Mesh(positions, holder.current_mesh().face_matrix()))
    target: int = holder.current_mesh_id()
    holder.set_current_mesh(moved)
    for _ in range(2):  # x + (target - x) is off by a rounding error the first time, exact from there
        holder.compute_coord_linear_morphing(targetmesh=target, percentmorph=100.0)
    holder.compute_normal_per_face()
    holder.compute_normal_per_vertex()
    return target


def _paint(holder: Any, colors: np.ndarray) -> None:
    """Set the vertex colours of the current mesh, in place; the copy that does it has no custom attributes."""
    names = []
    for channel, values in zip("rgb", colors.T, strict=True):
        names.append(f"qgeo_paint_{channel}")
        holder.current_mesh().add_vertex_custom_scalar_attribute(np.round(255 * np.clip(values, 0, 1)), names[-1])
    holder.compute_color_by_function_per_vertex(x=names[0], y=names[1], z=names[2], a="255")
    holder.generate_copy_of_current_mesh()


def _carry_over(rebuilt: Any, layer: Any) -> None:
    """What ``add_mesh`` forgets: transformation, texture image, visibility."""
    if not np.array_equal(layer.transform_matrix(), np.eye(4)):
        rebuilt.set_matrix(transformmatrix=layer.transform_matrix(), freeze=False)
    textures = layer.textures()
    if len(textures) == 1:
        with tempfile.TemporaryDirectory() as folder:
            ((name, image),) = textures.items()
            path = str(Path(folder) / re.sub(r"[/\\]", "_", name))
            image.save(path)
            rebuilt.set_texture_per_mesh(textname=path)
    elif textures:
        warnings.warn(
            f"layer {layer.label()!r} has {len(textures)} texture images, and PyMeshLab can attach only one: the copy "
            "keeps the texture coordinates, not the images",
            stacklevel=5,
        )
    if not layer.is_visible():
        rebuilt.set_mesh_visibility(rebuilt.current_mesh_id(), False)
