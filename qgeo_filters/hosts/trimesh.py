"""Trimesh objects: vertex attributes both ways."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.segments import segments
from qgeo_filters.io.raw_mesh import RawMesh
from qgeo_filters.surface import Surface


def read(mesh: Any, repair: bool) -> RawMesh:
    """Arrays of a Trimesh; its ``vertex_attributes`` are the attributes."""
    if not hasattr(mesh, "faces"):
        raise MeshError(
            f"a trimesh {type(mesh).__qualname__} is no mesh: pass scene.to_mesh(), or one of its geometries"
        )
    attributes = {name: np.asarray(values) for name, values in mesh.vertex_attributes.items()}
    return RawMesh(np.asarray(mesh.vertices), np.asarray(mesh.faces), attributes)


def write(mesh: Any, attributes: Mapping[str, np.ndarray]) -> Any:
    """Copy of the mesh with arrays added to its ``vertex_attributes``."""
    copy = mesh.copy()
    copy.vertex_attributes.update({name: values.copy() for name, values in attributes.items()})
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
