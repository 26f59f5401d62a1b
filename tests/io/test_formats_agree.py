"""One mesh in every format, written by us and by other libraries, is one surface; the table of formats is complete."""

from __future__ import annotations

import re

import numpy as np
import pytest
from shapes import blob

from qgeo_filters.errors import MeshError
from qgeo_filters.io import formats
from qgeo_filters.surface import Surface

V, F = blob(2)
SINGLE = V.astype("f4").astype(float)  # what every format holds
SURFACE = Surface(SINGLE, F)


def by_trimesh(file):
    import trimesh

    mesh = trimesh.Trimesh(SINGLE, F, process=False)
    mesh.export(file)


def by_open3d(file):
    o3d = pytest.importorskip("open3d")
    mesh = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(SINGLE), o3d.utility.Vector3iVector(F.astype("i4")))
    mesh.compute_vertex_normals()
    assert o3d.io.write_triangle_mesh(str(file), mesh)


def by_pymeshlab(file):
    pymeshlab = pytest.importorskip("pymeshlab")
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(SINGLE, F))
    meshes.save_current_mesh(str(file))


def by_pyvista(file):
    pyvista = pytest.importorskip("pyvista")
    pyvista.PolyData.from_regular_faces(SINGLE, F).save(file)


def by_meshio(file):
    meshio = pytest.importorskip("meshio")
    mesh = meshio.Mesh(SINGLE, [("triangle", F)])
    meshio.gmsh.write(file, mesh) if file.suffix == ".msh" else meshio.write(file, mesh)


def by_nibabel(file):
    nibabel = pytest.importorskip("nibabel")
    if file.suffix != ".gii":
        nibabel.freesurfer.write_geometry(file, SINGLE, F)
        return
    arrays = [
        nibabel.gifti.GiftiDataArray(values, f"NIFTI_INTENT_{intent}", values.dtype.name)
        for values, intent in ((SINGLE.astype("f4"), "POINTSET"), (F.astype("i4"), "TRIANGLE"))
    ]
    nibabel.gifti.GiftiImage(darrays=arrays).to_filename(file)


WRITERS = [
    *((SURFACE.write, f"qgeo{suffix}") for suffix in (".ply", ".off", ".obj", ".stl", ".glb", ".vert", ".mat")),
    *((by_trimesh, f"trimesh{suffix}") for suffix in (".ply", ".off", ".obj", ".stl", ".glb", ".gltf")),
    *((by_open3d, f"open3d{suffix}") for suffix in (".ply", ".off", ".obj", ".stl", ".glb", ".gltf")),
    *((by_pymeshlab, f"pymeshlab{suffix}") for suffix in (".ply", ".off", ".obj", ".stl")),
    *((by_pyvista, f"pyvista{suffix}") for suffix in (".ply", ".stl", ".vtk", ".vtp")),
    *((by_meshio, f"meshio{suffix}") for suffix in (".ply", ".off", ".obj", ".stl", ".vtk", ".vtu", ".msh")),
    *((by_nibabel, name) for name in ("nibabel.gii", "lh.white")),
]


@pytest.mark.parametrize(("write", "name"), WRITERS, ids=[name for _, name in WRITERS])
def test_a_mesh_is_the_same_surface_whoever_wrote_it(tmp_path, write, name):
    write(tmp_path / name)
    surface = Surface.read(tmp_path / name)
    assert (surface.n_vertices, surface.n_faces, surface.genus) == (len(V), len(F), 0)
    in_text = name.endswith((".off", ".obj")) and not name.startswith("qgeo")
    tolerance = 1e-5 if in_text else 0  # six digits and more
    np.testing.assert_allclose(surface.vertices[surface.faces], SINGLE[F], rtol=0, atol=tolerance)


@pytest.mark.parametrize(
    ("library", "suffix"),
    [*(("open3d", suffix) for suffix in (".off", ".obj", ".ply", ".glb")),
     *(("pymeshlab", suffix) for suffix in (".off", ".obj", ".ply"))],
)  # fmt: skip
def test_colors_are_the_same_whoever_wrote_them(tmp_path, library, suffix):
    colors = np.abs(SINGLE) / np.abs(SINGLE).max()
    file = tmp_path / f"a{suffix}"
    package = pytest.importorskip(library)
    if library == "open3d":
        vectors = package.utility.Vector3dVector
        mesh = package.geometry.TriangleMesh(vectors(SINGLE), package.utility.Vector3iVector(F.astype("i4")))
        mesh.vertex_colors = vectors(colors)
        mesh.compute_vertex_normals()
        assert package.io.write_triangle_mesh(str(file), mesh)
    else:
        meshes = package.MeshSet()
        meshes.add_mesh(package.Mesh(SINGLE, F, v_color_matrix=np.column_stack([colors, np.ones(len(V))])))
        meshes.save_current_mesh(str(file), save_vertex_color=True)
    read = Surface.read(file)
    found = read.attributes["colors"][:, :3]
    np.testing.assert_allclose(found / (255 if found.dtype == np.uint8 else 1), colors, atol=1 / 200)
    if "normals" in read.attributes:
        normals = read.attributes["normals"]
        assert (np.einsum("ij,ij->i", normals, SURFACE.vertex_normals) > 0.9 * np.linalg.norm(normals, axis=1)).all()


def test_the_table_names_every_suffix_that_is_read(tmp_path):
    (tmp_path / "a.nothing").write_text("")
    with pytest.raises(MeshError, match=r"unknown suffix '.nothing'; read are .* and FreeSurfer's surfaces") as caught:
        Surface.read(tmp_path / "a.nothing")
    suffixes = set(re.findall(r" (\.\w+)", str(caught.value).partition("read are")[2]))
    assert suffixes
    assert suffixes <= set(re.findall(r"\.[a-z]+", formats.__doc__ or ""))


@pytest.mark.parametrize("name", ["a.VTP", "a.GII", "A.MSH", "a b.Glb", "ö.gltf"])
def test_suffixes_in_capitals_and_names_with_blanks(tmp_path, name):
    suffix = name.lower().rpartition(".")[2]
    write = {"vtp": by_pyvista, "gii": by_nibabel, "msh": by_meshio, "glb": by_trimesh, "gltf": by_trimesh}[suffix]
    write(tmp_path / f"x.{suffix}")
    (tmp_path / f"x.{suffix}").rename(tmp_path / name)
    assert Surface.read(str(tmp_path / name)).n_faces == len(F)
