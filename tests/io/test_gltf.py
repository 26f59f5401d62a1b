"""glTF: every kind of primitive, accessor and placement, and what damaged files say."""

from __future__ import annotations

import json
import struct
from contextlib import suppress

import numpy as np
import pytest
from gltf_files import GltfFile, glb
from shapes import icosphere

from qgeo_filters.errors import MeshError, MissingPackageError
from qgeo_filters.io.formats import read_raw
from qgeo_filters.surface import Surface

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="f4")
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
VOLUME = 1 / 6


def tetrahedron(dtype="u2", points=POINTS):
    made = GltfFile()
    made.primitive(points, FACES.astype(dtype).ravel())
    return made


def volume(surface):
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def read(made, tmp_path, **options):
    return Surface.read(made.write(tmp_path / "a.glb"), **options)


# -- the numbers ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
@pytest.mark.parametrize("dtype", ["u1", "u2", "u4"])
def test_indices_of_every_width_in_both_forms(tmp_path, suffix, dtype):
    surface = Surface.read(tetrahedron(dtype).write(tmp_path / f"a{suffix}"))
    np.testing.assert_array_equal(surface.vertices, POINTS)
    np.testing.assert_array_equal(surface.faces, FACES)


@pytest.mark.parametrize("dtype", ["i1", "u1", "i2", "u2"])
@pytest.mark.parametrize("normalized", [False, True])
def test_positions_stored_as_integers(tmp_path, dtype, normalized):
    largest = np.iinfo(dtype).max
    made = tetrahedron(points=(POINTS * largest).astype(dtype))
    made.tree["extensionsRequired"] = ["KHR_mesh_quantization"]
    if normalized:
        made.tree["accessors"][0]["normalized"] = True
    np.testing.assert_array_equal(read(made, tmp_path).vertices, POINTS * (1 if normalized else largest))


def test_the_lowest_normalised_integer_is_minus_one_too(tmp_path):
    made = tetrahedron(points=np.where(POINTS == 1, -128, 0).astype("i1"))
    made.tree["accessors"][0]["normalized"] = True
    np.testing.assert_array_equal(read(made, tmp_path).vertices, -POINTS)


@pytest.mark.parametrize("base", ["stored", "zeros"])
def test_sparse_positions_are_put_in(tmp_path, base):
    moved = POINTS.copy()
    moved[[1, 3]] = 7
    made = tetrahedron(points=moved if base == "stored" else POINTS)
    at = np.array([1, 3] if base == "stored" else [0, 1, 2, 3], dtype="u1")
    made.tree["accessors"][0]["sparse"] = {
        "count": len(at),
        "indices": {"bufferView": made.view(at.tobytes()), "componentType": 5121},
        "values": {"bufferView": made.view(POINTS[at].tobytes())},
    }
    if base == "zeros":
        del made.tree["accessors"][0]["bufferView"]
    np.testing.assert_array_equal(read(made, tmp_path).vertices, POINTS)


def test_positions_between_other_numbers(tmp_path):
    made = tetrahedron()
    mixed = np.hstack([np.full((4, 3), np.nan, "f4"), POINTS, np.full((4, 2), np.nan, "f4")])
    made.tree["accessors"][0].update(bufferView=made.view(mixed.tobytes(), byteStride=32), byteOffset=12)
    np.testing.assert_array_equal(read(made, tmp_path).vertices, POINTS)


def test_buffers_in_files_beside_it(tmp_path):
    made = tetrahedron()
    made.tree["buffers"] = [{"byteLength": len(made.binary), "uri": "the%20numbers.bin"}]
    (tmp_path / "the numbers.bin").write_bytes(made.binary)
    file = made.write(tmp_path / "a.gltf")
    np.testing.assert_array_equal(Surface.read(file).faces, FACES)
    (tmp_path / "the numbers.bin").unlink()
    with pytest.raises(MeshError, match=r"buffers\[0\] is in the file 'the numbers.bin', which is missing beside it"):
        Surface.read(file)


# -- attributes -----------------------------------------------------------------------------------------


COLORS = np.array([[255, 0, 0, 255], [0, 128, 0, 255], [0, 0, 7, 0], [1, 2, 3, 4]], dtype="u1")


