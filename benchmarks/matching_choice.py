"""By what the right one of several close maps is told best, as a Markdown table.

    python benchmarks/matching_choice.py ROOT --categories cat dog centaur [--json FILE]

ROOT as for ``matching.py``. For each pair, the contenders that `qg.match` takes further: what they cost in the preview,
and where they end (see `choose_map`). A rule chooses the one that costs least at the end, which is what `qg.match`
does; the same without what the relief and the smoothed curvature add to the cost; in the preview ("trial"); or in the
geometric mean of the last two. Where right maps (mean error below .1 sqrt(area)) and wrong ones compete: how many times
as much the cheapest wrong one costs as the cheapest right one; below 1 the choice is wrong. The last columns are the
error of the map that each rule chooses, before the last stage.
"""

from __future__ import annotations

import argparse

import numpy as np
from record import Record, Table, machine, recorded

from qgeo_filters.evaluation import ToscaRemeshed, geodesic_error
from qgeo_filters.evaluation.datasets import PointMap
from qgeo_filters.evaluation.runner import by_target
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.search import competing_candidates
from qgeo_filters.matching.selection.decision import close_contenders, previewed, settled

#: Everything at full resolution: maps between coarse shapes could not be compared with the truth.
FULL = MatchingParameters(search_vertices=1_000_000, registration_vertices=1_000_000)

WRONG = 0.1
RULES = ("end", "end without relief", "trial", "both")


def main(record: Record) -> None:
    """Print a row for each category; each pair with a wrong contender as it is done, as a comment."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--categories", nargs="+", default=["cat", "dog", "centaur"])
    parser.add_argument("--pairs", nargs="+", metavar="X-Y", help="these alone, as one category")
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    if arguments.pairs:
        groups = {"these": [(x, y) for x, y in (pair.split("-") for pair in arguments.pairs)]}
    else:
        groups = {category: list(data.pairs(category)) for category in arguments.categories}
    print(f"{machine()}\n")
    heads = [f"least ratio, by {rule}" for rule in RULES] + [f"error, by {rule}" for rule in RULES]
    table = record.table("", "category", "pairs", "with a wrong contender", *heads, align="l" + 10 * "r")
    for category, pairs in groups.items():
        _row(table, data, category, by_target(pairs))


def _row(table: Table, data: ToscaRemeshed, category: str, pairs: list[tuple[str, str]]) -> None:
    shapes: dict[str, PreparedShape] = {}
    ruler: tuple[str, np.ndarray] = ("", np.zeros((0, 0)))
    ratios, chosen = [], []
    for a, b in pairs:
        for name in (a, b):
            shapes.setdefault(name, PreparedShape(data.read(name), parameters=FULL))
        if ruler[0] != b:
            ruler = (b, distance_matrix(shapes[b].surface))
        costs, errors = _contending(shapes[a], shapes[b], data.truth(a, b), ruler[1])
        chosen.append(errors[costs.argmin(axis=0)])
        wrong = errors > WRONG
        if wrong.any() and not wrong.all():
            ratios.append(costs[wrong].min(axis=0) / costs[~wrong].min(axis=0))
            print(f"<!-- {a}-{b}: {', '.join(f'{ratio:.2f}' for ratio in ratios[-1])} -->", flush=True)
    least = [f"{ratio:.2f}" for ratio in np.min(ratios, axis=0)] if ratios else ["-"] * len(RULES)
    means = [f"{error:.4f}" for error in np.mean(chosen, axis=0)]
    table.row(category, len(pairs), len(ratios), *least, *means)


def _contending(
    x: PreparedShape, y: PreparedShape, truth: PointMap, matrix: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Costs (c, 4) of the contenders by each rule, and their errors (c,)."""
    problem = MatchProblem(x, y, FULL)
    keeping, reversing, _ = competing_candidates(problem)
    pool, problem = (keeping, problem) if keeping else (reversing, problem.with_mirrored_y())
    close = close_contenders(problem, previewed(problem, pool))
    ends = settled(problem, close)
    x.arap.release()
    trial, plain, end = (
        np.array(costs) for costs in ([c.cost for c in close], [c.cost for c in ends], [c.end_cost for c in ends])
    )
    errors = [geodesic_error(c.dense.p2p[truth.points], truth.images, y.surface, matrix=matrix).mean() for c in ends]
    return np.column_stack([end, plain, trial, np.sqrt(trial * plain)]), np.array(errors)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
