"""Meshes, peers and measures that the benchmarks of the geodesics share. CPU time throughout, all threads counted."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import igl
import numpy as np
import potpourri3d
import pygeodesic.geodesic as pygeodesic
from scipy.spatial import ConvexHull, Delaunay

from qgeo_filters.geodesics.dijkstra import edge_distances
from qgeo_filters.geodesics.metric import LiftedMetric, cartesian_metric
from qgeo_filters.geodesics.mmp.exact import exact_distances
from qgeo_filters.surface import Surface

Mesh = tuple[np.ndarray, np.ndarray]


def cpu(call: Callable[[], object]) -> tuple[object, float]:
    """What a call returns, and the CPU seconds that it took."""
    before = time.process_time()
    result = call()
    return result, time.process_time() - before


def blob(n: int, seed: int = 0) -> Mesh:
    """Closed irregular mesh: random points on a sphere, displaced by random harmonics."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices
    corners = points[faces]
    inward = (
        np.einsum("ij,ij->i", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), corners[:, 0]) < 0
    )
    faces[inward] = faces[inward, ::-1]
    radius = np.ones(n)
    for degree in (1, 2, 3, 5):
        axis = rng.normal(size=3)
        radius += 0.15 * np.cos(degree * np.arccos(np.clip(points @ axis / np.linalg.norm(axis), -1, 1)))
    return points * radius[:, None], faces.astype(np.int64)


def sheet(n: int, seed: int = 0) -> Mesh:
    """Open irregular mesh: random points over the unit square, on a hilly graph."""
    xy = np.random.default_rng(seed).random((n, 2))
    height = 0.15 * np.sin(9 * xy[:, 0]) * np.cos(7 * xy[:, 1])
    return np.column_stack([xy, height]), Delaunay(xy).simplices.astype(np.int64)


def stretched(n: int) -> Mesh:
    """Closed anisotropic mesh: the blob, drawn out eight times, with its triangles."""
    vertices, faces = blob(n)
    return vertices * [1, 1, 8], faces


def lifted(n: int, weight: float, seed: int = 0) -> tuple[Mesh, LiftedMetric]:
    """Planar mesh lifted by a rough scalar: as a surface in space for the peers, as a metric for us."""
    xy = np.random.default_rng(seed).random((n, 2))
    flat = Surface(np.column_stack([xy, np.zeros(n)]), Delaunay(xy).simplices)
    noise = np.random.default_rng(seed + 1).normal(size=n)
    scalar = np.sin(9 * xy[:, 0]) * np.cos(7 * xy[:, 1]) + 0.2 * noise
    scalar /= scalar.std()
    vertices = flat.vertices.copy()
    vertices[:, 2] = weight * np.sqrt(flat.area) * scalar
    lengths = np.linalg.norm(vertices[flat.edges[:, 0]] - vertices[flat.edges[:, 1]], axis=1)
    return (vertices, flat.faces.astype(np.int64)), LiftedMetric(flat, scalar, weight, lengths)


def cases(n: int) -> Iterator[tuple[str, Mesh, Surface, LiftedMetric | None]]:
    """The kinds of meshes of the tables, each as arrays for the peers and as surface and metric for us."""
    for name, mesh in {"closed": blob(n), "open": sheet(n), "anisotropic": stretched(n)}.items():
        yield name, mesh, Surface(*mesh), None
    for weight in (0.03, 0.3):
        mesh, metric = lifted(n, weight)
        yield f"lifted, weight {weight}", mesh, metric.surface, metric
    cat = Path(os.environ.get("QGEO_DATA", "")) / "tosca" / "remeshed" / "cat0.off"
    if "QGEO_DATA" in os.environ and n < 5000:
        surface = Surface.read(cat)
        yield "TOSCA cat0", (surface.vertices, surface.faces.astype(np.int64)), surface, None


def exact_rows(mesh: Mesh, sources: np.ndarray) -> tuple[np.ndarray, float]:
    """Exact distances (s, n) by pygeodesic, and CPU seconds a source."""
    solver = pygeodesic.PyGeodesicAlgorithmExact(*mesh)
    rows, seconds = cpu(lambda: np.array([solver.geodesicDistances(np.array([s]), None)[0] for s in sources]))
    return np.asarray(rows), seconds / len(sources)


def peers(mesh: Mesh, sources: np.ndarray) -> Iterator[tuple[str, np.ndarray, float]]:
    """Distances (s, n) of each peer and CPU seconds a source, its preparation spread over n sources."""
    vertices, faces = mesh
    n = len(vertices)

    def rows(
        name: str, prepare: Callable[[], object], row: Callable[[object, int], np.ndarray], count: int
    ) -> tuple[str, np.ndarray, float]:
        solver, once = cpu(prepare)
        result, seconds = cpu(lambda: np.array([row(solver, s) for s in sources[:count]]))
        return name, np.asarray(result), once / n + seconds / count

    few, many = min(3, len(sources)), len(sources)
    yield rows("libigl exact_geodesic", lambda: None, lambda _, s: _igl_exact(mesh, s), 1)
    yield rows(
        "potpourri3d heat, robust", lambda: potpourri3d.MeshHeatMethodDistanceSolver(vertices, faces, use_robust=True),
        lambda solver, s: solver.compute_distance(s), many,
    )  # fmt: skip
    yield rows(
        "potpourri3d heat, plain", lambda: potpourri3d.MeshHeatMethodDistanceSolver(vertices, faces, use_robust=False),
        lambda solver, s: solver.compute_distance(s), many,
    )  # fmt: skip
    yield rows(
        "potpourri3d fast marching", lambda: potpourri3d.MeshFastMarchingDistanceSolver(vertices, faces),
        lambda solver, s: np.asarray(solver.compute_distance([[(int(s), [])]])).ravel(), few,
    )  # fmt: skip
    try:
        import pymeshlab
    except ImportError:
        pass
    else:

        def filtered(meshes: object, s: int) -> np.ndarray:
            meshes.compute_scalar_by_geodesic_distance_from_given_point_per_vertex(  # type: ignore[attr-defined]
                startpoint=vertices[s], maxdistance=pymeshlab.PureValue(1e9)
            )
            return meshes.current_mesh().vertex_scalar_array()  # type: ignore[attr-defined]

        def loaded() -> object:
            meshes = pymeshlab.MeshSet()
            meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
            return meshes

        yield rows("pymeshlab geodesic filter", loaded, filtered, few)
    intrinsic = cartesian_metric(Surface(vertices, faces)).intrinsic()
    result, seconds = cpu(lambda: edge_distances(intrinsic, sources))
    yield "SciPy Dijkstra on edges", np.asarray(result), seconds / many
    result, seconds = cpu(lambda: exact_distances(intrinsic, sources[:few], workers=1))
    yield "qgeo-filters, exact", np.asarray(result), seconds / few


def _igl_exact(mesh: Mesh, source: int) -> np.ndarray:
    n = len(mesh[0])
    nothing = np.zeros(0, np.int64)
    return igl.exact_geodesic(*mesh, np.array([source], np.int64), nothing, np.arange(n, dtype=np.int64), nothing)


def relative_error(rows: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Signed relative errors, the sources themselves left out."""
    exact = exact[: len(rows)]
    return ((rows - exact) / np.where(exact > 0, exact, 1))[exact > 0]


def percent(value: float) -> str:
    """A share with three figures, in per cent."""
    return f"{100 * value:.3g}"
