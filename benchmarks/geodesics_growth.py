"""Growth of the whole matrix with n: CPU and wall time on one and two threads, memory beside the matrix.

    python benchmarks/geodesics_growth.py [1700 3400 6800 10000] [--json results/geodesics_growth.json]

Each row is a process of its own, so that its peak of memory is its own.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import threading
import time

import numpy as np
from geodesics_common import blob
from record import Record, recorded

from qgeo_filters.compilation import warmup
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.surface import Surface


def measure(n: int, workers: int) -> dict[str, float]:
    """One matrix: CPU and wall seconds, and the peak of memory above what was there before, in matrices."""
    warmup()
    surface = Surface(*blob(n))
    surface.components, surface.edge_lengths, surface.twins  # noqa: B018  what every use of a surface needs
    peak = _Peak()
    cpu, wall = time.process_time(), time.perf_counter()
    with peak:
        matrix = distance_matrix(surface, workers=workers)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    return {"cpu": cpu, "wall": wall, "memory": peak.bytes / matrix.nbytes}


class _Peak:
    """Highest resident memory within the block, above that at its start, sampled every few milliseconds."""

    def __enter__(self) -> None:
        self.bytes, self._start, self._running = 0, _resident(), True
        self._thread = threading.Thread(target=self._watch)
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._running = False
        self._thread.join()

    def _watch(self) -> None:
        while self._running:
            self.bytes = max(self.bytes, _resident() - self._start)
            time.sleep(0.002)


def _resident() -> int:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()


def main(record: Record) -> None:
    """Print the table and the fitted exponents."""
    sizes = [int(x) for x in record.arguments] or [1700, 3400, 6800, 10000]
    walls = [f"wall s, {threads}" for threads in ("1 thread", "2 threads")]
    table = record.table("", "n", "CPU s, 1 thread", "CPU ms a source", *walls, "peak memory / matrix")
    times = []
    for n in sizes:
        one, two = (
            json.loads(
                subprocess.run(
                    [sys.executable, __file__, "one", str(n), str(w)], stdout=subprocess.PIPE, check=True
                ).stdout
            )
            for w in (1, 2)
        )
        times.append(one["cpu"])
        seconds = (f"{one['cpu']:.2f}", f"{1e3 * one['cpu'] / n:.3f}", f"{one['wall']:.2f}", f"{two['wall']:.2f}")
        table.row(n, *seconds, f"{two['memory']:.2f}")
    record.note(f"CPU time grows as n^{np.polyfit(np.log(sizes), np.log(times), 1)[0]:.2f}.")


if __name__ == "__main__":
    if sys.argv[1:2] == ["one"]:
        print(json.dumps(measure(int(sys.argv[2]), int(sys.argv[3]))))
    else:
        with recorded() as record:
            main(record)
