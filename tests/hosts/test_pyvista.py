"""PyVista surfaces, both ways, and the accessor."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from host_meshes import ATTRIBUTES, FACES, VERTICES, M, N, assert_attributes

from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.dispatch import as_surface, with_positions, write_back
from qgeo_filters.hosts.repair import repair_surface

pyvista = pytest.importorskip("pyvista")


@pytest.fixture
def mesh():
    mesh = pyvista.PolyData.from_regular_faces(VERTICES, FACES)
    mesh.point_data["own"] = np.arange(N, dtype=np.int16)
    mesh.cell_data["own"] = np.arange(M)
    mesh.field_data["note"] = ["kept"]
    mesh.point_data.active_texture_coordinates = VERTICES[:, :2]
    mesh.set_active_scalars("own", preference="cell")
    return mesh


def test_arrays_and_attributes_come_along(mesh):
    surface = as_surface(mesh)
    np.testing.assert_array_equal(surface.vertices, VERTICES)
    np.testing.assert_array_equal(surface.faces, FACES)
    assert surface.attributes["own"].dtype == np.int16
    np.testing.assert_array_equal(surface.attributes["own"], np.arange(N))


def test_attributes_go_and_come_back_and_the_host_keeps_its_own(mesh):
    names = set(mesh.point_data.keys())
    out = write_back(mesh, as_surface(mesh), ATTRIBUTES)
    assert type(out) is pyvista.PolyData
    assert_attributes(as_surface(out), {**ATTRIBUTES, "own": np.arange(N, dtype=np.int16)})
    np.testing.assert_array_equal(out.cell_data["own"], np.arange(M))
    assert list(out.field_data["note"]) == ["kept"]
    np.testing.assert_array_equal(out.active_texture_coordinates, mesh.active_texture_coordinates)
    assert out.active_scalars_info == mesh.active_scalars_info
    assert set(mesh.point_data.keys()) == names


def test_the_copy_shares_nothing_with_the_input(mesh):
    out = write_back(mesh, as_surface(mesh), ATTRIBUTES)
    out.points[:] = 0
    out.point_data["own"][:] = 0
    out.point_data["qgeo_scalar"][:] = 0
    np.testing.assert_array_equal(mesh.points, VERTICES)
    np.testing.assert_array_equal(mesh.point_data["own"], np.arange(N))
    assert ATTRIBUTES["qgeo_scalar"].any()


def test_attributes_survive_operations_of_the_host(mesh):
    out = write_back(mesh, as_surface(mesh), ATTRIBUTES)
    part = as_surface(out.extract_cells(np.arange(M // 2)).extract_surface(algorithm=None))
    np.testing.assert_array_equal(part.attributes["qgeo_wide"], ATTRIBUTES["qgeo_wide"][part.attributes["own"]])
    clipped = out.clip("z")
    assert clipped.point_data["qgeo_scalar"].shape == (clipped.n_points,)


def test_pose(mesh):
    out = write_back(mesh, as_surface(mesh), ATTRIBUTES).compute_normals(split_vertices=False, auto_orient_normals=True)
    posed = with_positions(out, VERTICES[:, [1, 2, 0]])
    np.testing.assert_array_equal(posed.points, VERTICES[:, [1, 2, 0]])
    assert_attributes(as_surface(posed), ATTRIBUTES)
    np.testing.assert_array_equal(posed.faces, out.faces)
    for data, normals in ((posed.point_data, out.point_data), (posed.cell_data, out.cell_data)):
        np.testing.assert_allclose(data["Normals"], normals["Normals"][:, [1, 2, 0]], atol=1e-6)
    np.testing.assert_array_equal(out.points, VERTICES)


@pytest.mark.parametrize(
    ("make", "counts", "triangles"),
    [
        (lambda: pyvista.Plane(i_resolution=4, j_resolution=5), "20 polygons and 0 strips beside its 0 triangles", 40),
        (lambda: pyvista.Sphere().strip(), r"0 polygons and \d+ strips beside its 0 triangles", 1680),
    ],
    ids=["quads", "strips"],
)
def test_polygons_and_strips_must_be_triangulated(make, counts, triangles):
    mesh = make()
    with pytest.raises(MeshError, match=rf"the PolyData has {counts}: pass mesh.triangulate\(\), or repair=True"):
        as_surface(mesh)
    repair = repair_surface(mesh)
    assert repair.surface.n_faces == triangles
    assert "split into triangles" in repair.report[0]
    np.testing.assert_array_equal(repair.surface.vertices, np.asarray(mesh.points)[repair.origin])


def test_other_data_sets_are_named(mesh):
    with pytest.raises(MeshError, match=r"a PyVista UnstructuredGrid is no surface: pass mesh.extract_surface"):
        as_surface(mesh.cast_to_unstructured_grid())
    with pytest.raises(MeshError, match="the mesh has no vertices"):
        as_surface(pyvista.PolyData())
    for bad in (np.zeros((N, 2, 2)), np.array(["a"] * N)):
        with pytest.raises(MeshError, match=r"attribute 'bad' of dtype .* cannot be held by a PyVista mesh"):
            write_back(mesh, as_surface(mesh), {"bad": bad})


needs_accessors = pytest.mark.skipif(
    not hasattr(pyvista, "register_dataset_accessor"), reason="PyVista has accessors from 0.48 on"
)


@needs_accessors
def test_accessor_offers_filters_and_applies_them(mesh):
    import qgeo_filters.filters.pyvista_accessor  # noqa: F401

    out = mesh.qgeo.differential_coordinates(weights="cotangent")
    assert type(out) is pyvista.PolyData
    added = set(out.point_data.keys()) - set(mesh.point_data.keys())
    assert added
    assert all(name.startswith("qgeo_") for name in added)
    from qgeo_filters import DifferentialCoordinates

    same = mesh.qgeo.apply(DifferentialCoordinates(weights="cotangent"))
    for name in added:
        np.testing.assert_array_equal(same.point_data[name], out.point_data[name])
    assert {"apply", "surface", "quasi_geodesic_spectrum", "paint"} <= set(dir(mesh.qgeo))
    assert mesh.qgeo.surface.n_vertices == N
    with pytest.raises(AttributeError, match=r"mesh.qgeo has no filter 'nothing'; it has .*quasi_geodesic_spectrum"):
        mesh.qgeo.nothing  # noqa: B018


@needs_accessors
def test_pyvista_finds_the_accessor_by_itself():
    code = "import pyvista; print(pyvista.Sphere().qgeo.surface)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.startswith("Surface(842 vertices"), done.stderr
