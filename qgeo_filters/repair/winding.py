"""Which side of a triangle mesh is out: by the signed volume where it is closed, by winding numbers where it is open.

Just above an outward triangle of a closed surface the winding number is 0 and just below it 1; of an inward one -1 and
0. Their sum is the outwardness of a surface there: 1 or -1 where it is closed, 0 on a plane, and in between on what is
open. The numbers are those of the whole mesh, so that the walls of a cavity are outward when they look into it.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import igl
import numpy as np

from qgeo_filters import connectivity
from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.equal_rows import occurring
from qgeo_filters.triangle_geometry import face_crosses, unit_normals

Winding: TypeAlias = Literal["outward", "inward", "mixed", "undetermined"]

# A hemisphere has 0.6, a long half-tube 0.5: a sheet that bends less may bend the other way in the next pose.
_TOLD = 0.5
# A closed volume, as a fraction of area^(3/2), below which its sign is rounding; a sphere has 0.094.
_NO_VOLUME = 1e-9
# Share of its volume at rest, with the other sign, from which a pose is inside out: limbs that cross take far less.
_INSIDE_OUT = 0.5
_SAMPLES = 256
_MOST_PIECES = 64  # of the largest area; smaller ones are not looked at
_OFFSET = 1e-3  # of sqrt(area) of a triangle


def winding(vertices: FloatArray, faces: IntArray) -> Winding:
    """Whether faces look outwards.

    Returns
    -------
    str
        "outward" or "inward"; "mixed" where neighbouring faces or pieces disagree; "undetermined" where no piece has
        an inside, such as a sheet, or less of one than a half-tube.
    """
    edges, face_edges, _ = connectivity.unique_edges(faces)
    if connectivity.flipped_edges(faces, connectivity.halfedge_twins(faces, face_edges, len(edges))).size:
        return "mixed"
    outwardness = _outwardness(vertices, faces, connectivity.vertex_components(edges, len(vertices))[1][faces[:, 0]])
    outward, inward = bool((outwardness > _TOLD).any()), bool((outwardness < -_TOLD).any())
    if outward and inward:
        return "mixed"
    return "outward" if outward else "inward" if inward else "undetermined"


def relative_volume(vertices: FloatArray, faces: IntArray) -> float:
    """Volume within, with its sign, over area^(3/2); holes are closed from the mean of the corners."""
    corners = vertices[faces]
    crosses = face_crosses(vertices, faces)
    area = 0.5 * np.linalg.norm(crosses, axis=1).sum()
    volume = np.einsum("ij,ij->", corners[:, 0] - corners.mean(axis=(0, 1)), crosses) / 6
    return float(volume / area**1.5) if area > 0 else 0.0


def is_inside_out(positions: FloatArray, rest: FloatArray, faces: IntArray) -> bool:
    """Whether what is inside at rest is outside in a pose, as on a mirror image; for surfaces that have an inside."""
    before, now = relative_volume(rest, faces), relative_volume(positions, faces)
    return bool(now * np.sign(before) < -_INSIDE_OUT * abs(before))


def _outwardness(vertices: FloatArray, faces: IntArray, piece: IntArray) -> FloatArray:
    """Mean outwardness over the area of each piece, -1 to 1, the largest pieces first; those of no area left out."""
    used = occurring(faces, len(vertices))  # the others may be anything
    number = np.zeros(len(vertices), dtype=faces.dtype)
    number[used] = np.arange(len(used))
    unit, faces = vertices[used], number[faces]
    unit = (unit - unit.mean(axis=0)) / (float(np.ptp(unit, axis=0).max()) or 1.0)  # libigl's tolerances are absolute
    crosses = face_crosses(unit, faces)
    area = np.bincount(piece, 0.5 * np.linalg.norm(crosses, axis=1))
    largest = np.argsort(-area, kind="stable")[:_MOST_PIECES]
    largest = largest[area[largest] > 0]
    _, _, counts = connectivity.unique_edges(faces)
    if len(largest) == 1 and counts.min() > 1:
        volume = relative_volume(unit, faces)
        return np.array([np.sign(volume) if abs(volume) > _NO_VOLUME else 0.0])
    chosen = [_spread(np.flatnonzero(piece == label), crosses) for label in largest]
    if not chosen:
        return np.empty(0)
    sums = _winding_sums(unit, faces, crosses, np.concatenate(chosen))
    return sums.reshape(len(chosen), _SAMPLES).mean(axis=1)


def _spread(own: IndexArray, crosses: FloatArray) -> IndexArray:
    """Faces of a piece, evenly spread over its area."""
    reached = np.cumsum(np.linalg.norm(crosses[own], axis=1))
    steps = (np.arange(_SAMPLES) + 0.5) / _SAMPLES * reached[-1]
    chosen: IndexArray = own[np.searchsorted(reached, steps)]
    return chosen


def _winding_sums(vertices: FloatArray, faces: IntArray, crosses: FloatArray, chosen: IndexArray) -> FloatArray:
    """Sum of the winding numbers just above and just below each of some triangles, -1 to 1."""
    middle = vertices[faces[chosen]].mean(axis=1)
    size = np.linalg.norm(crosses[chosen], axis=1, keepdims=True)
    step = _OFFSET * np.sqrt(size / 2) * unit_normals(crosses[chosen])
    numbers = igl.fast_winding_number(vertices, faces.astype(np.int64), np.concatenate([middle + step, middle - step]))
    above, below = np.split(numbers, 2)
    return np.clip(above + below, -1.0, 1.0)
