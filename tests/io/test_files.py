"""Files of every format, both ways, and what broken ones say."""

from __future__ import annotations

import os

import numpy as np
import pytest
from host_meshes import ATTRIBUTES
from shapes import blob, icosphere

from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.dispatch import as_surface, write_back
from qgeo_filters.hosts.repair import repair_surface
from qgeo_filters.io.formats import read_raw
from qgeo_filters.surface import Surface

V, F = blob(1)
SURFACE = Surface(V * np.pi, F)
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def wrote(tmp_path, name, text):
    file = tmp_path / name
    file.write_text(text)
    return file


# -- round trips --------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".ply", ".off", ".obj", ".vert", ".tri", ".mat"])
def test_round_trip_is_exact(tmp_path, suffix):
    file = tmp_path / f"shape{suffix}"
    SURFACE.write(file)
    back = Surface.read(file)
    np.testing.assert_array_equal(back.vertices, SURFACE.vertices)
    np.testing.assert_array_equal(back.faces, SURFACE.faces)


@pytest.mark.parametrize("suffix", [".stl", ".glb"])
def test_round_trip_in_single_precision(tmp_path, suffix):
    file = tmp_path / f"shape{suffix}"
    SURFACE.write(file)
    back = Surface.read(file)
    single = SURFACE.vertices.astype(np.float32)
    np.testing.assert_array_equal(back.vertices[back.faces], single[SURFACE.faces])
    assert back.n_vertices == SURFACE.n_vertices  # welded
    assert back.genus == 0


def test_both_files_of_a_pair_are_written_and_any_name_reads_them(tmp_path):
    SURFACE.write(tmp_path / "shape.vert")
    assert {file.name for file in tmp_path.iterdir()} == {"shape.vert", "shape.tri"}
    assert (tmp_path / "shape.tri").read_text().split()[:3] == [str(i + 1) for i in F[0]]
    for name in ("shape.vert", "shape.tri", "shape"):
        np.testing.assert_array_equal(Surface.read(tmp_path / name).faces, F)


@pytest.mark.parametrize("suffix", [".off", ".obj", ".stl", ".vert", ".mat", ".glb"])
def test_attributes_are_dropped_aloud(tmp_path, suffix):
    wide = np.full((len(V), 5), np.nan)
    surface = SURFACE.with_attributes({"b": wide, "a": wide})
    with pytest.warns(UserWarning, match=rf"{suffix} holds no attributes, dropped: 'a', 'b' \(write .ply\)") as caught:
        surface.write(tmp_path / f"shape{suffix}")
    assert caught[0].filename == __file__  # the line of the caller, not one of ours


def test_suffixes_may_be_in_capitals(tmp_path):
    SURFACE.write(tmp_path / "shape.OFF")
    assert Surface.read(str(tmp_path / "shape.OFF")).n_faces == SURFACE.n_faces


@pytest.mark.parametrize("suffix", [".ply", ".off", ".obj", ".stl", ".mat", ".vert"])
def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, suffix, monkeypatch):
    file = tmp_path / f"shape{suffix}"
    SURFACE.write(file)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def fail(*args):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        Surface(2 * V, F).write(file)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_writing_into_no_folder_names_it(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"cannot write .*nowhere is not a folder"):
        SURFACE.write(tmp_path / "nowhere" / "shape.ply")


# -- files of others ----------------------------------------------------------------------------------


def test_off_dialects(tmp_path):
    plain = "0 0 0\n1 0 0\n0 1 0\n"
    for name, text in {
        "counts on the first line": f"OFF 3 1 0\n{plain}3 0 1 2\n",
        "comments and empty lines": "OFF # a\n\n# b\n3 1 0\n0 0 0 # c\n\n1 0 0\n0 1 0\n3 0 1 2\n",
        "face colours": f"OFF\n3 1 3\n{plain}3 0 1 2 255 0 0\n",
        "vertex colours": "COFF\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n3 0 1 2\n",
        "vertex normals": "NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n",
        "windows": f"OFF\r\n3 1 0\r\n{plain}3 0 1 2\r\n",
        "exponents": "OFF\n3 1 0\n0e0 0 0\n1.0E+0 0 0\n.0 1. 0\n3 0 1 2\n",
    }.items():
        surface = Surface.read(wrote(tmp_path, "a.off", text))
        np.testing.assert_array_equal(surface.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], err_msg=name)
        np.testing.assert_array_equal(surface.faces, [[0, 1, 2]], err_msg=name)


