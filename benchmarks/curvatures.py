"""Principal curvatures against formulas, beside libigl, trimesh, PyVista and PyMeshLab; then on TOSCA.

    python benchmarks/curvatures.py [--data ROOT] [--json results/curvatures.json]

ROOT holds TOSCA's remeshed, full and ground_truth.

A cell is the root mean square error of (k1, k2) over the root mean square curvature, in %, at about 642, 2562 and 10242
vertices, those at a boundary left out. Peers whose sign is the other way are turned; trimesh, which needs rtree here,
is asked at 300 vertices. ROOT: poses of some 3000 vertices against curvatures of the same pose at full resolution (the
mean of libigl's quadrics over two and over four rings), mean error over mean curvature.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import igl
import numpy as np
import pymeshlab
import pyvista
import trimesh
from record import Record, recorded
from scipy.spatial import ConvexHull

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import shapes

from qgeo_filters.differential.curvature import gaussian_curvature, mean_curvature, principal_curvatures
from qgeo_filters.surface import Surface

Curvatures = tuple[np.ndarray, np.ndarray]
Sample = tuple[str, Surface, Curvatures]
AXES = np.array([1.5, 1.0, 0.7])
JITTER = 0.3
SAMPLE = 300
POSES = ("cat0", "horse0", "centaur0")


def of_mean_and_gauss(mean: np.ndarray, gauss: np.ndarray) -> Curvatures:
    """H + and - the root of H^2 - K."""
    root = np.sqrt(np.maximum(mean**2 - gauss, 0))
    return mean + root, mean - root


def fitted(surface: Surface) -> Curvatures:
    """The default of this package."""
    principal = principal_curvatures(surface)
    return principal.k1, principal.k2


def discrete(surface: Surface) -> Curvatures:
    """Cotangents and angle defects of this package."""
    return of_mean_and_gauss(mean_curvature(surface), gaussian_curvature(surface))


def libigl(radius: int) -> Callable[[Surface], Curvatures]:
    """Quadrics over some rings, by libigl."""

    def call(surface: Surface) -> Curvatures:
        _, _, k1, k2, _ = igl.principal_curvature(surface.vertices, surface.faces.astype(np.int64), radius, True)
        return np.maximum(k1, k2), np.minimum(k1, k2)

    return call


def of_trimesh(surface: Surface) -> Curvatures:
    """Curvature measures of trimesh in balls of two edge lengths, over a disc's area; NaN but for a sample."""
    mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    radius = 2 * surface.edge_lengths.mean()
    sample = np.random.default_rng(0).permutation(surface.n_vertices)[:SAMPLE]
    measures = np.full((2, surface.n_vertices), np.nan)
    for row, measure in zip(
        measures,
        (trimesh.curvature.discrete_mean_curvature_measure, trimesh.curvature.discrete_gaussian_curvature_measure),
        strict=True,
    ):
        row[sample] = measure(mesh, mesh.vertices[sample], radius) / (np.pi * radius**2)
    return of_mean_and_gauss(*measures)


def of_pyvista(surface: Surface) -> Curvatures:
    """PyVista's (VTK's) maximum and minimum."""
    mesh = pyvista.PolyData.from_regular_faces(surface.vertices, surface.faces)
    return mesh.curvature("maximum"), mesh.curvature("minimum")


def of_meshlab(surface: Surface) -> Curvatures:
    """PyMeshLab's default, quadric fitting."""
    found = []
    for which in ("Max Curvature", "Min Curvature"):
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(surface.vertices, surface.faces))
        meshes.compute_curvature_principal_directions_per_vertex(curvcolormethod=which, autoclean=False)
        found.append(meshes.current_mesh().vertex_scalar_array())
    return np.maximum(*found), np.minimum(*found)


METHODS: dict[str, Callable[[Surface], Curvatures]] = {
    "**`principal_curvatures`**": fitted,
    "`mean_curvature`, `gaussian_curvature`": discrete,
    "libigl, 5 rings (its default)": libigl(5),
    "libigl, 2 rings": libigl(2),
    "trimesh, balls of 2 edges": of_trimesh,
    "PyVista": of_pyvista,
    "PyMeshLab, quadric fitting": of_meshlab,
}


def sphere(level: int, jitter: float) -> Sample:
    """Unit sphere: an icosphere, or the convex hull of its vertices moved about."""
    points, faces = shapes.icosphere(level)
    if jitter:
        edge = np.sqrt(4 * np.pi / len(points))
        points = points + np.random.default_rng(level).uniform(-jitter, jitter, points.shape) * edge
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        faces = ConvexHull(points).simplices
        corners = points[faces]
        inward = np.linalg.det(corners) < 0
        faces[inward] = faces[inward, ::-1]
    return "sphere", Surface(points, faces), (np.ones(len(points)), np.ones(len(points)))


def ellipsoid(level: int, jitter: float) -> Sample:
    """Ellipsoid with axes 1.5, 1, .7, so that triangles are drawn out."""
    points = sphere(level, jitter)[1].vertices * AXES
    height = 1 / np.linalg.norm(points / AXES**2, axis=1)
    gauss = height**4 / AXES.prod() ** 2
    mean = height**3 * ((AXES**2).sum() - (points**2).sum(axis=1)) / (2 * AXES.prod() ** 2)
    return "ellipsoid", Surface(points, sphere(level, jitter)[1].faces), of_mean_and_gauss(mean, gauss)


