"""Where the registration ends when it starts from the true map, as a Markdown table: its share of a match's error.

    python benchmarks/matching_from_truth.py ROOT --pairs cat4-cat7 cat9-cat7 dog0-dog3

ROOT as for ``matching.py``. Columns: the registration of `qg.match`, from the true map; the same without starting
afresh from low frequencies (`Stage.untwist`), so that it stays near the truth; ZoomOut of the Laplacian's
eigenfunctions, 20 to 200, from the true map. Mean error in units of sqrt(area), and strain of the deformation: where
the first column has the lower strain and the larger error, the truth is not the deformation that strains least.
"""

from __future__ import annotations

import argparse

import numpy as np
from record import Record, machine, recorded

from qgeo_filters.evaluation import ToscaRemeshed, geodesic_error
from qgeo_filters.evaluation.datasets import PointMap
from qgeo_filters.matching.maps.functional_map import nearest_neighbors, zoomout
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.registration_stages import COARSE_TO_FINE, FINAL
from qgeo_filters.matching.schedule import Schedule
from qgeo_filters.matching.smooth_shells import register

#: Everything at full resolution: maps between coarse shapes could not be compared with the truth.
FULL = MatchingParameters(search_vertices=1_000_000, registration_vertices=1_000_000)

PAIRS = [
    "cat4-cat7", "cat9-cat7", "cat7-cat1", "cat4-cat9", "cat1-cat9", "cat6-cat10", "cat0-cat9", "cat2-cat7",
    "dog0-dog3", "dog1-dog6", "centaur3-centaur1",
]  # fmt: skip
SIZES = (20, 30, 45, 65, 90, 120, 160, 200)


def zoomed_out(x: PreparedShape, y: PreparedShape, p2p: np.ndarray) -> np.ndarray:
    """ZoomOut (spectral upsampling) of a map between all vertices."""
    functional = zoomout(x.laplacian, y.laplacian, p2p, np.arange(x.n_vertices), SIZES)
    return nearest_neighbors(x.laplacian @ functional, y.laplacian)


def main(record: Record) -> None:
    """Print a row for each pair, and the means."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--pairs", nargs="+", default=PAIRS, metavar="X-Y")
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    print(f"{machine()}\n")
    columns = ("pair", "registration: error, strain", "without the start afresh: error, strain", "ZoomOut: error")
    table = record.table("", *columns, align="lrrr")
    rows = []
    for pair in arguments.pairs:
        problem = MatchProblem.of(*(data.read(name) for name in pair.split("-")), FULL)
        x, y = problem.x, problem.y
        truth = data.truth(*pair.split("-"))
        start = np.zeros(x.n_vertices, dtype=np.int64)
        start[truth.points] = truth.images

        values = []
        for stages in (COARSE_TO_FINE + FINAL[1:], FINAL):
            result = register(problem, start, Schedule.of(problem, stages))
            values += [_error(result.p2p, truth, y), x.arap.energy(result.positions)]
        rows.append([*values, _error(zoomed_out(x, y, start), truth, y)])
        table.row(pair, *_cells(rows[-1]))
    table.row("mean", *_cells(np.mean(rows, axis=0)))


def _error(p2p: np.ndarray, truth: PointMap, y: PreparedShape) -> float:
    return float(geodesic_error(p2p[truth.points], truth.images, y.surface).mean())


def _cells(row: np.ndarray | list[float]) -> tuple[str, str, str]:
    one, strain, other, other_strain, zoomed = row
    return f"{one:.4f}, {strain:.3f}", f"{other:.4f}, {other_strain:.3f}", f"{zoomed:.4f}"


if __name__ == "__main__":
    with recorded() as record:
        main(record)
