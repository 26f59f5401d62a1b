"""PLY: any attribute reads back bit by bit, and files of other programs are understood."""

from __future__ import annotations

import numpy as np
import plyfile
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from qgeo_filters.errors import MeshError
from qgeo_filters.surface import Surface

V = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) / 3
F = np.array([[0, 1, 2], [0, 2, 3]])

DTYPES = (
    hnp.integer_dtypes(endianness="?")
    | hnp.unsigned_integer_dtypes(endianness="?")
    | hnp.floating_dtypes(endianness="?", sizes=(32, 64))
    | hnp.complex_number_dtypes(endianness="?", sizes=(64, 128))
    | hnp.boolean_dtypes()
)
SHAPES = st.lists(st.integers(0, 4), max_size=2).map(lambda widths: (4, *widths))
ATTRIBUTES = st.dictionaries(
    st.text(max_size=12) | st.sampled_from(["x", "red", "nx", "normals", "colors", "a", "a_0", "vertex_indices"]),
    st.tuples(DTYPES, SHAPES).flatmap(lambda pair: hnp.arrays(pair[0], pair[1])),
    max_size=6,
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(attributes=ATTRIBUTES)
def test_any_attribute_reads_back_bit_by_bit(tmp_path, attributes):
    surface = Surface(V, F, attributes)
    surface.write(tmp_path / "a.ply")
    back = Surface.read(tmp_path / "a.ply")
    assert back.vertices.tobytes() == surface.vertices.tobytes()
    np.testing.assert_array_equal(back.faces, surface.faces)
    assert set(back.attributes) == set(attributes)
    for name, values in attributes.items():
        found = back.attributes[name]
        assert (found.dtype, found.shape) == (values.dtype, values.shape)
        assert found.tobytes() == values.tobytes()


@pytest.mark.parametrize("dtype", [np.float16, np.int64, np.uint64])
def test_extremes_of_types_that_ply_lacks(tmp_path, dtype):
    info = np.finfo(dtype) if dtype is np.float16 else np.iinfo(dtype)
    values = np.array([info.min, info.max, 0, 1], dtype=dtype)
    Surface(V, F, {"a": values, "small": np.arange(4, dtype=dtype)}).write(tmp_path / "a.ply")
    back = Surface.read(tmp_path / "a.ply")
    np.testing.assert_array_equal(back.attributes["a"], values)
    assert back.attributes["a"].dtype == dtype
    assert back.attributes["small"].dtype == dtype


def test_other_programs_find_plain_columns(tmp_path):
    attributes = {
        "qgeo_scalar": np.arange(4.0),
        "qgeo_wide": np.arange(20.0).reshape(4, 5),
        "qgeo_index": np.arange(4),
        "normals": np.ones((4, 3)),
        "colors": np.full((4, 3), 200, np.uint8),
    }
    Surface(V, F, attributes).write(tmp_path / "a.ply")
    ply = plyfile.PlyData.read(tmp_path / "a.ply")
    names = [item.name for item in ply["vertex"].properties]
    wide = [f"qgeo_wide_{j}" for j in range(5)]
    assert names == ["x", "y", "z", "qgeo_scalar", *wide, "qgeo_index", "nx", "ny", "nz", "red", "green", "blue"]
    assert ply["vertex"]["qgeo_index"].dtype == np.int32
    np.testing.assert_array_equal(ply["vertex"]["qgeo_wide_3"], attributes["qgeo_wide"][:, 3])
    np.testing.assert_array_equal(np.stack(ply["face"]["vertex_indices"]), F)


def test_the_hosts_read_our_files(tmp_path):
    o3d, pymeshlab, pyvista = map(pytest.importorskip, ("open3d", "pymeshlab", "pyvista"))
    file = tmp_path / "a.ply"
    colors = np.full((4, 3), 51, np.uint8)
    Surface(V, F, {"odd name é\n": np.arange(8.0).reshape(4, 2), "colors": colors}).write(file)
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(file))
    np.testing.assert_array_equal(meshes.current_mesh().vertex_matrix(), V)
    np.testing.assert_allclose(meshes.current_mesh().vertex_color_matrix()[:, :3], 0.2)
    np.testing.assert_array_equal(np.asarray(o3d.io.read_triangle_mesh(str(file)).triangles), F)
    np.testing.assert_array_equal(pyvista.read(file).faces.reshape(-1, 4)[:, 1:], F)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("order", ["<", ">", "ascii"])
@pytest.mark.parametrize("corners", ["vertex_indices", "vertex_index"])
def test_files_of_other_programs(tmp_path, dtype, order, corners):
    vertex = np.zeros(4, [(name, dtype) for name in ("x", "y", "z", "nx", "ny", "nz", "quality")])
    for k, axis in enumerate("xyz"):
        vertex[axis] = V[:, k]
    vertex["nz"], vertex["quality"] = 1, np.arange(4) / 7
    vertex = np.array(vertex)
    face = np.empty(2, [(corners, object), ("red", "u1")])
    face[corners], face["red"] = [row.astype(np.int32) for row in F], 3
    elements = [plyfile.PlyElement.describe(vertex, "vertex"), plyfile.PlyElement.describe(face, "face")]
    ascii_only = order == "ascii"
    ply = plyfile.PlyData(elements, text=ascii_only, byte_order="=" if ascii_only else order, comments=["by hand"])
    ply.write(tmp_path / "a.ply")
    surface = Surface.read(tmp_path / "a.ply")
    np.testing.assert_allclose(surface.vertices, V, rtol=1e-6)
    np.testing.assert_array_equal(surface.faces, F)
    assert set(surface.attributes) == {"normals", "quality"}
    np.testing.assert_array_equal(surface.attributes["normals"], [[0, 0, 1]] * 4)
    np.testing.assert_allclose(surface.attributes["quality"], np.arange(4) / 7, rtol=1e-6)


