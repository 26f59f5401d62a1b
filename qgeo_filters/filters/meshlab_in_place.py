"""Scalars, colours and positions of a layer of a ``pymeshlab.MeshSet``, changed in place.

PyMeshLab sets scalars and colours from expressions alone, and an expression can read a custom attribute, which can be
neither removed nor replaced by an array: so the first free ``name``, ``name_v2``, ``name_v3`` ... is used.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import ParameterError, require_package
from qgeo_filters.hosts.meshlab import move_current

#: The colours of a mesh as one number for each vertex, red * 65536 + green * 256 + blue, as in the files of PCL.
PACKED_COLORS = "qgeo_rgb"

_MOST_VERSIONS = 10_000


def set_scalar(meshset: Any, name: str, values: np.ndarray) -> None:
    """Set the scalar (the "quality") of the vertices of the current mesh."""
    meshset.compute_scalar_by_function_per_vertex(q=add_free(meshset.current_mesh(), name, values))


def set_colors(meshset: Any, colors: npt.NDArray[np.float64]) -> None:
    """Set the colours of the vertices of the current mesh: (n, 3) in [0, 1]."""
    red, green, blue = np.round(255 * np.clip(colors, 0.0, 1.0)).T
    name = add_free(meshset.current_mesh(), PACKED_COLORS, 65536 * red + 256 * green + blue)
    # Expressions know how to round, and not how to cut off.
    high, middle = f"rint({name} / 65536 - 0.5 + 1 / 131072)", f"rint({name} / 256 - 0.5 + 1 / 512)"
    meshset.compute_color_by_function_per_vertex(
        x=high, y=f"{middle} - 256 * {high}", z=f"{name} - 256 * {middle}", a="255"
    )


def is_packed_color(name: str) -> bool:
    """Whether a custom attribute of this name is there because colours were set."""
    return re.fullmatch(rf"{PACKED_COLORS}(_v\d+)?", name) is not None


def set_positions(meshset: Any, positions: npt.NDArray[np.float64]) -> None:
    """Move the vertices of the current mesh; normals are computed anew."""
    moved = meshset.current_mesh_id()
    helper = move_current(meshset, positions)
    meshset.set_current_mesh(helper)
    meshset.delete_current_mesh()
    meshset.set_current_mesh(moved)


def add_free(mesh: Any, name: str, values: np.ndarray) -> str:
    """Name of the custom attribute, scalars (n,) or points (n, 3), that was added: the first that was free."""
    pymeshlab = require_package("pymeshlab", "meshlab", "a PyMeshLab mesh")
    array = np.array(values, dtype=np.float64)
    add = mesh.add_vertex_custom_point_attribute if array.ndim == 2 else mesh.add_vertex_custom_scalar_attribute
    version, free = 1, name
    while True:
        try:
            add(array, free)
            return free
        except pymeshlab.PyMeshLabException:
            version += 1
            free = f"{name}_v{version}"
            if version > _MOST_VERSIONS:
                raise


@contextmanager
def as_current(meshset: Any, layer: int) -> Iterator[None]:
    """Context in which another layer is the current mesh."""
    before = meshset.current_mesh_id()
    meshset.set_current_mesh(layer)
    try:
        yield
    finally:
        meshset.set_current_mesh(before)


def checked_layer(meshset: Any, layer: Any, name: str) -> int:
    """The number of a layer, or `ParameterError`."""
    there = sorted(mesh.id() for mesh in meshset)
    if not isinstance(layer, (int, np.integer)) or isinstance(layer, bool) or layer not in there:
        raise ParameterError(f"{name} must be a layer of the MeshSet, one of {there}, got {layer!r}")
    return int(layer)
