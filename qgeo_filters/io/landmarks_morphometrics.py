"""Landmarks of geometric morphometrics: ``.tps``, Landmark Editor's ``.pts``, Avizo's ``.landmarkAscii``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from qgeo_filters.errors import MeshError
from qgeo_filters.io.landmark_text import (
    MISSING,
    LandmarkSet,
    Point,
    number,
    position,
    text_of,
    whole_number,
    without_head,
    words_of,
)
from qgeo_filters.io.landmarks import Landmarks

_ABSENT = (9999.0, 9999.0, 9999.0)  # Landmark Editor's missing landmark
_Line = tuple[int, str]


def read_tps(path: Path) -> list[LandmarkSet]:
    """Specimens of a tps file: landmarks in three dimensions, then the points of curves, times SCALE.

    The landmarks are called 1, 2, ..., points of curves ``curve 1.1``, ...; a specimen what its ID and IMAGE say.
    """
    lines = _lines(path)
    found: list[LandmarkSet] = []
    line = next(lines, None)
    while line is not None:
        specimen, line = _specimen(line, lines)
        found.append(specimen)
    if not found:
        raise MeshError("the file holds no landmarks")
    return found


def write_tps(path: Path, landmarks: Landmarks) -> bytes:
    """One specimen, called as the file."""
    rows = [" ".join(words_of(point, "NA")) for point in landmarks.points]
    return "\n".join([f"LM3={len(rows)}", *rows, f"ID={path.stem}", ""]).encode("utf-8", errors="backslashreplace")


def read_pts(path: Path) -> list[LandmarkSet]:
    """Rows of x y z, or of a name before these; with the number of rows before them (Landmark Editor's), or not."""
    lines = list(_lines(path))
    if lines and lines[0][1].lower().startswith("version"):
        lines = lines[1:]
    count = whole_number(lines[0][1], f"line {lines[0][0]}") if lines and len(lines[0][1].split()) == 1 else None
    rows = lines if count is None else lines[1:]
    names: list[str] = []
    points: list[Point] = []
    for line, text in rows:
        words = text.split()
        named = len(words) == 4
        point = position(words[named:], f"line {line}")
        points.append(MISSING if point == _ABSENT else point)
        names.append(words[0] if named else str(len(names) + 1))
    if count is not None and count != len(points):
        raise MeshError(f"line {lines[0][0]} announces {count} landmarks, where {len(points)} follow")
    return [LandmarkSet((), Landmarks(names, _some(points)))]


def write_pts(path: Path, landmarks: Landmarks) -> bytes:
    """Landmark Editor's form; blanks in names become underscores."""
    names = [name.replace(" ", "_") or "_" for name in landmarks.names]
    rows = [" ".join([name, *words_of(p, "9999")]) for name, p in zip(names, landmarks.points, strict=True)]
    return "\n".join(["Version 1.0", str(len(rows)), *rows, ""]).encode("utf-8", errors="backslashreplace")


def read_landmark_ascii(path: Path) -> list[LandmarkSet]:
    """Sets of landmarks of Amira and Avizo, in the order of the file; they have no names."""
    text = text_of(path.read_bytes())
    count = re.search(r"^\s*define\s+Markers\s+(\d{1,9})\s*$", text, re.MULTILINE)
    marks = re.findall(r"Markers\s*\{\s*(?:float|double)\[3\]\s+Coordinates\d*\s*\}\s*=?\s*@(\d{1,9})", text)
    if not text.lstrip().startswith("#") or count is None or not marks:
        raise MeshError("no landmarks of Amira or Avizo: 'define Markers' or 'Markers { float[3] ... } @1' is missing")
    lines = text.split("\n")
    found = []
    for mark in marks:
        start = next((i for i, line in enumerate(lines) if line.strip() == f"@{mark}"), None)
        if start is None:
            raise MeshError(f"there is no section @{mark}")
        points = []
        for i in range(start + 1, len(lines)):
            words = lines[i].split("#")[0].split()
            if words[:1] and words[0].startswith("@"):
                break
            if words:
                points.append(position(words, f"line {i + 1}"))
        if len(points) != int(count[1]):
            raise MeshError(f"section @{mark} has {len(points)} landmarks, where {int(count[1])} are announced")
        found.append(LandmarkSet((mark,), Landmarks(points=_some(points))))
    return found


def write_landmark_ascii(path: Path, landmarks: Landmarks) -> bytes:
    """One set of landmarks, without names."""
    head = (
        "# Avizo 3D ASCII 2.0\n\n\n"
        f"define Markers {len(landmarks)}\n\n"
        'Parameters {\n    NumSets 1,\n    ContentType "LandmarkSet"\n}\n\n'
        "Markers { float[3] Coordinates } @1\n\n"
        "# Data section follows\n@1\n"
    )
    return (head + "".join(f"{' '.join(words_of(point, 'NaN'))}\n" for point in landmarks.points)).encode()


def _lines(path: Path) -> Iterator[_Line]:
    """Lines that are not empty, nor comments at the beginning, with their numbers."""
    for i, line in enumerate(without_head(text_of(path.read_bytes())).split("\n")):
        content = line.strip()
        if content:
            yield i + 1, content


def _specimen(line: _Line, lines: Iterator[_Line]) -> tuple[LandmarkSet, _Line | None]:
    """A specimen that begins with a line, and the first line of the next one."""
    key, value = _entry(line)
    if key not in ("LM", "LM3"):
        raise MeshError(f"line {line[0]}: a specimen begins with LM3=, got {line[1][:40]!r}")
    points = _points(value, line[0], lines)
    names = [str(i + 1) for i in range(len(points))]
    called: list[str] = []
    curve, scale = 0, 1.0
    following = next(lines, None)
    while following is not None:
        key, value = _entry(following)
        if key in ("LM", "LM3"):
            break
        if key in ("POINTS", "POINTS3D"):
            curve += 1
            more = _points(value, following[0], lines)
            names += [f"curve {curve}.{i + 1}" for i in range(len(more))]
            points += more
        elif key in ("ID", "IMAGE") and value:
            # Of an image also the name without folder and suffix; the ID comes first.
            stem = re.sub(r"\.\w{1,5}$", "", re.split(r"[\\/]", value)[-1])
            called = [value, *called] if key == "ID" else [*called, value, stem]
        elif key == "SCALE":
            scale = number(value.split()[0] if value.split() else "", f"line {following[0]}")
            if not scale > 0:
                raise MeshError(f"line {following[0]}: SCALE must be a positive number, got {value[:40]!r}")
        following = next(lines, None)
    with np.errstate(over="ignore"):
        scaled = scale * np.array(_some(points))
    if np.isinf(scaled).any():
        raise MeshError(f"line {line[0]}: landmarks times SCALE are beyond all numbers")
    return LandmarkSet(tuple(called), Landmarks(names, scaled)), following


def _entry(line: _Line) -> tuple[str, str]:
    key, found, value = line[1].partition("=")
    if not found:
        raise MeshError(f"line {line[0]}: expected NAME=VALUE, got {line[1][:40]!r}")
    return key.strip().upper(), value.strip()


def _points(count: str, line: int, lines: Iterator[_Line]) -> list[Point]:
    wanted = whole_number(count, f"line {line}")
    if wanted < 0:
        raise MeshError(f"line {line}: {count[:40]!r} is no number of landmarks")
    points: list[Point] = []
    while len(points) < wanted:
        at, text = next(lines, (0, ""))
        if not at or "=" in text:
            raise MeshError(f"line {line} announces {wanted} landmarks, where {len(points)} follow")
        words = text.split()
        if len(words) == 2:
            raise MeshError(f"line {at}: the landmarks have two coordinates; those of surfaces have three")
        points.append(position(words, f"line {at}"))
    return points


def _some(points: list[Point]) -> list[Point]:
    if not points:
        raise MeshError("the file holds no landmarks")
    return points
