"""What costs what on large meshes: wall-clock and CPU seconds, and peak memory, of each job in a fresh process.

    python benchmarks/sizes.py MESH.ply ... [--only JOB,JOB]
    python benchmarks/sizes.py MESH.ply --split 1       (its faces split in four so many times, with noise)
    python benchmarks/sizes.py 6 7 8       (lopsided spheres with noise, of 40962, 163842 and 655362 vertices)

Noise is of .03 mean edges on every vertex. A job is a function of a surface in `JOBS`. Reading the file, and loading
the kernels, is not counted in the others; peak memory is that of the whole process, with the interpreter and the mesh.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import igl
import numpy as np
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.decimation import decimated
from qgeo_filters.differential.curvature import mean_curvature, principal_curvatures
from qgeo_filters.report.render import render_mesh
from qgeo_filters.spectral.landmarks import farthest_points

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from shapes import blob


def described(surface: qg.Surface) -> object:
    """All that a surface derives from itself."""
    names = [name for name in dir(type(surface)) if isinstance(getattr(type(surface), name), property)]
    names += [name for name in vars(type(surface)) if not name.startswith("_")]
    return [getattr(surface, name) for name in sorted(set(names))]


def some(surface: qg.Surface, count: int) -> np.ndarray:
    """Vertices at random."""
    return np.random.default_rng(0).integers(0, surface.n_vertices, count)


#: Name of a job, and what it does with a surface; the first reads the file.
JOBS: dict[str, Callable[[qg.Surface], object]] = {
    "read (binary PLY)": lambda surface: None,
    "surface, all derived quantities": described,
    "vertex normals, corrected": qg.vertex_normals,
    "mean curvature": mean_curvature,
    "principal curvatures": principal_curvatures,
    "lifted metric": qg.lifted_metric,
    "proxy of 2500 vertices": lambda surface: decimated(surface, 2500),
    "1000 farthest points": lambda surface: farthest_points(surface, 1000),
    "distances, 10 sources, edges": lambda surface: qg.distances(surface, some(surface, 10), method="edges"),
    "distances, 10 sources, accuracy .01": lambda surface: qg.distances(surface, some(surface, 10), accuracy=1e-2),
    "distances, 10 sources, accuracy .001": lambda surface: qg.distances(surface, some(surface, 10)),
    "path": lambda surface: qg.quasi_geodesic(surface, *some(surface, 2).tolist(), initial="edges"),
    "distance spectrum, surface's metric": lambda surface: qg.distance_spectrum(surface, 20, "cartesian"),
    "distance spectrum, lifted metric": lambda surface: qg.distance_spectrum(surface, 20, "lifted"),
    "Laplacian spectrum, 20": lambda surface: qg.laplacian_spectrum(surface, 20),
    "Laplacian spectrum, 200": lambda surface: qg.laplacian_spectrum(surface, 200),
    "picture": lambda surface: render_mesh(surface.vertices, surface.faces),
}


def rough(surface: qg.Surface, folder: Path) -> Path:
    """File of the surface with noise of .03 mean edges."""
    step = 0.03 * float(surface.edge_lengths.mean())
    moved = surface.vertices + step * np.random.default_rng(0).standard_normal(surface.vertices.shape)
    path = folder / f"{surface.n_vertices}.ply"
    surface.with_vertices(moved).write(path)
    return path


def mesh_file(mesh: str, split: int, folder: Path) -> Path:
    """The file that was named; one of the mesh with its faces split; or of a sphere of 10 * 4^level + 2 vertices."""
    if mesh.isdigit():
        return rough(qg.Surface(*blob(int(mesh), seed=1)), folder)
    if not split:
        return Path(mesh)
    given = qg.Surface.read(mesh)
    return rough(qg.Surface(*igl.upsample(given.vertices, given.faces, split)), folder)


def measured(path: Path, job: str) -> dict[str, float]:
    """Seconds and memory of one job; called in a process of its own."""
    qg.warmup()
    wall, cpu = time.perf_counter(), time.process_time()
    surface = qg.Surface.read(path)
    if job != next(iter(JOBS)):
        wall, cpu = time.perf_counter(), time.process_time()
        JOBS[job](surface)
    return {
        "wall": time.perf_counter() - wall,
        "cpu": time.process_time() - cpu,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024),
    }


def main(record: Record) -> None:
    """Print the table, row by row."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+")
    parser.add_argument("--split", type=int, default=0, help="how often the faces of each file are split in four")
    parser.add_argument("--only", help="jobs whose names begin with these, with commas between")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args(record.arguments)
    if arguments.one:
        print(json.dumps(measured(Path(arguments.meshes[0]), arguments.only)))
        return
    with tempfile.TemporaryDirectory() as folder:
        meshes = [mesh_file(mesh, arguments.split, Path(folder)) for mesh in arguments.meshes]
        sizes = [qg.Surface.read(mesh).n_vertices for mesh in meshes]
        starts = tuple(arguments.only.split(",")) if arguments.only else ("",)
        print(f"{machine()}")
        table = record.table("wall-clock s / CPU s / peak GB", "", *map(str, sizes), align="l" + len(sizes) * "r")
        for job in (name for name in JOBS if name.startswith(starts)):
            cells = []
            for mesh in meshes:
                command = [sys.executable, __file__, str(mesh), "--one", "--only", job]
                ended = subprocess.run(command, capture_output=True, text=True, check=False)
                if ended.returncode:
                    cells.append((ended.stderr.strip().splitlines() or ["killed"])[-1])
                else:
                    took = json.loads(ended.stdout.splitlines()[-1])
                    cells.append(f"{took['wall']:.1f} / {took['cpu']:.1f} / {took['memory'] / 1e9:.2f}")
            table.row(job, *cells)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
