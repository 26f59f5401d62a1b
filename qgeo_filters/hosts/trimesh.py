"""Trimesh objects: vertex attributes and colours both ways."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.segments import segments
from qgeo_filters.io.raw_mesh import RawMesh
from qgeo_filters.surface import Surface

#: Name under which vertex colours, (n, 3) in [0, 1], come and go; the mesh keeps them as its own colours.
COLORS = "colors"


def read(mesh: Any, repair: bool) -> RawMesh:
    """Arrays of a Trimesh; its ``vertex_attributes`` are the attributes, and ``"colors"``, those that it shows."""
    if not hasattr(mesh, "faces"):
        raise MeshError(
            f"a trimesh {type(mesh).__qualname__} is no mesh: pass scene.to_mesh(), or one of its geometries"
        )
    attributes = {name: np.asarray(values) for name, values in mesh.vertex_attributes.items()}
    if COLORS not in attributes and mesh.visual.kind == "vertex":
        attributes[COLORS] = np.asarray(mesh.visual.vertex_colors)[:, :3] / 255
    return RawMesh(np.asarray(mesh.vertices), np.asarray(mesh.faces), attributes)


def write(mesh: Any, attributes: Mapping[str, np.ndarray]) -> Any:
    """Copy of the mesh with arrays added to its ``vertex_attributes``; colours are what it shows."""
    copy = mesh.copy()
    added = {name: values.copy() for name, values in attributes.items()}
    if COLORS in added and added[COLORS].shape == (len(copy.vertices), 3):
        from trimesh.visual import ColorVisuals

        shown = np.round(255 * np.clip(added.pop(COLORS), 0, 1)).astype(np.uint8)
        copy.visual = ColorVisuals(mesh=copy, vertex_colors=shown)
        copy.vertex_attributes.pop(COLORS, None)
    copy.vertex_attributes.update(added)
    return copy


def with_positions(mesh: Any, vertices: npt.NDArray[np.float64]) -> Any:
    """Copy of the mesh at other positions."""
    copy = mesh.copy()
    copy.vertices = vertices
    return copy


def make(surface: Surface) -> Any:
    """Trimesh with the vertices, faces and attributes of a surface."""
    import trimesh  # takes a while to load

    mesh = trimesh.Trimesh(np.array(surface.vertices), np.array(surface.faces), process=False)
    return write(mesh, surface.attributes)


def lines(curves: Sequence[npt.NDArray[np.float64]]) -> Any:
    """Path3D with a line for each curve."""
    from trimesh.path import Path3D
    from trimesh.path.entities import Line

    points, _ = segments(curves)
    starts = np.cumsum([0, *map(len, curves)])
    entities = [Line(np.arange(len(curve)) + start) for curve, start in zip(curves, starts, strict=False)]
    return Path3D(entities=entities, vertices=points, process=False)
