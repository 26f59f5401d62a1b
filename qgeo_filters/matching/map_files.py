"""A match in files: a table of the map as CSV, and all of it as NumPy's .npz."""

from __future__ import annotations

import json
from dataclasses import MISSING, fields
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.io.number_files import saved_arrays, whole_numbers
from qgeo_filters.io.vertex_table import table_text
from qgeo_filters.matching.maps.barycentric import BarycentricMap
from qgeo_filters.matching.match_log import LoggedMap, MatchLog
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

#: Name of the array in a file that holds what is no array, as JSON.
DOCUMENT = "qgeo_match"
_VERSION = 1
_TYPES: dict[str, type] = {"float": float, "int": int, "bool": bool, "str": str, "None": type(None)}
_LARGEST = 1e100
_PLAIN = (str, int, float, bool, list, tuple, dict, type(None))

COLUMNS = (
    "x_vertex", "y_vertex", "y_x", "y_y", "y_z", "y_face", "weight_0", "weight_1", "weight_2", "distortion",
)  # fmt: skip


def write_map_table(
    path: str | PathLike[str], p2p: IndexArray, barycentric: BarycentricMap, y: Surface, distortion: FloatArray
) -> None:
    """Write a row for each vertex of X, see `MatchResult.to_csv`."""
    numbers = np.column_stack([barycentric.pulled_back(y.vertices), barycentric.coordinates, distortion]).astype(object)
    numbers[np.isnan(numbers.astype(np.float64))] = None
    rows = zip(p2p.tolist(), barycentric.faces.tolist(), numbers.tolist(), strict=True)
    with atomic_write(path) as file:
        file.write(table_text(COLUMNS, ([i, v, *n[:3], f, *n[3:]] for i, (v, f, n) in enumerate(rows))))


def arrays_of(result: Any) -> dict[str, np.ndarray]:
    """All fields of a dataclass of arrays, numbers, surfaces, maps and a log, as arrays by name.

    A surface ``x`` becomes ``x_vertices``, ``x_faces`` and ``x_attribute_NAME``, a map ``b`` the arrays ``b_faces``,
    ``b_corners`` and ``b_coordinates``; what is no array is in one JSON text.

    Raises
    ------
    ParameterError
        An attribute of a surface that holds Python objects.
    """
    found: dict[str, np.ndarray] = {}
    others: dict[str, Any] = {}
    for field in fields(result):
        name, value = field.name, getattr(result, field.name)
        if isinstance(value, Surface):
            found |= {f"{name}_vertices": value.vertices, f"{name}_faces": value.faces}
            found |= {f"{name}_attribute_{key}": array for key, array in value.attributes.items()}
        elif isinstance(value, BarycentricMap):
            found |= {f"{name}_{part.name}": getattr(value, part.name) for part in fields(value)}
        elif isinstance(value, MatchLog):
            others[name] = value.table()
        elif isinstance(value, (np.ndarray, np.generic, float, int)):
            found[name] = np.asarray(value)
        elif isinstance(value, _PLAIN):
            others[name] = value
        else:
            raise TypeError(f"{name} is a {type(value).__name__}, which has no place in a file")
    objects = [name for name, array in found.items() if array.dtype.hasobject]
    if objects:
        raise ParameterError(f"{objects[0]} holds Python objects, which no .npz file holds safely: leave it out")
    found[DOCUMENT] = np.array(json.dumps({"version": _VERSION, **others}))
    return found


def write_arrays(path: str | PathLike[str], arrays: dict[str, np.ndarray]) -> None:
    """Write an .npz file, whole or not at all."""
    with atomic_write(path) as file:
        np.savez(file, **arrays)  # type: ignore[arg-type]


def read_match(path: str | PathLike[str], kind: Any) -> dict[str, Any]:
    """Fields of a dataclass that `arrays_of` made arrays of, checked against each other.

    Raises
    ------
    MeshError
        No such file, a damaged one, or one whose arrays do not fit together; the message starts with the path.
    """
    file = Path(path)
    with path_in_errors(file):
        arrays = saved_arrays(file)
        return fields_of(arrays, _document(arrays), kind)


def fields_of(arrays: dict[str, np.ndarray], others: dict[str, Any], kind: Any) -> dict[str, Any]:
    """Fields of a dataclass, checked against each other, from its arrays and from what else `arrays_of` found.

    Raises
    ------
    MeshError
        Arrays that are missing, or do not fit together.
    """
    values = {field.name: _value(field.name, str(field.type), arrays, others) for field in fields(kind)}
    needed = [f.name for f in fields(kind) if f.default is MISSING and f.default_factory is MISSING]
    lacking = [name for name in needed if values[name] is MISSING]
    if lacking:
        raise MeshError(f"the match has no {lacking[0]}: it was saved by another version of the package")
    values = {name: value for name, value in values.items() if value is not MISSING}
    _check(values)
    return values


