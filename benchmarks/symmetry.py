"""Errors of the self-symmetry map on TOSCA, as Markdown tables: a row for each shape, then one for each category.

    python benchmarks/symmetry.py ROOT --shapes cat0 horse5 [--json FILE]

ROOT as for ``matching.py``; all shapes by default. Errors in units of sqrt(area): of the involution, and of the nearest
vertex to the mirror point. CPU seconds are those of everything, preparation included, in one thread, kernels compiled
before.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from record import Record, recorded

from qgeo_filters.compilation import warmup
from qgeo_filters.evaluation import ToscaRemeshed, geodesic_error
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.symmetry import self_symmetry


def main(record: Record) -> None:
    """Print a row for each shape."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--shapes", nargs="+")
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    warmup()
    columns = ("shape", "found", "involution", "nearest vertex", "distortion", "CPU s")
    table = record.table("each shape", *columns, align="llrrrr")
    rows: dict[str, list[tuple[float, float, bool, float]]] = {}
    for name in arguments.shapes or data.names():
        surface = data.read(name)
        start = time.process_time()
        shape = PreparedShape(surface)
        found = self_symmetry(shape, workers=1)
        seconds = time.process_time() - start
        truth = data.symmetry(name).images
        errors = [geodesic_error(p2p, truth, shape.given).mean() for p2p in (found.p2p, found.nearest)]
        cells = [name, "yes" if found.found else "no", *(f"{error:.4f}" for error in errors)]
        table.row(*cells, f"{found.score:.4f}", f"{seconds:.1f}")
        rows.setdefault(data.category(name), []).append((errors[1], errors[0], found.found, seconds))
    columns = ("category", "shapes", "mean (`nearest`)", "largest", "mean (involution)", "found", "CPU s", "at most")
    table = record.table("each category", *columns, align="lrrrrrrr")
    for category, some in rows.items():
        nearest, involution, there, seconds_of = (np.array(column) for column in zip(*some, strict=True))
        means = (f"{nearest.mean():.4f}", f"{nearest.max():.4f}", f"{involution.mean():.4f}")
        seconds = (f"{seconds_of.mean():.1f}", f"{seconds_of.max():.1f}")
        table.row(category, len(some), *means, there.sum(), *seconds)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
