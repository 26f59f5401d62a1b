"""Custom attributes of one PyMeshLab mesh: their names, their values, and how wider ones are stored."""

from __future__ import annotations

import contextlib
import ctypes
import io
import os
import re
import sys
import threading
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from qgeo_filters.errors import MeshError, require_package

Key = tuple[str, str]
"""Per what ("vertex" or "face"), and the name."""

_KINDS = {"vs": "vertex", "vp": "vertex", "fs": "face", "fp": "face"}
_WIDE = re.compile(r"(qgeo_\w*)_(\d+)")
_lock = threading.Lock()


def custom_attributes(mesh: Any) -> tuple[dict[Key, np.ndarray], list[str]]:
    """Custom attributes of a mesh, (n,) for scalars and (n, 3) for points, and what is like the names of others.

    Names that are no identifiers are the others: PyMeshLab does not tell them as they are, so that the
    values cannot be had.
    """
    found: dict[Key, np.ndarray] = {}
    unnamed = []
    for code, name in _listed_names(mesh):
        kind = _KINDS[code]
        getter = "scalar_attribute_array" if code.endswith("s") else "point_attribute_matrix"
        try:
            found[kind, name] = np.array(getattr(mesh, f"{kind}_custom_{getter}")(name))
        except _exception():
            unnamed.append(name)
    return found, unnamed


def add_attributes(mesh: Any, attributes: Mapping[Key, np.ndarray]) -> None:
    """Add custom attributes to a mesh, in place; none of the names may exist already."""
    for (kind, name), values in attributes.items():
        what = "scalar" if values.ndim == 1 else "point"
        getattr(mesh, f"add_{kind}_custom_{what}_attribute")(np.array(values, dtype=np.float64), name)


def split(attributes: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same values in arrays of shape (n,) and (n, 3), which is all that PyMeshLab holds.

    Raises
    ------
    MeshError
        Names that PyMeshLab's own filters cannot stand, values that are no real numbers, three dimensions.
    """
    columns: dict[str, np.ndarray] = {}
    for name, values in attributes.items():
        if not re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII):
            raise MeshError(
                f"attribute {name!r} must be an identifier: other names break all function filters of PyMeshLab"
            )
        if values.dtype.kind not in "biuf" or values.ndim > 2:
            raise MeshError(
                f"attribute {name!r} of dtype {values.dtype} and shape {values.shape} cannot be held by PyMeshLab"
            )
        if values.ndim == 1 or values.shape[1] == 3:
            columns[name] = values
        elif values.shape[1] == 1:
            columns[name] = values[:, 0]
        else:
            columns.update({f"{name}_{j}": values[:, j] for j in range(values.shape[1])})
    return columns


def joined(attributes: Mapping[Key, np.ndarray]) -> dict[str, np.ndarray]:
    """Attributes per vertex, where scalars ``qgeo_name_0``, ``qgeo_name_1``, ... are one of shape (n, k) again.

    Other names are left alone: a user's own ``landmark_0`` and ``landmark_1`` stay two scalars.
    """
    scalars = {name: values for (kind, name), values in attributes.items() if kind == "vertex"}
    groups: dict[str, dict[int, np.ndarray]] = {}
    for name, values in scalars.items():
        match = _WIDE.fullmatch(name)
        if match and values.ndim == 1 and match[2] == str(int(match[2])):
            groups.setdefault(match[1], {})[int(match[2])] = values
    for name, columns in groups.items():
        width = len(columns)
        if width > 1 and name not in scalars and set(columns) == set(range(width)):
            for j in range(width):
                del scalars[f"{name}_{j}"]
            scalars[name] = np.column_stack([columns[j] for j in range(width)])
    return scalars


def _exception() -> type[Exception]:
    return require_package("pymeshlab", "meshlab", "a PyMeshLab mesh").PyMeshLabException


def _listed_names(mesh: Any) -> list[tuple[str, str]]:
    """Codes and names of the custom attributes: "vs" vertex scalar, "vp" vertex point, "fs", "fp".

    PyMeshLab has no call for this. Its PLY exporter has one switch per custom attribute, and prints all
    switches when asked for its parameters; the export itself then fails on a folder that is not there.
    """
    pymeshlab = require_package("pymeshlab", "meshlab", "a PyMeshLab mesh")
    scratch = pymeshlab.MeshSet()
    scratch.add_mesh(mesh)
    scratch.set_parameter_verbosity(True)
    printed = io.StringIO()
    nowhere = os.path.join(os.sep, "qgeo-no-such-folder", "names.ply")
    with _lock, _no_c_output(), contextlib.redirect_stdout(printed), contextlib.suppress(_exception()):
        scratch.save_current_mesh(nowhere)
    return re.findall(r"'__ca_([vf][sp])__([^']*)': ", printed.getvalue())


@contextlib.contextmanager
def _no_c_output() -> Iterator[None]:
    """Context in which the process's standard output goes nowhere: one line is printed from C++."""
    saved, null = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    try:
        _flush_c_output()
        os.dup2(null, 1)
        yield
    finally:
        _flush_c_output()
        os.dup2(saved, 1)
        os.close(saved)
        os.close(null)


def _flush_c_output() -> None:
    """Write what C has printed and not written yet: into a file or a pipe it writes at the end only."""
    with contextlib.suppress(OSError):  # no such library: the line comes late, as it did
        ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None).fflush(None)
