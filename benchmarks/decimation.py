"""Proxies of 2500 vertices, by `qgeo_filters.decimation` and by other libraries: time, topology, shape, geodesics.

    python benchmarks/decimation.py [--vertices 2500] FILE [FILE ...] [--subdivided FILE ...] [--json FILE]

Each file is repaired first; those after --subdivided are subdivided twice by Loop's rule. Libraries that are not
installed are left out with a line that says so. A Markdown table is printed for each mesh:

CPU s: of the decimation alone, the arrays being ready; vertices of the proxy; topology: what has changed; gap: largest
and mean distance of the original's vertices from the proxy; triangles: quality (1: equilateral) of the worst hundredth
and mean, spread of the edges (standard deviation by mean); geodesics: mean error, relative, of distances between
points of the original from their places on the proxy. Lengths are in sqrt(area).
"""

from __future__ import annotations

import argparse
import importlib
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import igl
import numpy as np
from record import Record, recorded

import qgeo_filters as qg
from qgeo_filters.barycentric import nearest_in_triangles
from qgeo_filters.decimation import decimated

Arrays = tuple[np.ndarray, np.ndarray]
SOURCES, TARGETS = 10, 300
LARGEST_WITH_GEODESICS = 100_000
TRIANGLES = ("quality: 1%", "mean", "edges' spread")
COLUMNS = ("by", "CPU s", "vertices", "topology", "gap: max", "mean", *TRIANGLES, "geodesics")


def by_qgeo(surface: qg.Surface, n: int) -> Arrays:
    """Ours; with it come the places of the original's vertices, that others leave to a search."""
    coarse = decimated(surface, n).surface
    return coarse.vertices, coarse.faces


def by_qslim(surface: qg.Surface, n: int) -> Arrays:
    """Libigl's quadrics."""
    return igl.qslim(surface.vertices, surface.faces, 2 * n)[:2]


def by_igl(surface: qg.Surface, n: int) -> Arrays:
    """Libigl's shortest edges to their middles."""
    return igl.decimate(surface.vertices, surface.faces, 2 * n)[:2]


def by_fast_simplification(surface: qg.Surface, n: int) -> Arrays:
    """PyVista's."""
    library = importlib.import_module("fast_simplification")
    return library.simplify(surface.vertices.copy(), surface.faces.copy(), target_count=2 * n)


def by_pyfqmr(surface: qg.Surface, n: int) -> Arrays:
    """The same method, bound by others."""
    simplifier = importlib.import_module("pyfqmr").Simplify()
    simplifier.setMesh(surface.vertices.copy(), surface.faces.copy())
    simplifier.simplify_mesh(target_count=2 * n, verbose=False, preserve_border=False)
    return simplifier.getMesh()[:2]


def by_pyacvd(surface: qg.Surface, n: int) -> Arrays:
    """Clusters of equal area; the mesh is subdivided first, as its manual asks, unless it is fine enough."""
    pyacvd, pyvista = importlib.import_module("pyacvd"), importlib.import_module("pyvista")
    clusters = pyacvd.Clustering(pyvista.PolyData.from_regular_faces(surface.vertices.copy(), surface.faces.copy()))
    if surface.n_vertices < 10 * n:
        clusters.subdivide(2)
    clusters.cluster(n)
    mesh = clusters.create_mesh()
    return np.asarray(mesh.points, dtype=float), mesh.regular_faces


def by_meshoptimizer(surface: qg.Surface, n: int) -> Arrays:
    """Subset of the vertices."""
    library = importlib.import_module("meshoptimizer")
    kept = np.zeros(surface.faces.size, dtype=np.uint32)
    points, corners = surface.vertices.astype(np.float32), surface.faces.ravel().astype(np.uint32)
    count = library.simplify(kept, corners, points, target_index_count=6 * n, target_error=1.0)
    used, faces = np.unique(kept[:count], return_inverse=True)
    return surface.vertices[used], faces.reshape(-1, 3)


def by_pymeshlab(surface: qg.Surface, n: int) -> Arrays:
    """Its quadrics, topology, boundary and normals kept."""
    pymeshlab = importlib.import_module("pymeshlab")
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(surface.vertices, surface.faces))
    meshes.meshing_decimation_quadric_edge_collapse(
        targetfacenum=2 * n, preservetopology=True, preserveboundary=True, preservenormal=True, planarquadric=True
    )
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix()


def by_open3d(surface: qg.Surface, n: int) -> Arrays:
    """Its quadrics."""
    geometry, utility = (getattr(importlib.import_module("open3d"), name) for name in ("geometry", "utility"))
    vertices, faces = utility.Vector3dVector(surface.vertices.copy()), utility.Vector3iVector(surface.faces.copy())
    mesh = geometry.TriangleMesh(vertices, faces).simplify_quadric_decimation(2 * n)
    return np.asarray(mesh.vertices), np.asarray(mesh.triangles)


