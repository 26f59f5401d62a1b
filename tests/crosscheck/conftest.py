"""Meshes and the two foreign exact solvers."""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
import pygeodesic.geodesic as pygeodesic
import pytest
import shapes

from qgeo_filters import Surface


def igl_distances(surface: Surface, source: int) -> np.ndarray:
    """Exact distances of libigl (MMP), which wants 64-bit indices."""
    none = np.array([], dtype=np.int64)
    faces = surface.faces.astype(np.int64)
    targets = np.arange(surface.n_vertices)
    return igl.exact_geodesic(surface.vertices, faces, np.array([source]), none, targets, none)


def pygeodesic_distances(surface: Surface, source: int) -> np.ndarray:
    """Exact distances of pygeodesic (Kirsanov's MMP)."""
    solver = pygeodesic.PyGeodesicAlgorithmExact(surface.vertices, surface.faces)
    return np.asarray(solver.geodesicDistances([source], None)[0])


SOLVERS = {"igl": igl_distances, "pygeodesic": pygeodesic_distances}


@pytest.fixture(params=SOLVERS)
def foreign_exact(request):
    """One of the foreign solvers: (surface, source) -> (n,)."""
    return SOLVERS[request.param]


SURFACES = {
    "plane": lambda: Surface(*shapes.terrain(250, 0)),
    "sphere": lambda: Surface(*shapes.icosphere(3)),
    "blob": lambda: Surface(*shapes.blob(3, seed=2)),
    "torus": lambda: Surface(*shapes.torus(30, 16)),
    "cylinder": lambda: Surface(*shapes.cylinder(24, 12)),
    "cone": lambda: Surface(*shapes.cone(24, 12)),
    "moebius": lambda: Surface(*shapes.moebius(30, 4)),
    "rough": lambda: Surface(*shapes.terrain(300, 1, 0.3)),
    "gentle": lambda: Surface(*shapes.terrain(300, 2, 0.02)),
    "anisotropic": lambda: Surface(*shapes.terrain(300, 3, 0.02, stretch=0.05)),
    "stretched blob": lambda: Surface(shapes.blob(3)[0] * [1, 6, 0.2], shapes.blob(3)[1]),
}


@pytest.fixture(params=SURFACES)
def surface(request):
    """An analytic or random surface of a few hundred vertices."""
    return SURFACES[request.param]()


@pytest.fixture(scope="session")
def cow() -> Surface:
    """The cow that PyMeshLab's wheel brings: 2904 vertices, closed."""
    pymeshlab = pytest.importorskip("pymeshlab")
    path = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"
    return Surface(*igl.read_triangle_mesh(str(path))[:2])


@pytest.fixture(params=["cat1", "centaur2", "horse10"])
def tosca(request, data_dir) -> Surface:
    """A pose of TOSCA, independently decimated."""
    return Surface(*igl.read_triangle_mesh(str(data_dir / "tosca" / "remeshed" / f"{request.param}.off"))[:2])
