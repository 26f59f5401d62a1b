"""Quasi-geodesic paths: how often the straightened path is the shortest, by how much the rest is longer, how fast.

    python benchmarks/paths.py [pairs] [--json results/paths.json]

Beside potpourri3d's edge flips (Sharp and Crane 2020) and the exact distance. CPU time, one thread.
QGEO_DATA names the folder of the evaluation data; without it the TOSCA rows are left out.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

import igl
import numpy as np
import potpourri3d
from record import Record, recorded

from qgeo_filters import Surface, lifted_metric
from qgeo_filters.geodesics.metric import LiftedMetric, cartesian_metric
from qgeo_filters.geodesics.mmp.exact import exact_distances
from qgeo_filters.geodesics.path.paths import quasi_geodesics


def meshes() -> Iterator[tuple[str, Surface, LiftedMetric]]:
    """The cow of PyMeshLab's wheel, TOSCA poses; each in its own metric, the cow in a lifted one too."""
    import pymeshlab

    cow = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"
    surface = Surface(*igl.read_triangle_mesh(str(cow))[:2])
    yield "cow", surface, cartesian_metric(surface)
    yield "cow, weight .03", surface, lifted_metric(surface, curvature_weight=0.03)
    if "QGEO_DATA" in os.environ:
        for name in ("cat0", "centaur0", "horse0"):
            path = Path(os.environ["QGEO_DATA"]) / "tosca" / "remeshed" / f"{name}.off"
            surface = Surface(*igl.read_triangle_mesh(str(path))[:2])
            yield name, surface, cartesian_metric(surface)


def exact_lengths(metric: LiftedMetric, pairs: np.ndarray) -> np.ndarray:
    """Exact distance of each pair."""
    sources, row = np.unique(pairs[:, 0], return_inverse=True)
    return exact_distances(metric.intrinsic(), sources)[row, pairs[:, 1]]


def cells(mesh: str, method: str, lengths: np.ndarray, exact: np.ndarray, seconds: float) -> tuple[str, ...]:
    """One row of the table."""
    excess = lengths / exact - 1
    longer = excess[excess > 1e-9]
    rest = f"{100 * longer.mean():.2g} / {100 * longer.max():.2g}" if longer.size else "-"
    share = 100 * np.mean(excess <= 1e-9)
    mean = f"{100 * excess.mean():.2g}" if longer.size else "0"
    return mesh, method, f"{share:.1f}", rest, mean, f"{len(exact) / seconds:.0f}"


def main(record: Record, n_pairs: int = 2000) -> None:
    """Print the table."""
    longer = ("the shortest, % of pairs", "the rest longer by, mean / max %", "all, mean %")
    table = record.table("", "mesh", "path", *longer, "paths a CPU s")
    for name, surface, metric in meshes():
        pairs = np.random.default_rng(0).integers(0, surface.n_vertices, (n_pairs, 2))
        pairs = pairs[pairs[:, 0] != pairs[:, 1]]
        exact = exact_lengths(metric, pairs)
        for initial, few in (("edges", len(pairs)), ("exact", len(pairs) // 10)):
            quasi_geodesics(surface, pairs[:1], metric, initial=initial)  # compiled by now
            start = time.process_time()
            paths = quasi_geodesics(surface, pairs[:few], metric, initial=initial, workers=1)
            seconds = time.process_time() - start
            lengths = np.array([path.length for path in paths])
            assert all(path.converged for path in paths)
            assert (lengths >= exact[:few] * (1 - 1e-9)).all()
            if initial == "edges":
                first = np.array([path.lengths[0] for path in paths])
                table.row(*cells(name, "along edges (Dijkstra), before", first, exact, seconds))
                table.row(*cells(name, "along edges, straightened", lengths, exact, seconds))
            else:
                table.row(*cells(name, "down the exact distance, straightened", lengths, exact[:few], seconds))
        if metric.curvature_weight == 0:
            solver = potpourri3d.EdgeFlipGeodesicSolver(surface.vertices, surface.faces)
            start = time.process_time()
            flips = [solver.find_geodesic_path(int(i), int(j)) for i, j in pairs]
            seconds = time.process_time() - start
            lengths = np.array([np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in flips])
            table.row(*cells(name, "potpourri3d, edge flips", lengths, exact, seconds))


if __name__ == "__main__":
    with recorded() as record:
        main(record, *map(int, record.arguments))
