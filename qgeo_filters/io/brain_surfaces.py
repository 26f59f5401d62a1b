"""Surfaces of neuroimaging, by nibabel: FreeSurfer's binary files, which have no suffix of their own, and GIFTI."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any
from xml.parsers.expat import ExpatError

import numpy as np

from qgeo_filters.errors import MeshError, reason, require_package
from qgeo_filters.io.damage import DAMAGED_FILE
from qgeo_filters.io.raw_mesh import RawMesh, counted

_TRIANGLES, _QUADS = b"\xff\xff\xfe", (b"\xff\xff\xff", b"\xff\xff\xfd")
_DIMENSIONALITY = re.compile(rb"Dimensionality\s*=\s*[\"'][\s+]*(\d+)")
_POSITIONS, _FACES, _NUMBERS = "NIFTI_INTENT_POINTSET", "NIFTI_INTENT_TRIANGLE", "NIFTI_INTENT_NODE_INDEX"


def is_freesurfer(path: Path) -> bool:
    """Whether a file (``lh.pial``, ``rh.white`` ...) begins as FreeSurfer's surfaces do."""
    with path.open("rb") as file:
        return file.read(3) in (_TRIANGLES, *_QUADS)


def read_freesurfer(path: Path, repair: bool) -> RawMesh:
    """Arrays of a FreeSurfer surface, in its own coordinates (surface RAS, millimetres)."""
    nibabel = require_package("nibabel", "files", f"reading {path.name}")
    _check_counts(path)
    try:
        with warnings.catch_warnings(action="ignore"):
            positions, faces = nibabel.freesurfer.read_geometry(path)
    except DAMAGED_FILE as error:
        raise MeshError(f"not a readable FreeSurfer surface ({reason(error)})") from error
    return RawMesh(positions, faces)


def read_gifti(path: Path, repair: bool) -> RawMesh:
    """Arrays of a GIFTI surface; what else it has per vertex are attributes."""
    nibabel = require_package("nibabel", "files", f"reading {path.name}")
    _check_dimensions(path)
    errors = (*DAMAGED_FILE, AssertionError, OSError, MemoryError, ExpatError, nibabel.filebasedimages.ImageFileError)
    try:
        with warnings.catch_warnings(action="ignore"):
            arrays = nibabel.gifti.GiftiImage.from_filename(path).darrays
            intents = [nibabel.nifti1.intent_codes.niistring[array.intent] for array in arrays]
    except errors as error:
        raise MeshError(f"not a readable GIFTI file ({reason(error)})") from error
    if _POSITIONS not in intents or _FACES not in intents:
        found = ", ".join(dict.fromkeys(intents)) or "none"
        raise MeshError(f"no surface, which takes points and triangles; its arrays are {found}")
    positions, faces = (np.asarray(arrays[intents.index(intent)].data) for intent in (_POSITIONS, _FACES))
    rest = [
        (intent, array)
        for intent, array in zip(intents, arrays, strict=True)
        if intent not in (_POSITIONS, _FACES, _NUMBERS) and np.ndim(array.data) and len(array.data) == len(positions)
    ]
    n_over = len(arrays) - len(rest) - 2
    notes = (f"{counted(n_over, 'array')} beside the surface passed over",) if n_over else ()
    return RawMesh(positions, faces, _attributes(rest), notes)


def _check_dimensions(path: Path) -> None:
    """Refuse arrays of more dimensions than NIfTI has, to whose number nibabel would count one by one."""
    content = path.read_bytes().replace(b"\0", b"")  # those of UTF-16
    for found in _DIMENSIONALITY.finditer(content):
        digits = found[1].lstrip(b"0")
        if len(digits) > 1 or digits > b"7":
            raise MeshError(f"not a readable GIFTI file (an array of {digits[:20].decode()} dimensions)")


def _check_counts(path: Path) -> None:
    """Refuse counts for which the file is too short, before arrays of their size are made."""
    with path.open("rb") as file:
        if file.read(3) != _TRIANGLES:
            return  # quadrilaterals are counted in 3 bytes
        file.readline()
        file.readline()
        counts = file.read(8)
        rest = path.stat().st_size - file.tell()
    n_vertices, n_faces = np.frombuffer(counts, ">i4").tolist() if len(counts) == 8 else (-1, -1)
    if n_vertices < 0 or n_faces < 0 or 12 * (n_vertices + n_faces) > rest:
        raise MeshError(
            f"not a readable FreeSurfer surface ({n_vertices} vertices and {n_faces} faces announced, "
            f"but only {rest} bytes follow)"
        )


def _attributes(arrays: list[tuple[str, Any]]) -> dict[str, np.ndarray]:
    """Values of the arrays under the names that the file gives them, or under those of their intents."""
    attributes: dict[str, np.ndarray] = {}
    for intent, array in arrays:
        name = base = (array.meta or {}).get("Name") or intent.removeprefix("NIFTI_INTENT_").lower()
        count = 1
        while name in attributes:
            count += 1
            name = f"{base}_{count}"
        values = np.asarray(array.data)
        attributes[name] = values.astype(values.dtype.newbyteorder("="))
    return attributes
