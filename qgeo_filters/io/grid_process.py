"""A program that reads one file of VTK or Gmsh and writes its arrays to its standard output, as an ``.npz``.

Run by `grids`, apart from the user's process: VTK's readers die of damaged files (SIGSEGV or SIGABRT, of every fifth
binary one), take memory by the counts that stand in them, and write to the terminal, as meshio does. Nothing of this
package is imported here, so that it starts quickly.
"""

from __future__ import annotations

import io
import os
import re
import sys
from typing import Any

import numpy as np

# VTK's codes of meshio's names.
MESHIO_CODES = {
    "vertex": 1, "line": 3, "triangle": 5, "polygon": 7, "quad": 9,
    "tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14,
}  # fmt: skip
_VERTICES, _LINES, _STRIPS, _POLYGONS = 2, 4, 6, 7
_LIBRARIES = 2 << 30  # bytes of address space


def main(kind: str, path: str) -> int:
    """Write the arrays, or the reason why there are none; exit code 0 or 1."""
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no array
    _limit_memory(64 * os.path.getsize(path))
    try:
        arrays: dict[str, Any] = {"vtk": _vtk_arrays, "gmsh": _gmsh_arrays}[kind](path)
    except (Exception, SystemExit) as error:  # whatever it is, it is the file's fault
        reason = " ".join(str(error).split()) or type(error).__name__
        sys.stderr.write(f"{reason[:300]}\n")
        return 1
    memory = io.BytesIO()
    np.savez(memory, **arrays)
    output.write(memory.getbuffer())
    output.close()
    return 0


def _limit_memory(size: int) -> None:
    """Let this process take that many bytes beyond what it has and what the libraries need; on Linux only."""
    try:
        import resource

        with open("/proc/self/statm") as file:
            taken = int(file.read().split()[0]) * resource.getpagesize()
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    except (ImportError, OSError):
        return
    most = taken + _LIBRARIES + size
    resource.setrlimit(resource.RLIMIT_AS, (most if hard < 0 else min(most, hard), hard))


def _vtk_arrays(path: str) -> dict[str, np.ndarray]:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
    from vtkmodules.vtkIOLegacy import vtkGenericDataObjectReader
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

    said = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(said)
    xml = {".vtp": vtkXMLPolyDataReader, ".vtu": vtkXMLUnstructuredGridReader}
    reader = xml.get(os.path.splitext(path)[1].lower(), vtkGenericDataObjectReader)()
    reader.SetFileName(path)
    if isinstance(reader, vtkGenericDataObjectReader):
        for what in ("Scalars", "Vectors", "Normals", "Tensors", "TCoords", "Fields", "ColorScalars"):
            getattr(reader, f"ReadAll{what}On")()
    reader.Update()
    data = reader.GetOutput()
    complaint = _text(said.GetOutput())
    if "ERR" in complaint.upper() or reader.GetErrorCode() or data is None:
        reasons = re.findall(r"\(0x[0-9a-f]+\): *(\S.*)", complaint)  # behind the object's name and address
        raise ValueError(reasons[0] if reasons else "VTK cannot read it")
    if data.IsA("vtkPolyData"):
        kinds = (
            (data.GetVerts(), _VERTICES),
            (data.GetLines(), _LINES),
            (data.GetPolys(), _POLYGONS),
            (data.GetStrips(), _STRIPS),
        )
        cells = [(array, np.full(array.GetNumberOfCells(), code)) for array, code in kinds if array.GetNumberOfCells()]
    elif data.IsA("vtkUnstructuredGrid"):
        array = data.GetCells()
        cells = [(array, vtk_to_numpy(data.GetCellTypes()))] if array.GetNumberOfCells() else []
    else:
        raise ValueError(f"it holds a {data.GetClassName()}, no surface")
    arrays = _cell_arrays(
        [codes for _, codes in cells],
        [np.diff(vtk_to_numpy(array.GetOffsetsArray())) for array, _ in cells],
        [vtk_to_numpy(array.GetConnectivityArray()) for array, _ in cells],
    )
    points = data.GetPoints()
    arrays["points"] = vtk_to_numpy(points.GetData()) if points else np.empty((0, 3))
    values = data.GetPointData()
    numeric = [values.GetArray(i) for i in range(values.GetNumberOfArrays()) if values.GetArray(i) is not None]
    return arrays | _named_arrays([(_text(array.GetName() or ""), vtk_to_numpy(array)) for array in numeric])


def _text(value: str | bytes) -> str:
    """What VTK says; it gives bytes where they are no UTF-8."""
    return value.decode(errors="replace") if isinstance(value, bytes) else value


def _gmsh_arrays(path: str) -> dict[str, np.ndarray]:
    import meshio.gmsh

    with open(path, "rb") as file:
        begin = file.read(20)
    if not begin.startswith((b"$MeshFormat", b"$Comments")):  # Fluent's meshes have the same suffix
        raise ValueError(f"it is no Gmsh file of version 2 or 4, as it begins with {begin!r}")
    mesh = meshio.gmsh.read(path)
    curved = sorted({block.type for block in mesh.cells} - set(MESHIO_CODES))
    if curved:
        raise ValueError(f"it has cells of kind {', '.join(curved)}; save it as a mesh of order 1")
    blocks = [np.asarray(block.data) for block in mesh.cells]
    arrays = _cell_arrays(
        [np.full(len(data), MESHIO_CODES[block.type]) for data, block in zip(blocks, mesh.cells, strict=True)],
        [np.full(len(data), data.shape[1]) for data in blocks],
        [data.ravel() for data in blocks],
    )
    arrays["points"] = np.asarray(mesh.points)
    return arrays | _named_arrays([(name, np.asarray(values)) for name, values in mesh.point_data.items()])


def _cell_arrays(kinds: list[Any], sizes: list[Any], corners: list[Any]) -> dict[str, np.ndarray]:
    none = [np.empty(0, dtype=np.int64)]
    return {
        name: np.concatenate(arrays or none).astype(np.int64)
        for name, arrays in (("kinds", kinds), ("sizes", sizes), ("corners", corners))
    }


def _named_arrays(arrays: list[tuple[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Values per point, their names apart, as these may be anything."""
    names = np.array([name for name, _ in arrays], dtype=np.str_)
    return {"names": names, **{f"values_{i}": values for i, (_, values) in enumerate(arrays)}}


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
