"""TOSCA's two forms: a ``.vert`` / ``.tri`` pair of text files and MATLAB's ``.mat``, both counting from 1."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_path
from qgeo_filters.errors import MeshError
from qgeo_filters.io.damage import DAMAGED_FILE
from qgeo_filters.io.raw_mesh import RawMesh

_MAT_ERRORS: tuple[type[Exception], ...] = (scipy.io.matlab.MatReadError, *DAMAGED_FILE)


def read_pair(path: Path, repair: bool) -> RawMesh:
    """Arrays of a ``.vert`` and its ``.tri`` file, given either."""
    files = path.with_suffix(".vert"), path.with_suffix(".tri")
    for file in files:
        if not file.is_file():
            raise MeshError(f"{file.name} is missing beside it")
    return RawMesh(_table(files[0], np.float64), _table(files[1], np.int64) - 1)


def read_mat(path: Path, repair: bool) -> RawMesh:
    """Arrays of the variable with fields X, Y, Z, TRIV (or VERT, TRIV), or of such variables themselves."""
    try:
        content = scipy.io.loadmat(path, squeeze_me=True, struct_as_record=False)
    except NotImplementedError as error:
        raise MeshError("MATLAB 7.3 files are not read; save with -v7") from error
    except _MAT_ERRORS as error:
        raise MeshError(f"not a readable MATLAB file ({error})") from error
    candidates = [content, *(vars(value) for value in content.values() if hasattr(value, "_fieldnames"))]
    for fields in candidates:
        upper = {name.upper(): value for name, value in fields.items()}
        if "TRIV" not in upper:
            continue
        if "VERT" in upper:
            return RawMesh(upper["VERT"], np.asarray(upper["TRIV"], dtype=np.int64) - 1)
        if {"X", "Y", "Z"} <= set(upper):
            positions = np.column_stack([np.ravel(upper[axis]) for axis in "XYZ"])
            return RawMesh(positions, np.asarray(upper["TRIV"], dtype=np.int64) - 1)
    names = ", ".join(name for name in content if not name.startswith("__")) or "nothing"
    raise MeshError(f"no mesh with fields X, Y, Z, TRIV (or VERT, TRIV) found; the file holds {names}")


def write_pair(path: Path, vertices: FloatArray, faces: IntArray) -> None:
    """Write both files with 17 digits, which give back every bit."""
    with atomic_path(path.with_suffix(".vert")) as vert, atomic_path(path.with_suffix(".tri")) as tri:
        np.savetxt(vert, vertices, fmt="%.17g")
        np.savetxt(tri, faces.astype(np.int64) + 1, fmt="%d")


def write_mat(path: Path, vertices: FloatArray, faces: IntArray) -> None:
    """Write the variable ``surface`` with fields X, Y, Z, TRIV."""
    x, y, z = vertices.T[:, :, None]
    fields: dict[str, Any] = {"X": x, "Y": y, "Z": z, "TRIV": faces.astype(np.float64) + 1}
    with atomic_path(path) as temporary:
        scipy.io.savemat(temporary, {"surface": fields}, appendmat=False)


def _table(path: Path, dtype: type) -> np.ndarray:
    if path.stat().st_size == 0:
        raise MeshError(f"{path.name} is empty")
    try:
        table: np.ndarray = np.loadtxt(path, dtype=dtype, ndmin=2)
    except ValueError as error:
        raise MeshError(f"{path.name} is no table of numbers ({error})") from error
    if table.shape[1] != 3:
        raise MeshError(f"{path.name} has {table.shape[1]} columns, expected 3")
    return table
