"""CSV: a row for each vertex, with its position and every attribute, for spreadsheets, R and pandas."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError
from qgeo_filters.io.vertex_colors import as_bytes, is_color

_COLORS = ("red", "green", "blue", "alpha")


def table_text(header: Any, rows: Any) -> bytes:
    """CSV of a header and rows; None is an empty cell, floats have the digits that give back every bit."""
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return out.getvalue().encode("utf-8", errors="backslashreplace")


def write(path: Path, vertices: FloatArray, faces: IntArray, attributes: Mapping[str, np.ndarray]) -> None:
    """Write the vertices, numbered from 0; faces have no place in it, and cells of NaN are empty.

    Raises
    ------
    MeshError
        An attribute that holds no real numbers.
    """
    columns: dict[str, list[Any]] = {"vertex": list(range(len(vertices)))}
    columns |= {axis: values.tolist() for axis, values in zip("xyz", vertices.T, strict=True)}
    for name, values in attributes.items():
        if values.dtype.kind not in "biuf":
            raise MeshError(f"attribute {name!r} of dtype {values.dtype} has no place in a table of numbers")
        if is_color(name, values):
            parts = dict(zip(_COLORS, as_bytes(values).T, strict=False))
        else:
            table = values.reshape(len(values), -1)
            parts = {name if values.ndim == 1 else f"{name}_{k}": column for k, column in enumerate(table.T)}
        columns |= {name: _cells(column) for name, column in parts.items()}
    with atomic_write(path) as file:
        file.write(table_text(columns, zip(*columns.values(), strict=True)))


def _cells(column: np.ndarray) -> list[Any]:
    cells = column.astype(int if column.dtype.kind == "b" else column.dtype).tolist()
    return [None if cell != cell else cell for cell in cells]
