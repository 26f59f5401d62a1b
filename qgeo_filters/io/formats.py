"""Surfaces from files and to files, by suffix.

==================  ============================================  =======================================
suffix              read                                          written
==================  ============================================  =======================================
.ply                ascii and binary, all vertex properties       binary, float64, every attribute
.off                OFF, COFF, NOFF; positions and faces          17 digits
.obj                positions and faces; groups are joined        17 digits
.stl                ascii and binary; equal corners are welded    binary, float32
.glb, .gltf         trimesh; equal vertices are welded            .glb, float32
.vert + .tri        TOSCA, from 1; either name or the stem        both files, 17 digits
.mat                TOSCA, ``surface`` with X, Y, Z, TRIV         the same
==================  ============================================  =======================================
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from pathlib import Path

from qgeo_filters.errors import MeshError
from qgeo_filters.io import off_obj, ply, stl_glb, tosca
from qgeo_filters.io.raw_mesh import RawMesh
from qgeo_filters.surface import Surface

Reader = Callable[[Path, bool], RawMesh]
Writer = Callable[[Path, Surface], None]

_READERS: dict[str, Reader] = {
    ".ply": ply.read,
    ".off": off_obj.read_off,
    ".obj": off_obj.read_obj,
    ".stl": stl_glb.read_stl,
    ".glb": stl_glb.read_glb,
    ".gltf": stl_glb.read_glb,
    ".vert": tosca.read_pair,
    ".tri": tosca.read_pair,
    ".mat": tosca.read_mat,
}
_WRITERS: dict[str, Writer] = {
    ".ply": ply.write,
    ".off": off_obj.write_off,
    ".obj": off_obj.write_obj,
    ".stl": stl_glb.write_stl,
    ".glb": stl_glb.write_glb,
    ".vert": tosca.write_pair,
    ".tri": tosca.write_pair,
    ".mat": tosca.write_mat,
}


def read_surface(path: str | os.PathLike[str], *, repair: bool = False) -> Surface:
    """Surface from a file.

    Parameters
    ----------
    path : path
        The format is told by the suffix, see the table at the top of this module. Of a TOSCA pair, either
        file or the stem without suffix.
    repair : bool
        Triangulate polygons and make the mesh manifold and one piece, see `repair.repair_surface`.

    Raises
    ------
    FileNotFoundError
    MeshError
        An unknown suffix, a malformed file, polygons, an invalid mesh; the message starts with the path.
    """
    raw = read_raw(path, repair=repair)
    try:
        if repair:
            from qgeo_filters.hosts.repair import repair_surface

            return repair_surface(raw).surface
        return raw.surface()
    except MeshError as error:
        raise type(error)(f"{os.fspath(path)}: {error}") from error


def read_raw(path: str | os.PathLike[str], *, repair: bool = False) -> RawMesh:
    """Arrays of a file, not checked yet; ``repair`` triangulates polygons."""
    file = Path(path)
    reader = _READERS.get(file.suffix.lower())
    stem = file.parent / f"{file.name}.vert"
    if reader is None and stem.is_file():
        file, reader = stem, tosca.read_pair
    if not file.exists():
        raise FileNotFoundError(f"no such file: {file}")
    if file.is_dir():
        raise IsADirectoryError(f"{file} is a folder, not a mesh")
    if reader is None:
        raise MeshError(f"{file}: unknown suffix {file.suffix!r}; read are {', '.join(_READERS)}")
    try:
        return reader(file, repair)
    except MeshError as error:
        raise MeshError(f"{file}: {error}") from error


def write_surface(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a surface to a file that is either whole or not there; the format is told by the suffix.

    Parameters
    ----------
    surface : Surface
    path : path
        PLY keeps everything and reads back bit by bit. The other formats hold no attributes.

    Warns
    -----
    UserWarning
        Naming the attributes that the format drops.

    Raises
    ------
    MeshError
        An unknown suffix, or an attribute that PLY cannot hold (text, objects).
    OSError
        Where the file cannot be written.
    """
    file = Path(path)
    writer = _WRITERS.get(file.suffix.lower())
    if writer is None:
        raise MeshError(f"{file}: unknown suffix {file.suffix!r}; written are {', '.join(_WRITERS)}")
    if surface.attributes and file.suffix.lower() != ".ply":
        names = ", ".join(map(repr, sorted(surface.attributes)))
        warnings.warn(f"{file}: {file.suffix} holds no attributes, dropped: {names} (write .ply)", stacklevel=2)
    writer(file, surface)
