"""Checks of arrays that come from outside: what is wrong, at which index, how often."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IntArray, RepairOption
from qgeo_filters.array_likes import as_array, vertex_number
from qgeo_filters.errors import MeshError, ParameterError


def frozen(array: np.ndarray) -> np.ndarray:
    """The same array, read-only from now on; that of the result cannot be undone through its flags."""
    array.setflags(write=False)
    return array.view()  # NumPy lets only the owner of the memory be made writeable again


def owned(array: np.ndarray) -> np.ndarray:
    """Read-only array of its own memory, so that nothing else can write there."""
    return frozen(array if array.base is None else array.copy())


def listed(indices: npt.ArrayLike, limit: int = 5) -> str:
    """First few indices for an error message."""
    values = np.atleast_1d(np.asarray(indices)).tolist()
    return ", ".join(map(str, values[:limit])) + (", ..." if len(values) > limit else "")


#: Widths of a mesh between which all that is computed of it stays in float64: geodesic graphs take sixth powers of
#: edges, which may be a ten-thousandth as long, and are silently wrong beyond.
NARROWEST, WIDEST = 1e-45, 1e50


def checked_vertices(vertices: npt.ArrayLike) -> FloatArray:
    """Copy of the coordinates as (n, 3) float64, or `MeshError`."""
    try:
        given = as_array(vertices)
        is_complex = given.dtype.kind == "c"
        array = np.array(given.real if is_complex else given, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise MeshError(f"vertices must be numbers in rows of three: {error}") from error
    if is_complex:
        raise MeshError("vertices must be real numbers, got complex ones")
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"vertices must have shape (n, 3), got {array.shape}")
    if len(array) == 0:
        raise MeshError("the mesh has no vertices")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if bad.size:
        raise MeshError(
            f"vertices[{bad[0]}] is {array[bad[0]].tolist()}: coordinates must be finite "
            f"({bad.size} such {'vertex' if bad.size == 1 else 'vertices'})"
        )
    extent = float(np.ptp(array, axis=0).max())
    if not extent < WIDEST or (0 < extent < NARROWEST):
        raise MeshError(f"the mesh is {extent:g} units wide, where powers of lengths leave float64; rescale it")
    return array


def checked_faces(faces: npt.ArrayLike, n_vertices: int) -> IntArray:
    """Copy of the vertex indices as (m, 3) int32, or `MeshError`."""
    try:
        array = as_array(faces)
    except ValueError as error:  # rows of different lengths
        raise MeshError(f"faces must be whole numbers in rows of three: {error}") from error
    if array.ndim != 2 or array.shape[1] != 3:
        hint = " (quadrilaterals? triangulate the mesh first)" if array.ndim == 2 and array.shape[1] == 4 else ""
        raise MeshError(f"faces must have shape (m, 3), got {array.shape}{hint}")
    if len(array) == 0:
        raise MeshError("the mesh has no faces")
    if array.dtype.kind not in "iu" and (array.dtype.kind != "f" or not np.all(array == np.floor(array))):
        raise MeshError(f"faces must hold whole numbers, got dtype {array.dtype}")
    outside = np.flatnonzero(((array < 0) | (array >= n_vertices)).any(axis=1))
    if outside.size:
        face = array[outside[0]]
        vertex = int(face[(face < 0) | (face >= n_vertices)][0])
        raise MeshError(
            f"faces[{outside[0]}] refers to vertex {vertex}, but there are {n_vertices} vertices, numbered "
            f"from 0 ({outside.size} such {'face' if outside.size == 1 else 'faces'})"
        )
    repeated = np.flatnonzero((array == np.roll(array, 1, axis=1)).any(axis=1))
    if repeated.size:
        raise MeshError(
            f"faces[{repeated[0]}] = {array[repeated[0]].astype(int).tolist()} names a vertex twice "
            f"({repeated.size} such {'face' if repeated.size == 1 else 'faces'}); remove them, "
            "or load the mesh with repair=True"
        )
    return np.array(array, dtype=np.int32, order="C")


def checked_attributes(attributes: Mapping[str, npt.ArrayLike], n_vertices: int) -> Mapping[str, np.ndarray]:
    """Read-only copies of per-vertex values, or `MeshError` where a length is not the number of vertices."""
    checked = {}
    for name, values in attributes.items():
        array = np.array(as_array(values))
        if array.ndim == 0 or len(array) != n_vertices:
            raise MeshError(f"attribute {name!r} has shape {array.shape}, but there are {n_vertices} vertices")
        checked[str(name)] = frozen(array)
    return MappingProxyType(checked)


def real_numbers(values: npt.ArrayLike, name: str) -> FloatArray:
    """Copy of the numbers as float64, of any shape, or `ParameterError`."""
    try:
        array = as_array(values)
    except ValueError as error:
        raise ParameterError(f"{name} must be numbers in an array: {error}") from error
    if array.dtype.kind not in "iuf":
        raise ParameterError(f"{name} must be real numbers, got an array of {array.dtype}")
    return np.array(array, dtype=np.float64)


def checked_repair(repair: RepairOption) -> RepairOption:
    """The option as it is, or `ParameterError`."""
    if isinstance(repair, (bool, np.bool_)) or (isinstance(repair, str) and repair in ("auto", "force", "wrap")):
        return repair
    raise ParameterError(f"repair must be 'auto', True, False, 'force' or 'wrap', got {repair!r}")


def checked_count(value: int, low: int, high: int | None, name: str, most: str | None = None) -> int:
    """The number as an int from low to high, or `ParameterError`; no bool, no float.

    Parameters
    ----------
    high : int or None
        None: no bound.
    name : str
        The argument, subject of the error's sentence.
    most : str, optional
        What the upper bound is, for that sentence: "the 20 eigenpairs of the spectrum".
    """
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if whole and low <= value and (high is None or value <= high):
        return int(value)
    if high is None:
        raise ParameterError(f"{name} must be a whole number, at least {low}, got {value!r}")
    raise ParameterError(f"{name} must be between {low} and {most or high}, got {value!r}")


def checked_index(index: int, count: int, name: str) -> int:
    """The index as an int in range, or `MeshError`."""
    index = vertex_number(index)
    if not isinstance(index, (int, np.integer)) or isinstance(index, bool):
        raise MeshError(f"{name} must be a vertex index, got {index!r}")
    if not 0 <= index < count:
        raise MeshError(f"{name} is vertex {index}, but there are {count} vertices, numbered from 0")
    return int(index)


def checked_indices(indices: npt.ArrayLike, count: int, name: str, *, missing: bool = False) -> npt.NDArray[np.int64]:
    """One-dimensional array of vertex indices in range, or `MeshError`; with ``missing`` -1 stands for none."""
    array = np.atleast_1d(as_array(indices))
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise MeshError(f"{name} must be vertex indices in one dimension, got {array.dtype} of shape {array.shape}")
    bad = np.flatnonzero((array < (-1 if missing else 0)) | (array >= count))
    if bad.size:
        raise MeshError(
            f"{name}[{bad[0]}] is vertex {array[bad[0]]}, but there are {count} vertices, numbered from 0 "
            f"({bad.size} such {'index' if bad.size == 1 else 'indices'})"
        )
    return array.astype(np.int64)
