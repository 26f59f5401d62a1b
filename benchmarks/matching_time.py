"""Seconds that a correspondence takes, and what is spent once for each shape, as a Markdown table.

    python benchmarks/matching_time.py ROOT --pairs dog0-dog3 victoria0-victoria7 michael0-michael3

ROOT as for ``matching.py``. Wall clock and CPU, after a first pair that is not counted (compilation, caches); run it on
a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from typing import TypeVar

from qgeo_filters.evaluation import ToscaRemeshed
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.parallel import worker_count

Result = TypeVar("Result")

_PAIRS = ["wolf0-wolf1", "dog0-dog3", "victoria0-victoria7", "michael0-michael3"]


def timed(task: Callable[[], Result]) -> tuple[Result, str]:
    """Its result, and wall and CPU seconds."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = task()
    return result, f"{time.perf_counter() - wall:.1f} / {time.process_time() - cpu:.1f}"


def main() -> None:
    """Print a row for each pair."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--pairs", nargs="+", default=_PAIRS, metavar="X-Y")
    arguments = parser.parse_args()
    data = ToscaRemeshed(arguments.root)
    match(data.read("wolf0"), data.read("wolf2"))
    print(f"Seconds, wall / CPU, {worker_count(None)} of {os.cpu_count()} cores.\n")
    print("| pair | vertices | descriptor of X | of Y | self-symmetry of Y | match |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for pair in arguments.pairs:
        (x, of_x), (y, of_y) = (timed(PreparedShape(data.read(name)).prepare) for name in pair.split("-"))
        _, symmetry = timed(lambda y=y: self_symmetry(y))
        _, matching = timed(lambda x=x, y=y: match(x, y))
        print(f"| {pair} | {x.n_vertices}, {y.n_vertices} | {of_x} | {of_y} | {symmetry} | {matching} |", flush=True)


if __name__ == "__main__":
    main()
