"""All-pairs geodesics side by side with the peers: CPU time a source, error, and both ratios of the goal.

    python benchmarks/geodesics_table.py [3400 10000] > table.md

QGEO_DATA=folder adds a mesh of TOSCA. Our time is that of the whole matrix, the graph included, divided by n.
"""

from __future__ import annotations

import sys

import numpy as np
from geodesics_common import cases, cpu, exact_rows, machine, peers, percent, relative_error

from qgeo_filters.compilation import warmup
from qgeo_filters.geodesics.matrix import distance_matrix


def main(sizes: list[int]) -> None:
    """Print one table a size, and one with the ratios."""
    warmup()
    print(f"Machine: {machine()}\n")
    ratios = [
        "| mesh | n | mean / max error, % | least error | x pygeodesic | x heat, robust |",
        "|---|---|---|---|---|---|",
    ]
    for n in sizes:
        for name, mesh, surface, metric in cases(n):
            sources = np.random.default_rng(0).integers(0, len(mesh[0]), 8 if n < 5000 else 5)
            exact, slow = exact_rows(mesh, sources)
            matrix, seconds = cpu(lambda s=surface, m=metric: distance_matrix(s, m))
            seconds /= surface.n_vertices
            print(f"**{name}, {surface.n_vertices} vertices**\n")
            print("| method | CPU ms a source | mean error, % | max error, % |\n|---|---|---|---|")
            rows = matrix[sources].astype(float)  # type: ignore[index]
            error = relative_error(rows, exact)
            heat = np.nan
            lines = [("pygeodesic (exact MMP)", np.zeros(1), slow), ("**qgeo-filters, graph**", error, seconds)]
            for peer, result, time in peers(mesh, sources):
                lines.append((peer, relative_error(result, exact), time))
                heat = time if peer == "potpourri3d heat, robust" else heat
            for peer, e, time in lines:
                mean, largest = percent(np.abs(e).mean()), percent(np.abs(e).max())
                print(f"| {peer} | {1e3 * time:.3g} | {mean} | {largest} |")
            print(flush=True)
            errors = f"{percent(error.mean())} / {percent(error.max())} | {error.min():.0e}"
            ratios.append(f"| {name} | {surface.n_vertices} | {errors} | {slow / seconds:.0f} | {heat / seconds:.1f} |")
    print("**Against the goals** (mean <= .03 %, max <= .3 %, >= 150x pygeodesic, >= 2x robust heat)\n")
    print("\n".join(ratios))


if __name__ == "__main__":
    main([int(x) for x in sys.argv[1:]] or [3400, 10000])
