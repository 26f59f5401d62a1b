"""Vertex-to-point maps beside vertex-to-vertex maps, against true points on the surface, as a Markdown table.

    python benchmarks/barycentric.py ROOT --pairs cat0-cat1 centaur0-centaur1 [--json FILE]

ROOT holds ``remeshed``, ``ground_truth`` and ``full`` (the second pose of each pair at full resolution). The true image
of a vertex is where the pose at full resolution has it, in general inside a triangle of Y: no map to vertices can do
better than the last column. Errors are straight distances in units of sqrt(area), means and 95th percentiles.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from record import Record, recorded

from qgeo_filters.evaluation import ToscaRemeshed
from qgeo_filters.matching.correspondence import match
from qgeo_filters.surface import Surface


def main(record: Record) -> None:
    """Print a row for each pair."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path)
    parser.add_argument("--pairs", nargs="+", default=["cat0-cat1", "centaur0-centaur1"])
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    columns = ("pair", "mean edge", "to vertices", "to points", "nearest vertices to the truth")
    table = record.table("", *columns, align="lrrrr")
    for pair in arguments.pairs:
        name_x, name_y = pair.split("-")
        x, y = data.read(name_x), data.read(name_y)
        with np.load(arguments.root / "ground_truth" / f"{name_x}.npz") as tables:
            place = Surface.read(arguments.root / "full" / f"{name_y}.off").vertices[tables["full_of_vertex"]]
        found = match(x, y)
        images = (
            y.vertices[found.p2p],
            found.barycentric.pulled_back(y.vertices),
            y.vertices[data.truth(name_x, name_y).images],
        )
        cells = [_cell(np.linalg.norm(image - place, axis=1) / np.sqrt(y.area)) for image in images]
        table.row(pair, f"{y.edge_lengths.mean() / np.sqrt(y.area):.4f}", *cells)


def _cell(errors: np.ndarray) -> str:
    return f"{errors.mean():.4f} / {np.percentile(errors, 95):.4f}"


if __name__ == "__main__":
    with recorded() as record:
        main(record)
