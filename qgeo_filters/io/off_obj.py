"""OFF and OBJ: positions and faces from text.

libigl reads both, but splits polygons without a word, prints to the process's standard error and gives no reason
when it fails, so the few lines are here.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError
from qgeo_filters.io.raw_mesh import RawMesh, triangles


def read_off(path: Path, repair: bool) -> RawMesh:
    """Positions and faces of an OFF file; colours and normals on the lines (COFF, NOFF, ...) are passed over."""
    numbered = [
        (number, content)
        for number, line in enumerate(_lines(path), start=1)
        if (content := line.partition("#")[0].strip())
    ]
    if not numbered or not numbered[0][1].split()[0].endswith("OFF"):
        raise MeshError("not an OFF file: the first line must be OFF")
    header = numbered[0][1].split()
    if header[0] in ("4OFF", "nOFF", "4nOFF") or "BINARY" in header:
        raise MeshError(f"OFF files of kind {' '.join(header)} are not read")
    if len(header) > 1:
        counts, start = header[1:], 1
    else:
        counts, start = (numbered[1][1].split() if len(numbered) > 1 else []), 2
    try:
        n_vertices, n_faces = int(counts[0]), int(counts[1])
    except (ValueError, IndexError):
        raise MeshError(f"the counts of vertices and faces are missing, found {' '.join(counts)!r}") from None
    rows = numbered[start:]
    if len(rows) < n_vertices + n_faces:
        raise MeshError(f"{n_vertices} vertices and {n_faces} faces announced, but only {len(rows)} lines follow")
    polygons = _off_faces(rows[n_vertices : n_vertices + n_faces])
    faces, notes = triangles(polygons, repair)
    return RawMesh(_positions(rows[:n_vertices], 0), faces, notes=notes)


def read_obj(path: Path, repair: bool) -> RawMesh:
    """Positions and faces of an OBJ file, all groups and objects together.

    Texture and normal indices are passed over, so that no vertex is split at a seam; indices that count
    back from the last vertex are understood.
    """
    vertices: list[tuple[int, str]] = []
    polygons: list[list[int]] = []
    continued = ""
    for number, line in enumerate(_lines(path), start=1):
        if line.endswith("\\"):
            continued += line[:-1] + " "
            continue
        line, continued = continued + line, ""
        if line.startswith(("v ", "v\t")):
            vertices.append((number, line))
        elif line.startswith(("f ", "f\t")):
            corners = _integers([word.partition("/")[0] for word in line.partition("#")[0].split()], number)
            if 0 in corners:
                raise MeshError(f"line {number} refers to vertex 0, but OBJ counts from 1: {line!r}")
            polygons.append([corner - 1 if corner > 0 else len(vertices) + corner for corner in corners])
    if not vertices:
        raise MeshError("no vertices (lines that start with 'v') found")
    faces, notes = triangles(polygons, repair)
    return RawMesh(_positions(vertices, 1), faces, notes=notes)


def write_off(path: Path, vertices: FloatArray, faces: IntArray) -> None:
    """Write as OFF with 17 digits, which give back every bit."""
    with atomic_write(path) as file:
        file.write(f"OFF\n{len(vertices)} {len(faces)} 0\n".encode())
        np.savetxt(file, vertices, fmt="%.17g")
        np.savetxt(file, faces, fmt="3 %d %d %d")


def write_obj(path: Path, vertices: FloatArray, faces: IntArray) -> None:
    """Write as OBJ with 17 digits, which give back every bit."""
    with atomic_write(path) as file:
        np.savetxt(file, vertices, fmt="v %.17g %.17g %.17g")
        np.savetxt(file, faces.astype(np.int64) + 1, fmt="f %d %d %d")


def _off_faces(rows: list[tuple[int, str]]) -> Any:
    """Corners of each face, from lines that begin with their number."""
    if not rows:
        return np.empty((0, 3), dtype=np.int64)
    try:  # triangles only, the usual case
        table = np.loadtxt((line for _, line in rows), dtype=np.int64, usecols=range(4), ndmin=2)
        if len(table) and (table[:, 0] == 3).all():
            return table[:, 1:]
    except ValueError:
        pass
    polygons = []
    for number, line in rows:
        words = line.split()
        count = int(words[0]) if words[0].isdigit() else 0
        corners = _integers(words[: count + 1], number)
        if not corners or len(corners) < count:
            raise MeshError(f"line {number} is no face: {line!r}")
        polygons.append(corners)
    return polygons


def _lines(path: Path) -> list[str]:
    return [line.strip() for line in path.read_text(encoding="utf-8", errors="replace").splitlines()]


def _integers(words: list[str], number: int) -> list[int]:
    """Whole numbers after the first word of a line."""
    try:
        return [int(word) for word in words[1:]]
    except ValueError:
        raise MeshError(f"line {number} is no face: {' '.join(words)!r}") from None


def _positions(rows: list[tuple[int, str]], skip: int) -> np.ndarray:
    """First three numbers of each line after ``skip`` words, shape (n, 3)."""
    if not rows:
        return np.empty((0, 3))
    try:
        return np.loadtxt((line for _, line in rows), usecols=range(skip, skip + 3), ndmin=2)
    except ValueError:
        for number, line in rows:
            words = line.split()[skip : skip + 3]
            try:
                complete = len([float(word) for word in words]) == 3
            except ValueError:
                complete = False
            if not complete:
                raise MeshError(f"line {number} is no vertex: {line!r}") from None
        raise
