"""By which of its terms the cost of a settled map tells right from wrong, as a Markdown table.

    python benchmarks/matching_terms.py DATA [--sets shrec19_r scape_r] [--pairs 8] [--json FILE]

DATA holds a folder for each set, named as in `qgeo evaluate`. Of each set so many pairs are taken, at random but always
the same ones, and searched thoroughly between the coarse shapes; a contender that has settled is right if the mean
distance to the true image is below .1 sqrt(area), and wrong above .15. For each wrong contender: how many times as much
each quantity is along it as along the cheapest right one of that pair; a quantity tells them apart where that is above
1. Deviations: the mean of the logarithm of these ratios in its standard deviations, each pair by its least ratio.
"Curvature, smoothed more" is what stood in the place of the relief before: mean curvature after .001 of heat.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from matching_lost import coarse_truth
from record import Record, machine, recorded

from qgeo_filters.differential.curvature import mean_curvature
from qgeo_filters.evaluation import BENCHMARKS
from qgeo_filters.evaluation.datasets import PointMap
from qgeo_filters.evaluation.runner import by_target
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.search import competing_candidates
from qgeo_filters.matching.selection.cost import Contender
from qgeo_filters.matching.selection.decision import close_contenders, previewed, settled
from qgeo_filters.matching.selection.signatures import curvature_agreement

RIGHT, WRONG = 0.1, 0.15
SMOOTHED_MORE = 0.001
SETS = ("shrec19_r", "scape_r", "smal_r", "tosca_nonisometric")


def main(record: Record) -> None:
    """Print the table; each pair that has a right and a wrong contender as it is done, as a comment."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--sets", nargs="+", default=SETS)
    parser.add_argument("--pairs", type=int, default=8)
    arguments = parser.parse_args(record.arguments)
    print(f"{machine()}\n")
    ratios: list[list[dict[str, float]]] = []
    for name in arguments.sets:
        data = BENCHMARKS[name].read(arguments.data / name)
        pairs = [pair for category in data.categories for pair in data.pairs(category)]
        some = np.random.default_rng(0).choice(len(pairs), min(arguments.pairs, len(pairs)), replace=False)
        shapes: dict[str, PreparedShape] = {}
        for a, b in by_target([pairs[i] for i in some]):
            x, y = (shapes.setdefault(one, PreparedShape(data.read(one))) for one in (a, b))
            found = _ratios(x, y, data.truth(a, b))
            if found:
                ratios.append(found)
                print(f"<!-- {name}, {a} - {b}: {len(found)} wrong -->", flush=True)
    table = record.table("", "quantity", "not above 1", "least", "median", "deviations", align="lrrrr")
    for quantity in ratios[0][0]:
        of = np.array([one[quantity] for found in ratios for one in found])
        least = np.log([min(one[quantity] for one in found) for found in ratios])
        cells = (f"{of.min():.2f}", f"{np.median(of):.2f}", f"{least.mean() / least.std():.1f}")
        table.row(quantity, f"{(of <= 1).sum()} of {len(of)}", *cells)
    record.note(f"{len(ratios)} pairs have both right and wrong contenders at the end.")


def _ratios(x: PreparedShape, y: PreparedShape, truth: PointMap) -> list[dict[str, float]]:
    """Of each wrong contender, what it has beside the cheapest right one; none where there are not both."""
    images = coarse_truth(x, y, truth)
    distances = distance_matrix(y.surface) / y.scale
    problem = MatchProblem.of(x, y)
    keeping, _, _ = competing_candidates(problem)
    if not keeping:
        return []
    ends = settled(problem, close_contenders(problem, previewed(problem, keeping)))
    x.arap.release()
    errors = [float(distances[c.dense.p2p, images].mean()) for c in ends]
    right = [c for c, error in zip(ends, errors, strict=True) if error < RIGHT]
    if not right:
        return []
    best = _terms(problem, min(right, key=lambda c: c.end_cost))
    wrong = [_terms(problem, c) for c, error in zip(ends, errors, strict=True) if error > WRONG]
    return [{name: value / best[name] for name, value in one.items()} for one in wrong]


def _terms(problem: MatchProblem, c: Contender) -> dict[str, float]:
    """What a contender costs at the end, and of what that is made."""
    given = problem.parameters
    here, there = (_smoothed_more(shape) for shape in (problem.x, problem.y))
    areas = problem.x.areas
    smoothed = 0.5 * areas @ (here - there[c.dense.p2p]) ** 2 / (areas @ (here - areas @ here) ** 2)
    return {
        "cost at the end": c.end_cost,
        "relief": 1 - c.relief_agreement + given.least_curvature_gap,
        "curvature": 1 - curvature_agreement(problem, c.dense.p2p) + given.least_curvature_gap,
        "curvature, smoothed more": float(smoothed) + given.least_curvature_gap,
        "heat kernels": 1 - c.hks_agreement + given.least_hks_gap,
        "strain": max(c.strain, given.least_strain),
        "torn": max(c.torn, given.least_torn),
        "folded": c.folded + given.least_folded,
        "distortion": max(c.mean_distortion, given.least_distortion),
    }


def _smoothed_more(shape: PreparedShape) -> np.ndarray:
    """Mean curvature after more heat than `PreparedShape.smoothed_mean_curvature` has, (n,)."""
    functions, values = shape.laplacian.astype(float), shape.laplacian_spectrum.eigenvalues
    limit = shape.parameters.curvature_limit
    curvature = np.clip(mean_curvature(shape.unit), -limit, limit)
    return np.asarray(functions @ (np.exp(-values * SMOOTHED_MORE) * (functions.T @ (shape.areas * curvature))))


if __name__ == "__main__":
    with recorded() as record:
        main(record)
