"""Binary glTF, written: colours of vertices, and attributes of one's own beside them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.io.vertex_colors import COLORS, is_color, linear_bytes

_WIDEST = 4  # columns that glTF has a type for


def is_kept(name: str, values: np.ndarray) -> bool:
    """Whether a glTF file holds an attribute: colours, and numbers that float32 has, up to four for a vertex."""
    if is_color(name, values):
        return True
    narrow = values.ndim == 1 or (values.ndim == 2 and 2 <= values.shape[1] <= _WIDEST)
    if not narrow or values.dtype.kind not in "biuf":
        return False
    with np.errstate(over="ignore"):
        single = values.astype(np.float32)
    whole = values.dtype.kind != "f"
    return bool(np.isfinite(single).all()) and (not whole or bool((single.astype(values.dtype) == values).all()))


def write(path: Path, vertices: FloatArray, faces: IntArray, attributes: Mapping[str, np.ndarray]) -> None:
    """Write as binary glTF, in float32; attributes that are not ``colors`` get an underscore in front, as glTF asks."""
    import trimesh  # takes a while to load, and few write glTF

    others = {name: values for name, values in attributes.items() if name != COLORS}
    if COLORS in attributes:
        mesh = colored_mesh(vertices, faces, attributes[COLORS])
    else:
        mesh = trimesh.Trimesh(vertices, faces, process=False, validate=False)
    for name, values in others.items():
        mesh.vertex_attributes[f"_{name}"] = values.astype(np.float32)
    with atomic_write(path) as file:
        file.write(mesh.export(file_type="glb"))


def colored_mesh(vertices: FloatArray, faces: np.ndarray, colors: np.ndarray, normals: FloatArray | None = None) -> Any:
    """Mesh of trimesh's with a dull material and a colour, sRGB as bytes or from 0 to 1, for each vertex."""
    import trimesh

    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=[255, 255, 255, 255], metallicFactor=0.0, roughnessFactor=0.8, doubleSided=True
    )
    visual = trimesh.visual.TextureVisuals(material=material)
    visual.vertex_attributes["color"] = linear_bytes(colors)
    return trimesh.Trimesh(vertices, faces, vertex_normals=normals, visual=visual, process=False, validate=False)
