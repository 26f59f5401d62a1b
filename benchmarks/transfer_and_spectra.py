"""Do C_XY and D(S), eq. (4) and (5) of the paper, tell how well poses go over? Error of the transfer, on TOSCA.

    python benchmarks/transfer_and_spectra.py ROOT [--pairs 10] [--categories cat horse] [--picture FILE] [--json FILE]

ROOT as for ``matching.py``. For pairs of poses of one body, each in a triangulation of its own: the map is found by
`match`, Y is brought into the pose of X (`transfer_pose`, one body), and its vertices are compared with where they
truly are on X, after a rigid motion, in units of sqrt(area). Beside it C_XY, D(S) of the two shapes and the distortion
of distances, all known without truth. Rank correlations are Spearman's, within each category and over all pairs by
their ranks within one.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from record import Record, machine, recorded
from scipy.stats import rankdata, spearmanr

import qgeo_filters as qg
from qgeo_filters.collection.pair_arrays import pair_compatibility
from qgeo_filters.deformation.similarity import Similarity
from qgeo_filters.evaluation import ToscaRemeshed
from qgeo_filters.report.panels import new_figure


class Prepared(dict[str, qg.PreparedShape]):
    """Shapes by name, each prepared when it is first asked for."""

    def __init__(self, prepare: Callable[[str], qg.PreparedShape]) -> None:
        super().__init__()
        self._prepare = prepare

    def __missing__(self, name: str) -> qg.PreparedShape:
        self[name] = self._prepare(name)
        return self[name]


def measured(
    data: ToscaRemeshed, x: str, y: str, shapes: dict[str, qg.PreparedShape]
) -> tuple[float, float, float, float]:
    """C_XY, D(S), distortion, and error of the transfer."""
    pose, body = (shapes[name].given for name in (x, y))
    found = qg.match(shapes[x], shapes[y])
    d_s = pair_compatibility(found, shapes[x], shapes[y])
    moved = qg.transfer_pose(pose, body, found, same_body=True, accept_unsure=True).vertices
    truth = data.truth(y, x)
    places = pose.vertices[truth.images]
    near = Similarity.between(moved[truth.points], places, np.ones(len(places)), 1.0)(moved[truth.points])
    error = np.linalg.norm(near - places, axis=1).mean() / np.sqrt(pose.area)
    return found.c_xy, d_s, found.score, float(error)


def main(record: Record) -> None:
    """Print a row for each pair, and the correlations; draw them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--pairs", type=int, default=10)
    parser.add_argument("--categories", nargs="+", default=["cat", "horse", "michael"])
    parser.add_argument("--picture", type=Path)
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    print(f"{machine()}\n")
    rows: dict[str, np.ndarray] = {}
    for category in arguments.categories:
        pairs = list(data.pairs(category))
        np.random.default_rng(0).shuffle(pairs)
        shapes = Prepared(lambda name: qg.PreparedShape(data.read(name)))
        found = []
        for x, y in pairs[: arguments.pairs]:
            found.append(measured(data, x, y, shapes))
            values = zip(("C_XY", "D(S)", "distortion", "error"), found[-1], strict=True)
            print(f"<!-- {x} - {y}: {', '.join(f'{name} {value:.4f}' for name, value in values)} -->", flush=True)
        rows[category] = np.array(found)
    correlations = ("rank correlation with C_XY", "with D(S)", "with the distortion")
    table = record.table("", "pairs of", "pairs", "C_XY", "D(S)", "error, mean", *correlations, align="lrrrrrrr")
    for category, values in rows.items():
        table.row(*_cells(category, values, values))
    ranks = np.concatenate([np.apply_along_axis(rankdata, 0, values) / len(values) for values in rows.values()])
    table.row(*_cells("all, ranks within each", np.concatenate(list(rows.values())), ranks))
    if arguments.picture:
        figure = new_figure(4.6, 3.4)
        axes = figure.add_subplot()
        for category, values in rows.items():
            axes.scatter(values[:, 0], values[:, -1], label=category, s=18)
        axes.set(xlabel="C_XY", ylabel="error of the transfer (√area)")
        axes.legend(frameon=False)
        figure.savefig(arguments.picture, dpi=110)


def _cells(label: str, values: np.ndarray, ranked: np.ndarray) -> list[object]:
    """A row: means of the values, correlations of what is ranked."""
    correlations = []
    for column in (0, 1, 2):
        result = spearmanr(ranked[:, column], ranked[:, -1])
        correlations.append(f"{result.statistic:+.2f} (p = {result.pvalue:.2g})")
    spans = [f"{values[:, k].min():.3f} to {values[:, k].max():.3f}" for k in (0, 1)]
    return [label, len(values), *spans, f"{values[:, -1].mean():.4f}", *correlations]


if __name__ == "__main__":
    with recorded() as record:
        main(record)
