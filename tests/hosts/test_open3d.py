"""Open3D tensor and legacy meshes, both ways."""

from __future__ import annotations

import numpy as np
import pytest
from host_meshes import ATTRIBUTES, FACES, VERTICES, M, N, assert_attributes

from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.dispatch import as_surface, with_positions, write_back

o3d = pytest.importorskip("open3d")


def tensor(array):
    return o3d.core.Tensor(np.ascontiguousarray(array))


@pytest.fixture
def mesh():
    """A mesh that holds all that a tensor mesh can hold."""
    mesh = o3d.t.geometry.TriangleMesh(tensor(VERTICES), tensor(FACES.astype(np.int64)))
    mesh.compute_vertex_normals()
    mesh.vertex.colors = tensor(np.abs(VERTICES / 3))
    mesh.vertex["own"] = tensor(np.arange(N, dtype=np.int32).reshape(-1, 1))
    mesh.triangle["own"] = tensor(np.arange(M, dtype=np.float32).reshape(-1, 1))
    mesh.triangle.texture_uvs = tensor(np.random.default_rng(0).random((M, 3, 2)))
    mesh.material.set_default_properties()
    mesh.material.material_name = "defaultLit"
    mesh.material.scalar_properties["roughness"] = 0.125
    mesh.material.texture_maps["albedo"] = o3d.t.geometry.Image(tensor(np.full((4, 4, 3), 7, np.uint8)))
    return mesh


@pytest.fixture
def legacy():
    points, corners = np.array(VERTICES), np.array(FACES)  # Open3D takes no read-only arrays
    mesh = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(points), o3d.utility.Vector3iVector(corners))
    mesh.compute_vertex_normals()
    mesh.vertex_colors = o3d.utility.Vector3dVector(np.abs(VERTICES / 3))
    return mesh


def content(mesh):
    """Everything per vertex and per face, as arrays."""
    return {
        **{("vertex", name): values.numpy().copy() for name, values in mesh.vertex.items()},
        **{("triangle", name): values.numpy().copy() for name, values in mesh.triangle.items()},
    }


def assert_content(mesh, expected):
    found = content(mesh)
    for key, values in expected.items():
        assert found[key].dtype == values.dtype, key
        np.testing.assert_array_equal(found[key], values, err_msg=str(key))


def test_arrays_and_attributes_come_along(mesh):
    surface = as_surface(mesh)
    np.testing.assert_array_equal(surface.vertices, VERTICES)
    np.testing.assert_array_equal(surface.faces, FACES)
    assert set(surface.attributes) == {"normals", "colors", "own"}
    np.testing.assert_array_equal(surface.attributes["own"], np.arange(N))
    assert surface.attributes["normals"].shape == (N, 3)


def test_attributes_go_and_come_back(mesh):
    out = write_back(mesh, as_surface(mesh), ATTRIBUTES)
    assert type(out) is type(mesh)
    exact = {name: values for name, values in ATTRIBUTES.items() if name != "qgeo_mask"}
    assert_attributes(as_surface(out), exact)
    mask = as_surface(out).attributes["qgeo_mask"]
    assert mask.dtype == np.int32  # Open3D's own filters fail on Bool
    np.testing.assert_array_equal(mask, ATTRIBUTES["qgeo_mask"])
    assert tuple(out.vertex["qgeo_scalar"].shape) == (N, 1)  # else clip_plane drops it
    assert tuple(out.vertex["qgeo_wide"].shape) == (N, 12)


def test_what_the_host_holds_survives_and_the_input_is_not_changed(mesh):
    before = content(mesh)
    out = write_back(mesh, as_surface(mesh), ATTRIBUTES)
    assert_content(out, before)
    assert out.material.material_name == "defaultLit"
    assert out.material.scalar_properties["roughness"] == 0.125
    assert (out.material.texture_maps["albedo"].as_tensor().numpy() == 7).all()
    assert set(content(mesh)) == set(before)
    assert_content(mesh, before)
    out.vertex["own"][:] = -1
    out.vertex.positions[:] = 0.0
    assert_content(mesh, before)


def test_an_attribute_can_be_replaced(mesh):
    once = write_back(mesh, as_surface(mesh), {"qgeo_a": np.zeros(N)})
    twice = write_back(once, as_surface(once), {"qgeo_a": np.ones((N, 2))})
    np.testing.assert_array_equal(as_surface(twice).attributes["qgeo_a"], np.ones((N, 2)))
    assert not as_surface(once).attributes["qgeo_a"].any()


