"""OBJ: positions, faces and colours of vertices; groups and objects are joined, seams do not split a vertex.

No library at hand keeps the mesh of all these files. trimesh splits vertices at seams and materials and drops those
that no face names; libigl and meshio do not know continued lines; trimesh and libigl stop at lines that begin with a
blank; all of them, and MeshLab, lose a first vertex behind a byte-order mark, which shifts every index in silence; and
none but MeshLab splits concave polygons rightly.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError
from qgeo_filters.io.polygons import Polygons, triangulated
from qgeo_filters.io.raw_mesh import RawMesh, counted
from qgeo_filters.io.text_numbers import numbers_of, read_text, whole, without_comments
from qgeo_filters.io.vertex_colors import COLORS, as_shade


def read(path: Path, repair: bool) -> RawMesh:
    """Arrays of an OBJ file; indices that count back from the last vertex are understood."""
    lines = _joined_lines(without_comments(read_text(path)))
    vertex_lines = _lines_of(lines, b"v")
    vertices, attributes, losses = _vertices(lines, vertex_lines)
    polygons = _faces(lines, vertex_lines, repair)
    faces, notes = triangulated(vertices, polygons, repair)
    return RawMesh(vertices, faces, attributes, losses + notes)


def write(path: Path, vertices: FloatArray, faces: IntArray, attributes: Mapping[str, np.ndarray]) -> None:
    """Write as OBJ with 17 digits, which give back every bit, and colours behind the positions."""
    shades = [as_shade(attributes[COLORS])[:, :3]] if COLORS in attributes else []
    with atomic_write(path) as file:
        np.savetxt(file, np.hstack([vertices, *shades]), fmt="v %.17g %.17g %.17g" + " %.6g %.6g %.6g" * len(shades))
        np.savetxt(file, faces.astype(np.int64) + 1, fmt="f %d %d %d")


def _joined_lines(text: bytes) -> list[bytes]:
    """Lines of the text; one that ends in a backslash is empty and stands before the next one."""
    lines = [line.strip() for line in text.split(b"\n")]
    if b"\\" not in text:
        return lines
    begun: list[bytes] = []
    for k, line in enumerate(lines):
        if line.endswith(b"\\") and k + 1 < len(lines):
            begun.append(line[:-1])
            lines[k] = b""
        elif begun:
            lines[k] = b" ".join([*begun, line]).strip()
            begun = []
    return lines


def _lines_of(lines: list[bytes], keyword: bytes) -> IndexArray:
    """Numbers of the lines, from 1, whose first word is the keyword."""
    begins = (keyword + b" ", keyword + b"\t")
    numbers = [k for k, line in enumerate(lines, start=1) if line.startswith(begins) or line == keyword]
    return np.array(numbers, dtype=np.int64)


def _only(lines: list[bytes], numbers: IndexArray) -> bytes:
    """Text of these lines without their keyword; all others are empty."""
    kept = [b""] * len(lines)
    for number in numbers.tolist():
        kept[number - 1] = lines[number - 1][1:]
    return b"\n".join(kept)


def _vertices(lines: list[bytes], numbers: IndexArray) -> tuple[FloatArray, dict[str, np.ndarray], tuple[str, ...]]:
    if not len(numbers):
        raise MeshError("no vertices (lines that start with 'v') found")
    found = numbers_of(_only(lines, numbers))
    found.require_all()
    widths = np.zeros(len(numbers), dtype=np.int64)
    widths[np.searchsorted(numbers, found.lines)] = found.counts
    short = np.flatnonzero(widths < 3)
    if short.size:
        raise _no(lines, int(numbers[short[0]]), "vertex")
    width = int(widths.min())
    table = found.values[found.starts[:-1, None] + np.arange(width)]
    colored = int((widths >= 6).sum())
    if width >= 6:  # x, y, z, red, green, blue and perhaps alpha
        return table[:, :3], {"colors": table[:, 3:7]}, ()
    losses = (f"colours passed over, which only {counted(colored, 'vertex', 'vertices')} of {len(widths)} have",)
    return table[:, :3], {}, losses if colored else ()


def _faces(lines: list[bytes], vertex_lines: IndexArray, repair: bool) -> Polygons:
    numbers = _lines_of(lines, b"f")
    text = _only(lines, numbers)
    if b"/" in text:
        text = re.sub(rb"(?<=[^\s/])/\S*", b"", text)  # indices of texture and normal
    found = numbers_of(text)
    found.require_all()
    sizes = np.zeros(len(numbers), dtype=np.int64)
    sizes[np.searchsorted(numbers, found.lines)] = found.counts
    line = np.repeat(numbers, sizes)
    broken = np.flatnonzero(~whole(found.values))
    if broken.size:
        raise _no(lines, int(line[broken[0]]), "face")
    corners = found.values.astype(np.int64)
    zero = np.flatnonzero(corners == 0)
    if zero.size and not repair:  # which removes the face with those of other missing vertices
        raise MeshError(
            f"line {line[zero[0]]} refers to vertex 0, but OBJ counts from 1: {_shown(lines, line[zero[0]])}"
        )
    before = np.searchsorted(vertex_lines, line) if (corners < 0).any() else 0
    return Polygons(np.where(corners < 0, before + corners, corners - 1), sizes)


def _no(lines: list[bytes], number: int, what: str) -> MeshError:
    return MeshError(f"line {number} is no {what}: {_shown(lines, number)}")


def _shown(lines: list[bytes], number: int) -> str:
    return repr(lines[number - 1].decode(errors="replace")[:80])
