"""Methods of ``pymeshlab.MeshSet`` for symmetry, correspondence and transfer, and one that saves.

Where a method takes a second mesh, that is a layer of the MeshSet, named by its id as in PyMeshLab's own filters. The
current mesh is the one that is changed.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Literal

import numpy as np

from qgeo_filters._typing import MirrorOption, PartialOption
from qgeo_filters.animation.transfer import transfer_deformation
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.filters import stages
from qgeo_filters.filters.meshlab_in_place import (
    add_free,
    as_current,
    checked_layer,
    is_packed_color,
    set_colors,
    set_positions,
    set_scalar,
)
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.hosts.meshlab import COLORS
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.parallel import default_workers
from qgeo_filters.report.colors import carried_colors, mirror_colors, position_colors
from qgeo_filters.surface import Surface

_AXES = np.eye(3)  # colours go by place along the axes of the layer
_SYMMETRY = ("asymmetry", "side", "mirror_vertex")
_MATCH = ("distortion", "corresponding_vertex", "region")


def compute_scalar_by_self_symmetry_per_vertex(
    meshset: Any,
    *,
    quantity: Literal["asymmetry", "side", "mirror_vertex"] = "asymmetry",
    colorize: bool = True,
    workers: int | None = None,
) -> dict[str, Any]:
    """Set the scalar to what is known of the mirror point of each vertex, and colour mirror points alike.

    Parameters
    ----------
    quantity : {"asymmetry", "side", "mirror_vertex"}
        The scalar: how much distances from the vertex and from its mirror point differ, in sqrt(area); 1 and -1 on the
        two sides and 0 on the axis; the number of the mirror vertex.
    colorize : bool
        Whether each vertex is painted in the colour of its mirror vertex too, grey where it has none.
    workers : int, optional
        Number of threads; by default all cores that this process may use.

    Returns
    -------
    dict
        ``found`` and ``reason``; ``mirror_vertex`` (n,), ``side`` (n,), ``asymmetry`` (n,) and ``score``, see
        `qgeo_filters.Symmetry`. Where no symmetry was found the scalar is that of no symmetry, and nothing is painted.
    """
    _check_quantity(quantity, _SYMMETRY)
    surface = as_surface(meshset)
    with default_workers(workers):
        symmetry = stages.symmetry_of(surface)
    answer: dict[str, np.ndarray] = {
        "mirror_vertex": np.array(symmetry.p2p),
        "side": np.array(symmetry.side),
        "asymmetry": np.array(symmetry.asymmetry),
    }
    set_scalar(meshset, f"qgeo_{quantity}", answer[quantity])
    if colorize and symmetry.found:
        set_colors(meshset, mirror_colors(surface.vertices, symmetry.p2p, _AXES))
    return {"found": symmetry.found, "reason": symmetry.reason, "score": symmetry.score, **answer}


def compute_scalar_by_correspondence_per_vertex(
    meshset: Any,
    *,
    targetmesh: int,
    quantity: Literal["distortion", "corresponding_vertex", "region"] = "distortion",
    normalize: bool = True,
    partial: PartialOption = "auto",
    mirror: MirrorOption = "auto",
    colorize: bool = True,
    workers: int | None = None,
) -> dict[str, Any]:
    """Set the scalar to what is known of the corresponding point of another layer, and colour both layers alike.

    Parameters
    ----------
    targetmesh : int
        Id of the other layer: another shape in any triangulation and position.
    quantity : {"distortion", "corresponding_vertex", "region"}
        The scalar of the current mesh: how much distances from the vertex and from its image differ, in sqrt(area); the
        number of the vertex of the other layer, -1: none; a region, of equal number on both layers.
    normalize, partial, mirror
        See `qgeo_filters.match`.
    colorize : bool
        Whether both layers are painted: places that belong together in one colour, grey without a partner.
    workers : int, optional
        Number of threads; by default all cores that this process may use.

    Returns
    -------
    dict
        ``confident`` and ``explanation``; ``corresponding_vertex`` (n,), ``inverse`` (of the other layer),
        ``distortion`` (n,) and ``score``, see `qgeo_filters.MatchResult`.
    """
    _check_quantity(quantity, _MATCH)
    target = checked_layer(meshset, targetmesh, "targetmesh")
    surface, other = as_surface(meshset), as_surface(meshset.mesh(target))
    with default_workers(workers):
        found = stages.correspondence_of(surface, other, normalize, partial=partial, mirror=mirror)
    values: dict[str, np.ndarray] = {
        "distortion": found.distortion,
        "corresponding_vertex": found.p2p,
        "region": found.regions_x,
    }
    set_scalar(meshset, f"qgeo_{quantity}", values[quantity])
    if quantity == "region" and target != meshset.current_mesh_id():
        with as_current(meshset, target):
            set_scalar(meshset, "qgeo_region", found.regions_y)
    if colorize:
        colors = position_colors(other.vertices, _AXES)
        if target != meshset.current_mesh_id():
            with as_current(meshset, target):
                set_colors(meshset, np.where(found.inverse[:, None] < 0, carried_colors(colors, [-1]), colors))
        set_colors(meshset, carried_colors(colors, found.p2p))
    return {
        **_verdict(found),
        "corresponding_vertex": np.array(found.p2p),
        "inverse": np.array(found.inverse),
        "distortion": np.array(found.distortion),
    }


def transfer_attributes_by_correspondence_per_vertex(
    meshset: Any,
    *,
    sourcemesh: int,
    normalize: bool = True,
    partial: PartialOption = "auto",
    mirror: MirrorOption = "auto",
    workers: int | None = None,
) -> dict[str, Any]:
    """Bring scalar, colours and custom attributes of another layer to the current mesh, along a map found for it.

    PyMeshLab's ``transfer_attributes_per_vertex`` takes the closest point in space; here the layers may be different
    poses and shapes.

    Parameters
    ----------
    sourcemesh : int
        Id of the layer that has the attributes.
    normalize, partial, mirror, workers
        See `compute_scalar_by_correspondence_per_vertex`.

    Returns
    -------
    dict
        ``confident``, ``explanation`` and ``score`` of the map, and ``attributes``: the names of what was brought, with
        ``_v2`` behind a name that was taken already.
    """
    source = checked_layer(meshset, sourcemesh, "sourcemesh")
    layer = meshset.mesh(source)
    surface, other = as_surface(meshset), as_surface(layer)
    with default_workers(workers):
        found = stages.correspondence_of(other, surface, normalize, partial=partial, mirror=mirror)
    names = []
    for name, values in _without_crumbs(other).items():
        if name == COLORS:
            colors = found.transfer(values)
            set_colors(meshset, np.where(np.isnan(colors), carried_colors(values, [-1]), colors))
            names.append(name)
            continue
        brought = found.transfer(values)
        columns = {name: brought} if brought.ndim == 1 or brought.shape[1] == 3 else _columns(name, brought)
        names += [add_free(meshset.current_mesh(), column, part) for column, part in columns.items()]
    scalar = np.asarray(layer.vertex_scalar_array()) if layer.has_vertex_scalar() else np.zeros(1)
    if (scalar != scalar[0]).any():  # else it was never set
        set_scalar(meshset, "qgeo_transferred_scalar", found.transfer(scalar.astype(np.float64)))
        names.append("scalar")
    return {**_verdict(found), "attributes": names}


def compute_coord_by_deformation_transfer(
    meshset: Any, *, sourcemesh: int, posemesh: int, workers: int | None = None
) -> dict[str, Any]:
    """Move the current mesh as one layer moves into another, with no markers and in any triangulation.

    Parameters
    ----------
    sourcemesh : int
        Id of the layer that stands as the current mesh does.
    posemesh : int
        Id of the same mesh, with equal triangles, in the pose that the current mesh shall take.
    workers : int, optional
        Number of threads; by default all cores that this process may use.

    Returns
    -------
    dict
        ``maximum``: how far a vertex was moved at most.

    See Also
    --------
    qgeo_filters.transfer_deformation : what it does, and for many poses.
    """
    layers = (sourcemesh, "sourcemesh"), (posemesh, "posemesh")
    source, pose = (as_surface(meshset.mesh(checked_layer(meshset, layer, name))) for layer, name in layers)
    surface = as_surface(meshset)
    moved = transfer_deformation(source, [pose], surface, workers=workers)[0].vertices
    set_positions(meshset, moved)
    return {"maximum": float(np.linalg.norm(moved - surface.vertices, axis=1).max())}


def save_current_mesh_with_attributes(meshset: Any, file_name: str | os.PathLike[str]) -> dict[str, Any]:
    """Save the current mesh as PLY with all of its custom attributes, its colours and its scalar.

    PyMeshLab's ``save_current_mesh`` saves custom attributes only one by one by name. What is saved here comes back
    with `qgeo_filters.Surface.read` and with every reader of PLY properties; the scalar is the property ``quality``.

    Parameters
    ----------
    file_name : path
        Its name ends in .ply.

    Returns
    -------
    dict
        ``attributes``: the names of what was saved.
    """
    path = Path(file_name)
    if path.suffix.lower() != ".ply":
        raise ParameterError(f"file_name must end in .ply, the format that keeps attributes, got {path.name!r}")
    surface = as_surface(meshset)
    surface = Surface(surface.vertices, surface.faces, _without_crumbs(surface))
    added = {}
    layer = meshset.current_mesh()
    if layer.has_vertex_scalar() and "quality" not in surface.attributes:
        added["quality"] = np.asarray(layer.vertex_scalar_array(), dtype=np.float64)
    whole: Surface = surface.with_attributes(added)
    whole.write(path)
    return {"attributes": list(whole.attributes)}


METHODS = (
    compute_scalar_by_self_symmetry_per_vertex,
    compute_scalar_by_correspondence_per_vertex,
    transfer_attributes_by_correspondence_per_vertex,
    compute_coord_by_deformation_transfer,
    save_current_mesh_with_attributes,
)


def _check_quantity(quantity: Any, known: tuple[str, ...]) -> None:
    if quantity not in known:
        raise ParameterError(f"quantity must be one of {', '.join(known)}, got {quantity!r}")


def _verdict(found: MatchResult) -> dict[str, Any]:
    return {"confident": found.confident, "explanation": found.explanation, "score": found.score}


def _without_crumbs(surface: Surface) -> dict[str, np.ndarray]:
    """Attributes of a layer, apart from those that its colours were set by."""
    return {name: values for name, values in surface.attributes.items() if not is_packed_color(name)}


def _columns(name: str, values: np.ndarray) -> dict[str, np.ndarray]:
    if values.ndim != 2:
        raise MeshError(f"attribute {name!r} of shape {values.shape} cannot be held by PyMeshLab")
    return {f"{name}_{k}": values[:, k] for k in range(values.shape[1])}
