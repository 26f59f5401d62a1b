"""Shapes with a known truth, from what anybody has: PyMeshLab's sample meshes, posed by Open3D, triangulated anew."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import open3d as o3d
import pymeshlab
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from qgeo_filters import Surface


def sample_path(name: str = "cow.obj") -> Path:
    """Path of a mesh that ships in PyMeshLab's wheel."""
    return Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / name


def posed(surface: Surface, handles: Mapping[int, np.ndarray], reach: float = 0.06) -> Surface:
    """The surface with some vertices moved to new places, the rest as rigid as possible.

    Parameters
    ----------
    surface : Surface
    handles : mapping of int to (3,) array
        New place of each handle. Vertices within ``reach`` (a fraction of the diagonal) of a handle move along.
    reach : float
    """
    mesh = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(surface.vertices.copy()), o3d.utility.Vector3iVector(surface.faces.copy())
    )
    diagonal = np.linalg.norm(np.ptp(surface.vertices, axis=0))
    tree = cKDTree(surface.vertices)
    places: dict[int, np.ndarray] = {}
    for vertex, place in handles.items():
        shift = np.asarray(place) - surface.vertices[vertex]
        for near in tree.query_ball_point(surface.vertices[vertex], reach * diagonal):
            places[near] = surface.vertices[near] + shift
    ids = o3d.utility.IntVector(list(places))
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        bent = mesh.deform_as_rigid_as_possible(ids, o3d.utility.Vector3dVector(np.array(list(places.values()))), 30)
    return surface.with_vertices(np.asarray(bent.vertices))


def extremities(surface: Surface, count: int) -> list[int]:
    """Vertices at the ends of limbs: far from the middle and from each other."""
    chosen = [int(np.linalg.norm(surface.vertices - surface.vertices.mean(axis=0), axis=1).argmax())]
    gap = np.full(surface.n_vertices, np.inf)
    while len(chosen) < count:
        gap = np.minimum(gap, np.linalg.norm(surface.vertices - surface.vertices[chosen[-1]], axis=1))
        chosen.append(int(gap.argmax()))
    return chosen


def remeshed(surface: Surface, vertices: int, seed: int = 0) -> tuple[Surface, np.ndarray]:
    """The surface triangulated anew, vertices shuffled, and its nearest vertex to each old one.

    Isotropic remeshing shares no vertex with the original.
    """
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(surface.vertices.copy(), surface.faces.copy()))
    length = np.sqrt(surface.area / vertices * 2 / np.sqrt(3))
    meshes.meshing_isotropic_explicit_remeshing(targetlen=pymeshlab.PureValue(length), iterations=6)
    meshes.meshing_repair_non_manifold_edges()
    meshes.meshing_repair_non_manifold_vertices()
    meshes.meshing_remove_unreferenced_vertices()
    mesh = meshes.current_mesh()
    shuffle = np.random.default_rng(seed).permutation(mesh.vertex_number())
    rank = np.empty_like(shuffle)
    rank[shuffle] = np.arange(len(shuffle))
    result, _ = Surface(mesh.vertex_matrix()[shuffle], rank[mesh.face_matrix()]).largest_component()
    return result, cKDTree(result.vertices).query(surface.vertices)[1]


def turned(surface: Surface, degrees: float, axis: str = "y") -> Surface:
    """The surface turned about an axis."""
    return surface.with_vertices(Rotation.from_euler(axis, degrees, degrees=True).apply(surface.vertices.copy()))


def posed_cow(cow: Surface) -> Surface:
    """PyMeshLab's cow with its head turned and lowered, two legs moved and the tail lifted."""
    shifts = {
        (0.03, 0.22, 0.87): (0.33, -0.22, -0.12),  # nose
        (-0.20, -0.60, 0.21): (0.0, 0.10, 0.26),  # a fore foot
        (0.20, -0.60, 0.21): (0.0, 0.0, 0.0),
        (0.24, -0.61, -0.59): (0.0, 0.06, -0.22),  # a hind foot
        (-0.24, -0.61, -0.59): (0.0, 0.0, 0.0),
        (-0.03, -0.35, -0.88): (0.0, 0.30, -0.25),  # end of the tail
        (0.0, 0.29, -0.09): (0.0, 0.0, 0.0),  # back
        (0.0, 0.29, -0.60): (0.0, 0.0, 0.0),
    }
    places = cKDTree(cow.vertices).query(np.array(list(shifts)))[1]
    handles = {int(v): cow.vertices[v] + shift for v, shift in zip(places, shifts.values(), strict=True)}
    return posed(cow, handles)
