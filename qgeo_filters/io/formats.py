"""Arrays of meshes from files and to files, by suffix.

==================  ============================================  =======================================
suffix              read                                          written
==================  ============================================  =======================================
.ply                ascii and binary, all vertex properties       binary, float64, every attribute
.off                OFF; COFF's colours, NOFF's normals           17 digits
.obj                faces, colours of vertices; groups joined     17 digits, colours
.stl                ascii and binary; equal corners are welded    binary, float32
.glb, .gltf         the scene, colours; vertices are welded       .glb, float32, narrow attributes
.vert + .tri        TOSCA, from 1; either name or the stem        both files, 17 digits
.mat                MATLAB 4 to 7: X, Y, Z (or VERT) with TRIV    ``surface`` with X, Y, Z, TRIV
.vtp, .vtu          polygons, strips, grids; point data           float64, every attribute
.vtk                as .vtp                                       no
.csv                no                                            a row for each vertex, every attribute
.msh                Gmsh 2 and 4; node data are attributes        no
.gii                GIFTI; further arrays are attributes          no
lh.pial, rh.white   FreeSurfer, told by the first bytes           no
==================  ============================================  =======================================

Reading VTK's files needs PyVista's extra, writing none; those below need the extra ``files``. Colours are the attribute
``colors``, as bytes or from 0 to 1. In .glb they are linear, as glTF has them, and read as they stand.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.errors import MeshError, reason
from qgeo_filters.io import (
    brain_surfaces,
    gltf,
    gltf_writing,
    grids,
    mat,
    obj,
    off,
    ply,
    stl,
    tosca,
    vertex_table,
    vtk_xml,
)
from qgeo_filters.io.raw_mesh import RawMesh
from qgeo_filters.io.single_precision import single_precision_note
from qgeo_filters.io.vertex_colors import is_color

Reader = Callable[[Path, bool], RawMesh]
BareWriter = Callable[[Path, FloatArray, IntArray], None]
Writer = Callable[[Path, FloatArray, IntArray, Mapping[str, np.ndarray]], None]
Kept = Callable[[str, np.ndarray], bool]

_READERS: dict[str, Reader] = {
    ".ply": ply.read,
    ".off": off.read,
    ".obj": obj.read,
    ".stl": stl.read,
    ".glb": gltf.read,
    ".gltf": gltf.read,
    ".vert": tosca.read_pair,
    ".tri": tosca.read_pair,
    ".mat": mat.read,
    ".gii": brain_surfaces.read_gifti,
    ".vtk": grids.read_vtk,
    ".vtp": grids.read_vtk,
    ".vtu": grids.read_vtk,
    ".msh": grids.read_gmsh,
}
#: Of files that are read. Of a TOSCA pair the one with the vertices stands for both.
SUFFIXES = frozenset(_READERS) - {".tri"}


def _bare(write: BareWriter) -> tuple[Writer, Kept]:
    """A writer of positions and faces alone, as one that keeps no attribute."""
    return lambda path, vertices, faces, _: write(path, vertices, faces), lambda name, values: False


def _all(name: str, values: np.ndarray) -> bool:
    return True


# How each is written, and which attributes it keeps.
_WRITERS: dict[str, tuple[Writer, Kept]] = {
    ".ply": (ply.write, _all),
    ".off": _bare(off.write),
    ".obj": (obj.write, is_color),
    ".stl": _bare(stl.write),
    ".glb": (gltf_writing.write, gltf_writing.is_kept),
    ".vert": _bare(tosca.write_pair),
    ".tri": _bare(tosca.write_pair),
    ".mat": _bare(mat.write),
    ".vtp": (vtk_xml.write_polygons, _all),
    ".vtu": (vtk_xml.write_cells, _all),
    ".csv": (vertex_table.write, _all),
}
_SINGLE_PRECISION = (".stl", ".glb")


def read_raw(path: str | os.PathLike[str], *, repair: bool = False) -> RawMesh:
    """Arrays of a file, not checked yet; ``repair`` triangulates polygons.

    Parameters
    ----------
    path : path
        The format is told by the suffix, see the table at the top of this module. Of a TOSCA pair, either
        file or the stem without suffix.
    repair : bool

    Warns
    -----
    UserWarning
        What of the file was passed over; with ``repair`` it stands in the notes instead.

    Raises
    ------
    FileNotFoundError, IsADirectoryError
    MeshError
        An unknown suffix, a malformed file, polygons; the message starts with the path.
    """
    file = Path(path)
    reader = _READERS.get(file.suffix.lower())
    stem = file.parent / f"{file.name}.vert"
    if reader is None and stem.is_file():
        file, reader = stem, tosca.read_pair
    if not file.exists():
        raise FileNotFoundError(f"no such file: {file}")
    if file.is_dir():
        raise IsADirectoryError(f"{file} is a folder, not a mesh")
    if reader is None and brain_surfaces.is_freesurfer(file):
        reader = brain_surfaces.read_freesurfer
    if reader is None:
        raise MeshError(
            f"{file}: unknown suffix {file.suffix!r}; read are {', '.join(_READERS)} and FreeSurfer's surfaces"
        )
    with path_in_errors(file), np.errstate(all="ignore"):  # what is not finite is found by the checks
        raw = reader(file, repair)
    if not repair:
        for note in raw.notes:
            warnings.warn(f"{file}: {note}", stacklevel=3)  # the level is that of who calls Surface.read
    return raw


def write_raw(
    path: str | os.PathLike[str],
    vertices: FloatArray,
    faces: IntArray,
    attributes: Mapping[str, np.ndarray] | None = None,
) -> None:
    """Write arrays to a file that is either whole or not there; the format is told by the suffix.

    Parameters
    ----------
    path : path
        PLY keeps everything and reads back bit by bit; what the others keep is in the table at the top.
    vertices : (n, 3) float64
    faces : (m, 3) int32
    attributes : mapping of str to array, shape (n,) or (n, ...), optional

    Warns
    -----
    UserWarning
        Naming the attributes that the format drops, and how far float32 moves the vertices where that can be seen.

    Raises
    ------
    MeshError
        An unknown suffix, an attribute that is not of numbers where these are kept, coordinates that float32 cannot
        hold; the message starts with the path.
    OSError
        Where the file cannot be written.
    """
    file = Path(path)
    suffix = file.suffix.lower()
    with path_in_errors(file):
        if suffix not in _WRITERS:
            raise MeshError(f"unknown suffix {file.suffix!r}; written are {', '.join(_WRITERS)}")
        write, is_kept = _WRITERS[suffix]
        note = single_precision_note(vertices, faces) if suffix in _SINGLE_PRECISION else None
    kept = {name: values for name, values in (attributes or {}).items() if is_kept(name, values)}
    # The level of warnings is that of who calls Surface.write.
    if note:
        warnings.warn(f"{file}: {note}", stacklevel=3)
    if lost := sorted((attributes or {}).keys() - kept.keys()):
        which = "attributes" if not kept else "such attributes"
        names = ", ".join(map(repr, lost))
        warnings.warn(f"{file}: {file.suffix} holds no {which}, dropped: {names} (write .ply)", stacklevel=3)
    with path_in_errors(file):
        write(file, vertices, faces, kept)


@contextmanager
def path_in_errors(path: str | os.PathLike[str] | None) -> Iterator[None]:
    """Context in which the message of a `MeshError` gets the path in front; None: nothing."""
    try:
        yield
    except MeshError as error:
        if path is None:
            raise
        raise type(error)(f"{os.fspath(path)}: {reason(error)}") from error
