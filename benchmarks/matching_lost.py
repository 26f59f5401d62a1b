"""At which stage the right map was lost, for pairs that come out wrong, as a Markdown table.

    python benchmarks/matching_lost.py FOLDER --pairs 8_woman_07-8_gorilla_01 8_woman_11-8_gorilla_01

FOLDER is a set as `VtsDataset` reads it. The thorough search only (see `match`), between the coarse shapes; errors are
mean distances there to the true image over sqrt(area). A candidate is right in the large if its error is below .2, a
contender that was registered if it is below .1. The stages: candidates (after signs and mirrored maps),
previewed, taken to the end, cheapest there. Beside the least error at each stage stand what the chosen map and the best
of the right ones, or else the true map registered, cost at the end.
"""

from __future__ import annotations

import argparse

import numpy as np
from record import Record, machine, recorded
from scipy.spatial import cKDTree

from qgeo_filters.evaluation import VtsDataset
from qgeo_filters.evaluation.datasets import PointMap
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.matching.initialization.candidates import mapped_points
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.search import competing_candidates
from qgeo_filters.matching.selection.cost import registered
from qgeo_filters.matching.selection.decision import close_contenders, previewed, settled

PROPOSED, RIGHT = 0.2, 0.1


def main(record: Record) -> None:
    """Print a row for each pair."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--pairs", nargs="+", required=True, metavar="X-Y")
    arguments = parser.parse_args(record.arguments)
    data = VtsDataset(arguments.folder)
    print(f"{machine()}\n")
    errors = ("least error: candidates", "previewed", "at the end", "chosen")
    table = record.table("", "pair", *errors, "lost", "cost of the chosen : the right", align="lrrrrlr")
    for pair in arguments.pairs:
        x, y = pair.split("-")
        table.row(pair, *_cells(PreparedShape(data.read(x)), PreparedShape(data.read(y)), data.truth(x, y)))


def coarse_truth(x: PreparedShape, y: PreparedShape, truth: PointMap) -> np.ndarray:
    """True vertex of the coarse Y for each of the coarse X, (n,): that of the nearest point for which it is known."""
    there = [np.arange(one.given.n_vertices) if one.repair is None else one.repair.vertex_of_original for one in (x, y)]
    known = x.vertex_of_full[there[0][truth.points]]
    nearest = cKDTree(x.unit.vertices[known]).query(x.unit.vertices)[1]
    return y.vertex_of_full[there[1][truth.images]][nearest]


def _cells(x: PreparedShape, y: PreparedShape, truth: PointMap) -> list[str]:
    images = coarse_truth(x, y, truth)
    distances = distance_matrix(y.surface) / y.scale

    def error(p2p: np.ndarray, points: np.ndarray | None = None) -> float:
        return float(distances[p2p, images if points is None else images[points]].mean())

    problem = MatchProblem(x, y)
    keeping, reversing, _ = competing_candidates(problem)
    pool, problem = (keeping, problem) if keeping else (reversing, problem.with_mirrored_y())
    ranked = previewed(problem, pool)
    ends = settled(problem, close_contenders(problem, ranked))
    chosen = min(ends, key=lambda c: c.end_cost)
    points = mapped_points(problem)
    least = (
        min(error(c.p2p, points) for c in pool),
        min(error(c.dense.p2p) for c in ranked),
        min(error(c.dense.p2p) for c in ends),
        error(chosen.dense.p2p),
    )
    stages = ["not proposed", "not previewed", "not taken to the end", "dearer at the end"]
    lost = next(
        (s for s, e, most in zip(stages, least, (PROPOSED, PROPOSED, RIGHT, RIGHT), strict=True) if e > most), "-"
    )
    (true,) = registered(problem, [(chosen.number, images)], problem.parameters.coarse_to_fine)
    right = min([c.end_cost for c in ends if error(c.dense.p2p) < RIGHT], default=true.end_cost)
    x.arap.release()
    return [*(f"{e:.3f}" for e in least), lost, f"{chosen.end_cost / right:.2f}"]


if __name__ == "__main__":
    with recorded() as record:
        main(record)
