"""Triangles out of cells of many kinds, numbered as VTK numbers them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import MeshError
from qgeo_filters.io.polygons import Polygons, strip_triangles, triangulated
from qgeo_filters.io.raw_mesh import counted

_EMPTY, _POINTS, _LINES, _STRIP, _PIXEL, _VOXEL = 0, (1, 2), (3, 4), 6, 8, 11
_POLYGONS = (5, 7, 8, 9)  # triangle, polygon, pixel, quadrilateral
# Sides of solid cells, turned outward.
_SIDES: dict[int, tuple[tuple[int, ...], ...]] = {
    10: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)),  # tetrahedron
    12: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),  # hexahedron
    13: ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),  # wedge
    14: ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),  # pyramid
}
_NAMES = {10: "tetrahedra", 12: "hexahedra", 13: "wedges", 14: "pyramids"}


def cell_triangles(
    vertices: FloatArray, kinds: IndexArray, sizes: IndexArray, corners: IndexArray, repair: bool
) -> tuple[npt.NDArray[np.int64], tuple[str, ...]]:
    """Triangles of a mesh of cells, and what was changed to get them.

    Parameters
    ----------
    vertices : (n, 3) float64
    kinds, sizes : (m,) int64
        VTK's code and the number of corners of each cell.
    corners : (total,) int64
        Vertices of all cells, one after the other.
    repair : bool
        Split polygons; of solid cells take the boundary.

    Raises
    ------
    MeshError
        Cells that are no surface; polygons or solid cells and not `repair`.
    """
    if (sizes < 0).any():
        raise MeshError(f"cell {np.argmax(sizes < 0)} has {sizes[sizes < 0][0]} corners")
    if len(kinds) != len(sizes) or sizes.sum() != len(corners):
        raise MeshError(f"{len(kinds)} cells have {sizes.sum()} corners, but {len(corners)} are listed")
    kinds, sizes, corners = _without_voxels(kinds, sizes, corners)
    known = np.isin(kinds, [_EMPTY, *_POINTS, *_LINES, _STRIP, *_POLYGONS, *_SIDES])
    if not known.all():
        at = int(np.argmin(known))
        raise MeshError(
            f"cell {at} is of VTK's kind {kinds[at]}, which is not read ({counted((~known).sum(), 'such cell')})"
        )
    cells = Polygons(corners, sizes)
    solid = np.isin(kinds, list(_SIDES))
    if solid.any():
        return _boundary(vertices, cells, kinds, solid, repair)
    strips = cells.selected(kinds == _STRIP)
    ends = np.cumsum(strips.sizes)
    faces, notes = triangulated(vertices, cells.selected(np.isin(kinds, _POLYGONS)), repair)
    faces = np.concatenate([faces, strip_triangles(np.insert(strips.corners, ends, -1))])
    loose = [
        counted(count, noun)
        for noun, of_kind in (("point", _POINTS), ("line", _LINES))
        if (count := _n_loose(cells, np.isin(kinds, of_kind), faces))
    ]
    if loose:
        notes = (*notes, f"{' and '.join(loose)} beside the faces passed over")
    return faces, notes


def _without_voxels(
    kinds: IndexArray, sizes: IndexArray, corners: IndexArray
) -> tuple[IndexArray, IndexArray, IndexArray]:
    """Pixels and voxels, whose corners go by coordinates, as quadrilaterals and hexahedra, which go around."""
    kinds, corners = kinds.copy(), corners.copy()
    starts = np.cumsum(sizes) - sizes
    for kind, size, other in ((_PIXEL, 4, 9), (_VOXEL, 8, 12)):
        for low in range(0, size, 4):
            at = starts[(kinds == kind) & (sizes == size)] + low
            corners[at + 2], corners[at + 3] = corners[at + 3], corners[at + 2]
        kinds[kinds == kind] = other
    return kinds, sizes, corners


def _n_loose(cells: Polygons, which: npt.NDArray[np.bool_], faces: IndexArray) -> int:
    """How many of these cells have a vertex that no face has; the others only mark parts of the surface."""
    chosen = cells.selected(which)
    elsewhere = ~np.isin(chosen.corners, faces)
    cell = np.repeat(np.arange(len(chosen.sizes)), chosen.sizes)
    return len(np.unique(cell[elsewhere]))


def _boundary(
    vertices: FloatArray, cells: Polygons, kinds: IndexArray, solid: npt.NDArray[np.bool_], repair: bool
) -> tuple[npt.NDArray[np.int64], tuple[str, ...]]:
    """Triangles of the sides that only one solid cell has."""
    what = " and ".join(f"{(kinds == kind).sum()} {_NAMES[kind]}" for kind in _SIDES if (kinds == kind).any())
    if not repair:
        raise MeshError(f"it holds a solid of {what}, no surface; repair=True takes its boundary")
    sides = []
    for kind, local in _SIDES.items():
        of_kind = cells.selected(kinds == kind)
        size = max(map(max, local)) + 1
        if (of_kind.sizes != size).any():
            raise MeshError(f"{_NAMES[kind]} of the file have {of_kind.sizes[of_kind.sizes != size][0]} corners")
        corners = of_kind.corners.reshape(-1, size)
        for side in local:  # all four long: the fourth corner of a triangle is -1
            sides.append(np.full((len(corners), 4), -1))
            sides[-1][:, : len(side)] = corners[:, side]
    every = np.concatenate(sides)
    _, first, count = np.unique(np.sort(every, axis=1), axis=0, return_index=True, return_counts=True)
    outer = every[np.sort(first[count == 1])]
    notes = [f"the boundary of {what} taken"]
    n_faces = int(np.isin(kinds, (*_POLYGONS, _STRIP)).sum())
    if n_faces:
        notes.append(f"{counted(n_faces, 'face')} beside them passed over")
    filled = outer >= 0
    filled[:, :3] = True  # an index that is out of range is found by those who check the mesh
    faces, _ = triangulated(vertices, Polygons.of_flat(outer[filled], filled.sum(axis=1)), repair)
    return faces, tuple(notes)
