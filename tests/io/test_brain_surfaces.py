"""FreeSurfer's surfaces, recognised by their first bytes, and GIFTI, with what is stored beside the triangles."""

from __future__ import annotations

import struct
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from shapes import blob

from qgeo_filters.errors import MeshError
from qgeo_filters.surface import Surface

nibabel = pytest.importorskip("nibabel")

V, F = blob(2)
SINGLE = V.astype("f4")
VALUES = np.linspace(0, 1, len(V), dtype="f4")
POINTS, TRIANGLES, SHAPE = "NIFTI_INTENT_POINTSET", "NIFTI_INTENT_TRIANGLE", "NIFTI_INTENT_SHAPE"


def gifti(file, *arrays, **options):
    """A file of (values, intent, name) arrays."""
    data = [
        nibabel.gifti.GiftiDataArray(
            values, intent, values.dtype.name, meta={"Name": name} if name else None, **options
        )
        for values, intent, name in arrays
    ]
    nibabel.gifti.GiftiImage(darrays=data).to_filename(file)
    return file


@pytest.mark.parametrize("name", ["lh.pial", "rh.white", "lh.sphere.reg", "surface", "lh.pial.T1"])
def test_freesurfer_surfaces_of_any_name(tmp_path, name):
    nibabel.freesurfer.write_geometry(tmp_path / name, V, F)
    surface = Surface.read(tmp_path / name)
    np.testing.assert_array_equal(surface.vertices, SINGLE)
    np.testing.assert_array_equal(surface.faces, F)


def test_freesurfer_quadrilaterals_of_old(tmp_path):
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    content = b"\xff\xff\xff" + (4).to_bytes(3, "big") + (1).to_bytes(3, "big")
    content += (100 * square).astype(">i2").tobytes() + b"".join(i.to_bytes(3, "big") for i in range(4))
    (tmp_path / "lh.orig").write_bytes(content)
    surface = Surface.read(tmp_path / "lh.orig")
    np.testing.assert_array_equal(surface.vertices, square)
    np.testing.assert_array_equal(surface.face_normals, [[0, 0, 1]] * 2)
    assert surface.area == 1


def test_freesurfer_surfaces_that_were_cut_off(tmp_path):
    file = tmp_path / "lh.pial"
    nibabel.freesurfer.write_geometry(file, V, F)
    content = file.read_bytes()
    for length in (3, 10, content.index(b"\n\n") + 6, len(content) - 1000):
        file.write_bytes(content[:length])
        with pytest.raises(MeshError, match=r"lh.pial: not a readable FreeSurfer surface"):
            Surface.read(file)
    start = content.index(b"\n\n") + 2
    for counts in ((2**31 - 1, len(F)), (len(V), -5), (2**30, 2**30)):
        file.write_bytes(content[:start] + struct.pack(">ii", *counts) + content[start + 8 :])
        with pytest.raises(MeshError, match=rf"{counts[0]} vertices and {counts[1]} faces announced, but only"):
            Surface.read(file)


@pytest.mark.parametrize("encoding", ["GIFTI_ENCODING_ASCII", "GIFTI_ENCODING_B64BIN", "GIFTI_ENCODING_B64GZ"])
def test_gifti_surfaces_and_their_values(tmp_path, encoding):
    arrays = (F.astype("i4"), TRIANGLES, ""), (SINGLE, POINTS, ""), (VALUES, SHAPE, "Curv"), (VALUES + 1, SHAPE, "Curv")
    labels = np.arange(len(V), dtype="i4"), "NIFTI_INTENT_LABEL", ""
    surface = Surface.read(gifti(tmp_path / "lh.midthickness.surf.gii", *arrays, labels, encoding=encoding))
    np.testing.assert_allclose(surface.vertices, SINGLE, rtol=1e-5, atol=1e-6)
    np.testing.assert_array_equal(surface.faces, F)
    assert list(surface.attributes) == ["Curv", "Curv_2", "label"]
    np.testing.assert_allclose(surface.attributes["Curv_2"], VALUES + 1, rtol=1e-5)
    np.testing.assert_array_equal(surface.attributes["label"], np.arange(len(V)))


