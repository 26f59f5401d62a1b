"""VTK's XML files, written: ``.vtp`` (polygons) and ``.vtu`` (cells) for ParaView and PyVista, with all attributes.

VTK itself is an extra of 100 MB, and meshio writes no ``.vtp``. Arrays stand in the text as base64, behind their
length in bytes: any XML parser reads such a file.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError
from qgeo_filters.io.vertex_colors import COLORS, as_bytes, is_color

_TRIANGLE = 5  # VTK's number of this kind of cell
_KINDS = {"i": "Int", "u": "UInt", "f": "Float"}


def write_polygons(path: Path, vertices: FloatArray, faces: IntArray, attributes: Mapping[str, np.ndarray]) -> None:
    """Write as ``.vtp`` with every attribute.

    Raises
    ------
    MeshError
        An attribute that holds no numbers.
    """
    none = "".join(f"<{kind}>{_cells(np.empty((0, 3)))}</{kind}>" for kind in ("Verts", "Lines", "Strips"))
    counts = f'NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{len(faces)}"'
    _write(path, "PolyData", counts, f"{none}<Polys>{_cells(faces)}</Polys>", vertices, attributes)


def write_cells(path: Path, vertices: FloatArray, faces: IntArray, attributes: Mapping[str, np.ndarray]) -> None:
    """Write as ``.vtu`` with every attribute.

    Raises
    ------
    MeshError
        An attribute that holds no numbers.
    """
    kinds = _array("types", np.full(len(faces), _TRIANGLE, dtype=np.uint8))
    cells = f"<Cells>{_cells(faces)}{kinds}</Cells>"
    _write(path, "UnstructuredGrid", f'NumberOfCells="{len(faces)}"', cells, vertices, attributes)


def _write(
    path: Path,
    kind: str,
    counts: str,
    cells: str,
    vertices: FloatArray,
    attributes: Mapping[str, np.ndarray],
) -> None:
    # Colours in bytes are shown as they are, and "Scalars" is what viewers show first.
    shown = {name: as_bytes(values) if is_color(name, values) else values for name, values in attributes.items()}
    first = next((name for name in (COLORS, *shown) if name in shown), None)
    active = "" if first is None else f" Scalars={quoteattr(first)}"
    parts = (
        f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        f'<{kind}>\n<Piece NumberOfPoints="{len(vertices)}" {counts}>',
        f"<PointData{active}>",
        *(_array(name, values) for name, values in shown.items()),
        f"</PointData>\n<CellData/>\n<Points>{_array('Points', vertices)}</Points>",
        f"{cells}</Piece>\n</{kind}>\n</VTKFile>\n",
    )
    with atomic_write(path) as file:
        for part in parts:
            file.write(f"{part}\n".encode())


def _cells(faces: np.ndarray) -> str:
    """Corners of triangles one after the other, and where each ends."""
    ends = np.arange(3, 3 * len(faces) + 3, 3, dtype=np.int64)
    return _array("connectivity", faces.astype(np.int64).ravel()) + _array("offsets", ends)


def _array(name: str, values: np.ndarray) -> str:
    """An array, of which the columns are VTK's components."""
    table = _known(name, values)
    # meshio makes a table of a single column where the number of columns is given.
    width = f' NumberOfComponents="{int(np.prod(table.shape[1:]))}"' if table.ndim > 1 else ""
    kind = f"{_KINDS[table.dtype.kind]}{8 * table.dtype.itemsize}"
    content = table.astype(table.dtype.newbyteorder("<"), copy=False).tobytes()
    code = base64.b64encode(len(content).to_bytes(8, "little") + content).decode()
    return f'<DataArray type="{kind}" Name={quoteattr(name)}{width} format="binary">{code}</DataArray>\n'


def _known(name: str, values: np.ndarray) -> np.ndarray:
    """The values in a type that VTK has: bytes for truth values, two columns for complex numbers."""
    if values.dtype.kind == "b":
        return values.astype(np.uint8)
    if values.dtype.kind == "c" and values.dtype.itemsize in (8, 16):
        return np.stack([values.real, values.imag], axis=-1)
    if values.dtype.kind == "f" and values.dtype.itemsize == 2:
        return values.astype(np.float32)
    if values.dtype.kind in _KINDS and values.dtype.itemsize <= 8:
        return values
    raise MeshError(f"attribute {name!r} of dtype {values.dtype} cannot be held by a VTK file")
