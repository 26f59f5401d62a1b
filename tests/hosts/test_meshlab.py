"""PyMeshLab mesh sets, both ways."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from host_meshes import ATTRIBUTES, FACES, VERTICES, M, N, assert_attributes

from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.dispatch import as_surface, with_positions, write_back

pymeshlab = pytest.importorskip("pymeshlab")
SAMPLES = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"


@pytest.fixture
def meshes():
    """Three layers, ids 0, 2 and 3, of which 2 is current and holds all that a layer can hold."""
    random = np.random.default_rng(0)
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(SAMPLES / "cow.obj"))
    meshes.create_cube()
    meshes.add_mesh(
        pymeshlab.Mesh(
            VERTICES,
            FACES,
            v_scalar_array=random.random(N),
            f_scalar_array=random.random(M),
            v_color_matrix=random.random((N, 4)),
            f_color_matrix=random.random((M, 4)),
            v_tex_coords_matrix=random.random((N, 2)),
            w_tex_coords_matrix=random.random((3 * M, 2)),
        ),
        "the blob",
    )
    meshes.add_mesh(pymeshlab.Mesh(random.random((10, 3))), "points")
    meshes.set_mesh_visibility(3, False)
    meshes.set_current_mesh(1)
    meshes.delete_current_mesh()
    meshes.set_current_mesh(2)
    meshes.set_matrix(transformmatrix=np.diag([1.0, 2.0, 3.0, 1.0]), freeze=False)
    meshes.compute_selection_by_condition_per_face(condselect="fi < 11")
    layer = meshes.current_mesh()
    layer.add_vertex_custom_scalar_attribute(np.arange(N, dtype=float), "own")
    layer.add_vertex_custom_point_attribute(random.random((N, 3)), "own_point")
    layer.add_face_custom_scalar_attribute(np.arange(M, dtype=float), "own_face")
    layer.add_face_custom_point_attribute(random.random((M, 3)), "own_face_point")
    meshes.mesh(0).add_vertex_custom_scalar_attribute(np.arange(2904.0), "of_the_cow")
    return meshes


CONTENT = [
    "vertex_matrix", "face_matrix", "vertex_normal_matrix", "vertex_scalar_array", "face_scalar_array",
    "vertex_color_matrix", "face_color_matrix", "vertex_tex_coord_matrix", "wedge_tex_coord_matrix",
    "vertex_selection_array", "face_selection_array", "transform_matrix",
]  # fmt: skip


def content(layer):
    """Everything that a layer holds, as arrays."""
    return {
        **{name: np.array(getattr(layer, name)()) for name in CONTENT},
        "own": layer.vertex_custom_scalar_attribute_array("own"),
        "own_point": layer.vertex_custom_point_attribute_matrix("own_point"),
        "own_face": layer.face_custom_scalar_attribute_array("own_face"),
        "own_face_point": layer.face_custom_point_attribute_matrix("own_face_point"),
    }


def assert_content(layer, expected, but=()):
    found = content(layer)
    for name in expected.keys() - set(but):
        np.testing.assert_array_equal(found[name], expected[name], err_msg=name)


def test_arrays_and_attributes_come_along(meshes):
    surface = as_surface(meshes)
    np.testing.assert_array_equal(surface.vertices, VERTICES)
    np.testing.assert_array_equal(surface.faces, FACES)
    assert set(surface.attributes) == {"own", "own_point", "colors"}
    np.testing.assert_array_equal(surface.attributes["colors"], meshes.current_mesh().vertex_color_matrix()[:, :3])
    np.testing.assert_array_equal(surface.attributes["own"], np.arange(N))
    assert as_surface(meshes.mesh(0)).attributes.keys() == {"of_the_cow"}


def test_attributes_go_and_come_back(meshes):
    out = write_back(meshes, as_surface(meshes), ATTRIBUTES)
    assert type(out) is pymeshlab.MeshSet
    assert_attributes(as_surface(out), ATTRIBUTES, exact_dtype=False)  # PyMeshLab has float64 only
    layer = out.current_mesh()
    np.testing.assert_array_equal(
        layer.vertex_custom_scalar_attribute_array("qgeo_wide_7"), ATTRIBUTES["qgeo_wide"][:, 7]
    )


def test_layers_and_what_they_hold_survive(meshes):
    expected = content(meshes.current_mesh())
    out = write_back(meshes, as_surface(meshes), ATTRIBUTES)
    assert [(layer.id(), layer.label()) for layer in out] == [(0, "cow.obj"), (2, "the blob"), (3, "points")]
    assert [layer.is_visible() for layer in out] == [True, True, False]
    assert out.current_mesh_id() == 2
    assert_content(out.current_mesh(), expected)
    assert out.current_mesh().selected_face_number() == 11
    np.testing.assert_array_equal(out.mesh(0).vertex_matrix(), meshes.mesh(0).vertex_matrix())
    np.testing.assert_array_equal(out.mesh(0).vertex_custom_scalar_attribute_array("of_the_cow"), np.arange(2904))
    assert out.mesh(3).vertex_number() == 10


def test_the_input_is_not_changed(meshes):
    before = content(meshes.current_mesh())
    out = write_back(meshes, as_surface(meshes), {**ATTRIBUTES, "own": np.zeros(N)})
    out.apply_coord_laplacian_smoothing()
    out.set_current_mesh(0)
    out.delete_current_mesh()
    assert meshes.mesh_number() == 3
    assert meshes.current_mesh_id() == 2
    assert_content(meshes.current_mesh(), before)
    assert set(as_surface(meshes).attributes) == {"own", "own_point", "colors"}


def test_attributes_can_be_replaced(meshes):
    expected = content(meshes.current_mesh())
    once = write_back(meshes, as_surface(meshes), ATTRIBUTES)
    new = {"qgeo_scalar": np.arange(N), "own_point": np.ones((N, 3)), "qgeo_wide": np.ones((N, 12))}
    twice = write_back(once, as_surface(once), new)
    assert_attributes(as_surface(twice), {**ATTRIBUTES, **new}, exact_dtype=False)
    assert_content(twice.current_mesh(), expected, but=["own_point"])
    assert [layer.id() for layer in twice] == [0, 2, 3]
    assert_attributes(as_surface(once), ATTRIBUTES, exact_dtype=False)


def test_attributes_work_in_function_filters(meshes):
    out = write_back(meshes, as_surface(meshes), ATTRIBUTES)
    out.compute_scalar_by_function_per_vertex(q="2 * qgeo_scalar + qgeo_wide_11", onselected=False)
    expected = 2 * ATTRIBUTES["qgeo_scalar"] + ATTRIBUTES["qgeo_wide"][:, 11]
    np.testing.assert_allclose(out.current_mesh().vertex_scalar_array(), expected, rtol=1e-12)


def test_attributes_can_be_saved_by_the_host(meshes, tmp_path):
    out = write_back(meshes, as_surface(meshes), {"qgeo_scalar": ATTRIBUTES["qgeo_scalar"]})
    file = tmp_path / "saved.ply"
    out.save_current_mesh(str(file), __ca_vs__qgeo_scalar=True)
    read = as_surface(file)
    np.testing.assert_array_equal(read.attributes["qgeo_scalar"], ATTRIBUTES["qgeo_scalar"])
    assert read.attributes["colors"].shape == (N, 4)


def test_a_textured_mesh_keeps_its_image(tmp_path):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(SAMPLES / "bunny10k_textured.obj"))
    out = write_back(meshes, as_surface(meshes), {"qgeo_a": np.zeros(5051)})
    layer = out.current_mesh()
    (name,) = meshes.current_mesh().textures()
    assert list(layer.textures()) == [name]
    assert layer.textures()[name].width() == 512
    np.testing.assert_array_equal(layer.wedge_tex_coord_matrix(), meshes.current_mesh().wedge_tex_coord_matrix())
    out.save_current_mesh(str(tmp_path / "saved.obj"))
    assert (tmp_path / name).stat().st_size > 0


def test_several_texture_images_are_missed_aloud(tmp_path):
    image = pymeshlab.MeshSet()
    image.load_new_mesh(str(SAMPLES / "bunny10k_textured.obj"))
    (texture,) = image.current_mesh().textures().values()
    for name in ("a", "b"):
        texture.save(str(tmp_path / f"{name}.png"))
    (tmp_path / "two.mtl").write_text("newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\n")
    (tmp_path / "two.obj").write_text(
        "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
        "usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 2/1 4/2 3/3\n"
    )
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(tmp_path / "two.obj"))
    with pytest.warns(UserWarning, match="'two.obj' has 2 texture images"):
        write_back(meshes, as_surface(meshes), {"qgeo_a": np.zeros(4)})


def test_a_bare_mesh_comes_back_in_a_mesh_set(meshes):
    out = write_back(meshes.mesh(0), as_surface(meshes.mesh(0)), {"qgeo_a": np.arange(2904)})
    assert type(out) is pymeshlab.MeshSet
    assert [(layer.id(), layer.label()) for layer in out] == [(0, "cow.obj")]
    assert set(as_surface(out).attributes) == {"qgeo_a", "of_the_cow"}


def test_pose_keeps_everything_but_positions_and_normals(meshes):
    expected = content(meshes.current_mesh())
    posed = np.random.default_rng(1).normal(size=(N, 3)) * 77
    out = with_positions(meshes, posed)
    np.testing.assert_array_equal(as_surface(out).vertices, posed)
    assert_content(out.current_mesh(), expected, but=["vertex_matrix", "vertex_normal_matrix"])
    assert [layer.id() for layer in out] == [0, 2, 3]
    assert_content(meshes.current_mesh(), expected)
    posed, fresh = with_positions(meshes, VERTICES[:, [1, 2, 0]]), with_positions(meshes, VERTICES)
    turned_normals = posed.current_mesh().vertex_normal_matrix()  # a mesh does not outlive its set: keep both
    fresh_normals = fresh.current_mesh().vertex_normal_matrix()
    np.testing.assert_allclose(turned_normals, fresh_normals[:, [1, 2, 0]], atol=1e-12)


def test_numbered_names_of_the_user_are_left_alone(meshes):
    layer = meshes.current_mesh()
    for name in ("landmark_0", "landmark_1", "qgeo_gap_0", "qgeo_gap_2"):
        layer.add_vertex_custom_scalar_attribute(np.zeros(N), name)
    names = set(as_surface(meshes).attributes)
    assert {"landmark_0", "landmark_1", "qgeo_gap_0", "qgeo_gap_2"} <= names
    assert not names & {"landmark", "qgeo_gap"}


def test_names_that_break_the_host_are_refused(meshes):
    with pytest.raises(MeshError, match="attribute 'a b' must be an identifier"):
        write_back(meshes, as_surface(meshes), {"a b": np.zeros(N)})
    for bad in (np.zeros((N, 2, 2)), np.zeros(N, complex), np.array(["a"] * N)):
        with pytest.raises(MeshError, match=r"attribute 'bad' of dtype .* cannot be held by PyMeshLab"):
            write_back(meshes, as_surface(meshes), {"bad": bad})


def test_attributes_whose_names_are_not_told_are_missed_aloud(meshes):
    meshes.current_mesh().add_vertex_custom_scalar_attribute(np.ones(N), "odd name")
    with pytest.warns(UserWarning, match="1 custom attribute of layer 'the blob' cannot be copied"):
        out = write_back(meshes, as_surface(meshes), {"qgeo_a": np.zeros(N)})
    assert set(as_surface(out).attributes) == {"own", "own_point", "colors", "qgeo_a"}


def test_nothing_is_printed(meshes, capfd):
    write_back(meshes, as_surface(meshes), ATTRIBUTES)
    with_positions(meshes, VERTICES)
    captured = capfd.readouterr()
    assert captured.out == ""
    assert captured.err == ""


def test_what_is_no_mesh_is_named():
    with pytest.raises(MeshError, match="the MeshSet has no meshes"):
        as_surface(pymeshlab.MeshSet())
    with pytest.raises(MeshError, match="a PyMeshLab PercentageValue is no mesh"):
        as_surface(pymeshlab.PercentageValue(3))
    points = pymeshlab.MeshSet()
    points.add_mesh(pymeshlab.Mesh(np.eye(3)))
    with pytest.raises(MeshError, match="the mesh has no faces"):
        as_surface(points)


def test_reading_attributes_prints_nothing_into_a_pipe() -> None:
    """PyMeshLab tells names in a line of C's, which waits in a buffer where the output is a pipe or a file."""
    code = (
        "import ctypes, sys, numpy as np, pymeshlab, qgeo_filters as qg\n"
        "c = ctypes.CDLL('ucrtbase' if sys.platform == 'win32' else None)\n"
        "surface = qg.testing.sample_surface()\n"
        "meshes = pymeshlab.MeshSet()\n"
        "meshes.add_mesh(pymeshlab.Mesh(surface.vertices, surface.faces))\n"
        "meshes.current_mesh().add_vertex_custom_scalar_attribute(np.arange(surface.n_vertices), 'height')\n"
        "c.puts(b'before')\n"
        "print(sorted(qg.as_surface(meshes).attributes))\n"
        "c.puts(b'after')\n"
    )
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=buffered)
    assert sorted(done.stdout.splitlines()) == ["['height']", "after", "before"]
