"""OFF: a stream of numbers, in which line breaks matter only where colours follow a face.

No library at hand reads what people have. trimesh, MeshLab, libigl and meshio all refuse files without the word OFF or
with it in lower case; trimesh gives no faces where a face stands on several lines, libigl and meshio stop at
comments, MeshLab at comments between vertices; libigl and MeshLab ask for the memory that a false header announces.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError
from qgeo_filters.io.polygons import Polygons, triangulated
from qgeo_filters.io.raw_mesh import RawMesh, counted
from qgeo_filters.io.text_numbers import Numbers, numbers_of, read_text, whole, without_comments

_HEADER = re.compile(rb"\s*((?:ST)?(?:CN?|NC?)?(?:ST)?4?n?)OFF(?=[\s\d]|$)([ \t]*BINARY)?", re.IGNORECASE)


def read(path: Path, repair: bool) -> RawMesh:
    """Arrays of an OFF file; of COFF the colours, of NOFF the normals, where each vertex has its line."""
    text = without_comments(read_text(path))
    kind, body = _header(text)
    numbers = numbers_of(body)
    n_vertices, n_faces, first = _counts(numbers)
    rows = np.append(first, numbers.starts[numbers.starts > first])  # first value of each line behind the counts
    found = _by_lines(numbers.values, rows, n_vertices, n_faces) or _as_stream(
        numbers.values, rows, first, n_vertices, n_faces, kind
    )
    if found is None:
        raise _mismatch(numbers, rows, n_vertices, n_faces, body)
    table, polygons = found
    faces, notes = triangulated(table[:, :3], polygons, repair)
    return RawMesh(table[:, :3], faces, _attributes(table[:, 3:], kind), notes)


def write(path: Path, vertices: FloatArray, faces: IntArray) -> None:
    """Write as OFF with 17 digits, which give back every bit."""
    with atomic_write(path) as file:
        file.write(f"OFF\n{len(vertices)} {len(faces)} 0\n".encode())
        np.savetxt(file, vertices, fmt="%.17g")
        np.savetxt(file, faces, fmt="3 %d %d %d")


def _header(text: bytes) -> tuple[str, bytes]:
    """Letters before OFF, in capitals, and the text without the header; the lines keep their numbers."""
    header = _HEADER.match(text)
    if header is None:
        word = (text.split(maxsplit=1) or [b""])[0].decode(errors="replace")[:40]
        if not re.match(r"\d", word):
            raise MeshError(f"not an OFF file: it begins with {word!r}, neither OFF nor the number of vertices")
        return "", text
    prefix = header[1].decode()
    if header[2] or "4" in prefix or (prefix.endswith("n") and b"OFF" in header[0]):
        raise MeshError(f"OFF files of kind {header[0].decode().strip()} are not read")
    return prefix.upper(), b"\n" * header[0].count(b"\n") + text[header.end() :]


def _counts(numbers: Numbers) -> tuple[int, int, int]:
    """Numbers of vertices and of faces, and the position of the first value behind them."""
    on_line = [int(count) for count in numbers.counts[:2]]
    # The third count, of edges, is left out by some.
    n_counts = 2 if on_line[:1] == [2] and on_line[1:] != [1] else 3
    counts = numbers.values[:n_counts]
    if len(counts) < 2 or not (whole(counts[:2]) & (counts[:2] >= 0)).all():
        numbers.require_all()
        found = " ".join(f"{count:g}" for count in counts)
        raise MeshError(f"the counts of vertices and faces are missing, found {found!r}")
    return int(counts[0]), int(counts[1]), len(counts)


def _by_lines(
    values: FloatArray, rows: IndexArray, n_vertices: int, n_faces: int
) -> tuple[FloatArray, Polygons] | None:
    """Table of the vertices, and the faces, where each stands on a line of its own; else None."""
    n = n_vertices + n_faces
    if len(rows) - 1 < n:
        return None
    widths = np.diff(rows)[:n]
    vertex_widths = widths[:n_vertices]
    if n_vertices and (vertex_widths.min() < 3 or (vertex_widths.min() < vertex_widths.max() and len(rows) - 1 > n)):
        return None  # lines enough, but they are divided otherwise
    columns = np.arange(vertex_widths.min() if n_vertices else 3)
    at = rows[n_vertices:n]
    sizes = values[at]
    if not (whole(sizes) & (sizes >= 0) & (sizes < widths[n_vertices:])).all():
        return None
    polygons = _gathered(values, at, sizes.astype(np.int64))
    return None if polygons is None else (values[rows[:n_vertices, None] + columns], polygons)


def _as_stream(
    values: FloatArray, rows: IndexArray, first: int, n_vertices: int, n_faces: int, kind: str
) -> tuple[FloatArray, Polygons] | None:
    """The same where lines end anywhere: without colours of faces, or else with these up to the end of a line."""
    for width in _widths(kind):
        begin = first + n_vertices * width
        if begin + n_faces > len(values):
            continue
        for skips_colours in (False, True) if begin in rows else (False,):
            at = np.fromiter(_face_positions(values, rows, begin, n_faces, skips_colours), np.int64)
            if len(at) <= n_faces or not (skips_colours or at[-1] == len(values)):
                continue
            polygons = _gathered(values, at[:-1], values[at[:-1]].astype(np.int64))
            if polygons is not None:
                return values[first:begin].reshape(n_vertices, width), polygons
    return None


def _face_positions(
    values: FloatArray, rows: IndexArray, position: int, n_faces: int, skips_colours: bool
) -> Iterator[int]:
    """Where each face begins in the stream, and where the last one ends; fewer if they do not fit."""
    lines = iter(rows.tolist())
    next_line = 0
    stream = values.data
    for _ in range(n_faces):
        size = stream[position] if position < len(values) else -1.0
        if not 0 <= size < len(values) - position or size != int(size):
            return
        yield position
        position += int(size) + 1
        if skips_colours:
            while next_line < position:
                next_line = next(lines, len(values))
            position = next_line
    yield position


def _widths(kind: str) -> list[int]:
    """Numbers that a vertex may have."""
    plain = 3 + 3 * ("N" in kind) + 2 * ("ST" in kind)
    return [plain + 4, plain + 3] if "C" in kind else [plain]


def _gathered(values: FloatArray, at: IndexArray, sizes: IndexArray) -> Polygons | None:
    """Faces whose sizes stand at these positions and the corners behind; None where a corner is no whole number."""
    ends = np.cumsum(sizes)
    corners = values[np.repeat(at + 1 - (ends - sizes), sizes) + np.arange(ends[-1] if len(ends) else 0)]
    return Polygons.of_flat(corners, sizes) if whole(corners).all() else None


def _attributes(rest: FloatArray, kind: str) -> dict[str, np.ndarray]:
    """Normals and colours from the numbers behind the position."""
    attributes = {}
    end = rest.shape[1] - 2 * ("ST" in kind)
    if "NC" in kind:  # as MeshLab writes them, colours first; all others have the normals first
        rest = np.column_stack([rest[:, end - 3 : end], rest[:, : end - 3], rest[:, end:]])
    if "N" in kind and end >= 3:
        attributes["normals"], rest = rest[:, :3], rest[:, 3:]
        end -= 3
    n_colors = min(end, 4)
    if "C" in kind and n_colors >= 3:
        colors = rest[:, :n_colors]
        is_byte = len(colors) > 0 and bool((whole(colors) & (colors >= 0) & (colors <= 255)).all()) and colors.max() > 1
        attributes["colors"] = colors.astype(np.uint8) if is_byte else colors
    return attributes


def _mismatch(numbers: Numbers, rows: IndexArray, n_vertices: int, n_faces: int, body: bytes) -> MeshError:
    """What to say of a file whose numbers are not those announced."""
    if numbers.stopped_by:
        return MeshError(numbers.stopped_by)
    n = n_vertices + n_faces
    lines = zip(rows[:n].tolist(), rows[1 : n + 1].tolist(), strict=True) if len(rows) > n else ()
    for k, (begin, end) in enumerate(lines):
        values = numbers.values[begin:end]
        if k < n_vertices:
            fits = len(values) >= 3
        else:
            fits = 0 <= values[0] < len(values) and bool(whole(values[: int(values[0]) + 1]).all())
        if not fits:
            line = int(numbers.lines[np.searchsorted(numbers.starts, begin, side="right") - 1])
            content = body.split(b"\n", line)[line - 1].strip().decode(errors="replace")[:80]
            return MeshError(f"line {line} is no {'vertex' if k < n_vertices else 'face'}: {content!r}")
    left = len(numbers.values) - int(rows[0])
    return MeshError(
        f"{counted(n_vertices, 'vertex', 'vertices')} and {counted(n_faces, 'face')} announced, which the "
        f"{counted(left, 'number')} that follow do not make"
    )
