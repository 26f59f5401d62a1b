"""Exact distances beside pygeodesic and libigl: CPU ms a source, and how far the values differ.

    python benchmarks/exact.py [sources] [--json results/exact.json]

QGEO_DATA names the folder of the evaluation data; without it the TOSCA rows are left out.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import igl
import numpy as np
import pygeodesic.geodesic as pygeodesic
from record import Record, recorded
from scipy.spatial import ConvexHull, Delaunay

from qgeo_filters import Surface
from qgeo_filters.geodesics.metric import cartesian_metric
from qgeo_filters.geodesics.mmp.exact import exact_distances


def meshes() -> Iterator[tuple[str, Surface]]:
    """Real and made-up meshes of 3k to 10k vertices."""
    import pymeshlab

    cow = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"
    yield "cow", Surface(*igl.read_triangle_mesh(str(cow))[:2])
    if "QGEO_DATA" in os.environ:
        for name in ("cat0", "horse0", "michael0"):
            path = Path(os.environ["QGEO_DATA"]) / "tosca" / "remeshed" / f"{name}.off"
            yield name, Surface(*igl.read_triangle_mesh(str(path))[:2])
    rng = np.random.default_rng(0)
    for n in (3400, 10000):
        points = rng.normal(size=(n, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        bumps = 1 + 0.2 * np.sin(3 * points[:, :1]) * np.cos(4 * points[:, 1:2])
        yield f"bumpy sphere {n}", Surface(points * bumps, ConvexHull(points).simplices)
    flat = rng.uniform(size=(3400, 2))
    heights = 0.15 * np.sin(9 * flat[:, 0]) * np.cos(7 * flat[:, 1])
    yield "open terrain 3400", Surface(np.column_stack([flat, heights]), Delaunay(flat).simplices)
    yield "the same, drawn out 8 times", Surface(np.column_stack([flat * [8, 1], heights]), Delaunay(flat).simplices)


def timed(rows: Callable[[], np.ndarray]) -> tuple[np.ndarray, float]:
    """Result and CPU seconds."""
    start = time.process_time()
    result = rows()
    return result, time.process_time() - start


def main(record: Record, n_sources: int = 20) -> None:
    """Print the table."""
    speeds = ("ours, ms", "pygeodesic, ms", "ratio", "libigl, ms")
    table = record.table("", "mesh", "vertices", *speeds, "difference to pygeodesic / libigl")
    none = np.array([], dtype=np.int64)
    for name, surface in meshes():
        n = surface.n_vertices
        sources = np.random.default_rng(1).choice(n, n_sources, replace=False)
        mesh = cartesian_metric(surface).intrinsic()
        exact_distances(mesh, sources[:1])  # compiled by now
        ours, t = timed(lambda: exact_distances(mesh, sources, workers=1))  # noqa: B023
        solver = pygeodesic.PyGeodesicAlgorithmExact(surface.vertices, surface.faces)
        theirs, t_py = timed(lambda: np.array([solver.geodesicDistances([int(s)], None)[0] for s in sources]))  # noqa: B023
        faces, every = surface.faces.astype(np.int64), np.arange(n)
        few = sources[:1]
        libigl, t_igl = timed(
            lambda: igl.exact_geodesic(surface.vertices, faces, few, none, every, none)[None]  # noqa: B023
        )
        differences = [np.abs(d - ours[: len(d)]).max() / ours.max() for d in (theirs, libigl)]
        times = (f"{1e3 * t / n_sources:.1f}", f"{1e3 * t_py / n_sources:.0f}", f"{t_py / t:.1f}", f"{1e3 * t_igl:.0f}")
        table.row(name, n, *times, f"{differences[0]:.0e} / {differences[1]:.0e}")


if __name__ == "__main__":
    with recorded() as record:
        main(record, *map(int, record.arguments))