METHODS: dict[str, Callable[[qg.Surface, int], Arrays]] = {
    "qgeo-filters": by_qgeo,
    "igl.qslim": by_qslim,
    "igl.decimate": by_igl,
    "fast_simplification": by_fast_simplification,
    "pyfqmr": by_pyfqmr,
    "pyacvd": by_pyacvd,
    "meshoptimizer": by_meshoptimizer,
    "PyMeshLab": by_pymeshlab,
    "Open3D": by_open3d,
}


def of_unit_area(surface: qg.Surface) -> qg.Surface:
    """Surface about the origin, with its connectivity known, as every method needs it or finds it by itself."""
    unit = qg.Surface((surface.vertices - surface.vertices.mean(axis=0)) / surface.area**0.5, surface.faces)
    unit.require_manifold("the comparison")
    return unit


def subdivided(surface: qg.Surface) -> qg.Surface:
    """Sixteen times the triangles."""
    return qg.Surface(*igl.loop(surface.vertices, surface.faces.astype(np.int64), 2))


def changes(surface: qg.Surface, coarse: qg.Surface) -> str:
    """What of the topology the proxy has not kept."""
    if not coarse.is_manifold:
        return "not manifold"
    if coarse.is_oriented != surface.is_oriented:
        return "not oriented"
    found = {
        "pieces": (coarse.components[0], surface.components[0]),
        "genus": (coarse.genus, surface.genus),
        "boundaries": (len(coarse.boundary_loops), len(surface.boundary_loops)),
    }
    return "; ".join(f"{name} {new}, not {old}" for name, (new, old) in found.items() if new != old) or "kept"


class Distances:
    """Geodesic distances between points of a surface, to which those on its proxies are compared."""

    def __init__(self, surface: qg.Surface) -> None:
        rng = np.random.default_rng(0)
        self.sources, self.targets = (rng.choice(surface.n_vertices, k, replace=False) for k in (SOURCES, TARGETS))
        self.points = surface.vertices
        self.true = qg.distances(surface, self.sources)[:, self.targets]

    def error(self, coarse: qg.Surface) -> float:
        """Mean relative error, of distances above a fifth of sqrt(area)."""
        places = [self._place(coarse, self.points[chosen]) for chosen in (self.sources, self.targets)]
        (corners, weights), (others, other_weights) = places
        starts, row = np.unique(corners, return_inverse=True)
        rows = qg.distances(coarse, starts)[row.reshape(-1, 3)]
        found = np.einsum("ia,iaj->ij", weights, rows)
        found = np.einsum("jb,ijb->ij", other_weights, found[:, others])
        far = self.true > 0.2
        return float(np.abs(found / np.where(far, self.true, 1) - 1)[far].mean())

    def _place(self, coarse: qg.Surface, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        _, face, _ = igl.point_mesh_squared_distance(points, coarse.vertices, coarse.faces.astype(np.int64))
        corners = coarse.faces[face]
        return corners, nearest_in_triangles(points, coarse.vertices[corners])[0]


def row(surface: qg.Surface, name: str, n: int, distances: Distances | None) -> list[object]:
    """Cells of one row of the table."""
    start = time.process_time()
    vertices, faces = METHODS[name](surface, n)
    seconds = time.process_time() - start
    if not len(faces):
        return [name, f"{seconds:.2f}", "", "nothing is left", *[""] * 6]
    coarse = qg.Surface(vertices, faces)
    squared, _, _ = igl.point_mesh_squared_distance(surface.vertices, coarse.vertices, coarse.faces.astype(np.int64))
    gap = np.sqrt(squared)
    corners = coarse.vertices[coarse.faces]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    quality = 4 * np.sqrt(3) * coarse.face_areas / (sides**2).sum(axis=1)
    topology = changes(surface, coarse)
    geodesics = f"{distances.error(coarse):.4f}" if distances and topology == "kept" else "-"
    spread = coarse.edge_lengths.std() / coarse.edge_lengths.mean()
    numbers: list[Any] = [f"{gap.max():.4f}", f"{gap.mean():.5f}", f"{np.quantile(quality, 0.01):.2f}"]
    numbers += [f"{quality.mean():.2f}", f"{spread:.2f}", geodesics]
    return [name, f"{seconds:.2f}", coarse.n_vertices, topology, *numbers]


def main(record: Record) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--subdivided", nargs="*", type=Path, default=[])
    parser.add_argument("--vertices", type=int, default=2500)
    parser.add_argument("--by", nargs="+", default=list(METHODS), choices=list(METHODS))
    asked = parser.parse_args(record.arguments)
    decimated(qg.Surface(*igl.icosahedron()), 8)  # compiles
    for file, finer in [*((file, False) for file in asked.files), *((file, True) for file in asked.subdivided)]:
        surface = of_unit_area(qg.Surface.read(file, repair="force"))
        if finer:
            surface = of_unit_area(subdivided(surface))
        kind = ", subdivided" if finer else ""
        table = record.table(f"{file.stem}, {surface.n_vertices} vertices{kind}", *COLUMNS)
        distances = Distances(surface) if surface.n_vertices <= LARGEST_WITH_GEODESICS else None
        for name in asked.by:
            try:
                table.row(*row(surface, name, asked.vertices, distances))
            except ImportError as error:
                table.row(name, "", "", f"left out: {error}", *[""] * 6)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
