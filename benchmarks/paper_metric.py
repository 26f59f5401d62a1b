"""Which metric should propose maps: C_XY and the search's proposals over the weight and the scalar.

    python benchmarks/paper_metric.py ROOT --out metrics.jsonl [--pairs 15] [--categories cat dog] [--weights .01 .03]
        [--json FILE]

ROOT holds TOSCA's ``remeshed``, ``ground_truth`` and ``symmetry``. For each pair of poses and each metric alone: C_XY
of 20 eigenfunctions paired by eq. (4) through the true map (`commutative_eigenspectra`), and the distinct coarse maps
that `sign_search` proposes, each with its mean distance on Y to the truth, or to the mirrored truth, in units of
sqrt(area). A proposal is right within .1; the mirrored counts, since the mirrored map is built of it. Results are
appended to the file as they come and not computed again.
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from record import Record, recorded

from qgeo_filters.evaluation import ToscaRemeshed
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.metric import lifted_metric
from qgeo_filters.matching.initialization.sign_search import sign_search
from qgeo_filters.matching.intrinsic_shape import IntrinsicShape, MetricEmbedding, farthest_rows
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.spectral.commutative import commutative_eigenspectra
from qgeo_filters.spectral.spectrum import spectrum_of_matrix
from qgeo_filters.surface import Surface

SCALARS = ("mean_curvature", "gaussian_curvature", "curvedness")
WEIGHTS = (0.01, 0.02, 0.03, 0.06)
TUNING = ("cat", "dog", "centaur")
FUNCTIONS, SPARE, POINTS = 20, 5, 300
RIGHT = 0.1

Metric = tuple[str, float]
Row = dict[str, Any]
CARTESIAN: Metric = ("none", 0.0)


def metrics(scalars: list[str], weights: list[float]) -> list[Metric]:
    """The Cartesian metric, and every scalar with every weight."""
    return [CARTESIAN, *itertools.product(scalars, (weight for weight in weights if weight > 0))]


def prepared(surface: Surface, metric: Metric, heat: IntrinsicShape) -> tuple[Any, Any]:
    """What `sign_search` reads of a prepared shape with this metric alone, and the spectrum.

    Proposals are ranked by surroundings, too, which are those of the surface in every metric.
    """
    scalar, weight = metric
    lifted = lifted_metric(surface, "mean_curvature" if weight == 0 else scalar, weight)
    matrix = distance_matrix(surface, lifted)
    spectrum = spectrum_of_matrix(matrix, surface.vertex_areas, FUNCTIONS + SPARE)
    fps = farthest_rows(matrix, surface.vertex_areas, POINTS)
    functions = spectrum.eigenfunctions.astype(np.float32)
    first = spectrum.truncated(FUNCTIONS)
    embedding = MetricEmbedding(weight, spectrum.eigenvalues, functions, first, matrix[fps])
    surroundings = {"log_hks": heat.log_hks, "relief": heat.relief, "areas": heat.areas}
    shape = SimpleNamespace(
        embedding=lambda _: embedding, fps=fps, fps_distances=embedding.fps_distances, **surroundings
    )
    return shape, spectrum


def main(record: Record) -> None:
    """Measure what is not in the file yet, then print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("root", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--pairs", type=int, default=15, help="pairs of each category, drawn at random (seed 0)")
    parser.add_argument("--categories", nargs="*", default=list(TUNING))
    parser.add_argument("--scalars", nargs="*", default=list(SCALARS))
    parser.add_argument("--weights", nargs="*", type=float, default=list(WEIGHTS))
    options = parser.parse_args(record.arguments)
    data = ToscaRemeshed(options.root)
    wanted = metrics(options.scalars, options.weights)
    found = [json.loads(line) for line in options.out.read_text().splitlines()] if options.out.exists() else []
    done = {(row["pair"], row["scalar"], row["weight"]) for row in found}
    with options.out.open("a") as file:
        for category in options.categories:
            pairs = list(data.pairs(category))
            np.random.default_rng(0).shuffle(pairs)
            for row in _measured(data, pairs[: options.pairs], wanted, done):
                file.write(json.dumps(row) + "\n")
                file.flush()
                found.append(row)
    record.markdown("", table(found, options.categories, wanted))


def _measured(
    data: ToscaRemeshed, pairs: list[tuple[str, str]], wanted: list[Metric], done: set[tuple[str, str, float]]
) -> Iterator[Row]:
    """A row for each pair and metric that is not done."""
    left = [m for m in wanted if any((f"{x}-{y}", *m) not in done for x, y in pairs)]
    if not left:
        return
    names = list(dict.fromkeys(name for pair in pairs for name in pair))
    units = {name: _unit(data.read(name)) for name in names}
    heats = {name: IntrinsicShape(unit, unit, MatchingParameters()) for name, unit in units.items()}
    cartesian = {y: distance_matrix(units[y]) for y in dict.fromkeys(y for _, y in pairs)}
    for metric in left:
        shapes = {name: prepared(units[name], metric, heats[name]) for name in names}
        for x, y in pairs:
            if (f"{x}-{y}", *metric) in done:
                continue
            truth, mirror = data.truth(x, y).images, data.symmetry(y).images
            c_xy = commutative_eigenspectra(shapes[x][1], shapes[y][1], truth, FUNCTIONS).c_xy
            errors = []
            given = MatchingParameters(curvature_weights=(metric[1],))
            for proposal in sign_search(MatchProblem(shapes[x][0], shapes[y][0], given)):
                target = truth[proposal.points]
                errors.append([float(cartesian[y][proposal.p2p, to].mean()) for to in (target, mirror[target])])
            row = {"pair": f"{x}-{y}", "category": data.category(x), "scalar": metric[0], "weight": metric[1]}
            yield {**row, "c_xy": c_xy, "errors": errors}


def _unit(surface: Surface) -> Surface:
    return Surface(surface.vertices / np.sqrt(surface.area), surface.faces)


def table(found: list[Row], categories: list[str], wanted: list[Metric]) -> str:
    """One line for each metric: C_XY against the Cartesian one, and what the search proposes over all pairs."""
    rows: dict[Metric, dict[str, Row]] = defaultdict(dict)
    for row in found:
        if row["category"] in categories:
            rows[row["scalar"], row["weight"]][row["pair"]] = row
    cartesian = rows[CARTESIAN]
    lines = [
        f"| scalar | weight | {' | '.join(f'C_XY {c}' for c in categories)} | change of C_XY (%) | pairs with a "
        "lower one | one is right | with those of weight 0 | the first is right | right a pair | error of the best |",
        "|---|---:|" + "---:|" * (len(categories) + 7),
    ]
    for metric in wanted:
        here = rows[metric]
        if not here:
            continue
        c_xy = [np.mean([r["c_xy"] for r in here.values() if r["category"] == c]) for c in categories]
        change = np.array([100 * (row["c_xy"] / cartesian[pair]["c_xy"] - 1) for pair, row in here.items()])
        best = np.array([_best(row) for row in here.values()])
        union = np.minimum(best, [_best(cartesian[pair]) for pair in here])
        first = np.array([min(row["errors"][0]) for row in here.values()])
        right = np.mean([sum(min(pair) <= RIGHT for pair in row["errors"]) for row in here.values()])
        deviation = change.std(ddof=1) / np.sqrt(len(change)) if len(change) > 1 else np.nan
        cells = [f"{value:.2f}" for value in c_xy]
        cells += [f"{change.mean():+.1f} ± {deviation:.1f}", f"{(change < 0).sum()} of {len(here)}"]
        cells += [f"{(values <= RIGHT).sum()} of {len(here)}" for values in (best, union, first)]
        cells += [f"{right:.1f}", f"{best.mean():.4f}"]
        lines.append(f"| {metric[0]} | {metric[1]:g} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _best(row: Row) -> float:
    """Error of the best proposal, mirrored or not."""
    return min(min(pair) for pair in row["errors"])


if __name__ == "__main__":
    with recorded() as record:
        main(record)
