"""Landmarks as 3D Slicer saves them: ``.fcsv`` and Markups, ``.mrk.json``; both say which frame they are in."""

from __future__ import annotations

import csv
import json
from io import StringIO
from pathlib import Path
from typing import Any

from qgeo_filters.errors import MeshError
from qgeo_filters.io.landmark_tables import csv_rows
from qgeo_filters.io.landmark_text import MISSING, LandmarkSet, Point, position, text_of, words_of
from qgeo_filters.io.landmarks import Frame, Landmarks

_COLUMNS = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID"
_FRAMES: dict[str, Frame] = {"0": "RAS", "ras": "RAS", "1": "LPS", "lps": "LPS"}
_SCHEMA = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
    "markups-schema-v1.0.3.json#"
)
_UNDEFINED = ("undefined", "preview", "missing")
_UNDEFINED_STATES = [["0"], ["1"], ["3"]]  # the same in .fcsv, behind the named columns; 2 is defined


def read_fcsv(path: Path) -> list[LandmarkSet]:
    """Landmarks of a fiducial list, of any version; without a word on it in RAS, as Slicer takes it."""
    content = path.read_bytes()
    if b"\n" in content and not content.startswith((b"\xff\xfe", b"\xfe\xff")):
        content = content.replace(b"\r", b"")  # Slicer 5 puts a carriage return within each row
    text = text_of(content)
    frame: Frame = "RAS"
    columns = _COLUMNS.lower().split(",")
    for line in text.split("\n"):
        if not line.startswith("#"):
            continue
        key, found, value = line.lstrip("# ").partition("=")
        key, cells = key.strip().lower(), [cell.strip().lower() for cell in (value if found else key).split(",")]
        if key == "coordinatesystem":
            frame = _frame(value.strip())
        elif {"x", "y", "z"} <= set(cells):
            columns = ["label" if cell == "name" else cell for cell in cells]
    names: list[str] = []
    points: list[Point] = []
    state = columns.index("associatednodeid") + 1 if "associatednodeid" in columns else len(columns)
    for line_number, cells in csv_rows(["" if line.startswith("#") else line for line in text.split("\n")], ","):
        place = f"line {line_number}"
        if len(cells) <= max(columns.index(axis) for axis in "xyz"):
            raise MeshError(f"{place} has {len(cells)} columns, expected {', '.join(columns)}")
        point = position([cells[columns.index(axis)] for axis in "xyz"], place)
        points.append(MISSING if cells[state : state + 1] in _UNDEFINED_STATES else point)
        label = columns.index("label") if "label" in columns else len(cells)
        names.append((cells[label] if label < len(cells) else "") or str(len(names) + 1))
    return [LandmarkSet((), Landmarks(names, _some(points), frame=frame))]


def write_fcsv(path: Path, landmarks: Landmarks) -> bytes:
    """Fiducial list; landmarks without a frame are called LPS, as Slicer takes meshes to be."""
    out = StringIO()
    out.write(f"# Markups fiducial file version = 4.11\n# CoordinateSystem = {landmarks.frame or 'LPS'}\n")
    out.write(f"# columns = {_COLUMNS}\n")
    writer = csv.writer(out, lineterminator="\n")
    for i, (name, point) in enumerate(zip(landmarks.names, landmarks.points, strict=True)):
        words = words_of(point, "")
        known = bool(words[0])
        writer.writerow([i + 1, *(words if known else "000"), 0, 0, 0, 1, 1, 1, 0, name, "", "", 2 if known else 0, 0])
    return out.getvalue().encode("utf-8", errors="backslashreplace")


def read_markups(path: Path) -> list[LandmarkSet]:
    """Control points of each markup of a file: lists of points, lines, curves."""
    try:
        document = json.loads(text_of(path.read_bytes()))
    except (ValueError, RecursionError) as error:
        raise MeshError(f"no readable JSON ({error if isinstance(error, ValueError) else 'too deep'})") from error
    markups = document.get("markups") if isinstance(document, dict) else None
    if not isinstance(markups, list) or not markups:
        raise MeshError("no Markups of Slicer: there is no list 'markups'")
    return [_markup(markup, f"markups[{i}]") for i, markup in enumerate(markups)]


def write_markups(path: Path, landmarks: Landmarks) -> bytes:
    """Markups with one list of points; landmarks without a frame are called LPS, as Slicer takes meshes to be."""
    points = [
        {
            "id": str(i + 1),
            "label": name,
            "position": point if point[0] == point[0] else [0.0, 0.0, 0.0],
            "orientation": [-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0],
            "selected": True,
            "locked": False,
            "visibility": True,
            "positionStatus": "defined" if point[0] == point[0] else "missing",
        }
        for i, (name, point) in enumerate(zip(landmarks.names, landmarks.points.tolist(), strict=True))
    ]
    markup = {
        "type": "Fiducial",
        "coordinateSystem": landmarks.frame or "LPS",
        "coordinateUnits": "mm",
        "locked": False,
        "fixedNumberOfControlPoints": False,
        "labelFormat": "%N-%d",
        "lastUsedControlPointNumber": len(points),
        "controlPoints": points,
    }
    return (json.dumps({"@schema": _SCHEMA, "markups": [markup]}, indent=4) + "\n").encode()


def _markup(markup: Any, where: str) -> LandmarkSet:
    if not isinstance(markup, dict) or not isinstance(markup.get("controlPoints"), list):
        raise MeshError(f"{where} has no list of controlPoints")
    frame = _frame(str(markup.get("coordinateSystem", "LPS")))
    names: list[str] = []
    points: list[Point] = []
    for i, entry in enumerate(markup["controlPoints"]):
        place = f"{where}.controlPoints[{i}]"
        if not isinstance(entry, dict):
            raise MeshError(f"{place} is no control point")
        names.append(str(entry.get("label") or i + 1))
        if entry.get("positionStatus", "defined") in _UNDEFINED:
            points.append(MISSING)
            continue
        words = entry.get("position")
        if not isinstance(words, list):
            raise MeshError(f"{place} has no position")
        points.append(position(words, place))
    called = tuple(str(markup[key]) for key in ("name", "id") if markup.get(key))
    return LandmarkSet(called, Landmarks(names, _some(points), frame=frame))


def _frame(word: str) -> Frame:
    if word.lower() not in _FRAMES:
        raise MeshError(f"the coordinates are in the system {word[:40]!r}; read are RAS and LPS")
    return _FRAMES[word.lower()]


def _some(points: list[Point]) -> list[Point]:
    if not points:
        raise MeshError("the file holds no landmarks")
    return points