def test_obj_dialects(tmp_path):
    texture = "mtllib a.mtl\nvt 0 0\nvt 1 0\nvn 0 0 1\ng part\nusemtl x\ns off\n"
    for name, text in {
        "plain": SQUARE + "f 1 2 3\nf 1 3 4\n",
        "seams do not split vertices": SQUARE + texture + "f 1/1/1 2/2/1 3/1/1\nf 1/2/1 3/2/1 4/1/1\n",
        "normals alone": SQUARE + texture + "f 1//1 2//1 3//1\no other\nf 1//1 3//1 4//1\n",
        "counted from the end": SQUARE + "f -4 -3 -2\nf -4 -2 -1\n",
        "colours after the position": SQUARE.replace("\n", " .1 .2 .3\n") + "f 1 2 3\nf 1 3 4\n",
        "continued lines": SQUARE + "f 1 2 \\\n3\nf \\\n1 3 4\n",
        "comments and tabs": "# a\n" + SQUARE.replace("v ", "v\t") + "f 1 2 3 # b\nf\t1 3 4\nl 1 2\n",
    }.items():
        surface = Surface.read(wrote(tmp_path, "a.obj", text))
        np.testing.assert_array_equal(surface.vertices, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], err_msg=name)
        np.testing.assert_array_equal(surface.faces, [[0, 1, 2], [0, 2, 3]], err_msg=name)


def test_ascii_stl_is_welded(tmp_path):
    text = "solid x\n" + "facet normal 0 0 1\n outer loop\n{}\n endloop\nendfacet\n" * 2 + "endsolid x\n"
    first, second = ("vertex 0 0 0\nvertex 1 0 0\nVERTEX 1 1 0", "vertex -0 0 0\nvertex 1e0 1 0\nvertex 0 1 0")
    surface = Surface.read(wrote(tmp_path, "a.stl", text.format(first, second)))
    np.testing.assert_array_equal(surface.vertices, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    np.testing.assert_array_equal(surface.faces, [[0, 1, 2], [0, 2, 3]])


def test_binary_stl_that_begins_like_an_ascii_one(tmp_path):
    file = tmp_path / "a.stl"
    SURFACE.write(file)
    file.write_bytes(b"solid" + file.read_bytes()[5:])
    assert Surface.read(file).n_faces == SURFACE.n_faces


def test_glb_scene_is_placed_and_joined(tmp_path):
    import trimesh

    v, f = icosphere(1)
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.Trimesh(v, f, process=False), node_name="a")
    scene.add_geometry(
        trimesh.Trimesh(v, f, process=False),
        node_name="b",
        transform=trimesh.transformations.scale_matrix(2, [9, 0, 0]),
    )
    (tmp_path / "a.glb").write_bytes(scene.export(file_type="glb"))
    surface = Surface.read(tmp_path / "a.glb")
    assert surface.components[0] == 2
    assert surface.area == pytest.approx(5 * Surface(v, f).area, rel=1e-6)


@pytest.mark.parametrize("form", ["struct", "struct with VERT", "variables"])
def test_mat_forms(tmp_path, form):
    import scipy.io

    x, y, z = V.T[:, :, None]
    fields = {"TRIV": F + 1.0, **({"VERT": V} if "VERT" in form else {"X": x, "Y": y, "Z": z})}
    scipy.io.savemat(tmp_path / "a.mat", fields if form == "variables" else {"shape": fields})
    surface = Surface.read(tmp_path / "a.mat")
    np.testing.assert_array_equal(surface.vertices, V)
    np.testing.assert_array_equal(surface.faces, F)


# -- what broken files say ----------------------------------------------------------------------------