@pytest.mark.parametrize("dtype", ["u1", "u2", "f4"])
def test_colors_and_attributes_of_ones_own(tmp_path, dtype):
    made = tetrahedron()
    primitive = made.tree["meshes"][0]["primitives"][0]
    whole = dtype != "f4"
    stored = (COLORS / 255 * (np.iinfo(dtype).max if whole else 1)).astype(dtype)
    primitive["attributes"] |= {
        "COLOR_0": made.accessor(stored, normalized=whole),
        "_HEAT": made.accessor(np.arange(4, dtype="f4")),
        "NORMAL": made.accessor(POINTS),
    }
    surface = read(made, tmp_path)
    assert set(surface.attributes) == {"colors", "HEAT"}
    np.testing.assert_array_equal(surface.attributes["HEAT"], [0, 1, 2, 3])
    if dtype == "u1":
        assert surface.attributes["colors"].dtype == np.uint8
        np.testing.assert_array_equal(surface.attributes["colors"], COLORS)
    else:
        np.testing.assert_allclose(surface.attributes["colors"], COLORS / 255, atol=1e-4)


def test_attributes_of_positions_that_are_joined(tmp_path):
    made = tetrahedron(points=np.vstack([POINTS, POINTS[1:]]))
    values = np.array([0, 1, 2, 3, 1, 2, 3], dtype="f4")
    attributes = made.tree["meshes"][0]["primitives"][0]["attributes"]
    attributes["_A"] = made.accessor(values)
    np.testing.assert_array_equal(read(made, tmp_path).attributes["A"], [0, 1, 2, 3])
    attributes["_A"] = made.accessor(values + np.array([0, 0, 0, 0, 1, 1, 0], dtype="f4"))
    with pytest.warns(UserWarning, match="attribute 'A' differs between positions that were joined to 2 vertices"):
        np.testing.assert_array_equal(read(made, tmp_path).attributes["A"], [0, 1, 2, 3])


def test_attributes_that_some_parts_lack_or_that_are_damaged_are_passed_over_aloud(tmp_path):
    made = tetrahedron()
    made.primitive(POINTS + np.float32(3), FACES.astype("u2").ravel())
    first, second = (primitive["attributes"] for primitive in made.tree["meshes"][0]["primitives"])
    first["COLOR_0"] = made.accessor(COLORS, normalized=True)
    with pytest.warns(UserWarning, match="attribute 'colors' passed over, which is not the same for all parts"):
        assert not read(made, tmp_path).attributes
    for damaged in (99, made.accessor(COLORS[:3], normalized=True)):
        first["COLOR_0"] = second["COLOR_0"] = damaged
        with pytest.warns(UserWarning, match="2 parts of the scene with an attribute 'colors' that cannot be read"):
            assert not read(made, tmp_path).attributes


