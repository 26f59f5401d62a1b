"""PyMeshLab mesh sets: custom attributes of the current mesh both ways.

PyMeshLab can add a custom attribute but neither list, replace nor remove one, and cannot copy a MeshSet. So a
changed MeshSet is a new one: ``add_mesh`` copies each layer with its custom attributes, and the rest (ids, labels,
visibility, transformation, texture image) is carried over by hand.
"""

from __future__ import annotations

import re
import tempfile
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MeshError, require_package
from qgeo_filters.interop.meshlab_attributes import (
    add_attributes,
    custom_attributes,
    joined,
    split,
)
from qgeo_filters.interop.raw import RawMesh


def read(mesh: Any, repair: bool) -> RawMesh:
    """Arrays of the current mesh; custom scalar and point attributes are the attributes.

    Raises
    ------
    MeshError
        An empty MeshSet, or a mesh with deleted elements (``mesh.compact()`` removes them).
    """
    layer = _layer(mesh)
    if not layer.is_compact():
        raise MeshError("the PyMeshLab mesh has deleted elements: call mesh.compact() first")
    return RawMesh(layer.vertex_matrix(), layer.face_matrix(), joined(custom_attributes(layer)))


def write(mesh: Any, attributes: Mapping[str, np.ndarray]) -> Any:
    """New MeshSet with all layers of the old one and the attributes on its current mesh.

    Scalars and 3-vectors are custom attributes of these names, wider ones the scalars ``name_0``,
    ``name_1``, ... All are float64, the only type that PyMeshLab has; a bare Mesh comes back in a MeshSet.
    """
    return _rebuilt(mesh, split(attributes), None)


def pose(mesh: Any, vertices: npt.NDArray[np.float64]) -> Any:
    """New MeshSet whose current mesh has other positions; normals are computed anew."""
    return _rebuilt(mesh, {}, vertices)


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
    layers = [current] if current is mesh else list(mesh)
    rebuilt = pymeshlab.MeshSet()
    next_id = 0
    for layer in layers:
        changed, holder = layer, None
        if layer.id() == current.id():
            holder, changed = _changed(pymeshlab, layer, attributes, positions)
        if current is not mesh:  # a MeshSet: the layers keep their ids, also where some were deleted
            while next_id < layer.id():
                rebuilt.add_mesh(_placeholder(pymeshlab))
                rebuilt.delete_current_mesh()
                next_id += 1
        rebuilt.add_mesh(changed, layer.label())
        next_id += 1
        _carry_over(rebuilt, layer)
        del holder  # owns `changed`
    if current is not mesh:
        rebuilt.set_current_mesh(current.id())
    return rebuilt


def _changed(
    pymeshlab: Any, layer: Any, attributes: Mapping[str, np.ndarray], positions: npt.NDArray[np.float64] | None
) -> tuple[Any, Any]:
    """MeshSet that owns a changed copy of the layer, and the copy."""
    holder = pymeshlab.MeshSet()
    holder.add_mesh(layer, layer.label())
    if positions is not None:
        _move(pymeshlab, holder, positions)
    existing = custom_attributes(layer)
    replaced = [name for name in attributes if ("vertex", name) in existing]
    if replaced:
        # This filter's copy has no custom attributes: the only way to get rid of one.
        holder.generate_copy_of_current_mesh()
        kept = {key: existing[key] for key in existing if key[0] == "face" or key[1] not in replaced}
        add_attributes(holder.current_mesh(), kept)
    add_attributes(holder.current_mesh(), {("vertex", name): values for name, values in attributes.items()})
    return holder, holder.current_mesh()


def _move(pymeshlab: Any, holder: Any, positions: npt.NDArray[np.float64]) -> None:
    """Move the only mesh of a MeshSet, in place, and compute its normals anew."""
    moved = holder.current_mesh_id()
    holder.add_mesh(pymeshlab.Mesh(positions, holder.current_mesh().face_matrix()))
    target = holder.current_mesh_id()
    holder.set_current_mesh(moved)
    for _ in range(2):  # x + (target - x) is off by a rounding error the first time, exact from there
        holder.compute_coord_linear_morphing(targetmesh=target, percentmorph=100.0)
    holder.compute_normal_per_face()
    holder.compute_normal_per_vertex()


def _placeholder(pymeshlab: Any) -> Any:
    return pymeshlab.Mesh(np.zeros((1, 3)))


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
            stacklevel=2,
        )
    if not layer.is_visible():
        rebuilt.set_mesh_visibility(rebuilt.current_mesh_id(), False)
