"""STL, which repeats a vertex for every face: equal positions become one vertex.

Of ascii files trimesh loses a solid without ``endsolid`` in silence and refuses one whose name holds that word;
meshio does not know capitals, nor libigl a byte-order mark; and none but ours reads the grammar's free white space.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError
from qgeo_filters.io.polygons import Polygons, triangulated
from qgeo_filters.io.raw_mesh import RawMesh, weld
from qgeo_filters.io.text_numbers import numbers_of, plain_text
from qgeo_filters.triangle_geometry import face_crosses, unit_normals

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read(path: Path, repair: bool) -> RawMesh:
    """Arrays of an STL file, binary or ascii, all solids together."""
    content = path.read_bytes()
    count = int.from_bytes(content[80:84], "little")
    if len(content) == 84 + count * _FACET.itemsize:
        corners = np.frombuffer(content, _FACET, count, offset=84)["corners"].reshape(-1, 3).astype(np.float64)
        sizes = np.full(count, 3)
    elif (text := plain_text(content).lower()).lstrip()[:5] == b"solid":
        corners, sizes = _ascii_facets(text)
    else:
        raise MeshError(
            f"not an STL file: {len(content)} bytes, where {count} announced triangles take "
            f"{84 + count * _FACET.itemsize}"
        )
    points, index = weld(corners)
    faces, notes = triangulated(points, Polygons(index, sizes), repair)
    return RawMesh(points, faces, notes=notes)


def write(path: Path, vertices: FloatArray, faces: IntArray) -> None:
    """Write as binary STL, in float32, which is all that it holds."""
    facets = np.zeros(len(faces), _FACET)
    facets["normal"] = unit_normals(face_crosses(vertices, faces))
    facets["corners"] = vertices[faces]
    with atomic_write(path) as file:
        file.write(b"qgeo-filters".ljust(80) + np.uint32(len(faces)).tobytes() + facets.tobytes())


def _ascii_facets(text: bytes) -> tuple[FloatArray, IndexArray]:
    """Corners of all facets, shape (total, 3), and the number of each one's."""
    lines = [line.strip() for line in text.split(b"\n")]
    if not any(line.startswith(b"vertex") for line in lines):  # the grammar asks for white space only
        lines = re.sub(rb"\s(?=(?:outer|vertex|endloop)\s)", b"\n", text).split(b"\n")
    is_corner = np.array([line.startswith(b"vertex") for line in lines])
    found = numbers_of(b"\n".join(line[6:] if line.startswith(b"vertex") else b"" for line in lines))
    found.require_all()
    at = np.flatnonzero(is_corner)
    counts = np.zeros(len(lines) + 1, dtype=np.int64)
    counts[found.lines] = found.counts
    bad = at[counts[at + 1] != 3]
    if bad.size:
        shown = lines[bad[0]][:80].decode(errors="replace")
        raise MeshError(f"line {bad[0] + 1} is no corner of a facet: {shown!r}")
    loops = np.flatnonzero([line.startswith(b"outer") for line in lines])
    facet = np.searchsorted(loops, at) - 1
    if not len(at) or facet.min(initial=0) < 0:
        raise MeshError(f"{len(at)} corners found in the STL file, which make no triangles")
    return found.values.reshape(-1, 3), np.bincount(facet, minlength=len(loops))
