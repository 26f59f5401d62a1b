"""vedo meshes, both ways; vedo holds coordinates in single precision."""

from __future__ import annotations

import numpy as np
import pytest
from host_meshes import ATTRIBUTES, FACES, VERTICES, N, assert_attributes

import qgeo_filters as qg
from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.dispatch import as_surface, with_positions, write_back
from qgeo_filters.hosts.protocol import load_host

vedo = pytest.importorskip("vedo")
SINGLE = {name: values for name, values in ATTRIBUTES.items() if values.dtype.kind != "b"}
HELD = VERTICES.astype(np.float32)


@pytest.fixture
def mesh():
    mesh = vedo.Mesh([VERTICES, FACES])
    mesh.pointdata["own"] = np.arange(N, dtype=np.int16)
    mesh.celldata["part"] = np.arange(len(FACES))
    mesh.name = "mine"
    return mesh


def test_arrays_and_attributes_come_along(mesh):
    surface = as_surface(mesh)
    np.testing.assert_array_equal(surface.vertices, HELD)
    np.testing.assert_array_equal(surface.faces, FACES)
    assert_attributes(surface, {"own": np.arange(N, dtype=np.int16)})
    np.testing.assert_array_equal(qg.distances(mesh, 17), qg.distances((HELD, FACES), 17))


def test_attributes_go_and_come_back_and_the_mesh_keeps_its_own(mesh):
    active = mesh.dataset.GetPointData().GetScalars().GetName()
    out = write_back(mesh, as_surface(mesh), ATTRIBUTES)
    assert type(out) is vedo.Mesh
    assert_attributes(as_surface(out), {**SINGLE, "own": np.arange(N, dtype=np.int16)})
    np.testing.assert_array_equal(out.pointdata["qgeo_mask"], ATTRIBUTES["qgeo_mask"])
    np.testing.assert_array_equal(out.celldata["part"], np.arange(len(FACES)))
    assert out.name == "mine"
    assert out.dataset.GetPointData().GetScalars().GetName() == active
    assert mesh.pointdata.keys() == ["own"]
    out.pointdata["own"][:] = 0
    np.testing.assert_array_equal(mesh.pointdata["own"], np.arange(N))


def test_what_is_painted_is_what_is_shown(mesh):
    colors = np.linspace(0, 1, 3 * N).reshape(N, 3)
    out = write_back(mesh, as_surface(mesh), {"colors": colors})
    np.testing.assert_array_equal(out.pointcolors, np.column_stack([np.round(255 * colors), np.full(N, 255)]))
    assert out.mapper.GetScalarVisibility()
    assert set(as_surface(out).attributes) == {"own", "colors"}
    np.testing.assert_array_equal(as_surface(out).attributes["colors"], colors)
    repainted = write_back(out, as_surface(out), {"colors": 1 - colors})
    np.testing.assert_array_equal(repainted.pointcolors[:, :3], np.round(255 * (1 - colors)))
    assert mesh.pointdata.keys() == ["own"]


def test_a_mesh_that_was_moved_is_where_it_is_shown(mesh):
    mesh.shift(1, 2, 3)
    np.testing.assert_allclose(as_surface(mesh).vertices, HELD + np.array([1, 2, 3]), atol=1e-6)


def test_filters_give_their_kind_back(mesh):
    out = (qg.DifferentialCoordinates() | qg.SurfaceScalar())(mesh)
    assert type(out) is vedo.Mesh
    assert set(out.pointdata.keys()) == {"own", "qgeo_delta", "qgeo_scalar"}


def test_another_pose_has_its_own_normals(mesh):
    mesh.compute_normals()
    turned = VERTICES @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    before = np.array(mesh.pointdata["Normals"])
    posed = with_positions(mesh, turned)
    np.testing.assert_array_equal(posed.coordinates, turned.astype(np.float32))
    np.testing.assert_allclose(
        posed.pointdata["Normals"], before @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]), atol=1e-5
    )
    np.testing.assert_array_equal(posed.cells, FACES)
    np.testing.assert_array_equal(mesh.coordinates, HELD)


def test_polygons_are_refused_or_split():
    square = vedo.Mesh([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]])
    with pytest.raises(MeshError, match=r"face 0 has 4 corners .* pass repair=True"):
        as_surface(square)
    assert as_surface(square, repair=True).n_faces == 2


def test_what_is_no_surface_and_what_cannot_be_held():
    with pytest.raises(MeshError, match=r"a vedo Volume is no surface: pass a vedo\.Mesh"):
        as_surface(vedo.Volume(np.zeros((2, 2, 2))))
    mesh = vedo.Mesh([VERTICES, FACES])
    with pytest.raises(MeshError, match=r"attribute 'a' of dtype <U1 and shape \(\d+,\) cannot be held by a vedo mesh"):
        write_back(mesh, as_surface(mesh), {"a": ["b"] * N})


def test_a_mesh_in_double_precision_stays_so():
    surface = qg.Surface(VERTICES, FACES, {"own": np.arange(N)})
    mesh = load_host("vedo").make(surface)
    np.testing.assert_array_equal(as_surface(mesh).vertices, VERTICES)
    np.testing.assert_array_equal(as_surface(with_positions(mesh, VERTICES / 3)).vertices, VERTICES / 3)
