"""What `match` costs and errs at any size, as a Markdown table: from two files to a map at full resolution.

    python benchmarks/matching_sizes.py ROOT --pair michael0-michael3 --sizes 3000 7000 15000 52565 200000 500000
        [--json FILE]

ROOT holds ``full/NAME.off``: TOSCA at full resolution, vertices of equal numbers in all poses. Smaller meshes are
decimated from it, each pose on its own; larger ones subdivided and decimated. Each match is a process of its own,
reading included, kernels compiled: wall-clock and CPU seconds, peak memory. The error is the straight distance between
the image of a vertex and its true place, mean over the vertices that the full mesh has too, in units of sqrt(area).
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

import igl
import numpy as np
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.decimation import decimated

_JOB = textwrap.dedent(
    """
    import json, resource, sys, time
    import numpy as np, qgeo_filters as qg
    qg.warmup()
    wall, cpu = time.perf_counter(), time.process_time()
    found = qg.match(qg.Surface.read(sys.argv[1]), qg.Surface.read(sys.argv[2]))
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    np.save(sys.argv[3], found.p2p)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(json.dumps([wall, cpu, peak, found.confident]))
    """
)


def resized(full: qg.Surface, size: int) -> tuple[qg.Surface, np.ndarray]:
    """The surface with about so many vertices, and the number in the full one of each vertex, -1 where it is new."""
    vertices, faces, known = full.vertices, full.faces.astype(np.int64), np.arange(full.n_vertices)
    while len(vertices) < size:
        vertices, faces = igl.upsample(vertices, faces, 1)
        known = np.concatenate([known, np.full(len(vertices) - len(known), -1)])
    surface = qg.Surface(vertices, faces)
    if surface.n_vertices == size:
        return surface, known
    small = decimated(surface, size)
    return small.surface, known[small.vertices]


def main(record: Record) -> None:
    """Print a row for each size."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path)
    parser.add_argument("--pair", default="michael0-michael3", metavar="X-Y")
    parser.add_argument("--sizes", nargs="+", type=int, default=[3000, 7000, 15_000, 52_565, 200_000, 500_000])
    arguments = parser.parse_args(record.arguments)
    poses = [qg.Surface.read(arguments.root / "full" / f"{name}.off") for name in arguments.pair.split("-")]
    print(machine())
    record.note(f"The pair is {arguments.pair}.")
    table = record.table("", "vertices", "wall s", "CPU s", "peak memory, GB", "error", "sure", align="rrrrrl")
    for size in arguments.sizes:
        with tempfile.TemporaryDirectory() as folder:
            files = [str(Path(folder) / name) for name in ("x.ply", "y.ply")]
            meshes = [resized(pose, size) for pose in poses]
            for (surface, _), file in zip(meshes, files, strict=True):
                surface.write(file)
            p2p = str(Path(folder) / "p2p.npy")
            done = subprocess.run([sys.executable, "-c", _JOB, *files, p2p], check=True, capture_output=True, text=True)
            wall, cpu, peak, sure = json.loads(done.stdout.splitlines()[-1])
            (x, known), (y, _) = meshes
            there = known >= 0
            gaps = np.linalg.norm(y.vertices[np.load(p2p)[there]] - poses[1].vertices[known[there]], axis=1)
            error = float(gaps.mean() / np.sqrt(poses[1].area))
        said = "yes" if sure else "no"
        table.row(str(x.n_vertices), f"{wall:.1f}", f"{cpu:.1f}", f"{peak:.2f}", f"{error:.4f}", said)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