BROKEN = {
    "nothing.off": ("", "not an OFF file"),
    "text.off": ("hello\n", "not an OFF file: it begins with 'hello'"),
    "binary.off": ("OFF BINARY\n", "OFF files of kind OFF BINARY are not read"),
    "counts.off": ("OFF\nthree\n", "line 2: 'three' is no number"),
    "short.off": (
        "OFF\n3 1 0\n0 0 0\n1 0 0\n",
        "3 vertices and 1 face announced, which the 6 numbers that follow do not make",
    ),
    "word.off": ("OFF\n3 1 0\n0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n", "line 4: 'x' is no number"),
    "two.off": ("OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n", "line 4 is no vertex: '1 0'"),
    "face.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", "line 6 is no face: '3 0 1'"),
    "float.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2.5\n", "line 6 is no face"),
    "range.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", r"faces\[0\] refers to vertex 3, but there are 3"),
    "nan.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n", r"vertices\[2\] is .*nan"),
    "polygon.off": ("OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2\n", "face 0 has 4 corners"),
    "edge.off": ("OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n", "face 1 has 2 corners"),
    "nothing.obj": ("# empty\n", "no vertices"),
    "points.obj": (SQUARE, "the mesh has no faces"),
    "word.obj": ("v 0 0 0\nv 1 zz 0\n", "line 2: 'zz' is no number"),
    "face.obj": (SQUARE + "f 1 2 x\n", "line 5: 'x' is no number"),
    "zero.obj": (SQUARE + "f 0 1 2\n", "line 5 refers to vertex 0, but OBJ counts from 1: 'f 0 1 2'"),
    "range.obj": (SQUARE + "f 1 2 9\n", r"faces\[0\] refers to vertex 8, but there are 4 vertices"),
    "before.obj": (SQUARE + "f -9 2 3\n", r"faces\[0\] refers to vertex -5"),
    "polygon.obj": (SQUARE + "f 1 2 3\nf 1 2 3 4\n", r"face 1 has 4 corners \(1 of 2 faces are polygons"),
    "nothing.stl": ("", "not an STL file: 0 bytes"),
    "text.stl": ("hello", "not an STL file"),
    "half.stl": ("solid\nvertex 0 0 0\nvertex 1 0 0\n", "2 corners found in the STL file, which make no triangles"),
    "word.stl": ("solid\nvertex 0 0 x\n", "line 2: 'x' is no number"),
    "nothing.glb": ("", "not a readable glTF file"),
    "nothing.mat": ("", "not a readable MATLAB file"),
    "nothing.ply": ("", "not a PLY file"),
    "alone.vert": ("0 0 0\n", "alone.tri is missing beside it"),
    "alone.tri": ("1 2 3\n", "alone.vert is missing beside it"),
    "mesh.xyz": ("", r"unknown suffix '.xyz'; read are .ply, .off"),
    "mesh": ("", r"unknown suffix ''; read are .ply, .off"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_named_with_the_reason_on_one_line(tmp_path, name, capfd):
    text, message = BROKEN[name]
    file = wrote(tmp_path, name, text)
    with pytest.raises(MeshError, match=message) as caught:
        Surface.read(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_broken_tables(tmp_path):
    wrote(tmp_path, "a.vert", "0 0 0\n1 0 0\n0 1 0\n")
    for text, message in (
        ("", "a.tri is empty"),
        ("1 2\n", "a.tri has 2 columns, expected 3"),
        ("1 2 x\n", "a.tri is no table of numbers"),
    ):
        wrote(tmp_path, "a.tri", text)
        with pytest.raises(MeshError, match=message):
            Surface.read(tmp_path / "a.vert")
    wrote(tmp_path, "a.tri", "0 1 2\n")
    with pytest.raises(MeshError, match=r"faces\[0\] refers to vertex -1"):
        Surface.read(tmp_path / "a.vert")


def test_mat_without_a_mesh_lists_what_there_is(tmp_path):
    import scipy.io

    scipy.io.savemat(tmp_path / "a.mat", {"volume": np.eye(3)})
    with pytest.raises(MeshError, match=r"no mesh with fields X, Y, Z, TRIV .* the file holds volume"):
        Surface.read(tmp_path / "a.mat")
    (tmp_path / "b.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + bytes(64))
    with pytest.raises(MeshError, match=r"MATLAB 7.3 files are not read"):
        Surface.read(tmp_path / "b.mat")


def test_missing_files_and_folders(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no such file: .*nothing.off"):
        Surface.read(tmp_path / "nothing.off")
    with pytest.raises(IsADirectoryError, match="is a folder, not a mesh"):
        Surface.read(tmp_path)
    with pytest.raises(MeshError, match=r"unknown suffix '.xyz'; written are .ply"):
        SURFACE.write(tmp_path / "a.xyz")


@pytest.mark.parametrize(
    "read",
    [
        Surface.read,
        lambda file: Surface.read(file, repair=True),
        as_surface,
        lambda file: as_surface(file, repair=True),
        repair_surface,
    ],
    ids=["read", "read and repair", "as_surface", "as_surface and repair", "repair_surface"],
)
@pytest.mark.filterwarnings("error")  # NumPy's "no data" is not the user's to read
@pytest.mark.parametrize("text", ["OFF\n0 0 0\n", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", "OFF\n1 1 0\nx 0 0\n3 0 0 0\n"])
def test_each_way_in_names_the_file_once(tmp_path, read, text):
    file = wrote(tmp_path, "a.off", text)
    with pytest.raises(MeshError) as caught:
        read(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert str(caught.value).count(str(file)) == 1


@pytest.mark.filterwarnings("error")
def test_repair_of_a_mesh_whose_areas_leave_float64(tmp_path):
    text = "OFF\n4 4 0\n0 0 0\n1e90 0 0\n0 1e90 0\n0 0 1e90\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
    with pytest.raises(MeshError, match=r"a\.off: the mesh is 1e\+90 units wide"):
        Surface.read(wrote(tmp_path, "a.off", text), repair=True)


def test_what_cannot_be_written_names_the_file(tmp_path):
    file = tmp_path / "a.ply"
    with pytest.raises(MeshError, match=r"attribute 'bad' of dtype <U1 cannot be held") as caught:
        Surface(V, F, {"bad": np.full(len(V), "x")}).write(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["polygon.off", "polygon.obj"])
def test_polygons_are_triangulated_by_repair(tmp_path, name):
    file = wrote(tmp_path, name, BROKEN[name][0])
    raw = read_raw(file, repair=True)
    assert raw.notes == ("1 polygon split into 2 triangles",)
    surface = Surface.read(file, repair=True)
    assert surface.is_manifold
    assert surface.n_faces == 2  # the triangle over half of the square is a duplicate


# -- real files ---------------------------------------------------------------------------------------


def test_the_samples_of_pymeshlab():
    pymeshlab = pytest.importorskip("pymeshlab")
    from pathlib import Path

    folder = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"
    cow = Surface.read(folder / "cow.obj")
    assert (cow.n_vertices, cow.n_faces, cow.genus) == (2904, 5804, 0)
    bone = Surface.read(folder / "bone.ply")
    assert bone.n_vertices == 1872
    assert bone.attributes["colors"].shape == (1872, 4)
    assert bone.unreferenced_vertices.size
    assert Surface.read(folder / "bunny10k_textured.obj").n_vertices == 5051
    for name in ("cow.obj", "bone.ply", "bunny10k_textured.obj"):
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(str(folder / name))
        surface = Surface.read(folder / name)
        np.testing.assert_allclose(surface.vertices, meshes.current_mesh().vertex_matrix(), rtol=1e-6)
        np.testing.assert_array_equal(surface.faces, meshes.current_mesh().face_matrix())


def test_tosca_in_both_forms(data_dir):
    folder = data_dir / "tosca" / "lowres"
    pair, mat = Surface.read(folder / "cat0"), Surface.read(folder / "cat0.mat")
    np.testing.assert_array_equal(pair.faces, mat.faces)
    np.testing.assert_allclose(pair.vertices, mat.vertices, atol=1e-7)
    assert pair.n_vertices == 3400


def test_attributes_survive_a_way_through_every_host(tmp_path):
    """From a file through Open3D, PyMeshLab and PyVista into a file again."""
    o3d, pymeshlab, pyvista = map(pytest.importorskip, ("open3d", "pymeshlab", "pyvista"))
    v, f = blob(2)
    Surface(v, f, ATTRIBUTES).write(tmp_path / "a.ply")
    surface = as_surface(tmp_path / "a.ply")
    tensor_mesh = o3d.t.geometry.TriangleMesh(o3d.core.Tensor(v.copy()), o3d.core.Tensor(f.astype(np.int64)))
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(v, f))
    for host in (tensor_mesh, meshes, pyvista.PolyData.from_regular_faces(v, f)):
        surface = as_surface(write_back(host, surface, surface.attributes))
    surface.write(tmp_path / "b.ply")
    back = as_surface(tmp_path / "b.ply")
    for name, values in ATTRIBUTES.items():
        np.testing.assert_array_equal(back.attributes[name], values)