def test_attributes_survive_operations_of_the_host(mesh):
    out = write_back(mesh, as_surface(mesh), ATTRIBUTES)
    keep = np.arange(N // 2)
    part = as_surface(out.select_by_index(tensor(keep)))
    index = part.attributes["own"]  # the vertices that Open3D really kept
    for name in ("qgeo_scalar", "qgeo_wide"):
        np.testing.assert_array_equal(part.attributes[name], ATTRIBUTES[name][index])
    clipped = as_surface(out.clip_plane(point=[0, 0, 0.05], normal=[0, 0, 1.0]))
    assert clipped.attributes["qgeo_scalar"].shape == (clipped.n_vertices,)


def test_single_precision_and_int32_meshes():
    mesh = o3d.t.geometry.TriangleMesh(tensor(VERTICES.astype(np.float32)), tensor(FACES.astype(np.int32)))
    surface = as_surface(mesh)
    np.testing.assert_array_equal(surface.vertices, VERTICES.astype(np.float32))
    out = write_back(mesh, surface, ATTRIBUTES)
    assert out.vertex.positions.dtype == o3d.core.float32
    assert out.triangle.indices.dtype == o3d.core.int32


def test_other_layouts_of_attributes_are_held(mesh):
    values = {
        "half": np.linspace(0, 1, N).astype(np.float16),
        "byte": (np.arange(N) % 200).astype(np.uint8),
        "short": np.arange(N, dtype=np.int16),
        "unsigned": np.arange(N, dtype=np.uint32),
        "long": np.arange(N, dtype=np.uint64),
        "big": np.linspace(0, 1, N).astype(">f8"),
        "fortran": np.asfortranarray(np.random.default_rng(0).random((N, 4))),
    }
    out = write_back(mesh, as_surface(mesh), values)
    assert_attributes(as_surface(out), values, exact_dtype=False)
    assert set(as_surface(out.clip_plane([0, 0, 0.05], [0, 0, 1.0])).attributes) >= set(values)
    for bad in (np.zeros(N, complex), np.array(["a"] * N)):
        with pytest.raises(MeshError, match=r"attribute 'bad' of dtype .* cannot be held by an Open3D mesh"):
            write_back(mesh, as_surface(mesh), {"bad": bad})


def test_an_attribute_that_open3d_has_lost_is_named(mesh):
    mesh.vertex["short"] = tensor(np.zeros((N, 1), np.int16))
    with pytest.raises(MeshError, match="attribute 'short' of the Open3D mesh has no data"):
        as_surface(mesh.clip_plane([0, 0, 0.05], [0, 0, 1.0]))


def test_legacy_comes_back_as_tensor_in_full_precision(legacy):
    surface = as_surface(legacy)
    np.testing.assert_array_equal(surface.vertices, VERTICES)
    np.testing.assert_array_equal(surface.attributes["colors"], np.abs(VERTICES / 3))
    out = write_back(legacy, surface, ATTRIBUTES)
    assert isinstance(out, o3d.t.geometry.TriangleMesh)
    expected = {**ATTRIBUTES, "normals": np.asarray(legacy.vertex_normals)}
    assert_attributes(as_surface(out), expected, exact_dtype=False)
    np.testing.assert_array_equal(np.asarray(legacy.vertices), VERTICES)


def test_pose_keeps_everything_but_positions_and_normals(mesh):
    before = content(mesh)
    posed = with_positions(mesh, VERTICES[:, [1, 2, 0]])  # a rotation
    np.testing.assert_array_equal(as_surface(posed).vertices, VERTICES[:, [1, 2, 0]])
    kept = {key: v for key, v in before.items() if key[1] not in ("positions", "normals")}
    assert_content(posed, kept)
    assert posed.material.material_name == "defaultLit"
    expected = before["vertex", "normals"][:, [1, 2, 0]]
    np.testing.assert_allclose(posed.vertex.normals.numpy(), expected, atol=1e-6)
    assert_content(mesh, before)
    with pytest.raises(MeshError, match=r"the pose has shape \(3, 3\), expected"):
        with_positions(mesh, np.eye(3))


def test_what_is_no_mesh_is_named():
    with pytest.raises(MeshError, match="an Open3D PointCloud is no triangle mesh"):
        as_surface(o3d.geometry.PointCloud())
    with pytest.raises(MeshError, match="the mesh has no vertices"):
        as_surface(o3d.t.geometry.TriangleMesh())