def header(*lines):
    return "\n".join(["ply", "format ascii 1.0", *lines, "end_header", ""])


XYZ = ["property float x", "property float y", "property float z"]
FACES = ["element face 1", "property list uchar int vertex_indices"]
POINTS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"


def test_lists_per_vertex(tmp_path):
    file = tmp_path / "a.ply"
    vertices = "0 0 0 2 5 6\n1 0 0 2 7 8\n0 1 0 2 9 1\n"
    file.write_text(header("element vertex 3", *XYZ, "property list uchar int a", *FACES) + vertices + "3 0 1 2\n")
    np.testing.assert_array_equal(Surface.read(file).attributes["a"], [[5, 6], [7, 8], [9, 1]])
    file.write_text(file.read_text().replace("2 5 6", "1 5"))
    with pytest.raises(MeshError, match="the vertex property 'a' is a list of different lengths"):
        Surface.read(file)


STRIPS = ["element tristrips 1", "property list int int vertex_indices"]
BROKEN = [
    ("hello\n", "not a readable PLY file"),
    (header("element vertex 4", *XYZ, *FACES) + "0 0 0\n", "not a readable PLY file .*vertex"),
    (header("element vertex 4", *XYZ, *FACES) + POINTS + "4 0 1 2 3\n", "face 0 has 4 corners"),
    (header("element vertex 4", *XYZ) + POINTS, "the mesh has no faces"),
    (header(*FACES) + "3 0 1 2\n", "the PLY file has no vertices, only face"),
    (header("element vertex 1", XYZ[0], *FACES) + "0\n3 0 1 2\n", "the vertices have no x, y, z, only x"),
    (
        header("element vertex 4", *XYZ, "element face 1", "property int a") + POINTS + "3\n",
        "no vertex_indices, only a",
    ),
    (header("element vertex 4", *XYZ, *STRIPS) + POINTS + "4 0 1 2 3\n", "the PLY file has triangle strips"),
    (header("element vertex 4", *XYZ, *FACES) + POINTS + "3 0 1 4\n", r"faces\[0\] refers to vertex 4"),
]


@pytest.mark.parametrize(("text", "message"), BROKEN)
def test_broken_files(tmp_path, text, message):
    file = tmp_path / "a.ply"
    file.write_text(text)
    with pytest.raises(MeshError, match=message) as caught:
        Surface.read(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert "\n" not in str(caught.value)


def test_a_file_cut_short_is_named(tmp_path):
    file = tmp_path / "a.ply"
    Surface(V, F, {"a": np.arange(4)}).write(file)
    file.write_bytes(file.read_bytes()[:-5])
    with pytest.raises(MeshError, match="not a readable PLY file"):
        Surface.read(file)


def test_binary_polygons(tmp_path):
    vertex = np.array([tuple(row) for row in V], [("x", "f4"), ("y", "f4"), ("z", "f4")])
    face = np.empty(2, [("vertex_indices", object)])
    face["vertex_indices"] = [np.arange(4), np.arange(3)]
    elements = [plyfile.PlyElement.describe(vertex, "vertex"), plyfile.PlyElement.describe(face, "face")]
    plyfile.PlyData(elements).write(tmp_path / "a.ply")
    with pytest.raises(MeshError, match=r"face 0 has 4 corners \(1 of 2 faces are polygons"):
        Surface.read(tmp_path / "a.ply")
    assert Surface.read(tmp_path / "a.ply", repair=True).n_faces == 2


def test_a_file_that_another_program_rewrote_falls_back_to_its_columns(tmp_path):
    Surface(V, F, {"a": np.arange(8.0).reshape(4, 2), "b": np.arange(4)}).write(tmp_path / "a.ply")
    ply = plyfile.PlyData.read(tmp_path / "a.ply")
    kept = ply["vertex"].data[["x", "y", "z", "a_1", "b"]]
    vertex = np.empty(4, [(name, kept.dtype[name]) for name in kept.dtype.names])
    for name in kept.dtype.names:
        vertex[name] = kept[name]
    elements = [plyfile.PlyElement.describe(vertex, "vertex"), ply["face"]]
    comments = [*ply.comments, "qgeo_attribute {broken", 'qgeo_attribute {"name": 3}']
    plyfile.PlyData(elements, comments=comments).write(tmp_path / "b.ply")
    back = Surface.read(tmp_path / "b.ply").attributes
    assert set(back) == {"a_1", "b"}
    assert back["b"].dtype == np.arange(4).dtype


@pytest.mark.parametrize("values", [np.array(["a", "b", "c", "d"]), np.array([None] * 4), np.zeros(4, "M8[s]")])
def test_what_is_no_number_is_refused_and_leaves_no_file(tmp_path, values):
    with pytest.raises(MeshError, match=r"attribute 'bad' of dtype .* cannot be held by a PLY file"):
        Surface(V, F, {"bad": values}).write(tmp_path / "a.ply")
    assert list(tmp_path.iterdir()) == []