# -- primitives -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("with_indices", [False, True])
@pytest.mark.parametrize("n", [3, 4, 7, 8])
def test_strips_keep_one_orientation(tmp_path, n, with_indices):
    zigzag = np.column_stack([np.arange(n) // 2, np.arange(n) % 2, np.zeros(n)]).astype("f4")
    made = GltfFile()
    made.primitive(zigzag, np.arange(n).astype("u2") if with_indices else None, mode=5)
    surface = read(made, tmp_path)
    assert surface.n_faces == n - 2
    np.testing.assert_array_equal(surface.face_normals, [[0, 0, -1]] * (n - 2))
    assert surface.area == (n - 2) / 2


def test_strips_turn_by_triangles_without_area(tmp_path):
    made = GltfFile()
    made.primitive(POINTS, np.array([0, 2, 1, 1, 3, 3, 2, 1], dtype="u2"), mode=5)
    faces = read(made, tmp_path).faces
    smallest_first = np.take_along_axis(faces, (faces.argmin(axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    assert smallest_first.tolist() == [[0, 2, 1], [1, 2, 3]]


def test_fans_are_triangles_around_their_first_corner(tmp_path):
    angles = np.arange(8) * np.pi / 7
    rim = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    made = GltfFile()
    made.primitive(np.vstack([np.zeros((1, 3)), rim]).astype("f4"), mode=6)
    surface = read(made, tmp_path)
    assert surface.n_faces == 7
    assert surface.area == pytest.approx(7 / 2 * np.sin(np.pi / 7), rel=1e-6)
    np.testing.assert_allclose(surface.face_normals, [[0, 0, 1]] * 7)


@pytest.mark.parametrize("mode", [0, 1, 2, 3])
def test_points_and_lines_are_passed_over_aloud(tmp_path, mode):
    made = tetrahedron()
    made.primitive(POINTS, mode=mode)
    file = made.write(tmp_path / "a.glb")
    with pytest.warns(UserWarning, match=r"a.glb: 1 part of the scene with points or lines, passed over"):
        assert Surface.read(file).n_faces == 4
    assert read_raw(file, repair=True).notes == ("1 part of the scene with points or lines, passed over",)
    made.tree["meshes"][0]["primitives"].pop(0)
    with pytest.raises(MeshError, match=r"the scene has no triangles; 1 part of the scene with points or lines"):
        read(made, tmp_path)


def test_primitives_that_share_their_positions_and_those_that_repeat_them_are_joined(tmp_path):
    v, f = icosphere(2)
    made = GltfFile()
    whole = made.primitive(v.astype("f4"), f[:100].astype("u2").ravel())
    made.tree["meshes"][0]["primitives"].append({**whole, "indices": made.accessor(f[100:200].astype("u2").ravel())})
    used = np.unique(f[200:], return_inverse=True)
    made.primitive(v[used[0]].astype("f4"), used[1].astype("u2").ravel())
    surface = read(made, tmp_path)
    assert (surface.n_vertices, surface.genus, surface.is_closed) == (len(v), 0, True)
    np.testing.assert_array_equal(surface.faces, f)


# -- placements -----------------------------------------------------------------------------------------


def test_nodes_place_by_matrix_or_by_translation_rotation_and_scale(tmp_path):
    c, s = np.cos(0.4), np.sin(0.4)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    made = tetrahedron()
    made.tree["nodes"] = [
        {"children": [1], "translation": [1, 2, 3], "rotation": [0, 0, np.sin(0.2), np.cos(0.2)], "scale": [1, 2, 3]},
        {"mesh": 0, "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 5, 0, 0, 1]},
    ]
    expected = ((POINTS * 2 + [5, 0, 0]) * [1, 2, 3]) @ rotation.T + [1, 2, 3]
    np.testing.assert_allclose(read(made, tmp_path).vertices, expected, atol=1e-12)


@pytest.mark.parametrize("scale", [[-1, 1, 1], [1, 1, -2], [-1, -1, -1], [-1, -1, 1]])
def test_what_a_node_mirrors_stays_outward(tmp_path, scale):
    made = tetrahedron()
    made.tree["nodes"][0]["scale"] = scale
    assert volume(read(made, tmp_path)) == pytest.approx(VOLUME * abs(np.prod(scale)))


def test_a_mesh_is_there_once_for_each_node_of_the_scene(tmp_path):
    made = tetrahedron()
    made.tree["nodes"] = [{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0], "camera": 0}, {"mesh": 0}]
    made.tree["scenes"] = [{"nodes": [2]}, {"nodes": [0, 1]}]
    made.tree["scene"] = 1
    assert read(made, tmp_path).components[0] == 2
    for keys, n in ((("scene",), 4), (("scene", "scenes"), 8), (("scene", "scenes", "nodes"), 4)):
        bare = tetrahedron()
        bare.tree.update({key: made.tree[key] for key in ("nodes", "scenes", "scene")})
        for key in keys:
            del bare.tree[key]
        assert read(bare, tmp_path).n_vertices == n, keys


def test_poses_are_left_at_rest_aloud(tmp_path):
    made = tetrahedron()
    made.tree["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": made.accessor(POINTS)}]
    assert read(made, tmp_path).n_faces == 4  # of weight zero: nothing is passed over
    made.tree["meshes"][0]["weights"] = [0.5]
    with pytest.warns(UserWarning, match=r"1 part of the scene with a pose of its own \(morph targets\), left at rest"):
        read(made, tmp_path)
    made.tree["nodes"][0]["skin"] = 0
    with pytest.warns(UserWarning, match=r"a pose of its own \(skin\), left at rest"):
        read(made, tmp_path)


def test_pictures_that_are_missing_do_not_matter(tmp_path):
    made = tetrahedron()
    made.tree["images"] = [{"uri": "missing.png"}]
    made.tree["textures"] = [{"source": 0}]
    made.tree["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    made.tree["meshes"][0]["primitives"][0]["material"] = 0
    made.tree["extensionsRequired"] = ["KHR_texture_transform", "KHR_materials_unlit"]
    assert read(made, tmp_path).n_faces == 4


# -- compression and other extensions -------------------------------------------------------------------


def draco(data):
    made = tetrahedron()
    for accessor in made.tree["accessors"]:
        del accessor["bufferView"]
    extension = {"bufferView": made.view(data), "attributes": {"POSITION": 0}}
    made.tree["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": extension}
    made.tree["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    return made


def test_draco_is_named_with_what_brings_it(tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "DracoPy", None)
    expected = r"^reading a.glb, compressed by KHR_draco_mesh_compression, needs DracoPy, .*'qgeo-filters\[files\]'$"
    for repair in (False, True):
        with pytest.raises(MissingPackageError, match=expected):
            read(draco(b"DRACO"), tmp_path, repair=repair)


def test_draco_is_decoded(tmp_path):
    package = pytest.importorskip("DracoPy")
    data = package.encode(POINTS, FACES.astype(np.uint32), preserve_order=True)
    surface = read(draco(data), tmp_path)
    assert volume(surface) == pytest.approx(VOLUME, rel=1e-3)
    assert (surface.n_vertices, surface.is_closed) == (4, True)
    with pytest.raises(MeshError, match=r"holds Draco data \(KHR_draco_mesh_compression\) that cannot be decoded"):
        read(draco(data[:20]), tmp_path)
    made = draco(data)
    made.tree["accessors"][0]["count"] = 5
    with pytest.raises(MeshError, match="announces 5 vertices, but Draco decodes 4"):
        read(made, tmp_path)


def test_draco_beside_the_same_uncompressed_is_passed_over(tmp_path):
    made = tetrahedron()
    extension = {"bufferView": made.view(b"DRACO"), "attributes": {"POSITION": 0}}
    made.tree["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": extension}
    np.testing.assert_array_equal(read(made, tmp_path).faces, FACES)


@pytest.mark.parametrize("name", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
def test_meshopt_is_named(tmp_path, name):
    made = tetrahedron()
    made.tree["extensionsRequired"] = [name]
    made.tree["buffers"] = [{"byteLength": len(made.binary)}, {"byteLength": 99, "extensions": {name: {}}}]
    for view in made.tree["bufferViews"]:
        view.update(buffer=1, extensions={name: {"buffer": 0, "byteLength": 8, "byteStride": 4, "count": 2}})
    with pytest.raises(MeshError, match=rf"its buffers are compressed \({name}\), which is not read; write the file"):
        read(made, tmp_path, repair=True)


def test_other_extensions_that_change_the_shape_are_named(tmp_path):
    made = tetrahedron()
    made.tree["extensionsRequired"] = ["ACME_subdivision"]
    with pytest.raises(MeshError, match=r"the file requires the extension ACME_subdivision, which is not read"):
        read(made, tmp_path)
    made.tree["extensionsRequired"] = ["EXT_mesh_gpu_instancing"]
    made.tree["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {}}}
    with pytest.raises(MeshError, match=r"nodes\[0\] repeats its mesh by EXT_mesh_gpu_instancing"):
        read(made, tmp_path)


# -- damage ---------------------------------------------------------------------------------------------


def test_an_index_beyond_the_vertices_is_named_and_repaired(tmp_path):
    made = GltfFile()
    indices = FACES.copy()
    indices[2, 1] = 60000
    made.primitive(POINTS, indices.astype("u2").ravel())
    expected = r"faces\[2\] refers to vertex 60000, but there are 4 vertices, numbered from 0 \(1 such face\)"
    with pytest.raises(MeshError, match=expected):
        read(made, tmp_path)
    assert read(made, tmp_path, repair=True).faces.tolist() == [FACES[0].tolist(), FACES[1].tolist(), FACES[3].tolist()]
    made.primitive(POINTS, np.array([0, 1, 4], "u2"))
    made.tree["meshes"][0]["primitives"].pop(0)
    made.primitive(POINTS, FACES.astype("u2").ravel())  # vertex 4 is one of this primitive, not of the other
    with pytest.raises(
        MeshError, match=r"faces\[0\] of primitive 0 of meshes\[0\] refers to vertex 4, but there are 4"
    ):
        read(made, tmp_path)


def test_corners_that_make_no_triangles(tmp_path):
    made = GltfFile()
    made.primitive(POINTS, np.array([0, 2, 1, 0, 1], "u2"))
    with pytest.raises(MeshError, match=r"primitive 0 of meshes\[0\] has 5 corners, which make no triangles"):
        read(made, tmp_path)
    assert read(made, tmp_path, repair=True).n_faces == 1


def bent(path, value):
    """A tetrahedron's file in which one entry of the JSON is another; None takes it away."""

    def bend(made):
        *way, last = path
        target = made.tree
        for key in way:
            target = target[key]
        target[last] = value
        if value is None:
            del target[last]

    return bend


ACCESSOR, VIEW, PRIMITIVE = ("accessors", 0), ("bufferViews", 0), ("meshes", 0, "primitives", 0)
DAMAGED = {
    "scene": (bent(("scene",), 3), r"the file refers to scenes\[3\], but there are 1"),
    "root": (bent(("scenes", 0, "nodes"), [7]), r"the scene refers to nodes\[7\], but there are 1"),
    "roots": (bent(("scenes", 0, "nodes"), "all"), "nodes of the scene are no list of indices"),
    "mesh": (bent(("nodes", 0, "mesh"), 1), r"nodes\[0\] refers to meshes\[1\], but there are 1"),
    "cycle": (bent(("nodes", 0, "children"), [0]), r"nodes\[0\] stands in the scene twice, or below itself"),
    "matrix": (bent(("nodes", 0, "matrix"), [1, 2]), r"the placement of nodes\[0\] cannot be read"),
    "rotation": (bent(("nodes", 0, "rotation"), [0, 0, 0, 0]), r"the placement of nodes\[0\] cannot be read"),
    "infinite": (bent(("nodes", 0, "scale"), [1e300, 1e300, 1e300]), "leave float64"),
    "accessor": (bent((*PRIMITIVE, "indices"), 8), r"primitive 0 of meshes\[0\] refers to accessors\[8\]"),
    "unhashable": (bent((*PRIMITIVE, "attributes", "POSITION"), [0]), r"refers to accessors\[\[0\]\]"),
    "mode": (bent((*PRIMITIVE, "mode"), 9), "is of mode 9, which glTF does not have"),
    "count": (
        bent((*ACCESSOR, "count"), 10**12),
        r"accessors\[0\] with 1000000000000 values ends at byte 12000000000000",
    ),
    "negative": (bent((*ACCESSOR, "count"), -1), r"count of accessors\[0\] is -1, expected a whole number"),
    "text": (bent((*ACCESSOR, "count"), "4"), r"count of accessors\[0\] is '4', expected a whole number"),
    "component": (bent((*ACCESSOR, "componentType"), 5130), r"accessors\[0\] is of 'VEC3' and component type 5130"),
    "type": (bent((*ACCESSOR, "type"), "VEC2"), r"the positions of primitive 0 of meshes\[0\] have 2 coordinates"),
    "indices": (bent(("accessors", 1, "componentType"), 5122), "the indices of primitive 0 .* expected whole numbers"),
    "offset": (bent((*ACCESSOR, "byteOffset"), 4), r"accessors\[0\] with 4 values ends at byte 52 of bufferViews\[0\]"),
    "view": (bent((*ACCESSOR, "bufferView"), 5), r"accessors\[0\] refers to bufferViews\[5\], but there are 2"),
    "no view": (bent((*ACCESSOR, "bufferView"), None), r"accessors\[0\] has no data"),
    "length": (bent((*VIEW, "byteLength"), 999), r"bufferViews\[0\] ends at byte 999 of buffers\[0\], which has 72"),
    "stride": (bent((*VIEW, "byteStride"), 4), r"has a stride of 4 bytes, less than the 12 of accessors\[0\]"),
    "buffer": (bent((*VIEW, "buffer"), 1), r"bufferViews\[0\] refers to buffers\[1\], but there are 1"),
    "bytes": (bent(("buffers",), [{"byteLength": 10**10}]), r"buffers\[0\] should hold 10000000000 bytes, but only 72"),
    "network": (
        bent(("buffers",), [{"byteLength": 8, "uri": "https://a/b.bin"}]),
        "only files beside this one are read",
    ),
    "data": (
        bent(("buffers",), [{"byteLength": 8, "uri": "data:;base64,?"}]),
        "the data URI of .* cannot be decoded|hold 8",
    ),
    "version": (bent(("asset", "version"), "1.0"), r"glTF of version 1\.0 is not read, only 2"),
    "asset": (bent(("asset",), None), "its JSON has no 'asset'"),
    "kinds": (bent(("accessors",), {"a": 1}), "accessors is .* expected a list"),
    "kind": (bent(("accessors",), [3, 4]), r"accessors\[0\] is 3, expected an object"),
}


@pytest.mark.parametrize("name", DAMAGED)
@pytest.mark.filterwarnings("error")
def test_damage_is_said_in_a_line(tmp_path, name):
    bend, message = DAMAGED[name]
    made = tetrahedron()
    bend(made)
    file = made.write(tmp_path / "a.glb")
    with pytest.raises(MeshError, match=message) as caught:
        Surface.read(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert len(str(caught.value)) < 300 + len(str(file))


def test_files_that_were_cut_off(tmp_path):
    content = tetrahedron().write(tmp_path / "a.glb").read_bytes()
    for length in (0, 3, 12, 19, 20, 100, len(content) - 50, len(content) - 1):
        (tmp_path / "a.glb").write_bytes(content[:length])
        with pytest.raises(MeshError, match=r"not a readable glTF file|the file is cut off: \d+ bytes of \d+"):
            Surface.read(tmp_path / "a.glb")


@pytest.mark.parametrize(
    "content",
    [
        b"{",
        b"[]",
        b"null",
        b"\xff\xfe{}",
        b"[" * 100_000,
        glb((b"BIN\0", b"")),
        glb((b"JSON", b"\xff" * 20)),
        struct.pack("<4sII", b"glTF", 1, 20) + bytes(8),
    ],
)
def test_what_is_no_gltf(tmp_path, content):
    (tmp_path / "a.gltf").write_bytes(content)
    with pytest.raises(MeshError, match=r"not a readable glTF file|GLB of version 1 is not read"):
        Surface.read(tmp_path / "a.gltf")


def test_a_byte_order_mark_and_the_other_suffix_do_not_matter(tmp_path):
    file = tetrahedron().write(tmp_path / "a.gltf")
    file.write_bytes(b"\xef\xbb\xbf" + file.read_bytes())
    assert Surface.read(file).n_faces == 4
    file.write_bytes(tetrahedron().write(tmp_path / "a.glb").read_bytes())
    assert Surface.read(file).n_faces == 4


def test_chunks_filled_up_with_zeros_and_chunks_of_others(tmp_path):
    made = tetrahedron()
    text = json.dumps({**made.tree, "buffers": [{"byteLength": len(made.binary)}]}).encode()
    content = glb((b"JSON", text + bytes(-len(text) % 4 + 4)), (b"MINE", bytes(8)), (b"BIN\0", made.binary))
    (tmp_path / "a.glb").write_bytes(content)
    assert Surface.read(tmp_path / "a.glb").n_faces == 4


def test_parts_without_vertices(tmp_path):
    made = GltfFile()
    made.primitive(POINTS[:0])
    with pytest.raises(MeshError, match=r"a.glb: the mesh has no vertices"):
        read(made, tmp_path)
    made.primitive(POINTS, FACES.astype("u2").ravel())
    np.testing.assert_array_equal(read(made, tmp_path).faces, FACES)


def test_a_scene_does_not_grow_far_beyond_its_file(tmp_path):
    v, f = icosphere(3)
    made = GltfFile()
    made.primitive(v.astype("f4"), f.astype("u2").ravel())
    made.tree["nodes"] = [{"mesh": 0}] * 2000
    made.tree["scenes"][0]["nodes"] = list(range(2000))
    with pytest.raises(MeshError, match="the scene repeats its meshes so often that they are 32 times larger than"):
        read(made, tmp_path)
    made = tetrahedron()
    sparse = {"count": 0, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 0}}
    made.tree["accessors"][0] = {"componentType": 5126, "type": "VEC3", "count": 10**10, "sparse": sparse}
    with pytest.raises(MeshError, match=r"accessors\[0\] has 10000000000 values, all but a few of them zeros"):
        read(made, tmp_path)


def test_mutated_files_are_surfaces_or_mesh_errors(tmp_path):
    """Bytes at random, and entries of the JSON at random."""
    rng = np.random.default_rng(5)
    made = tetrahedron()
    content = made.write(tmp_path / "a.glb").read_bytes()
    text = json.dumps(made.tree)
    file = tmp_path / "b.glb"
    for round_ in range(400):
        if round_ % 2:
            damaged = bytearray(content)
            for at in rng.integers(0, len(damaged), 1 + round_ % 4):
                damaged[at] = rng.integers(256)
            file.write_bytes(bytes(damaged))
        else:
            words = list(text)
            digits = [at for at, letter in enumerate(words) if letter.isdigit()]
            for at in rng.choice(digits, 2):
                words[at] = str(rng.choice(["-1", "99999999999", "null", "[]", "{}", '"x"', "1e400", "0.5", "true"]))
            chunk = "".join(words).encode()
            file.write_bytes(glb((b"JSON", chunk + b" " * (-len(chunk) % 4)), (b"BIN\0", made.binary)))
        with suppress(MeshError):
            assert Surface.read(file, repair=bool(round_ % 3)).n_vertices
