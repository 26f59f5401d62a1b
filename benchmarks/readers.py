"""Whether files are read alike: vertices, faces, area and volume by `qgeo_filters` and two other readers each.

    python benchmarks/readers.py [FOLDER ...] [--json results/readers.json]

On the mesh files that install with PyMeshLab, PyVista and nibabel, on PyMeshLab's cow in every further format as other
libraries write it, and on the mesh files of the folders given. Polygons are triangulated, nothing else is repaired.
"""

from __future__ import annotations

import contextlib
import io
import logging
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import meshio
import nibabel
import numpy as np
import open3d
import pymeshlab
import pyvista
import trimesh
from record import Record, recorded

from qgeo_filters.errors import MeshError
from qgeo_filters.io.formats import read_raw

SUFFIXES = {".ply", ".off", ".obj", ".stl", ".glb", ".gltf", ".vtk", ".vtp", ".vtu", ".msh", ".gii", ".pial"}
Arrays = tuple[np.ndarray, np.ndarray]


class Measures(NamedTuple):
    """What is compared of a mesh."""

    n_vertices: int
    n_faces: int
    area: float
    volume: float


def measures(arrays: Arrays) -> Measures:
    """Measures of vertices and triangles, the volume about the middle of their box."""
    vertices, faces = np.asarray(arrays[0], dtype=float), np.asarray(arrays[1], dtype=np.int64)
    if faces.max(initial=-1) >= len(vertices):
        raise MeshError(f"faces refer to vertex {faces.max()}, but there are {len(vertices)}")
    corners = vertices[faces] if len(faces) else np.zeros((1, 3, 3))
    a, b, c = np.moveaxis(corners - (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1))) / 2, 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    return Measures(len(vertices), len(faces), float(area), float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6))


def by_qgeo(file: Path) -> Arrays:
    """Through our readers, before anything else is repaired."""
    raw = read_raw(file, repair=True)
    return np.asarray(raw.vertices), np.asarray(raw.faces)


def by_trimesh(file: Path) -> Arrays:
    """All geometry of the scene, unprocessed."""
    mesh = trimesh.load_scene(file, process=False, maintain_order=True).to_mesh()
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def by_pymeshlab(file: Path) -> Arrays:
    """Its current mesh, as it comes."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(file), unify_vertices=False) if file.suffix == ".stl" else meshes.load_new_mesh(str(file))
    mesh = meshes.current_mesh()
    return mesh.transformed_vertex_matrix(), mesh.face_matrix()


def by_pyvista(file: Path) -> Arrays:
    """VTK's reader; a scene is combined, a grid replaced by its surface."""
    mesh = pyvista.read(file)
    if isinstance(mesh, pyvista.MultiBlock):
        mesh = mesh.combine()
    if not isinstance(mesh, pyvista.PolyData):
        mesh = mesh.extract_surface(algorithm=None)
    mesh = mesh.triangulate()
    return np.asarray(mesh.points), mesh.regular_faces


def by_open3d(file: Path) -> Arrays:
    """Its legacy mesh."""
    mesh = open3d.io.read_triangle_mesh(str(file))
    return np.asarray(mesh.vertices), np.asarray(mesh.triangles)


def by_meshio(file: Path) -> Arrays:
    """Its triangles, and its quadrilaterals cut along their first diagonal."""
    mesh = meshio.read(file)
    blocks = [block.data for block in mesh.cells if block.type == "triangle"]
    blocks += [
        block.data[:, list(cut)] for block in mesh.cells if block.type == "quad" for cut in ((0, 1, 2), (0, 2, 3))
    ]
    return mesh.points, np.vstack(blocks) if blocks else np.empty((0, 3))


def by_nibabel(file: Path) -> Arrays:
    """Points and triangles."""
    if file.suffix != ".gii":
        return nibabel.freesurfer.read_geometry(file)
    image = nibabel.load(file)
    return image.agg_data("pointset"), image.agg_data("triangle")


PEERS: dict[str, tuple[Callable[[Path], Arrays], ...]] = {
    ".ply": (by_trimesh, by_pymeshlab),
    ".off": (by_trimesh, by_pymeshlab),
    ".obj": (by_pymeshlab, by_pyvista),
    ".stl": (by_trimesh, by_pyvista),
    ".glb": (by_trimesh, by_open3d),
    ".gltf": (by_trimesh, by_open3d),
    ".vtk": (by_pyvista, by_meshio),
    ".vtp": (by_pyvista,),
    ".vtu": (by_pyvista, by_meshio),
    ".msh": (by_meshio, by_pyvista),
    ".gii": (by_nibabel,),
    ".pial": (by_nibabel,),
}


