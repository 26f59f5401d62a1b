"""Pairs, mesh-like objects, trimesh, paths; what is imported when; what a missing host says."""

from __future__ import annotations

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from host_meshes import ATTRIBUTES, FACES, VERTICES, N, assert_attributes
from tensors import Tensor

from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.dispatch import as_surface, with_positions, write_back
from qgeo_filters.surface import Surface


@pytest.mark.parametrize(
    "make",
    [
        lambda: (VERTICES, FACES),
        lambda: [VERTICES.tolist(), FACES.tolist()],
        lambda: SimpleNamespace(vertices=VERTICES, faces=FACES),
        lambda: Surface(VERTICES, FACES),
    ],
    ids=["tuple", "lists", "object", "Surface"],
)
def test_arrays_become_a_surface_with_attributes(make):
    host = make()
    surface = as_surface(host)
    np.testing.assert_array_equal(surface.vertices, VERTICES)
    np.testing.assert_array_equal(surface.faces, FACES)
    out = write_back(host, surface, ATTRIBUTES)
    assert isinstance(out, Surface)
    assert_attributes(out, ATTRIBUTES)


def test_a_surface_is_taken_as_it_is():
    surface = Surface(VERTICES, FACES)
    assert as_surface(surface) is surface


def test_a_pair_is_posed_as_a_pair():
    posed = with_positions((VERTICES, FACES), 2 * VERTICES)
    assert isinstance(posed, tuple)
    np.testing.assert_array_equal(posed[0], 2 * VERTICES)
    assert posed[1] is FACES
    posed = with_positions((VERTICES, FACES), Tensor(2 * VERTICES, requires_grad=True, device="cuda:0"))
    np.testing.assert_array_equal(posed[0], 2 * VERTICES)


def test_paths_become_surfaces(tmp_path):
    file = tmp_path / "a.off"
    Surface(VERTICES, FACES).write(file)
    for path in (file, str(file)):
        surface = as_surface(path)
        np.testing.assert_array_equal(surface.vertices, VERTICES)
        assert_attributes(write_back(path, surface, ATTRIBUTES), ATTRIBUTES)
        np.testing.assert_array_equal(with_positions(path, 2 * VERTICES).vertices, 2 * VERTICES)


@pytest.mark.parametrize("thing", [3, None, (VERTICES,), (VERTICES, FACES, 3), np.zeros((2, 3)), object()])
def test_what_is_no_mesh_is_named(thing):
    with pytest.raises(MeshError, match=rf"cannot take a mesh from .*{type(thing).__name__}: expected"):
        as_surface(thing)


def test_attribute_of_wrong_length_is_named():
    surface = as_surface((VERTICES, FACES))
    with pytest.raises(MeshError, match=rf"attribute 'a' has shape \(3,\), but there are {N} vertices"):
        write_back((VERTICES, FACES), surface, {"a": np.zeros(3)})


def test_trimesh_both_ways():
    import trimesh

    colors = np.tile(np.array([[1, 2, 3, 255]], np.uint8), (N, 1))
    mesh = trimesh.Trimesh(
        VERTICES, FACES, process=False, vertex_attributes={"own": np.arange(N)}, vertex_colors=colors,
        face_attributes={"own": np.arange(len(FACES))}, metadata={"note": "kept"},
    )  # fmt: skip
    surface = as_surface(mesh)
    np.testing.assert_array_equal(surface.attributes["own"], np.arange(N))
    np.testing.assert_array_equal(surface.attributes["colors"], colors[:, :3] / 255)
    out = write_back(mesh, surface, ATTRIBUTES)
    assert type(out) is trimesh.Trimesh
    assert_attributes(as_surface(out), {**ATTRIBUTES, "own": np.arange(N)})
    np.testing.assert_array_equal(out.visual.vertex_colors, colors)
    np.testing.assert_array_equal(out.face_attributes["own"], np.arange(len(FACES)))
    assert out.metadata["note"] == "kept"
    assert set(mesh.vertex_attributes) == {"own"}
    posed = with_positions(out, 2 * VERTICES)
    np.testing.assert_array_equal(posed.vertices, 2 * VERTICES)
    assert_attributes(as_surface(posed), ATTRIBUTES)
    np.testing.assert_array_equal(mesh.vertices, VERTICES)
    with pytest.raises(MeshError, match=r"a trimesh Scene is no mesh: pass scene.to_mesh\(\)"):
        as_surface(trimesh.Scene(mesh))


def test_what_is_painted_is_what_trimesh_shows_and_writes(tmp_path):
    import trimesh

    mesh = trimesh.Trimesh(VERTICES, FACES, process=False, vertex_attributes={"own": np.arange(N, dtype=np.float32)})
    assert set(as_surface(mesh).attributes) == {"own"}
    colors = np.linspace(0, 1, 3 * N).reshape(N, 3)
    out = write_back(mesh, as_surface(mesh), {"colors": colors})
    assert out.visual.kind == "vertex"
    assert set(out.vertex_attributes) == {"own"}
    np.testing.assert_array_equal(out.visual.vertex_colors, np.column_stack([np.round(255 * colors), np.full(N, 255)]))
    for suffix in ("ply", "obj", "glb"):
        out.export(tmp_path / f"painted.{suffix}")
        again = trimesh.load(tmp_path / f"painted.{suffix}", process=False, force="mesh")
        assert np.abs(again.visual.vertex_colors[:, :3] / 255.0 - colors).max() < 0.003, suffix
    repainted = write_back(out, as_surface(out), {"colors": 1 - colors})
    np.testing.assert_allclose(as_surface(repainted).attributes["colors"], 1 - colors, atol=0.5 / 255 + 1e-9)
    assert mesh.visual.kind is None


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)


def test_no_host_is_imported_before_one_of_its_objects_is_met():
    code = """
import sys
import qgeo_filters as qg
surface = qg.as_surface(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
qg.as_surface((surface.vertices, surface.faces), repair=True)
hosts = {"open3d", "pymeshlab", "pyvista", "vtk", "trimesh", "ipywidgets", "matplotlib"}
print(sorted(hosts & set(sys.modules)))
"""
    done = run(code)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr


@pytest.mark.parametrize("installed", ["None", "broken"])
def test_a_missing_host_says_what_brings_it(tmp_path, installed):
    Surface(VERTICES, FACES)
    (tmp_path / "a.gii").write_bytes(b"")
    if installed == "broken":
        (tmp_path / "nibabel.py").write_text("raise ImportError('libGL.so.1: cannot open shared object file')")
        block = f"sys.path.insert(0, {str(tmp_path)!r})"
        expected = "which is installed but does not load: libGL.so.1"
    else:
        block = "sys.modules['nibabel'] = None"
        expected = "which is not installed: pip install 'qgeo-filters[files]'"
    code = f"""
import sys
{block}
import qgeo_filters as qg
try:
    qg.Surface.read({str(tmp_path / "a.gii")!r})
except qg.MissingPackageError as error:
    print(error)
"""
    done = run(code)
    assert done.stdout.strip().startswith(f"reading a.gii needs nibabel, {expected}"), done.stdout + done.stderr
