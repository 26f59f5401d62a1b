"""Files of simulation codes: VTK's ``.vtk``, ``.vtp``, ``.vtu`` and Gmsh's ``.msh``.

VTK and meshio read them, in a process of their own; `grid_process` says why.
"""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np

from qgeo_filters.errors import MeshError, reason, require_package
from qgeo_filters.io import grid_process
from qgeo_filters.io.cells import cell_triangles
from qgeo_filters.io.damage import DAMAGED_FILE
from qgeo_filters.io.raw_mesh import RawMesh

_SECONDS, _BYTES_A_SECOND = 60, 1_000_000


def read_vtk(path: Path, repair: bool) -> RawMesh:
    """Arrays of a VTK file of polygons or of an unstructured grid; its point data are attributes."""
    require_package("vtkmodules", "pyvista", f"reading {path.name}")
    return _read(path, "vtk", repair)


def read_gmsh(path: Path, repair: bool) -> RawMesh:
    """Arrays of a Gmsh file, text or binary, version 2 or 4; its node data are attributes."""
    require_package("meshio", "files", f"reading {path.name}")
    return _read(path, "gmsh", repair)


def _read(path: Path, kind: str, repair: bool) -> RawMesh:
    arrays = _arrays(path, kind)
    faces, notes = cell_triangles(arrays["points"], arrays["kinds"], arrays["sizes"], arrays["corners"], repair)
    attributes = {name or f"values_{i}": arrays[f"values_{i}"] for i, name in enumerate(arrays["names"].tolist())}
    return RawMesh(arrays["points"], faces, attributes, notes)


def _arrays(path: Path, kind: str) -> dict[str, np.ndarray]:
    """What `grid_process` finds in a file."""
    program = [sys.executable, "-P", grid_process.__file__, kind, str(path.absolute())]
    try:
        done = subprocess.run(
            program,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_SECONDS + path.stat().st_size / _BYTES_A_SECOND,
            check=False,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        )
    except subprocess.TimeoutExpired as error:
        raise MeshError(
            f"not a readable {path.suffix} file (its reader was stopped after {error.timeout:.0f} s)"
        ) from error
    if done.returncode:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        died = done.returncode < 0 or not lines
        why = f"its reader ended by {_end(done.returncode)}" if died else lines[-1]
        raise MeshError(f"not a readable {path.suffix} file ({why})")
    try:
        with np.load(io.BytesIO(done.stdout), allow_pickle=False) as arrays:
            return dict(arrays)
    except DAMAGED_FILE as error:
        raise MeshError(f"not a readable {path.suffix} file ({reason(error)})") from error


def _end(code: int) -> str:
    return signal.Signals(-code).name if code < 0 else f"exit code {code}"
