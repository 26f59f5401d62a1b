"""What other programs show of a command's results: files are opened by each of them and read back."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import Result

import qgeo_filters as qg
from qgeo_filters.cli.match_outputs import deformed
from qgeo_filters.report.colors import MISSING, sequential
from qgeo_filters.report.shown import Shown

Qgeo = Callable[..., Result]


def grey(count: int) -> np.ndarray:
    """That many grey vertices, as bytes."""
    return np.tile(np.rint(255 * np.array(MISSING)), (count, 1))


@pytest.fixture
def folder(qgeo: Qgeo) -> Path:
    """Distances from a vertex, written in all forms."""
    result = qgeo("distances", "blob.off", "-s", 7, "--also", "vtp,vtu,glb", "--also", ".CSV,obj", "--no-pictures")
    assert result.exit_code == 0, result.output
    return Path("qgeo-out/distances-blob")


def test_colours_are_those_of_the_picture_and_quality_is_the_distance(folder: Path) -> None:
    written = qg.Surface.read(folder / "blob.ply").attributes
    distance = written["qgeo_distance"]
    assert list(written) == ["colors", "quality", "qgeo_distance"]
    np.testing.assert_array_equal(written["quality"], distance)
    np.testing.assert_array_equal(written["colors"], np.rint(255 * sequential(distance)(distance)))
    assert len(np.unique(written["colors"], axis=0)) > 50


def test_open3d_shows_the_colours(folder: Path) -> None:
    open3d = pytest.importorskip("open3d")
    colors = qg.Surface.read(folder / "blob.ply").attributes["colors"]
    mesh = open3d.io.read_triangle_mesh(str(folder / "blob.ply"))
    np.testing.assert_array_equal(np.rint(255 * np.asarray(mesh.vertex_colors)), colors)
    by_tensors = open3d.t.io.read_triangle_mesh(str(folder / "blob.ply"))
    np.testing.assert_allclose(255 * by_tensors.vertex.colors.numpy(), colors, atol=1e-3)
    assert open3d.io.read_triangle_mesh(str(folder / "blob.glb")).has_vertex_colors()
    assert open3d.io.read_triangle_mesh(str(folder / "blob.obj")).has_vertex_colors()


def test_meshlab_shows_the_colours_and_the_quality(folder: Path) -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    expected = qg.Surface.read(folder / "blob.ply").attributes
    meshes = pymeshlab.MeshSet()
    for suffix in ("ply", "obj", "glb"):
        meshes.load_new_mesh(str(folder / f"blob.{suffix}"))
        assert meshes.current_mesh().has_vertex_color(), suffix
    meshes.set_current_mesh(0)
    mesh = meshes.current_mesh()
    np.testing.assert_array_equal(np.rint(255 * mesh.vertex_color_matrix()[:, :3]), expected["colors"])
    np.testing.assert_allclose(mesh.vertex_scalar_array(), expected["quality"], rtol=1e-6)


def test_pyvista_and_with_it_paraview_shows_colours_and_attributes(folder: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    expected = qg.Surface.read(folder / "blob.ply").attributes
    for suffix in ("vtp", "vtu"):
        data = pyvista.read(folder / f"blob.{suffix}").point_data
        for name, values in expected.items():
            np.testing.assert_array_equal(data[name], values)
    for suffix, rounding in (("ply", 0), ("obj", 1)):  # VTK cuts the decimals of OBJ's colours off
        rgb = pyvista.read(folder / f"blob.{suffix}").point_data["RGB"]
        np.testing.assert_allclose(rgb.astype(int), expected["colors"], rtol=0, atol=rounding)
    (part,) = pyvista.read(folder / "blob.glb").recursive_iterator()
    assert {"COLOR_0", "_quality", "_qgeo_distance"} <= set(part.point_data.keys())


def test_trimesh_and_meshio_show_what_the_table_says(folder: Path) -> None:
    trimesh, meshio = pytest.importorskip("trimesh"), pytest.importorskip("meshio")
    expected = qg.Surface.read(folder / "blob.ply").attributes
    for suffix, rounding in (("ply", 0), ("obj", 1)):
        colors = trimesh.load(folder / f"blob.{suffix}", process=False).visual.vertex_colors[:, :3]
        np.testing.assert_allclose(colors.astype(int), expected["colors"], rtol=0, atol=rounding)
    mesh = trimesh.load(folder / "blob.glb", process=False, force="mesh")
    np.testing.assert_array_equal(mesh.vertex_attributes["_quality"].ravel(), expected["quality"].astype(np.float32))
    data = meshio.read(folder / "blob.ply").point_data
    rgb = np.column_stack([data[name].astype(np.uint8) for name in ("red", "green", "blue")])  # it takes uchar for int8
    np.testing.assert_array_equal(rgb, expected["colors"])
    np.testing.assert_array_equal(data["quality"], expected["quality"])
    np.testing.assert_array_equal(meshio.read(folder / "blob.vtu").point_data["colors"], expected["colors"])


def test_the_table_has_a_row_for_each_vertex(folder: Path) -> None:
    surface = qg.Surface.read(folder / "blob.ply")
    with (folder / "blob.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["vertex", "x", "y", "z", "red", "green", "blue", "quality", "qgeo_distance"]
    table = np.array(rows, dtype=float)
    np.testing.assert_array_equal(table[:, 0], np.arange(surface.n_vertices))
    np.testing.assert_array_equal(table[:, 1:4], surface.vertices)
    np.testing.assert_array_equal(table[:, 4:7], surface.attributes["colors"])
    np.testing.assert_array_equal(table[:, 8], surface.attributes["qgeo_distance"])


def test_an_unknown_form_is_refused_before_anything_is_computed(qgeo: Qgeo) -> None:
    result = qgeo("info", "blob.off", "--also", "vtp,fbx")
    assert result.exit_code == 2
    assert "'fbx' is none of vtp, vtu, glb, csv, obj" in result.stderr
    assert not Path("qgeo-out").exists()


def test_a_mesh_called_as_a_result_is_refused(qgeo: Qgeo) -> None:
    Path("match.off").write_bytes(Path("blob.off").read_bytes())
    result = qgeo("match", "match.off", "mirror.off", "--also", "glb")
    assert result.exit_code == 2
    assert "a mesh would be written as match.glb, which is another result" in result.stderr


def test_a_match_has_one_colouring_and_x_lies_on_y(qgeo: Qgeo) -> None:
    blob = qg.Surface.read("blob.off")
    blob.with_vertices(2 * blob.vertices[:, [1, 2, 0]]).write("turned.off")
    assert qgeo("match", "blob.off", "turned.off", "--no-pictures").exit_code == 0
    folder = Path("qgeo-out/match-blob-turned")
    x, y, laid = (qg.Surface.read(folder / f"{name}.ply") for name in ("blob", "turned", "blob_on_turned"))
    image = x.attributes["qgeo_correspondence"]
    near = np.abs(x.attributes["colors"].astype(int) - y.attributes["colors"][image]).max(axis=1)
    assert np.median(near) <= 8  # the points of Y are within triangles, not at their corners
    np.testing.assert_array_equal(x.attributes["quality"], x.attributes["qgeo_distortion"])
    np.testing.assert_array_equal(laid.attributes["colors"], x.attributes["colors"])
    np.testing.assert_array_equal(laid.faces, x.faces)
    distance = np.linalg.norm(laid.vertices - y.vertices[image], axis=1)
    assert distance.max() < y.edge_lengths.max()


def test_x_on_y_leaves_out_what_has_no_partner() -> None:
    x = qg.testing.sample_surface()
    found = qg.match(x, x.with_vertices(2 * x.vertices))
    p2p = found.p2p.copy()
    p2p[:5] = -1
    shown = Shown(np.zeros((x.n_vertices, 3)), found.distortion)
    laid = deformed(x.with_attributes({"id": np.arange(x.n_vertices)}), replace(found, p2p=p2p), shown)
    left = laid.attributes["qgeo_vertex"]
    assert set(left) == set(range(5, x.n_vertices))
    np.testing.assert_array_equal(laid.attributes["id"], left)
    np.testing.assert_array_equal(laid.vertices, found.positions[left])


def test_colours_of_its_own_are_kept_beside_those_of_the_result(qgeo: Qgeo) -> None:
    blob = qg.Surface.read("blob.off")
    own = np.tile(np.array([10, 200, 30], dtype=np.uint8), (blob.n_vertices, 1))
    blob.with_attributes({"colors": own, "quality": np.arange(blob.n_vertices)}).write("painted.ply")
    before = Path("painted.ply").read_bytes()
    assert qgeo("info", "painted.ply", "--no-pictures").exit_code == 0
    np.testing.assert_array_equal(qg.Surface.read("qgeo-out/info-painted/painted.ply").attributes["colors"], own)
    assert qgeo("spectrum", "painted.ply", "-k", 4, "--no-pictures").exit_code == 0
    written = qg.Surface.read("qgeo-out/spectrum-painted/painted.ply").attributes
    np.testing.assert_array_equal(written["own_colors"], own)
    np.testing.assert_array_equal(written["own_quality"], np.arange(blob.n_vertices))
    np.testing.assert_array_equal(written["quality"], written["qgeo_phi"][:, 1])
    assert Path("painted.ply").read_bytes() == before


def test_vertices_that_a_repair_removed_are_grey(qgeo: Qgeo) -> None:
    blob = qg.Surface.read("blob.off")
    loose = np.array([[9.0, 9, 9], [9, 9, 8], [9, 8, 9]])
    pieces = qg.Surface(np.vstack([blob.vertices, loose]), np.vstack([blob.faces, [[162, 163, 164]]]))
    pieces.write("pieces.off")
    result = qgeo("spectrum", "pieces.off", "-k", 4, "--no-pictures")
    assert result.exit_code == 0, result.output
    written = qg.Surface.read("qgeo-out/spectrum-pieces/pieces.ply").attributes
    np.testing.assert_array_equal(written["colors"][162:], grey(3))
    assert np.isnan(written["quality"][162:]).all()
    assert np.isfinite(written["quality"][:162]).all()


@pytest.mark.parametrize(
    ("values", "kinds"),
    [
        (np.arange(30) % 3, 3),  # labels: each its colour
        (np.where(np.arange(30) < 3, -1, 0), 2),  # no label: grey
        (np.arange(30.0), 30),
    ],
)
def test_an_attribute_has_the_colours_of_its_picture(values: Any, kinds: int) -> None:
    shown = Shown.of_attribute(values)
    assert len(np.unique(shown.colors, axis=0)) == kinds
    assert shown.quality is not None
    np.testing.assert_array_equal(shown.quality, values)
    negative = np.asarray(values) < 0
    assert (shown.colors[negative] == MISSING).all()