def torus(level: int, jitter: float) -> Sample:
    """Torus of radii 1 and .4, its parameters moved about."""
    n = 2 ** (level + 1)
    around, tube = np.divmod(np.arange(n * (5 * n // 2)), n)
    moved = np.random.default_rng(level).uniform(-jitter, jitter, (2, len(tube)))
    s, t = 2 * np.pi * (around + moved[0]) / (5 * n // 2), 2 * np.pi * (tube + moved[1]) / n
    ring = 1 + 0.4 * np.cos(t)
    points = np.column_stack([ring * np.cos(s), ring * np.sin(s), 0.4 * np.sin(t)])
    return "torus", Surface(points, shapes.torus(5 * n // 2, n)[1]), (np.full(len(t), 2.5), np.cos(t) / ring)


def cylinder(level: int, jitter: float) -> Sample:
    """Open cylinder of radius 1 and height 3.5, its parameters moved about."""
    n, m = 2 ** (level + 2), 9 * 2 ** (level + 1) // 8
    along, around = np.divmod(np.arange(n * (m + 1)), n)
    moved = np.random.default_rng(level).uniform(-jitter, jitter, (2, len(along)))
    angle = 2 * np.pi * (around + moved[0]) / n
    z = 3.5 * (along + np.where((along > 0) & (along < m), moved[1], 0)) / m
    points = np.column_stack([np.cos(angle), np.sin(angle), z])
    return "cylinder", Surface(points, shapes.cylinder(n, m)[1]), (np.ones(len(z)), np.zeros(len(z)))


def noisy(surface: Surface, amount: float) -> Surface:
    """Vertices moved by a normal deviate of some mean edge lengths along each axis."""
    step = np.random.default_rng(0).normal(size=surface.vertices.shape) * surface.edge_lengths.mean()
    return Surface(surface.vertices + amount * step, surface.faces)


def error(found: Curvatures, truth: Curvatures, inner: np.ndarray) -> float:
    """Root mean square error over the root mean square curvature, in %, of the better of the two signs."""
    k1, k2 = found
    errors = [np.hypot(a - truth[0], b - truth[1])[inner] for a, b in ((k1, k2), (-k2, -k1))]
    size = np.sqrt(np.mean(np.hypot(*truth)[inner] ** 2))
    return float(100 * min(np.sqrt(np.nanmean(e**2)) for e in errors) / size)


def analytic(record: Record, title: str, jitter: float, noise: float) -> None:
    """A table of shapes whose curvatures are known."""
    makes = (sphere, torus, ellipsoid, cylinder)
    samples = [[make(level, jitter) for level in (3, 4, 5)] for make in makes]
    table = record.table(title, "method", *(row[0][0] for row in samples))
    for name, method in METHODS.items():
        cells = []
        for row in samples:
            errors = []
            for _, surface, truth in row:
                inner = np.ones(surface.n_vertices, dtype=bool)
                inner[surface.boundary_vertices] = False
                errors.append(error(method(noisy(surface, noise) if noise else surface), truth, inner))
            cells.append(" / ".join(f"{e:.2g}" if e < 10 else f"{e:.0f}" for e in errors))
        table.row(name, *cells)


def scanned(record: Record, root: Path) -> None:
    """TOSCA's table: low resolution against high, without and with noise."""
    table = record.table("TOSCA", "method", *(f"{pose}, noise 0 / 2 / 10 %" for pose in POSES))
    pairs = []
    for pose in POSES:
        coarse, fine = (Surface.read(root / folder / f"{pose}.off") for folder in ("remeshed", "full"))
        place = np.load(root / "ground_truth" / f"{pose}.npz")["full_of_vertex"]
        pairs.append((coarse, [[k[place] for k in libigl(rings)(fine)] for rings in (2, 4)]))
    methods = ("**`principal_curvatures`**", "libigl, 5 rings (its default)", "libigl, 2 rings")
    for name in methods:
        cells = []
        for coarse, references in pairs:
            numbers = []
            for noise in (0.0, 0.02, 0.1):
                k1, k2 = METHODS[name](noisy(coarse, noise))
                errors = [
                    coarse.vertex_areas @ np.hypot(k1 - a, k2 - b) / (coarse.vertex_areas @ np.hypot(a, b))
                    for a, b in references
                ]
                numbers.append(f"{100 * np.mean(errors):.0f}")
            cells.append(" / ".join(numbers))
        table.row(name, *cells)


def main(record: Record) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, help="TOSCA's folder")
    options = parser.parse_args(record.arguments)
    for title, jitter, noise in (
        ("regular", 0.0, 0.0),
        ("irregular", JITTER, 0.0),
        ("irregular, noise of 1 % of an edge", JITTER, 0.01),
        ("irregular, noise of 5 % of an edge", JITTER, 0.05),
    ):
        analytic(record, title, jitter, noise)
    if options.data:
        scanned(record, options.data)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
