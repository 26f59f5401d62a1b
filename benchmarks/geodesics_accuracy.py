"""Accuracy against time: the graph method at several bounds among its peers, as a table and a plot.

python benchmarks/geodesics_accuracy.py [3400] > table.md      (writes geodesics_accuracy.svg beside it)
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from geodesics_common import blob, cpu, exact_rows, machine, peers, percent, relative_error

from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.warmup import warmup
from qgeo_filters.surface import Surface


def main(n: int) -> None:
    """Print the table, draw the plot."""
    warmup()
    mesh = blob(n)
    sources = np.random.default_rng(0).integers(0, n, 10)
    exact, slow = exact_rows(mesh, sources)
    print(f"Machine: {machine()}\n\nClosed irregular mesh of {n} vertices.\n")
    print("| accuracy (the bound), % | CPU ms a source | mean error, % | max error, % |\n|---|---|---|---|")
    ours = []
    for accuracy in (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5):
        surface = Surface(*mesh)
        matrix, seconds = cpu(lambda s=surface, a=accuracy: distance_matrix(s, accuracy=a))
        error = relative_error(matrix[sources].astype(float), exact)  # type: ignore[index]
        ours.append((1e3 * seconds / n, error.mean(), error.max()))
        print(
            f"| {percent(accuracy)} | {ours[-1][0]:.3g} | {percent(error.mean())} | {percent(error.max())} |",
            flush=True,
        )

    figure, axes = plt.subplots(figsize=(7.2, 4.6), layout="constrained")
    time, mean, largest = np.transpose(ours)
    axes.loglog(time, 100 * mean, "o-", color="C3", label="qgeo-filters, mean error")
    axes.loglog(time, 100 * largest, "o:", color="C3", mfc="none", label="qgeo-filters, largest error")
    others = [
        (name, np.abs(relative_error(rows, exact)).mean(), seconds) for name, rows, seconds in peers(mesh, sources)
    ]
    labels = {  # where the usual place, on the right, is taken
        "potpourri3d heat, plain": ((0, 8), "right"),
        "pygeodesic (exact)": ((0, 8), "center"),
        "libigl exact_geodesic": ((-7, -3), "right"),
    }
    for name, error, seconds in [("pygeodesic (exact)", 0.0, slow), *others]:
        if not name.startswith("qgeo"):
            place = 1e3 * seconds, max(100 * error, 1e-4)
            offset, side = labels.get(name, ((7, -3), "left"))
            axes.plot(*place, "s", color="0.4")
            axes.annotate(name, place, xytext=offset, textcoords="offset points", fontsize=8, ha=side)
    axes.set(
        xlabel="CPU ms a source (all pairs)",
        ylabel="mean error, % (exact: at the bottom)",
        title=f"All-pairs geodesics, {n} vertices",
    )
    axes.set_ylim(5e-5, 30)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="center right")
    figure.savefig(Path(__file__).with_name("geodesics_accuracy.svg"))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3400)