def _document(arrays: dict[str, np.ndarray]) -> dict[str, Any]:
    text = arrays.get(DOCUMENT)
    if text is None or text.dtype.kind != "U" or text.ndim:
        raise MeshError("no match that to_npz wrote")
    try:
        document = json.loads(str(text))
    except (ValueError, RecursionError) as error:
        raise MeshError(f"{DOCUMENT} is no JSON") from error
    if not isinstance(document, dict) or document.get("version") != _VERSION:
        raise MeshError("the match was saved by another version of the package")
    return document


def _value(name: str, kind: str, arrays: dict[str, np.ndarray], others: dict[str, Any]) -> Any:
    """Value of a field of a type, as an annotation has it; MISSING if the file has none."""
    if f"{name}_vertices" in arrays:
        prefix = f"{name}_attribute_"
        attributes = {key.removeprefix(prefix): array for key, array in arrays.items() if key.startswith(prefix)}
        vertices, faces = arrays[f"{name}_vertices"], _array(arrays, f"{name}_faces")
        if vertices.ndim != 2 or faces.ndim != 2:
            raise MeshError(f"the vertices and faces of {name} must be tables")
        return Surface(vertices, faces, attributes)
    if f"{name}_coordinates" in arrays:
        faces, corners = (whole_numbers(_array(arrays, f"{name}_{part}"), name) for part in ("faces", "corners"))
        return BarycentricMap(frozen(faces), frozen(corners), frozen(np.array(arrays[f"{name}_coordinates"])))
    if kind == "MatchLog":
        return _log(others.get(name))
    value: Any = others.get(name, MISSING)
    if name in arrays:
        value = arrays[name].item() if arrays[name].ndim == 0 else frozen(arrays[name].copy())
    if isinstance(value, list):
        value = tuple(value)  # JSON knows no tuples
    if kind == "float" and type(value) is int:
        value = float(value)
    expected = tuple(np.ndarray if "Array" in part else _TYPES.get(part, object) for part in kind.split(" | "))
    if value is not MISSING and not isinstance(value, expected):
        raise MeshError(f"{name} of the match must be {kind}, got {type(value).__name__}")
    return value


def _array(arrays: dict[str, np.ndarray], name: str) -> np.ndarray:
    if name not in arrays:
        raise MeshError(f"the match has no {name}")
    return arrays[name]


def _log(rows: Any) -> MatchLog:
    log, names = MatchLog(), {field.name for field in fields(LoggedMap)}
    for row in rows if isinstance(rows, list) else []:
        if not isinstance(row, dict) or not {"number", "proposed_by", "mean_distortion"} <= row.keys() <= names:
            raise MeshError("the log of the match is damaged")
        log.maps.append(LoggedMap(**row))
    return log


def _check(values: dict[str, Any]) -> None:
    """Raise where the arrays of a match do not fit its surfaces."""
    x, y, place = values["x"], values["y"], values["barycentric"]
    if not (isinstance(x, Surface) and isinstance(y, Surface) and isinstance(place, BarycentricMap)):
        raise MeshError("the match has no surfaces, or no map between them")
    _indices(values["p2p"], "p2p", x.n_vertices, y.n_vertices)
    _indices(values["inverse"], "inverse", y.n_vertices, x.n_vertices)
    _indices(place.faces, "barycentric_faces", x.n_vertices, y.n_faces)
    for name, array, shape in (
        ("distortion", values["distortion"], (x.n_vertices,)),
        ("positions", values["positions"], (x.n_vertices, 3)),
        ("barycentric_coordinates", place.coordinates, (x.n_vertices, 3)),
    ):
        if not isinstance(array, np.ndarray) or array.shape != shape or array.dtype.kind != "f":
            raise MeshError(f"{name} of the match must be {shape} floating-point numbers")
        if (np.abs(array) > _LARGEST).any():
            raise MeshError(f"{name} of the match leave float64 when they are squared")
    known = place.faces >= 0
    if not np.array_equal(place.corners, np.where(known[:, None], y.faces[place.faces], -1)):
        raise MeshError("the corners of the match are not those of its faces")


def _indices(array: Any, name: str, count: int, limit: int) -> None:
    whole: npt.NDArray[np.int64] = whole_numbers(array, f"{name} of the match")
    if whole.shape != (count,) or whole.min(initial=0) < -1 or whole.max(initial=-1) >= limit:
        raise MeshError(f"{name} of the match must be {count} numbers from -1 to {limit - 1}")