def converted(folder: Path) -> Iterator[tuple[str, Path]]:
    """PyMeshLab's cow as other libraries write it, and who does."""
    cow = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"
    vertices, faces = by_qgeo(cow)
    scene = trimesh.Scene(trimesh.Trimesh(vertices, faces, process=False))
    grid = pyvista.PolyData.from_regular_faces(vertices, faces)
    plain = meshio.Mesh(vertices, [("triangle", faces)])
    legacy = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(vertices), open3d.utility.Vector3iVector(faces.astype(np.int32))
    )
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(cow))
    arrays = [
        nibabel.gifti.GiftiDataArray(vertices.astype("f4"), "NIFTI_INTENT_POINTSET", "NIFTI_TYPE_FLOAT32"),
        nibabel.gifti.GiftiDataArray(faces.astype("i4"), "NIFTI_INTENT_TRIANGLE", "NIFTI_TYPE_INT32"),
    ]
    writers: list[tuple[str, str, Callable[[Path], object]]] = [
        ("trimesh", "glb", scene.export),
        ("Open3D", "glb", lambda file: open3d.io.write_triangle_mesh(str(file), legacy)),
        ("trimesh", "off", lambda file: scene.to_mesh().export(file)),
        ("PyMeshLab", "off", lambda file: meshes.save_current_mesh(str(file))),
        ("PyMeshLab", "stl", lambda file: meshes.save_current_mesh(str(file))),
        ("PyVista", "vtk", grid.save),
        ("PyVista", "vtp", grid.save),
        ("meshio", "vtu", lambda file: meshio.write(file, plain)),
        ("meshio", "msh", lambda file: meshio.gmsh.write(file, plain)),
        ("nibabel", "gii", lambda file: nibabel.save(nibabel.gifti.GiftiImage(darrays=arrays), file)),
        ("nibabel", "pial", lambda file: nibabel.freesurfer.write_geometry(file, vertices, faces)),
    ]
    for who, suffix, write in writers:
        file = folder / f"{who}.{suffix}"
        write(file)
        yield f"cow.{suffix} of {who}", file


def files(folders: list[str], made: Path) -> Iterator[tuple[str, Path]]:
    """Every mesh file, and what it is called in the table."""
    samples = [Path(package.__file__).parent / where for package, where in (
        (pymeshlab, "tests/sample_meshes"), (pyvista, "examples"), (nibabel, "gifti/tests/data"),
    )]  # fmt: skip
    for folder in [*samples, *map(Path, folders)]:
        for file in sorted(folder.rglob("*")):
            if file.suffix.lower() in SUFFIXES and file.is_file():
                yield file.name, file
    yield from converted(made)


def verdict(ours: Measures, theirs: Measures) -> str:
    """In what two readers differ, more than float32 does."""
    if not theirs.n_faces:
        return "no faces"
    different = [
        f"{name} {other:.6g}"
        for name, one, other in zip(("vertices", "faces", "area", "volume"), ours, theirs, strict=True)
        if abs(one - other) > (0 if isinstance(one, int) else 1e-5 * max(ours.area, abs(one)))
    ]
    return ", ".join(different) or "the same"


def main(record: Record) -> None:
    """Print the table, and what was refused."""
    warnings.simplefilter("ignore")
    logging.disable(logging.CRITICAL)
    open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
    table = record.table("files", "file", "vertices", "faces", "area", "volume", "other readers")
    refused = []
    with tempfile.TemporaryDirectory() as made:
        for name, file in files(record.arguments, Path(made)):
            try:
                ours = measures(by_qgeo(file))
            except MeshError as error:
                refused.append((name, str(error).removeprefix(f"{file}: ")))
                continue
            said = []
            for peer in PEERS[file.suffix.lower()]:
                quiet = io.StringIO()
                try:
                    with contextlib.redirect_stdout(quiet), contextlib.redirect_stderr(quiet):
                        theirs = measures(peer(file))
                    found = verdict(ours, theirs)
                except (Exception, SystemExit) as error:  # theirs, whatever it is
                    found = f"fails ({type(error).__name__})"
                said.append(f"{peer.__name__.removeprefix('by_')}: {found}")
            table.row(name, ours.n_vertices, ours.n_faces, f"{ours.area:.6g}", f"{ours.volume:.6g}", "; ".join(said))
    table = record.table("refused", "file", "why")
    for cells in refused:
        table.row(*cells)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
