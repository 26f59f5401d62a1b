"""STL, which repeats a vertex for every face: equal positions become one vertex."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError
from qgeo_filters.io.raw_mesh import RawMesh, weld
from qgeo_filters.triangle_geometry import face_crosses, unit_normals

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read(path: Path, repair: bool) -> RawMesh:
    """Arrays of an STL file, binary or ascii."""
    content = path.read_bytes()
    count = int.from_bytes(content[80:84], "little")
    if len(content) == 84 + count * _FACET.itemsize:
        corners = np.frombuffer(content, _FACET, count, offset=84)["corners"].reshape(-1, 3).astype(np.float64)
    elif content.lstrip()[:5].lower() == b"solid":
        corners = _ascii_corners(content.decode("ascii", errors="replace"))
    else:
        raise MeshError(
            f"not an STL file: {len(content)} bytes, where {count} announced triangles take "
            f"{84 + count * _FACET.itemsize}"
        )
    points, index = weld(corners)
    return RawMesh(points, index.reshape(-1, 3))


def write(path: Path, vertices: FloatArray, faces: IntArray) -> None:
    """Write as binary STL, in float32, which is all that it holds."""
    facets = np.zeros(len(faces), _FACET)
    facets["normal"] = unit_normals(face_crosses(vertices, faces))
    facets["corners"] = vertices[faces]
    with atomic_write(path) as file:
        file.write(b"qgeo-filters".ljust(80) + np.uint32(len(faces)).tobytes() + facets.tobytes())


def _ascii_corners(text: str) -> np.ndarray:
    words = re.findall(r"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)\s*$", text, re.MULTILINE | re.IGNORECASE)
    try:
        corners = np.array(words, dtype=np.float64).reshape(-1, 3)
    except ValueError as error:
        raise MeshError(f"a vertex of the STL file is no point ({error})") from error
    if len(corners) == 0 or len(corners) % 3:
        raise MeshError(f"{len(corners)} corners found in the STL file, which make no triangles")
    return corners
