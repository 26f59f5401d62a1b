"""All-pairs geodesics side by side with the peers: CPU time a source, error, and both ratios of the goal.

    python benchmarks/geodesics_table.py [3400 10000] [--json results/geodesics_table.json]

QGEO_DATA=folder adds a mesh of TOSCA. Our time is that of the whole matrix, the graph included, divided by n.
"""

from __future__ import annotations

import numpy as np
from geodesics_common import cases, cpu, exact_rows, peers, percent, relative_error
from record import Record, recorded

from qgeo_filters.compilation import warmup
from qgeo_filters.geodesics.matrix import distance_matrix

#: Kinds of mesh in README.md, which has fewer rows.
IN_SHORT = {
    "closed": "closed, irregular",
    "lifted, weight 0.03": "lifted plane, weight .03",
    "lifted, weight 0.3": "lifted plane, weight .3",
    "TOSCA cat0": "TOSCA cat0, remeshed",
}


def main(record: Record) -> None:
    """Print one table a mesh, one with the ratios, and the same in short."""
    warmup()
    ratios: dict[str, list[tuple[int, str, str, str, str, str]]] = {}
    for n in [int(x) for x in record.arguments] or [3400, 10000]:
        for name, mesh, surface, metric in cases(n):
            sources = np.random.default_rng(0).integers(0, len(mesh[0]), 8 if n < 5000 else 5)
            exact, slow = exact_rows(mesh, sources)
            matrix, seconds = cpu(lambda s=surface, m=metric or "cartesian": distance_matrix(s, m))
            seconds /= surface.n_vertices
            title = f"{name}, {surface.n_vertices} vertices"
            table = record.table(title, "method", "CPU ms a source", "mean error, %", "max error, %")
            rows = matrix[sources].astype(float)  # type: ignore[index]
            error = relative_error(rows, exact)
            heat = np.nan
            lines = [("pygeodesic (exact MMP)", np.zeros(1), slow), ("**qgeo-filters, graph**", error, seconds)]
            for peer, result, time in peers(mesh, sources):
                lines.append((peer, relative_error(result, exact), time))
                heat = time if peer == "potpourri3d heat, robust" else heat
            for peer, e, time in lines:
                table.row(peer, f"{1e3 * time:.3g}", percent(np.abs(e).mean()), percent(np.abs(e).max()))
            found = percent(error.mean()), percent(error.max()), f"{error.min():.0e}"
            ratios.setdefault(name, []).append(
                (surface.n_vertices, *found, f"{slow / seconds:.0f}", f"{heat / seconds:.1f}")
            )
    goals = ("mesh", "n", "mean / max error, %", "least error", "x pygeodesic", "x heat, robust")
    table = record.table("Against the goals", *goals)
    for place in range(max(map(len, ratios.values()))):
        for name, runs in ratios.items():
            for n, mean, largest, least, exact_ratio, heat_ratio in runs[place : place + 1]:
                table.row(name, n, f"{mean} / {largest}", least, exact_ratio, heat_ratio)
    columns = (
        "mesh",
        "vertices",
        "mean / largest error, %",
        "times as fast as pygeodesic",
        "as the robust heat method",
    )
    table = record.table("In short", *columns)
    for name, runs in ratios.items():
        sizes, means, largest, _, *speeds = zip(*runs, strict=True)
        errors = ", ".join(f"{mean} / {most}" for mean, most in zip(means, largest, strict=True))
        cells = [" / ".join(map(str, column)) for column in (sizes, *speeds)]
        table.row(IN_SHORT.get(name, name), cells[0], errors, *cells[1:])


if __name__ == "__main__":
    with recorded() as record:
        main(record)
