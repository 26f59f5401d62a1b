"""A manifold mesh in one piece from the arrays of any triangle soup, with what was changed and the way back.

PyMeshLab's repair filters renumber vertices without telling how, so that attributes could not be carried back.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from qgeo_filters import connectivity
from qgeo_filters._typing import FloatArray, IndexArray, IntArray, RepairOption
from qgeo_filters.equal_rows import equal_rows, occurring
from qgeo_filters.errors import DisconnectedError, MeshError
from qgeo_filters.io.raw_mesh import RawMesh, counted
from qgeo_filters.repair.copies import without_copies
from qgeo_filters.repair.manifold import consistent_flips, split_into_fans
from qgeo_filters.repair.sound import SoundMesh
from qgeo_filters.repair.welding import welded
from qgeo_filters.repair.winding import winding
from qgeo_filters.triangle_geometry import face_crosses
from qgeo_filters.validation import frozen, listed

#: Which pieces of a mesh stay when it is repaired.
Pieces: TypeAlias = Literal["largest", "all"]
#: The same, those first that change least.
PIECES: tuple[Pieces, ...] = ("all", "largest")

#: Share of the area beyond which a repair that was asked for is refused unless it is forced.
MOST_AREA_LOST = 0.01
# The same where only what is wrong is repaired: crumbs around the one piece that is meant, as scans have.
_MOST_AREA_OF_CRUMBS = 0.1
# The same of faces without a place, whose area nobody knows.
_MOST_FACES_LOST = 0.5


@dataclass(frozen=True, eq=False)
class RepairedMesh:
    """Arrays of a manifold mesh in one piece and how its vertices correspond to the original ones.

    Attributes
    ----------
    mesh : RawMesh
        The attributes are those of the original vertices.
    origin : (n_new,) int64
        Original index of each vertex; one original vertex may appear several times, where it was split.
    vertex_of_original : (n_old,) int64
        Vertex that stands for each original one, -1 where it is gone.
    face_origin : (m_new,) int64
        Face of the input that each face was.
    turned : (m_new,) bool
        Whether it was turned over: its corners are those of the input from last to first.
    report : tuple of str
        What was changed, one sentence each with its count, the notes of the input first; empty if nothing was.
    """

    mesh: RawMesh
    origin: IndexArray
    vertex_of_original: IndexArray
    face_origin: IndexArray
    turned: npt.NDArray[np.bool_]
    report: tuple[str, ...]


@np.errstate(over="ignore", invalid="ignore")  # coordinates too large for areas are refused in words
def repaired_mesh(sound: SoundMesh, *, most_lost: float = MOST_AREA_LOST, pieces: Pieces = "largest") -> RepairedMesh:
    """Manifold mesh in one piece; the steps are listed at `hosts.repair.repair_surface`.

    Parameters
    ----------
    sound : SoundMesh
    most_lost : float
        Share of the area that may be removed, and of the faces if it is more than half; 1 for whatever is left.
    pieces : {"largest", "all"}
        Which pieces stay; with all of them the mesh is only as connected as it was.

    Raises
    ------
    MeshError
        No faces are left, or too much would be removed.
    """
    report, vertices, faces = list(sound.notes), sound.vertices, sound.faces
    n_old = len(vertices)
    stands_for = _collapsed(vertices, faces, report)
    faces, kept = _without_repeats(stands_for[faces].astype(np.int32), np.arange(len(faces)), report)
    if len(faces) == 0:
        raise MeshError(f"nothing is left of the mesh after repair: {'; '.join(report)}")
    kept, original = _without_copies(vertices, faces, kept, report)
    faces = stands_for[sound.faces[kept]].astype(np.int32)
    joined = _welded(vertices, faces, report)
    stands_for = joined[original[stands_for]]
    faces, kept = _without_repeats(joined[faces].astype(np.int32), kept, report)
    area = _area(vertices, faces)
    origin, faces, left = split_into_fans(vertices, faces, report)
    kept = kept[left]
    if pieces == "largest":
        largest, sizes = _largest_piece(vertices[origin], faces, report)
        faces, kept = faces[largest], kept[largest]
        _check_loss(1 - _area(vertices[origin], faces) / area, sound.share_lost, sizes, most_lost, report)
    faces, turned = _turned_outwards(vertices[origin], faces, report)
    used = occurring(faces, len(origin))
    renumbered = np.full(len(origin), -1, dtype=np.int32)
    renumbered[used] = np.arange(len(used))
    origin, faces = origin[used], renumbered[faces]
    representative = np.full(n_old, -1, dtype=np.int64)
    representative[origin[::-1]] = np.arange(len(origin))[::-1]  # of several, the first
    vertex_of_original = representative[stands_for]
    loose = int((vertex_of_original < 0).sum())
    if loose:
        gone = listed(np.flatnonzero(vertex_of_original < 0))
        report.append(f"of {n_old} vertices {loose} {'is' if loose == 1 else 'are'} gone ({gone})")
    mesh = RawMesh(vertices[origin], faces, {name: values[origin] for name, values in sound.attributes.items()})
    return RepairedMesh(
        mesh,
        frozen(origin),
        frozen(vertex_of_original),
        frozen(sound.face_origin[kept]),
        frozen(turned),
        tuple(report),
    )


def most_lost(repair: RepairOption) -> float:
    """Share of the area that a repair may remove, for the option that asks for it."""
    return 1.0 if repair == "force" else _MOST_AREA_OF_CRUMBS if repair == "auto" else MOST_AREA_LOST


def _collapsed(vertices: np.ndarray, faces: IntArray, report: list[str]) -> IndexArray:
    """Vertex that each vertex becomes when edges of length zero are collapsed, the smallest of each group."""
    a, b = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).T
    zero = (vertices[a] == vertices[b]).all(axis=1)
    joined = connectivity.smallest_connected(np.column_stack([a, b])[zero], len(vertices))
    count = int((joined != np.arange(len(vertices))).sum())
    if count:
        report.append(f"{counted(count, 'vertex', 'vertices')} joined with a neighbour at the same position")
    return joined


def _without_copies(
    vertices: FloatArray, faces: IntArray, kept: IndexArray, report: list[str]
) -> tuple[IndexArray, IndexArray]:
    """Which faces stay when pieces that lie on others go, and the vertex that each vertex becomes."""
    stays, stands_for, n_pieces = without_copies(vertices, faces)
    if n_pieces:
        gone = counted(int((~stays).sum()), "face")
        report.append(f"{counted(n_pieces, 'piece')} removed that lay on others face by face, with {gone}")
    return kept[stays], stands_for


def _welded(vertices: FloatArray, faces: IntArray, report: list[str]) -> IndexArray:
    """Vertex that each vertex becomes when boundary edges that lie on each other are joined."""
    joined, distance = welded(vertices, faces)
    count = int((joined != np.arange(len(joined))).sum())
    if count:
        apart = f", up to {distance:.3g} apart" if distance else ""
        report.append(
            f"{counted(count, 'boundary vertex', 'boundary vertices')} joined with others at the same place{apart}"
        )
    return joined


def _without_repeats(faces: IntArray, kept: IndexArray, report: list[str]) -> tuple[IntArray, IndexArray]:
    """Faces, with the numbers that they go by, but for those without an inside and all but the first of equals."""
    flat = (faces == np.roll(faces, 1, axis=1)).any(axis=1)  # left by the collapse
    faces, kept = faces[~flat], kept[~flat]
    _, first = equal_rows(np.sort(faces, axis=1))
    if len(first) < len(faces):
        report.append(f"{counted(len(faces) - len(first), 'duplicate face')} removed")
    first.sort()
    return faces[first], kept[first]


def _area(positions: FloatArray, faces: IntArray) -> float:
    """Total area; the number of faces where none has any."""
    area = 0.5 * float(np.linalg.norm(face_crosses(positions, faces), axis=1).sum())
    return area or float(len(faces))


def _largest_piece(
    positions: np.ndarray, faces: IntArray, report: list[str]
) -> tuple[npt.NDArray[np.bool_], IndexArray]:
    """Which faces are those of the piece of largest area, and how many faces each piece has, the most first."""
    n = len(positions)
    _, label = connectivity.vertex_components(np.concatenate([faces[:, :2], faces[:, 1:]]), n)
    piece = label[faces[:, 0]]
    area = np.bincount(piece, 0.5 * np.linalg.norm(face_crosses(positions, faces), axis=1))
    size = np.bincount(piece)
    pieces = np.flatnonzero(size)
    sizes = np.sort(size[pieces])[::-1]
    if len(pieces) == 1:
        return np.ones(len(faces), dtype=bool), sizes
    largest = pieces[area[pieces].argmax()]
    kept = piece == largest
    share = 100 * area[largest] / area.sum() if area.sum() > 0 else 100 * kept.mean()
    report.append(
        f"{counted(len(pieces) - 1, 'smaller piece')} with {counted((~kept).sum(), 'face')} removed; the largest, "
        f"kept, has {share:.4g} % of the area"
    )
    return kept, sizes


def _check_loss(of_area: float, of_faces: float, sizes: IndexArray, most: float, report: list[str]) -> None:
    """Refuse a repair that keeps a shred: it removes much area, or most faces were without a place and so an area."""
    if of_area <= most and (of_faces <= _MOST_FACES_LOST or of_faces <= most):
        return
    lost = f"{100 * of_area:.3g} % of the area" if of_area > most else f"{100 * of_faces:.3g} % of the faces"
    several = len(sizes) > 1
    pieces = f"; one piece is needed, and there are {len(sizes)} pieces, of {listed(sizes)} faces" if several else ""
    raise (DisconnectedError if several else MeshError)(
        f"repair would remove {lost} ({'; '.join(report)}){pieces}; pass the piece that is meant, repair='force' to "
        "take what is left, or repair='wrap' for a closed surface around all of it"
    )


def _turned_outwards(
    positions: FloatArray, faces: IntArray, report: list[str]
) -> tuple[IntArray, npt.NDArray[np.bool_]]:
    """Faces of one orientation, which is outwards where there is an inside, and which of them were turned for that."""
    flips, orientable = consistent_flips(faces)
    if not orientable:
        report.append("the mesh is not orientable and keeps the orientation of its faces")
    turned = np.zeros(len(faces), dtype=bool)
    turned[flips] = True
    faces = np.where(turned[:, None], faces[:, ::-1], faces)
    inside_out = winding(positions, faces) == "inward"
    if inside_out:
        faces, turned = faces[:, ::-1], ~turned
    if turned.all():
        report.append(f"the mesh was inside out: {counted(len(faces), 'face')} turned over")
    elif turned.any():
        side = "so that all look outwards" if inside_out else "to the orientation of the others"
        report.append(f"{counted(turned.sum(), 'face')} turned over {side}")
    return np.ascontiguousarray(faces), turned
