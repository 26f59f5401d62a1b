"""Landmarks in tables of text: names, positions and vertices in columns, with a header or without."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from io import StringIO
from pathlib import Path

import numpy as np

from qgeo_filters.errors import MeshError, reason
from qgeo_filters.io.landmark_text import (
    MISSING,
    LandmarkSet,
    Point,
    position,
    text_of,
    whole_number,
    without_head,
    words_of,
)
from qgeo_filters.io.landmarks import Frame, Landmarks

_NAMES = ("label", "name", "landmark", "point", "marker", "title", "id")  # the first of these that there is
_VERTICES = ("vertex", "vertex_index", "vertex_id", "vertexid", "vertex index", "vertex id")
_COORDINATE = re.compile(r"(?:pos|position|coord)?[ _.]*([xyz])[ _.]*(?:coord|mm|\(mm\)|\[mm\])?")
_AXES: dict[str, Frame | None] = {"xyz": None, "ras": "RAS", "lps": "LPS"}  # Slicer's tables: r, a, s
_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")

Rows = list[tuple[int, list[str]]]


def read(path: Path) -> list[LandmarkSet]:
    """Landmarks of a table with commas, semicolons, tabs or blanks; comments, which begin with ``#``, may precede it.

    A header names the columns: label or name, x, y, z (or r, a, s; l, p, s), vertex; others are not looked at. Without
    one the rows hold x y z, name x y z, a vertex, or name and vertex.
    """
    rows = table_rows(text_of(path.read_bytes()))
    if not rows:
        raise MeshError("the file holds no landmarks")
    header = [_plain(cell) for cell in rows[0][1]]
    columns = _columns(header)
    if columns is None:
        return [LandmarkSet((), _landmarks(rows, _columns_by_count(rows[0]), None))]
    frame = next((frame for axes, frame in _AXES.items() if set(axes) <= set(header)), None)
    return [LandmarkSet((), _landmarks(rows[1:], columns, frame))]


def write(path: Path, landmarks: Landmarks) -> bytes:
    """Table with a header: name, x, y, z and vertex, as far as they are known; CSV, or separated by tabs."""
    placed = bool(np.isfinite(landmarks.points).any()) or not (landmarks.vertices >= 0).any()
    meshed = bool((landmarks.vertices >= 0).any())
    out = StringIO()
    writer = csv.writer(out, delimiter="," if path.suffix.lower() == ".csv" else "\t", lineterminator="\n")
    writer.writerow(["name", *("xyz" if placed else ""), *(["vertex"] if meshed else [])])
    for name, point, vertex in zip(landmarks.names, landmarks.points, landmarks.vertices.tolist(), strict=True):
        writer.writerow([name, *(words_of(point, "NA") if placed else []), *([vertex] if meshed else [])])
    return out.getvalue().encode("utf-8", errors="backslashreplace")


def table_rows(text: str) -> Rows:
    """Cells of the rows that hold any, each with the number of its line."""
    lines = without_head(text).split("\n")
    first = next((line for line in lines if line.strip()), "")
    mark = next((mark for mark in "\t;," if mark in first), None)
    if mark is None:
        return [(i + 1, cells) for i, line in enumerate(lines) if (cells := line.split())]
    rows = csv_rows(lines, mark)
    if mark != ",":  # German and French tables: 1,5 is a number
        rows = [(i, [c.replace(",", ".") if _COMMA.fullmatch(c) else c for c in cells]) for i, cells in rows]
    return rows


def csv_rows(lines: Sequence[str], mark: str) -> Rows:
    """Cells, without white space around them, of the rows in which one is not empty."""
    reader = csv.reader((f"{line}\n" for line in lines), delimiter=mark, skipinitialspace=True)
    rows = []
    try:
        for cells in reader:
            stripped = [cell.strip() for cell in cells]
            if any(stripped):
                rows.append((reader.line_num, stripped))
    except csv.Error as error:
        raise MeshError(f"line {reader.line_num}: {reason(error)}") from error
    return rows


def _plain(cell: str) -> str:
    """Name of a column, without capitals; x for whatever a column of x is called."""
    name = cell.strip().strip("\"'").lower()
    coordinate = _COORDINATE.fullmatch(name)
    return coordinate[1] if coordinate else name


def _columns(header: list[str]) -> dict[str, list[int]] | None:
    """Places of the columns of a header by what they hold; None if it is no header."""
    found: dict[str, list[int]] = {}
    axes = next((axes for axes in _AXES if set(axes) <= set(header)), "")
    if axes:
        found["position"] = [header.index(axis) for axis in axes]
    for what, names in (("name", _NAMES), ("vertex", _VERTICES), ("defined", ("defined",))):
        places = [header.index(name) for name in names if name in header]
        if places:
            found[what] = places[:1]
    return found if "position" in found or "vertex" in found else None


def _columns_by_count(row: tuple[int, list[str]]) -> dict[str, list[int]]:
    """Places of the columns of a table without header."""
    line, cells = row
    known: dict[int, dict[str, list[int]]] = {
        1: {"vertex": [0]},
        2: {"name": [0], "vertex": [1]},
        3: {"position": [0, 1, 2]},
        4: {"name": [0], "position": [1, 2, 3]},
    }
    if len(cells) not in known:
        raise MeshError(
            f"line {line} has {len(cells)} columns, but no header names them: expected are x y z, name x y z, a "
            "vertex, name and vertex, or a header with name, x, y, z, vertex"
        )
    return known[len(cells)]


def _landmarks(rows: Rows, columns: dict[str, list[int]], frame: Frame | None) -> Landmarks:
    names: list[str] = []
    points: list[Point] = []
    vertices: list[int] = []
    width = max(place for places in columns.values() for place in places) + 1
    for line, cells in rows:
        if len(cells) < width:
            raise MeshError(f"line {line} has {len(cells)} columns, expected at least {width}")
        place = f"line {line}"
        point = position([cells[i] for i in columns["position"]], place) if "position" in columns else MISSING
        if "defined" in columns and cells[columns["defined"][0]] in ("0", "false"):
            point = MISSING
        points.append(point)
        vertices.append(whole_number(cells[columns["vertex"][0]], place) if "vertex" in columns else -1)
        if vertices[-1] < -1:
            raise MeshError(f"{place}: {vertices[-1]} is no vertex: they are numbered from 0")
        names.append(cells[columns["name"][0]] if "name" in columns else str(len(names) + 1))
    if not names:
        raise MeshError("the file holds no landmarks")
    return Landmarks(names, points, vertices, frame)
