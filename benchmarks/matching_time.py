"""Seconds from two files to a finished map, beside pyFM on the same pairs in the same run, as a Markdown table.

    pip install pyfmaps
    python benchmarks/matching_time.py ROOT --pairs dog0-dog3 victoria0-victoria7 michael0-michael3 [--busy 1]

With ``--json FILE`` the table is kept there, too

ROOT as for ``matching.py``. Everything counts: files are read, nothing is prepared; only the kernels are compiled
before. Wall clock and CPU of all threads; the peer does what ``matching_peers.py`` says. Errors are direct, mean over
the vertices of X, in units of sqrt(area of Y). With ``--busy`` so many processes that do nothing but count run beside.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import numpy as np
from matching_peers import processed, pyfm_maps
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.evaluation import ToscaRemeshed, geodesic_error
from qgeo_filters.parallel import worker_count

Result = TypeVar("Result")

_PAIRS = ["wolf0-wolf1", "dog0-dog3", "victoria0-victoria7", "michael0-michael3"]


def timed(task: Callable[[], Result]) -> tuple[Result, float, float]:
    """Its result, and wall and CPU seconds."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = task()
    return result, time.perf_counter() - wall, time.process_time() - cpu


def ours(x: Path, y: Path, workers: int | None) -> np.ndarray:
    """Map of `match` from two files."""
    return qg.match(qg.Surface.read(x), qg.Surface.read(y), workers=workers).p2p


def theirs(x: Path, y: Path) -> np.ndarray:
    """Map of pyFM from two files: signatures, functional map, ZoomOut."""
    maps = list(pyfm_maps(processed(qg.Surface.read(x)), processed(qg.Surface.read(y))))
    return maps[-1][1]


@contextmanager
def busy(count: int) -> Iterator[None]:
    """So many processes beside, each of which takes a core."""
    others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for other in others:
            other.kill()


def main(record: Record) -> None:
    """Print a row for each pair, and the means."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path)
    parser.add_argument("--pairs", nargs="+", default=_PAIRS, metavar="X-Y")
    parser.add_argument("--workers", type=int, help="threads of ours; all cores by default")
    parser.add_argument("--busy", type=int, default=0, help="processes that keep cores busy beside")
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    qg.warmup()
    print(machine())
    record.note(f"{worker_count(arguments.workers)} threads of ours; {arguments.busy} busy processes beside.")
    each = ("`match`: wall / CPU s", "error", "pyFM: wall / CPU s", "error", "wall, pyFM : ours", "CPU")
    table = record.table("", "pair", "vertices", *each, align="lrrrrrrr")
    rows = []
    with busy(arguments.busy):
        for pair in arguments.pairs:
            one, other = pair.split("-")
            x, y = (arguments.root / "remeshed" / f"{name}.off" for name in (one, other))
            truth, target = data.truth(one, other), data.read(other)
            row: list[float] = []
            for task in (lambda x=x, y=y: ours(x, y, arguments.workers), lambda x=x, y=y: theirs(x, y)):
                p2p, wall, cpu = timed(task)
                row += [wall, cpu, float(geodesic_error(p2p[truth.points], truth.images, target).mean())]
            rows.append(row)
            table.row(*cells(pair, f"{data.read(one).n_vertices}, {target.n_vertices}", row))
    table.row(*cells("mean", "", np.mean(rows, axis=0).tolist()))


def cells(pair: str, vertices: str, row: list[float]) -> tuple[str, ...]:
    """One row of the table."""
    wall, cpu, error, their_wall, their_cpu, their_error = row
    return (
        *(pair, vertices, f"{wall:.1f} / {cpu:.1f}", f"{error:.4f}", f"{their_wall:.1f} / {their_cpu:.1f}"),
        *(f"{their_error:.4f}", f"{their_wall / wall:.2f}", f"{their_cpu / cpu:.2f}"),
    )


if __name__ == "__main__":
    with recorded() as record:
        main(record)
