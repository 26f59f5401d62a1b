"""One connectivity for two shapes (`remesh_like`): triangles turned over, error and distance from the surface.

    python benchmarks/remesh_like.py ROOT --category cat --shapes 6 --store DIR [--pairs 7] [--json FILE]
    python benchmarks/remesh_like.py faust_r --store DIR [--pairs 7]

ROOT, ``--category``, ``--shapes`` and DIR as for ``consistent_maps.py``, whose matches are taken, the first so many
pairs in both directions. Turned over: triangles that look the other way than the surface does, which `remesh_like`
counts itself; folded edges: across which two triangles lie on each other that do not on the template. Lengths are in
units of sqrt(area): mean distance of the vertices from their true places, and of the vertices of the shape from the
remeshed one.
"""

from __future__ import annotations

import argparse
import re
import warnings
from itertools import islice
from pathlib import Path

import numpy as np
from consistent_maps import matched, opened
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.animation.measures import folded_edges
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.closest_points import closest_points
from qgeo_filters.evaluation.datasets import PointMap


def measured(x: qg.Surface, y: qg.Surface, place: BarycentricMap, truth: PointMap) -> tuple[float, ...]:
    """Share of triangles turned over in per cent, folded edges, error, and distance of the shape."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        same = qg.remesh_like(x, y, place)
    counts = [re.match(r"(\d+) of \d+ triangles are turned", str(warning.message)) for warning in caught]
    turned = sum(int(count[1]) for count in counts if count)
    unit = np.sqrt(y.area)
    error = np.linalg.norm(same.vertices[truth.points] - y.vertices[truth.images], axis=1).mean() / unit
    near = closest_points(y.vertices, same).pulled_back(same.vertices)
    gap = np.linalg.norm(near - y.vertices, axis=1).mean() / unit
    return 100 * turned / x.n_faces, float(folded_edges(x, same.vertices)), float(error), float(gap)


def main(record: Record) -> None:
    """Print a row of means."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path)
    parser.add_argument("--category", default="victoria")
    parser.add_argument("--shapes", type=int)
    parser.add_argument("--pairs", type=int, default=7)
    parser.add_argument("--store", type=Path, required=True)
    arguments = parser.parse_args(record.arguments)
    data, names = opened(arguments.root, arguments.category)
    maps = matched(data, sorted(names[: arguments.shapes]), arguments.store)
    rows = [
        measured(data.read(x), data.read(y), maps[x, y], data.truth(x, y)) for x, y in islice(maps, 2 * arguments.pairs)
    ]
    turned, folded, error, gap = np.mean(rows, axis=0)
    worst = max(row[0] for row in rows)
    print(f"<!-- {machine()}; {names[0]} ... -->")
    columns = ("maps", "turned over, %", "worst", "none at all", "folded edges", "error", "from the shape")
    table = record.table("", *columns, align=7 * "r")
    none = sum(row[0] == 0 for row in rows)
    table.row(len(rows), f"{turned:.2f}", f"{worst:.2f}", none, f"{folded:.0f}", f"{error:.4f}", f"{gap:.5f}")


if __name__ == "__main__":
    with recorded() as record:
        main(record)
