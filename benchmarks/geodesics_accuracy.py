"""Accuracy against time: the graph method at several bounds among its peers, as a table and a plot.

    python benchmarks/geodesics_accuracy.py [3400] [--json results/geodesics_accuracy.json]

Writes geodesics_accuracy.svg beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from geodesics_common import blob, cpu, exact_rows, peers, percent, relative_error
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from record import Record, recorded

from qgeo_filters.compilation import warmup
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.surface import Surface

Peer = tuple[str, float, float]  # name, CPU ms a source, mean error in per cent


def main(record: Record) -> None:
    """Print the table, draw the plot."""
    n = int(record.arguments[0]) if record.arguments else 3400
    warmup()
    mesh = blob(n)
    sources = np.random.default_rng(0).integers(0, n, 10)
    exact, slow = exact_rows(mesh, sources)
    columns = ("accuracy (the bound), %", "CPU ms a source", "mean error, %", "max error, %")
    table = record.table(f"closed irregular mesh of {n} vertices", *columns)
    ours = []
    for accuracy in (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5):
        surface = Surface(*mesh)
        matrix, seconds = cpu(lambda s=surface, a=accuracy: distance_matrix(s, accuracy=a))
        error = relative_error(matrix[sources].astype(float), exact)  # type: ignore[index]
        ours.append((1e3 * seconds / n, 100 * error.mean(), 100 * error.max()))
        table.row(percent(accuracy), f"{ours[-1][0]:.3g}", percent(error.mean()), percent(error.max()))
    others: list[Peer] = [("pygeodesic (exact)", 1e3 * slow, 0.0)]
    for name, rows, seconds in peers(mesh, sources):
        others.append((name, 1e3 * seconds, 100 * float(np.abs(relative_error(rows, exact)).mean())))
    figure = plot(ours, others, f"All-pairs geodesics, {n} vertices")
    figure.savefig(Path(__file__).with_name("geodesics_accuracy.svg"))


def plot(ours: Sequence[tuple[float, float, float]], others: Sequence[Peer], title: str) -> Figure:
    """Error against time of the graph method (time, mean, largest), and of each of the others."""
    figure, axes = plt.subplots(figsize=(7.2, 4.6), layout="constrained")
    time, mean, largest = np.transpose(ours)
    curves = axes.loglog(time, mean, "o-", color="C3", label="qgeo-filters, graph, mean error")
    curves += axes.loglog(time, largest, "o:", color="C3", mfc="none", label="qgeo-filters, graph, largest error")
    axes.set(xlabel="CPU ms a source (all pairs)", ylabel="mean error, % (exact: at the bottom)", title=title)
    axes.set_ylim(2e-5, 30)
    axes.grid(alpha=0.3)
    legend = axes.legend(fontsize=8, loc="center right")
    places = [(ms, max(error, 1e-4)) for _, ms, error in others]
    for (name, _, _), place in zip(others, places, strict=True):
        axes.plot(*place, "s", color="C3" if name.startswith("qgeo") else "0.4")
    figure.canvas.draw()
    figure.set_layout_engine("none")  # so that what is measured below stays where it is
    taken = [legend.get_window_extent()]
    taken += [Bbox.from_bounds(x - 5, y - 5, 10, 10) for x, y in axes.transData.transform(places)]
    for curve in curves:
        ends = axes.transData.transform(curve.get_xydata())
        along = [a + t * (b - a) for a, b in pairwise(ends) for t in np.linspace(0, 1, 20)]
        taken += [Bbox.from_bounds(x - 3, y - 3, 6, 6) for x, y in along]
    for (name, _, _), place in zip(others, places, strict=True):
        label = _label(axes, name, place, taken)
        taken.append(label.get_window_extent())
    return figure


def _label(axes: Axes, name: str, place: tuple[float, float], taken: Sequence[Bbox]) -> Text:
    """Name of a marker beside, above or below it, in the first of these places that is free."""
    sides = [((7, 0), "left"), ((-7, 0), "right")]
    for y in (11, -12, 22, -23):
        sides += [((0, y), "center"), ((5, y), "right"), ((-5, y), "left")]
    for offset, side in sides:
        label = axes.annotate(name, place, xytext=offset, textcoords="offset points", fontsize=8, ha=side, va="center")
        extent = label.get_window_extent()
        if (
            axes.bbox.contains(extent.x0, extent.y0)
            and axes.bbox.contains(extent.x1, extent.y1)
            and not extent.count_overlaps(taken)
        ):
            return label
        label.remove()
    raise RuntimeError(f"no free place for the label {name!r}")


if __name__ == "__main__":
    with recorded() as record:
        main(record)
