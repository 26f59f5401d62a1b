"""Retrieval on TOSCA's nine categories of ``lowres``: nearest neighbour, first and second tier, mAP, as Markdown.

    python benchmarks/retrieval.py ROOT [--per-category 3] [--store DIR] [--c-xy]

ROOT holds ``lowres`` (``.vert`` and ``.tri``). The shapes are repaired where they need it, the groups are the
categories. Rows: ShapeDNA (the first 50 eigenvalues of the Laplace-Beltrami operator of the unit-area shape,
compared by the root mean square of their relative differences), by LaPy where it is installed and by
`laplacian_spectrum`; the first 20 eigenvalues of the quasi-geodesic distances in the same way; and with ``--c-xy``
C_XY of `match`, whose finished pairs are kept in DIR: one pair takes about as long as everything else of a shape.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
from itertools import combinations
from pathlib import Path

import numpy as np
from record import machine

import qgeo_filters as qg
from qgeo_filters.atomic import atomic_path
from qgeo_filters.errors import QgeoError
from qgeo_filters.evaluation import ToscaLowres, retrieval_scores
from qgeo_filters.hosts.dispatch import surface_and_repair
from qgeo_filters.surface import Surface

DNA, GAMMA = 50, 20


def dna(shape: Surface) -> np.ndarray:
    """Eigenvalues of the Laplacian of the unit-area shape, (50,), zero left out."""
    return qg.laplacian_spectrum(shape, DNA + 1).eigenvalues[1:] * shape.area


def dna_of_lapy(shape: Surface) -> np.ndarray:
    """The same from LaPy's linear finite elements."""
    from lapy import Solver, TriaMesh

    return Solver(TriaMesh(shape.vertices, shape.faces)).eigs(k=DNA + 1)[0][1:] * shape.area


def gamma(shape: Surface) -> np.ndarray:
    """Eigenvalues of the quasi-geodesic distances of the unit-area shape, (20,)."""
    return qg.distance_spectrum(shape, GAMMA, repair=True).eigenvalues / shape.area**1.5


def by_relative_difference(rows: np.ndarray) -> np.ndarray:
    """Root mean square of the relative differences of all pairs of rows, (m, m)."""
    size = 0.5 * (np.abs(rows)[:, None] + np.abs(rows)[None])
    return np.sqrt((((rows[:, None] - rows[None]) / size) ** 2).mean(axis=2))


def by_c_xy(shapes: dict[str, Surface], store: Path) -> np.ndarray:
    """C_XY of all pairs, (m, m), each kept in the store; infinite where there is no match."""
    store.mkdir(parents=True, exist_ok=True)
    prepared: dict[str, qg.PreparedShape] = {}
    names = list(shapes)
    square = np.zeros((len(names), len(names)))
    for i, j in combinations(range(len(names)), 2):
        x, y = names[i], names[j]
        file = store / f"{x}-{y}.json"
        if not file.is_file():
            for name in (x, y):
                if name not in prepared:
                    prepared[name] = qg.PreparedShape(shapes[name])
            try:
                value = qg.match(prepared[x], prepared[y]).c_xy
            except QgeoError as error:
                print(f"<!-- {x} - {y}: {error} -->", flush=True)
                value = float("inf")
            with atomic_path(file) as path:
                path.write_text(json.dumps(value))
        square[i, j] = square[j, i] = json.loads(file.read_text())
    return square


def main() -> None:
    """Print a row for each distance."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path)
    parser.add_argument("--per-category", type=int, help="the first so many of each; all by default")
    parser.add_argument("--store", type=Path, default=Path("retrieval-pairs"))
    parser.add_argument("--c-xy", action="store_true")
    arguments = parser.parse_args()
    data = ToscaLowres(arguments.root / "lowres")
    shapes = {}
    for category in data.categories:
        for name in data.names(category)[: arguments.per_category]:
            try:
                given, repair = surface_and_repair(data.read(name), "auto")
            except QgeoError as error:
                print(f"<!-- left out: {error} -->")
                continue
            shapes[name] = given if repair is None else repair.surface
    groups = [data.category(name) for name in shapes]
    squares = {
        "ShapeDNA, laplacian_spectrum": lambda: by_relative_difference(np.stack([dna(s) for s in shapes.values()]))
    }
    if importlib.util.find_spec("lapy"):
        squares["ShapeDNA, LaPy"] = lambda: by_relative_difference(np.stack([dna_of_lapy(s) for s in shapes.values()]))
    squares["eigenvalues of the distances"] = lambda: by_relative_difference(
        np.stack([gamma(s) for s in shapes.values()])
    )
    if arguments.c_xy:
        squares["C_XY of match"] = lambda: by_c_xy(shapes, arguments.store)
    print(f"{machine()}; {len(shapes)} shapes of {len(set(groups))} categories\n")
    print("| distance | nearest neighbour | first tier | second tier | mAP |")
    print("| --- | ---: | ---: | ---: | ---: |")
    for name, make in squares.items():
        found = retrieval_scores(make(), groups)
        scores = found.nearest_neighbor, found.first_tier, found.second_tier, found.mean_average_precision
        print(f"| {name} | {' | '.join(f'{100 * score:.1f}' for score in scores)} |", flush=True)


if __name__ == "__main__":
    main()
