"""PLY: any attribute reads back bit by bit, and files of other programs are understood."""

from __future__ import annotations

import numpy as np
import plyfile
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from qgeo_filters.errors import MeshError
from qgeo_filters.io.ply_elements import read_elements
from qgeo_filters.io.ply_header import Lists
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


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
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
    with pytest.warns(UserWarning, match="the lists 'a' of the vertices have different lengths, dropped") as caught:
        assert "a" not in Surface.read(file).attributes
    assert str(file) in str(caught[0].message)
    assert caught[0].filename == __file__


BROKEN = [
    ("hello\n", "not a PLY file: it begins with no ply"),
    ("ply\nformat ascii 1.0\n", "not a PLY file: it has no end_header"),
    ("ply\nelement vertex 3\nend_header\n", "does not say which format"),
    (header("element vertex 4", *XYZ, *FACES) + "0 0 0\n", "4 rows of 'vertex' announced, .* but 3 are left"),
    (header("element vertex 4", *XYZ, *FACES) + POINTS, "1 rows of 'face' announced, .* but 0 are left"),
    (
        header("element vertex 4", *XYZ, *FACES) + POINTS + "3 0 1\n",
        "the file ends within row 0 of 1 of 'face'",
    ),
    (header("element vertex 4", *XYZ, *FACES) + POINTS + "-3 0 1 2\n", "a length of -3, which the file has not"),
    (header("element vertex 4", *XYZ, *FACES) + POINTS + "3 0 1 2.5\n", "2.5 stands where the header announces int"),
    (header("element vertex 4", *XYZ, *FACES) + POINTS + "3 0 1 zwei\n", "'zwei' is no number"),
    (
        header("element vertex 4", *XYZ, *FACES) + "0 0 0 7\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n",
        "announces uchar|more than the header",
    ),
    (
        header("element vertex 4", *XYZ, "property list float int a", *FACES) + POINTS,
        "line 7 of the PLY header is no property",
    ),
    (header("element vertex 4", *XYZ, XYZ[0], *FACES) + POINTS, "the property 'x' a second time"),
    (header("element vertex 4", *XYZ, "element vertex 4", *FACES) + POINTS, "the element 'vertex' a second time"),
    (
        header("element vertex -4", *XYZ, *FACES) + POINTS,
        "line 3 of the PLY header is not understood: 'element vertex -4'",
    ),
    (header("element vertex 4000000000", *XYZ, *FACES) + POINTS, "4000000000 rows of 'vertex' announced"),
    (header("element vertex 4", *XYZ, *FACES) + POINTS + "4 0 1 2 3\n", "face 0 has 4 corners"),
    (header("element vertex 4", *XYZ) + POINTS, "the mesh has no faces"),
    (header(*FACES) + "3 0 1 2\n", "the PLY file has no vertices, only face"),
    (header("element vertex 1", XYZ[0], *FACES) + "0\n3 0 1 2\n", "the vertices have no x, y, z, only x"),
    (
        header("element vertex 4", *XYZ, "element face 1", "property int a") + POINTS + "3\n",
        "no list vertex_indices, only a",
    ),
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
    content = file.read_bytes()
    for cut in range(1, 2 * 13 + 4 * 28):
        file.write_bytes(content[:-cut])
        with pytest.raises(MeshError, match=r"a\.ply: .*(the file has not|the file ends|are left)"):
            Surface.read(file)


def test_a_binary_header_that_announces_more_than_is_there(tmp_path):
    """Nothing is allocated before it is known to be there."""
    file = tmp_path / "a.ply"
    Surface(V, F).write(file)
    content = file.read_bytes()
    for kind, count in (("vertex", 4), ("face", 2)):
        for announced in (3_000_000_000, 10**17):
            file.write_bytes(
                content.replace(f"element {kind} {count}".encode(), f"element {kind} {announced}".encode())
            )
            with pytest.raises(MeshError, match=f"{announced} rows of '{kind}' announced, .* are left"):
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


# -- what other programs write ------------------------------------------------------------------------

PLAIN = header("element vertex 3", *XYZ, *FACES) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"


@pytest.mark.parametrize(
    "content",
    [
        PLAIN.replace("format", "comment Größe.png\nformat").encode(),
        PLAIN.replace("format", "comment créé\nformat").encode("latin-1"),
        PLAIN.encode("utf-8-sig"),
        PLAIN.replace("\n", " \r\n").encode(),
        PLAIN.replace("\n", "\r").encode(),
        PLAIN.replace("\nformat", "\n\nformat").encode(),
        PLAIN.replace("end_header\n", "end_header\n\n \n").replace("3 0 1 2", "\n3 0 1 2").encode(),
        PLAIN.replace("1 0 0\n", "1 0\n0\n").replace("3 0 1 2\n", "3\n0 1\n2").encode(),
        PLAIN.replace("0 0 0\n1 0 0", "0 0 0 1 0 0").encode(),
        (PLAIN + "made by hand\n1 2 3\n").encode(),
        PLAIN.replace("element face", "obj_info no 1\nelement face").encode(),
    ],
)
def test_text_is_words_and_comments_are_no_data(tmp_path, content):
    file = tmp_path / "a.ply"
    file.write_bytes(content)
    surface = Surface.read(file)
    np.testing.assert_array_equal(surface.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    np.testing.assert_array_equal(surface.faces, [[0, 1, 2]])


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_a_binary_header_with_any_line_break_and_comment(tmp_path, newline):
    """The first byte of the data is that of a line feed."""
    names = {"x": "f4", "y": "f4", "z": "f4"}
    vertex = np.zeros(3, list(names.items()))
    vertex["x"] = np.frombuffer(b"\n\r\n\x3f" + np.float32([1, 0]).tobytes(), "<f4")
    vertex["y"][2] = 1
    lines = [
        "ply",
        "format binary_little_endian 1.0",
        "comment Größe",
        "element vertex 3",
        *XYZ,
        *FACES,
        "end_header",
        "",
    ]
    data = vertex.tobytes() + b"\x03" + np.int32([0, 1, 2]).tobytes()
    (tmp_path / "a.ply").write_bytes(newline.join(lines).encode() + data)
    np.testing.assert_array_equal(Surface.read(tmp_path / "a.ply").vertices[:, 0], vertex["x"])


@pytest.mark.filterwarnings("ignore:loadtxt")  # plyfile's, of empty lists
@pytest.mark.parametrize("order", ["<", ">", "ascii"])
def test_rows_of_any_kind_are_what_plyfile_reads(tmp_path, order):
    """Lists of several lengths between numbers, in elements that nobody knows, before and behind those of the mesh."""
    random = np.random.default_rng(0)
    other = np.empty(5, [("a", object), ("n", "i2"), ("b", object)])
    other["a"] = [random.integers(0, 9, size).astype(np.int32) for size in (0, 3, 1, 7, 2)]
    other["n"] = [1, -2, 3, -4, 5]
    other["b"] = [random.random(size) for size in (2, 2, 0, 1, 5)]
    vertex = np.array([tuple(row) for row in V], [("x", "f8"), ("y", "f8"), ("z", "f8")])
    face = np.empty(3, [("flag", "u1"), ("vertex_indices", object), ("weights", object)])
    face["flag"], face["vertex_indices"] = [7, 8, 9], [np.int32([0, 1, 2]), np.int32([0, 2, 3]), np.int32([0, 1, 3])]
    face["weights"] = [random.random(size).astype("f4") for size in (1, 0, 4)]
    named = {"before": other, "vertex": vertex, "face": face, "behind": other}
    types = {"b": "f8", "weights": "f4"}
    elements = [plyfile.PlyElement.describe(values, name, val_types=types) for name, values in named.items()]
    ascii_only = order == "ascii"
    plyfile.PlyData(elements, text=ascii_only, byte_order="=" if ascii_only else order).write(tmp_path / "a.ply")
    found = read_elements(tmp_path / "a.ply").elements
    assert list(found) == list(named)
    for name in named:
        values = plyfile.PlyData.read(tmp_path / "a.ply")[name].data  # which writes single big-endian numbers wrongly
        for column in values.dtype.names:
            read = found[name].columns[column]
            if values.dtype[column].kind == "O":
                assert isinstance(read, Lists)
                assert read.values.dtype == values[column][0].dtype.newbyteorder("=")
                np.testing.assert_array_equal(read.sizes, list(map(len, values[column])))
                np.testing.assert_array_equal(read.values, np.concatenate(list(values[column])))
            else:
                assert read.dtype == values.dtype[column].newbyteorder("=")
                np.testing.assert_array_equal(read, values[column])


def test_triangle_strips(tmp_path):
    """Every other triangle of a strip is turned; a strip ends at -1 and at the end of its list."""
    file = tmp_path / "a.ply"
    strips = ["element tristrips 2", "property list int int vertex_indices"]
    grid = "".join(f"{x} {y} 0\n" for x in range(4) for y in range(2))
    rows = "9 0 2 1 3 -1 4 6 5 7\n3 2 4 3\n"
    file.write_text(header("element vertex 8", *XYZ, *strips) + grid + rows)
    surface = Surface.read(file)
    np.testing.assert_array_equal(surface.faces, [[0, 2, 1], [1, 2, 3], [4, 6, 5], [5, 6, 7], [2, 4, 3]])
    assert np.all(surface.face_normals[:, 2] > 0)
    file.write_text(header("element vertex 8", *XYZ, *FACES, *strips) + grid + "3 3 4 5\n" + rows)
    assert Surface.read(file).faces[0].tolist() == [3, 4, 5]
    assert Surface.read(file).n_faces == 6


# -- colours ------------------------------------------------------------------------------------------

RGBA = np.array([[255, 0, 0, 255], [0, 255, 0, 128], [0, 0, 255, 0], [9, 9, 9, 1]], np.uint8)


@pytest.mark.parametrize("width", [3, 4])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32, np.float64])
def test_colours_are_seen_by_other_programs(tmp_path, width, dtype):
    o3d, pymeshlab, trimesh = map(pytest.importorskip, ("open3d", "pymeshlab", "trimesh"))
    colors = RGBA[:, :width] if dtype == np.uint8 else (RGBA[:, :width] / 255).astype(dtype)
    file = tmp_path / "a.ply"
    Surface(V, F, {"before": np.arange(4), "colors": colors, "behind": np.arange(4.0)}).write(file)
    back = Surface.read(file).attributes
    assert list(back) == ["before", "colors", "behind"]
    assert back["colors"].dtype == dtype
    assert back["colors"].tobytes() == colors.tobytes()
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(file))
    shown = meshes.current_mesh().vertex_color_matrix()
    np.testing.assert_allclose(shown[:, :width], RGBA[:, :width] / 255, atol=1e-6)
    assert trimesh.load(file, process=False).visual.kind == "vertex"
    np.testing.assert_array_equal(trimesh.load(file, process=False).visual.vertex_colors[:, :width], RGBA[:, :width])
    np.testing.assert_allclose(np.asarray(o3d.io.read_triangle_mesh(str(file)).vertex_colors), RGBA[:, :3] / 255)


