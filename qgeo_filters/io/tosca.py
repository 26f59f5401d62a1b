"""TOSCA's pair of text files: ``.vert`` and ``.tri``, which counts from 1."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_path
from qgeo_filters.errors import MeshError
from qgeo_filters.io.number_files import number_table, whole_numbers
from qgeo_filters.io.raw_mesh import RawMesh


def read_pair(path: Path, repair: bool) -> RawMesh:
    """Arrays of a ``.vert`` and its ``.tri`` file, given either."""
    files = path.with_suffix(".vert"), path.with_suffix(".tri")
    for file in files:
        if not file.is_file():
            raise MeshError(f"{file.name} is missing beside it")
    vertices, faces = map(_three_columns, files)
    return RawMesh(vertices, whole_numbers(faces, files[1].name) - 1)


def write_pair(path: Path, vertices: FloatArray, faces: IntArray) -> None:
    """Write both files with 17 digits, which give back every bit."""
    with atomic_path(path.with_suffix(".vert")) as vert, atomic_path(path.with_suffix(".tri")) as tri:
        np.savetxt(vert, vertices, fmt="%.17g")
        np.savetxt(tri, faces.astype(np.int64) + 1, fmt="%d")


def _three_columns(path: Path) -> FloatArray:
    table = number_table(path)
    if table.shape[1] != 3:
        raise MeshError(f"{path.name} has {table.shape[1]} columns, expected 3")
    return table