def test_gifti_of_either_byte_order(tmp_path):
    file = gifti(
        tmp_path / "a.gii", (SINGLE, POINTS, ""), (F.astype("i4"), TRIANGLES, ""), encoding="GIFTI_ENCODING_B64BIN"
    )
    import base64

    text = file.read_text().replace("LittleEndian", "BigEndian")
    for array in (SINGLE, F.astype("i4")):
        text = text.replace(
            base64.b64encode(array.tobytes()).decode(), base64.b64encode(array.byteswap().tobytes()).decode()
        )
    file.write_text(text)
    np.testing.assert_array_equal(Surface.read(file).vertices, SINGLE)
    np.testing.assert_array_equal(Surface.read(file).faces, F)


def test_gifti_without_a_surface_says_what_it_has(tmp_path):
    file = gifti(tmp_path / "a.func.gii", (VALUES, SHAPE, "Curv"))
    with pytest.raises(MeshError, match=r"a.func.gii: no surface, .* its arrays are NIFTI_INTENT_SHAPE"):
        Surface.read(file)


def test_gifti_arrays_of_another_length_are_passed_over_aloud(tmp_path):
    arrays = (SINGLE, POINTS, ""), (F.astype("i4"), TRIANGLES, ""), (VALUES[:9], SHAPE, "short")
    with pytest.warns(UserWarning, match="1 array beside the surface passed over"):
        assert not Surface.read(gifti(tmp_path / "a.gii", *arrays)).attributes


@pytest.mark.filterwarnings("error")
def test_damaged_gifti_files(tmp_path, capfd):
    file = gifti(tmp_path / "a.gii", (SINGLE, POINTS, ""), (F.astype("i4"), TRIANGLES, ""))
    text = file.read_text()
    for damaged in (
        "",
        "<GIFTI",
        text[: len(text) // 2],
        text.replace(f'Dim0="{len(V)}"', 'Dim0="99999999999"'),
        text.replace(f'Dim0="{len(V)}"', 'Dim0="many"'),
        text.replace('Dimensionality="2"', 'Dimensionality="5"'),
        text.replace("NIFTI_TYPE_FLOAT32", "NIFTI_TYPE_NONE"),
        text.replace("GZipBase64Binary", "Base64Binary"),
        text.replace("GZipBase64Binary", "ExternalFileBinary"),
        text.replace(POINTS, "NIFTI_INTENT_NOTHING"),
    ):
        assert damaged != text
        file.write_text(damaged)
        with pytest.raises(MeshError, match=r"a\.gii: not a readable GIFTI file|a\.gii: no surface"):
            Surface.read(file)
    assert capfd.readouterr() == ("", "")


def test_mutated_files_are_surfaces_or_mesh_errors(tmp_path):
    rng = np.random.default_rng(2)
    nibabel.freesurfer.write_geometry(tmp_path / "lh.pial", V, F)
    gifti(tmp_path / "a.gii", (SINGLE, POINTS, ""), (F.astype("i4"), TRIANGLES, ""), (VALUES, SHAPE, "Curv"))
    for name in ("lh.pial", "a.gii"):
        content = (tmp_path / name).read_bytes()
        file = tmp_path / f"b{Path(name).suffix}"
        for _ in range(150):
            damaged = bytearray(content)
            for at in rng.integers(0, 2000, 3):
                damaged[at] = rng.integers(256)
            file.write_bytes(bytes(damaged))
            with suppress(MeshError):
                assert Surface.read(file).n_vertices == len(V)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_gifti_of_dimensions_without_end(tmp_path, encoding):
    """Their library counts up to the number one by one: four thousand million steps."""
    file = gifti(tmp_path / "a.gii", (SINGLE, POINTS, None), (F, TRIANGLES, None))
    text = file.read_text().replace('Dimensionality="2"', 'Dimensionality="4294967295"', 1)
    file.write_bytes(text.replace('"UTF-8"', f'"{encoding.upper()}"').encode(encoding))
    with pytest.raises(MeshError, match=r"not a readable GIFTI file \(an array of 4294967295 dimensions\)"):
        Surface.read(file)
