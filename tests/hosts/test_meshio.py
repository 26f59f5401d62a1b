"""meshio meshes, both ways: blocks of cells, what is no surface, what its own formats keep."""

from __future__ import annotations

import numpy as np
import pytest
from host_meshes import ATTRIBUTES, FACES, VERTICES, N, assert_attributes

import qgeo_filters as qg
from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.dispatch import as_surface, with_positions, write_back

meshio = pytest.importorskip("meshio")
SINGLE = {name: values for name, values in ATTRIBUTES.items() if values.dtype.kind != "b"}


@pytest.fixture
def mesh():
    return meshio.Mesh(
        VERTICES,
        [("line", FACES[:5, :2]), ("triangle", FACES[:100]), ("triangle", FACES[100:])],
        point_data={"own": np.arange(N, dtype=np.int16)},
        cell_data={"part": [np.zeros(5), np.ones(100), np.full(len(FACES) - 100, 2.0)]},
        field_data={"note": np.array([1, 2])},
    )


def test_all_blocks_of_triangles_are_the_surface(mesh):
    surface = as_surface(mesh)
    np.testing.assert_array_equal(surface.vertices, VERTICES)
    np.testing.assert_array_equal(surface.faces, FACES)
    assert_attributes(surface, {"own": np.arange(N, dtype=np.int16)})
    np.testing.assert_array_equal(qg.distances(mesh, 17), qg.distances((VERTICES, FACES), 17))


def test_attributes_go_and_come_back_and_the_mesh_keeps_its_own(mesh):
    out = write_back(mesh, as_surface(mesh), ATTRIBUTES)
    assert type(out) is meshio.Mesh
    assert_attributes(as_surface(out), {**SINGLE, "own": np.arange(N, dtype=np.int16)})
    assert out.point_data["qgeo_mask"].dtype == np.int8
    np.testing.assert_array_equal(out.point_data["qgeo_mask"], ATTRIBUTES["qgeo_mask"])
    assert [(block.type, len(block)) for block in out.cells] == [(block.type, len(block)) for block in mesh.cells]
    assert list(out.cell_data) == ["part"]
    assert list(out.field_data) == ["note"]
    assert set(mesh.point_data) == {"own"}
    out.points[:] = 0
    out.point_data["own"][:] = 0
    np.testing.assert_array_equal(mesh.points, VERTICES)
    np.testing.assert_array_equal(mesh.point_data["own"], np.arange(N))


def test_what_a_filter_adds_is_in_the_file_that_meshio_saves(mesh, tmp_path):
    out = (qg.DifferentialCoordinates() | qg.SurfaceScalar())(write_back(mesh, as_surface(mesh), ATTRIBUTES))
    out.write(tmp_path / "a.vtu")
    back = meshio.read(tmp_path / "a.vtu")
    for name in ("qgeo_delta", "qgeo_scalar", "qgeo_mask", "own"):
        np.testing.assert_array_equal(back.point_data[name], out.point_data[name])


def test_another_pose_keeps_the_precision(mesh):
    mesh.points = VERTICES.astype(np.float32)
    posed = with_positions(mesh, 2 * VERTICES)
    assert posed.points.dtype == np.float32
    np.testing.assert_array_equal(posed.points, 2 * VERTICES.astype(np.float32))
    np.testing.assert_array_equal(mesh.points, VERTICES.astype(np.float32))


def test_a_plane_mesh_lies_at_height_zero():
    surface = as_surface(meshio.Mesh(np.array([[0.0, 0], [1, 0], [0, 1]]), [("triangle", np.array([[0, 1, 2]]))]))
    np.testing.assert_array_equal(surface.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])


def test_polygons_and_solids_are_refused_or_repaired():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]])
    mixed = meshio.Mesh(square, [("quad", np.array([[0, 1, 2, 3]])), ("triangle", np.array([[1, 4, 2]]))])
    with pytest.raises(MeshError, match=r"face 0 has 4 corners .* pass repair=True"):
        as_surface(mixed)
    assert as_surface(mixed, repair=True).n_faces == 3
    solid = meshio.Mesh(np.eye(4)[:, :3], [("tetra", np.array([[0, 1, 2, 3]]))])
    with pytest.raises(MeshError, match="it holds a solid of 1 tetrahedra, no surface; repair=True takes its boundary"):
        as_surface(solid)
    assert as_surface(solid, repair=True).is_closed


def test_curved_cells_and_other_objects_are_refused():
    curved = meshio.Mesh(np.zeros((6, 3)), [("triangle6", np.arange(6)[None])])
    with pytest.raises(MeshError, match="cells of kind triangle6: make it a mesh of order 1"):
        as_surface(curved)
    with pytest.raises(MeshError, match="a meshio CellBlock is no mesh"):
        as_surface(curved.cells[0])


def test_an_attribute_that_cannot_be_held_is_named(mesh):
    with pytest.raises(MeshError, match=r"attribute 'a' of dtype <U1 cannot be held by a meshio mesh"):
        write_back(mesh, as_surface(mesh), {"a": ["b"] * N})
