"""The pictures of the README, all from the cow in PyMeshLab's wheel.

    python benchmarks/readme_pictures.py [FOLDER]

writes eigenfunctions.png, symmetry.png, matrix.png, match.png, path.png and transfer.png, by default into docs/images.
The second cow is the first one with its head turned and a foreleg raised by Open3D's as-rigid-as-possible deformation,
then triangulated anew, so that its vertices have nothing to do with the first one's.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import qgeo_filters as qg
from qgeo_filters.atomic import atomic_write
from qgeo_filters.cli.demo import cow
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.report import figures
from qgeo_filters.report.film import plot_film_strip
from qgeo_filters.surface import Surface

LARGEST = 150_000  # bytes of a picture
ROUNDS = 40
REMESHED_EDGE = 1.6  # per cent of the diagonal of the bounding box


def posed_cow(surface: Surface) -> Surface:
    """The cow with its head turned to a side and lowered, and one foreleg forward."""
    import open3d as o3d

    vertices = np.array(surface.vertices)
    moved = vertices.copy()
    head, foreleg, others = _handles(vertices)
    neck = vertices[head].mean(axis=0) * [0, 1, 1] - [0, 0.05, 0.12] * np.ptp(vertices, axis=0)
    moved[head] = neck + (vertices[head] - neck) @ _turn("y", 35).T @ _turn("x", 20).T
    moved[foreleg] += np.array([0.0, 0.08, 0.16]) * np.ptp(vertices, axis=0)
    fixed = np.concatenate([head, foreleg, others])
    mesh = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(np.array(surface.faces))
    )
    posed = mesh.deform_as_rigid_as_possible(
        o3d.utility.IntVector(fixed.astype(np.int32)), o3d.utility.Vector3dVector(moved[fixed]), max_iter=ROUNDS
    )
    return surface.with_vertices(np.asarray(posed.vertices))


def remeshed(surface: Surface) -> Surface:
    """The surface on another triangulation, which shares no vertex with the first."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.array(surface.vertices), np.array(surface.faces)))
    meshes.meshing_isotropic_explicit_remeshing(iterations=6, targetlen=pymeshlab.PercentageValue(REMESHED_EDGE))
    return qg.repair_surface(meshes).surface


def _handles(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices of the head, of one forefoot, and of the feet and the hind part, which stay where they are."""
    unit = (vertices - vertices.min(axis=0)) / np.ptp(vertices, axis=0)
    # The horns are the highest vertices: they tell which end is the front.
    along = unit[:, 2] if unit[unit[:, 1].argmax(), 2] > 0.5 else 1 - unit[:, 2]
    feet = unit[:, 1] < 0.12
    head = np.flatnonzero((along > 0.86) & (unit[:, 1] > 0.6))
    front_left = np.flatnonzero(feet & (along > 0.5) & (unit[:, 0] > 0.5))
    others = np.flatnonzero((feet & ~((along > 0.5) & (unit[:, 0] > 0.5))) | ((along < 0.3) & (unit[:, 1] > 0.6)))
    return head, front_left, others


def _turn(axis: str, degrees: float) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_euler(axis, degrees, degrees=True).as_matrix()


def write(figure: Figure, path: Path, dpi: int = 110) -> None:
    """Save as PNG, with fewer pixels until the file is small enough."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi, pil_kwargs={"optimize": True}, metadata={"Software": None})
    if buffer.tell() > LARGEST:
        write(figure, path, int(0.93 * dpi))
        return
    with atomic_write(path) as file:
        file.write(buffer.getvalue())
    sys.stdout.write(f"{path.name}  {buffer.tell() // 1000} kB\n")


def main(folder: Path) -> None:
    """Make all of them."""
    folder.mkdir(parents=True, exist_ok=True)
    surface = qg.Surface.read(cow())
    metric = qg.lifted_metric(surface)
    matrix = qg.distance_matrix(surface, metric)
    spectrum = qg.distance_spectrum(surface, 6, metric, matrix=matrix)
    write(figures.plot_eigenfunctions(surface, spectrum), folder / "eigenfunctions.png")
    write(figures.plot_distance_matrix(matrix, surface), folder / "matrix.png")
    nose, tail = np.unravel_index(int(matrix.argmax()), matrix.shape)
    path = qg.quasi_geodesic(surface, int(nose), int(tail))
    write(figures.plot_path(surface, path), folder / "path.png")
    descriptor = PreparedShape(surface)
    symmetry = self_symmetry(descriptor)
    sys.stdout.write(f"symmetry: {symmetry.reason}\n")
    write(figures.plot_symmetry(surface, p2p=symmetry.nearest), folder / "symmetry.png")
    standing_posed = posed_cow(surface)
    posed = remeshed(standing_posed)
    found = match(descriptor, posed)
    sys.stdout.write(f"match of {surface.n_vertices} to {posed.n_vertices} vertices: {found.explanation}\n")
    names = (f"{surface.n_vertices} vertices", f"posed and remeshed, {posed.n_vertices} vertices")
    write(figures.plot_correspondence(surface, posed, found.p2p, names=names), folder / "match.png")
    walk = qg.interpolate(surface, standing_posed, np.linspace(0, 1, 5))
    moved = qg.transfer_deformation(surface, walk.positions, remeshed(surface))
    write(plot_film_strip(moved, 5, names=("given", "found")), folder / "transfer.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1] / "docs" / "images")
