"""glTF, text or binary: equal positions, which it repeats at seams, become one vertex."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError, require_package
from qgeo_filters.io.damage import DAMAGED_FILE
from qgeo_filters.io.raw_mesh import RawMesh, weld


def read(path: Path, repair: bool) -> RawMesh:
    """Arrays of all triangle meshes of a glTF scene, placed as the scene places them."""
    trimesh = require_package("trimesh", "trimesh", f"reading {path.name}")
    try:
        scene = trimesh.load_scene(path, process=False)
        mesh = scene.to_mesh()
    except DAMAGED_FILE as error:
        raise MeshError(f"not a readable glTF file ({error or type(error).__name__})") from error
    if len(mesh.faces) == 0:
        raise MeshError("the scene has no triangles")
    points, index = weld(np.asarray(mesh.vertices, dtype=np.float64))
    return RawMesh(points, index[np.asarray(mesh.faces)])


def write(path: Path, vertices: FloatArray, faces: IntArray) -> None:
    """Write as binary glTF, in float32."""
    trimesh = require_package("trimesh", "trimesh", f"writing {path.name}")
    mesh = trimesh.Trimesh(vertices, faces, process=False, validate=False)
    with atomic_write(path) as file:
        file.write(mesh.export(file_type="glb"))