def test_colours_painted_by_another_program_are_newer_than_ours(tmp_path):
    Surface(V, F, {"colors": np.full((4, 3), 0.3)}).write(tmp_path / "a.ply")
    ply = plyfile.PlyData.read(tmp_path / "a.ply")
    ply["vertex"]["red"][1] = 255
    ply.write(tmp_path / "b.ply")
    painted = Surface.read(tmp_path / "b.ply").attributes["colors"]
    assert painted.dtype == np.uint8
    np.testing.assert_array_equal(painted[:, 0], [76, 255, 76, 76])


@pytest.mark.parametrize(
    "colors", [np.full((4, 3), 1.5), np.full((4, 3), np.nan), np.full((4, 2), 0.5), np.full((4, 3), 7)]
)
def test_what_is_no_colour_from_0_to_1_is_not_shown_as_one(tmp_path, colors):
    Surface(V, F, {"colors": colors}).write(tmp_path / "a.ply")
    assert "red" not in [p.name for p in plyfile.PlyData.read(tmp_path / "a.ply")["vertex"].properties]
    np.testing.assert_array_equal(Surface.read(tmp_path / "a.ply").attributes["colors"], colors)


def test_an_attribute_called_red_keeps_its_name_from_the_colours(tmp_path):
    attributes = {"red": np.arange(4.0), "colors": RGBA / 255}
    Surface(V, F, attributes).write(tmp_path / "a.ply")
    back = Surface.read(tmp_path / "a.ply").attributes
    assert set(back) == {"red", "colors"}
    for name, values in attributes.items():
        np.testing.assert_array_equal(back[name], values)
