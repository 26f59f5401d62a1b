"""What `Surface` can hold of a triangle list, with the vertices as they are numbered: before anything is repaired."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.errors import MeshError
from qgeo_filters.io.raw_mesh import RawMesh, counted
from qgeo_filters.validation import checked_attributes, checked_faces, checked_vertices, frozen, listed


@dataclass(frozen=True, eq=False)
class SoundMesh:
    """A mesh of finite coordinates and faces of three different vertices, and what had to be left out for that.

    Attributes
    ----------
    vertices : (n, 3) float64
        All that were given; one whose coordinates are not finite has no face and lies in the middle of the others.
    faces : (m, 3) int32
    face_origin : (m,) int64
        Index of each face among those that were given.
    attributes : mapping of str to array, shape (n, ...)
    notes : tuple of str
        The notes of the input and what was left out, one sentence each with its count.
    share_lost : float
        Of the faces that were given, those that name a vertex that is missing or not finite.
    """

    vertices: FloatArray
    faces: IntArray
    face_origin: IndexArray
    attributes: dict[str, np.ndarray]
    notes: tuple[str, ...]
    share_lost: float

    @property
    def raw(self) -> RawMesh:
        """The same arrays as a mesh that came from outside."""
        return RawMesh(self.vertices, self.faces, self.attributes, self.notes)


def sound_mesh(raw: RawMesh) -> SoundMesh:
    """The mesh without faces that no `Surface` can hold.

    Raises
    ------
    MeshError
        No face is left, or the arrays are no triangle list at all.
    """
    vertices, faces = _arrays(raw)
    attributes = dict(checked_attributes(raw.attributes, len(vertices)))
    report = list(raw.notes)
    outside = ((faces < 0) | (faces >= len(vertices))).any(axis=1)
    lost = np.logical_not(np.isfinite(vertices).all(axis=1))
    touched = np.zeros(len(faces), dtype=bool)
    if outside.any():
        report.append(f"{counted(outside.sum(), 'face')} with missing vertices removed")
    if lost.any():
        touched[~outside] = lost[faces[~outside]].any(axis=1)
        report.append(
            f"{counted(lost.sum(), 'vertex', 'vertices')} with coordinates that are not finite "
            f"({listed(np.flatnonzero(lost))}) removed, with {counted(touched.sum(), 'face')}"
        )
        vertices[lost] = vertices[~lost].mean(axis=0) if not lost.all() else 0.0
    placed = ~outside & ~touched
    twice = placed & (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    if twice.any():
        report.append(f"{counted(twice.sum(), 'face')} with a repeated vertex removed")
    kept = np.flatnonzero(placed & ~twice)
    if len(kept) == 0:
        raise MeshError(f"nothing is left of the mesh after repair: {'; '.join(report) or 'it has no faces'}")
    share_lost = 1 - np.count_nonzero(placed) / len(faces)
    return SoundMesh(vertices, faces[kept], frozen(kept), attributes, tuple(report), share_lost)


def _arrays(raw: RawMesh) -> tuple[FloatArray, IntArray]:
    """Arrays of the right shape; what no repair can make sense of is refused as always."""
    try:
        if np.iscomplexobj(raw.vertices):  # NumPy would drop the imaginary part, with a warning
            raise TypeError
        vertices, faces = np.array(raw.vertices, dtype=np.float64), np.asarray(raw.faces)
    except (TypeError, ValueError):
        checked_faces(raw.faces, len(checked_vertices(raw.vertices)))  # raises, with the reason
        raise
    whole = faces.dtype.kind in "iu" or (faces.dtype.kind == "f" and bool(np.all(faces == np.floor(faces))))
    if (
        len(vertices) == 0
        or vertices.ndim != 2
        or vertices.shape[1:] != (3,)
        or faces.ndim != 2
        or faces.shape[1:] != (3,)
        or not whole
    ):
        checked_faces(faces, len(checked_vertices(vertices)))  # raises
        raise AssertionError("unreachable: Surface accepts what repair does not")
    finite = np.isfinite(vertices).all(axis=1)
    if finite.any():
        checked_vertices(vertices[finite])  # raises where it is too large or too small
    # Out of range where int32 does not reach is out of range all the same.
    return vertices, np.clip(faces, -1, np.iinfo(np.int32).max).astype(np.int32)
