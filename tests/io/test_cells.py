"""Triangles of cells: strips, pixels, polygons; the boundary of solids, turned outward."""

from __future__ import annotations

import numpy as np
import pytest

from qgeo_filters.errors import MeshError
from qgeo_filters.io.cells import cell_triangles
from qgeo_filters.surface import Surface

CUBE = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
AROUND = [0, 1, 3, 2, 4, 5, 7, 6]  # the cube's corners as a hexahedron names them
# kind: cells of the unit cube's corners that fill it
FILLINGS = {
    "tetrahedra": [
        (10, [0, a, b, 7]) for a, b in ((1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1))
    ],
    "hexahedra": [(12, AROUND)],
    "voxels": [(11, list(range(8)))],
    "wedges": [(13, [4, 5, 7, 0, 1, 3]), (13, [4, 7, 6, 0, 3, 2])],
    "pyramids": [(14, [0, 1, 3, 2, 7]), (14, [0, 4, 5, 1, 7]), (14, [0, 2, 6, 4, 7])],
    "tetrahedra and pyramids": [
        (10, [0, 1, 3, 7]), (10, [0, 3, 2, 7]), (14, [0, 4, 5, 1, 7]), (14, [0, 2, 6, 4, 7]),
    ],
}  # fmt: skip


def triangles(vertices, cells, repair=False):
    """Of (kind, corners) pairs."""
    kinds = np.array([kind for kind, _ in cells], dtype=np.int64)
    sizes = np.array([len(corners) for _, corners in cells], dtype=np.int64)
    corners = np.array([corner for _, corners in cells for corner in corners], dtype=np.int64)
    return cell_triangles(vertices, kinds, sizes, corners, repair)


@pytest.mark.parametrize("name", FILLINGS)
def test_the_boundary_of_a_solid_is_closed_and_faces_outward(name):
    with pytest.raises(MeshError, match=r"it holds a solid of \d+ .*, no surface; repair=True takes its boundary"):
        triangles(CUBE, FILLINGS[name])
    faces, notes = triangles(CUBE, FILLINGS[name], repair=True)
    surface = Surface(CUBE, faces)
    assert (surface.is_closed, surface.genus, surface.n_faces) == (True, 0, 12)
    assert surface.area == pytest.approx(6)
    a, b, c = np.moveaxis(CUBE[faces], 1, 0)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(1)
    assert len(notes) == 1


def test_faces_beside_a_solid_are_passed_over_aloud():
    faces, notes = triangles(CUBE, [*FILLINGS["hexahedra"], (5, [0, 3, 1]), (3, [0, 1])], repair=True)
    assert len(faces) == 12
    assert notes == ("the boundary of 1 hexahedra taken", "1 face beside them passed over")


def test_surface_cells_of_every_kind_cover_the_same_square():
    grid = np.array([[x, y, 0] for y in range(2) for x in range(3)], dtype=float)
    for cells in (
        [(5, [0, 1, 4]), (5, [0, 4, 3]), (5, [1, 2, 5]), (5, [1, 5, 4])],
        [(6, [0, 1, 3, 4]), (6, [1, 2, 4, 5])],
        [(8, [0, 1, 3, 4]), (8, [1, 2, 4, 5])],
        [(9, [0, 1, 4, 3]), (9, [1, 2, 5, 4])],
        [(7, [0, 1, 2, 5, 4, 3])],
        [(7, [0, 1, 4, 3]), (6, [1, 2, 4, 5])],
    ):
        faces, _ = triangles(grid, cells, repair=True)
        surface = Surface(grid, faces)
        assert surface.area == pytest.approx(2)
        np.testing.assert_array_equal(surface.face_normals, [[0, 0, 1]] * surface.n_faces)


def test_strips_need_no_repair_but_polygons_do():
    assert triangles(CUBE, [(6, [0, 1, 2, 3])])[0].tolist() == [[0, 1, 2], [2, 1, 3]]
    with pytest.raises(MeshError, match="face 0 has 4 corners"):
        triangles(CUBE, [(9, [0, 1, 3, 2])])


def test_points_and_lines_are_named_where_they_are_no_part_of_the_surface():
    cells = [(5, [0, 1, 2]), (1, [0]), (3, [0, 1]), (4, [1, 2, 0])]
    assert triangles(CUBE, cells)[1] == ()
    assert triangles(CUBE, [*cells, (1, [7]), (3, [2, 3])])[1] == ("1 point and 1 line beside the faces passed over",)


def test_cells_that_are_not_read_are_named():
    with pytest.raises(MeshError, match=r"cell 1 is of VTK's kind 22, which is not read \(1 such cell\)"):
        triangles(CUBE, [(5, [0, 1, 2]), (22, [0, 1, 2, 3, 4, 5])])
    with pytest.raises(MeshError, match="1 cells have 4 corners, but 3 are listed"):
        cell_triangles(CUBE, np.array([5]), np.array([4]), np.array([0, 1, 2]), False)
    with pytest.raises(MeshError, match="cell 1 has -1 corners"):
        cell_triangles(CUBE, np.array([5, 5]), np.array([4, -1]), np.array([0, 1, 2]), False)
    with pytest.raises(MeshError, match="tetrahedra of the file have 3 corners"):
        triangles(CUBE, [(10, [0, 1, 2])], repair=True)
