"""Retrieval on TOSCA's nine categories of ``lowres``: nearest neighbour, first and second tier, mAP, as Markdown.

    python benchmarks/retrieval.py ROOT [--store DIR] [--per-category 3] [--workers 1] [--json FILE]

ROOT holds ``lowres`` (``.vert`` and ``.tri``). The shapes are repaired where they need it, the groups are the
categories. Two tables. The first is of all shapes, by what needs no map: ShapeDNA (the first 50 eigenvalues of the
Laplace-Beltrami operator of the unit-area shape, compared by the root mean square of their relative differences), by
LaPy where it is installed and by `laplacian_spectrum`; and the first 20 eigenvalues of the geodesic distances
(`distance_spectrum`) in the same way. The second, with ``--store``, is of the first few shapes of each category, by
these and by `Collection.distances`: every pair is matched once (as whole shapes, orientation kept), and what is
finished stays in DIR, so that a run that was killed goes on.
"""

from __future__ import annotations

import argparse
import importlib.util
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.collection.settings import surface_key
from qgeo_filters.errors import QgeoError
from qgeo_filters.evaluation import ToscaLowres, retrieval_scores
from qgeo_filters.hosts.dispatch import surface_and_repair
from qgeo_filters.surface import Surface

DNA, GAMMA = 50, 20
# Names of `Collection.distances`, those that need no map last.
MEASURES = ("c_xy", "d_s", "distortion", "eigenvalues", "shape_dna")


def dna(shape: Surface) -> np.ndarray:
    """Eigenvalues of the Laplacian of the unit-area shape, (50,), zero left out."""
    return qg.laplacian_spectrum(shape, DNA + 1).eigenvalues[1:] * shape.area


def dna_of_lapy(shape: Surface) -> np.ndarray:
    """The same from LaPy's linear finite elements."""
    from lapy import Solver, TriaMesh

    return Solver(TriaMesh(shape.vertices, shape.faces)).eigs(k=DNA + 1)[0][1:] * shape.area


def gamma(shape: Surface) -> np.ndarray:
    """Eigenvalues of the geodesic distances of the unit-area shape, (20,): curvature has no sign on one-sided ones."""
    return qg.distance_spectrum(shape, GAMMA, metric="cartesian").eigenvalues / shape.area**1.5


def by_relative_difference(rows: np.ndarray) -> np.ndarray:
    """Root mean square of the relative differences of all pairs of rows, (m, m)."""
    size = 0.5 * (np.abs(rows)[:, None] + np.abs(rows)[None])
    return np.sqrt((((rows[:, None] - rows[None]) / size) ** 2).mean(axis=2))


def read(data: ToscaLowres) -> dict[str, Surface]:
    """All shapes that can be read, repaired where they need it; of equal ones the first."""
    shapes: dict[str, Surface] = {}
    first: dict[str, str] = {}
    for name in data.names():
        try:
            mesh = data.read(name)
            given, repair = surface_and_repair(mesh, "auto")
        except QgeoError as error:
            print(f"<!-- left out: {Path(str(error)).name} -->")
            continue
        same = first.setdefault(surface_key(mesh), name)
        if same != name:
            print(f"<!-- left out: {name} holds the same mesh as {same} -->")
            continue
        shapes[name] = given if repair is None else repair.surface
    return shapes


def sampled(fellows: Mapping[str, list[str]], shapes: Mapping[str, Surface], count: int) -> list[str]:
    """The first shapes of each category that can be matched: one-sided ones cannot."""
    chosen: list[str] = []
    for members in fellows.values():
        kept = 0
        for name in members:
            if kept == count:
                break
            try:
                qg.PreparedShape(shapes[name])
            except QgeoError as error:
                print(f"<!-- cannot be matched: {name}, {str(error)[:90]} ... -->")
                continue
            chosen.append(name)
            kept += 1
    return chosen


def by_eigenvalues(shapes: Mapping[str, Surface]) -> dict[str, np.ndarray]:
    """Squares of the distances that need no map, by name."""
    ways: dict[str, Callable[[Surface], np.ndarray]] = {"ShapeDNA, laplacian_spectrum, 50": dna}
    if importlib.util.find_spec("lapy"):
        ways["ShapeDNA, LaPy, 50"] = dna_of_lapy
    ways["distance_spectrum, 20"] = gamma
    rows = {name: np.stack([way(shape) for shape in shapes.values()]) for name, way in ways.items()}
    return {name: by_relative_difference(of_all) for name, of_all in rows.items()}


def table(record: Record, title: str, squares: Mapping[str, np.ndarray], groups: list[str]) -> None:
    """A row for each distance."""
    rows = record.table(title, "distance", "nearest neighbour", "first tier", "second tier", "mAP", align="lrrrr")
    for name, square in squares.items():
        found = retrieval_scores(square, groups)
        scores = found.nearest_neighbor, found.first_tier, found.second_tier, found.mean_average_precision
        rows.row(name, *(f"{100 * score:.1f}" for score in scores))


def by_maps(
    record: Record, shapes: Mapping[str, Surface], groups: dict[str, str], store: Path, workers: int
) -> dict[str, np.ndarray]:
    """Squares of all measures of a collection, all pairs matched."""
    collection = qg.Collection(shapes, store, groups=groups, partial=False, mirror="no")
    collection.match(workers=workers)
    status = collection.status()
    record.note(f"{status.matched} of {status.pairs} pairs matched, {status.seconds:.0f} CPU s.")
    found = collection.table()
    within = found.group_x == found.group_y
    sure = found.confident.fillna(False).astype(bool)
    record.note(
        f"Of {within.sum()} maps within a category {(sure & within).sum()} are sure, of {(~within).sum()} between two "
        f"{(sure & ~within).sum()}."
    )
    for problem in collection.problems:
        if problem.lost:
            print(f"<!-- {problem} -->")
    return {name: collection.distances(name).to_numpy() for name in MEASURES}


def main(record: Record) -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path)
    parser.add_argument("--store", type=Path, help="of the maps; without it none are sought")
    parser.add_argument("--per-category", type=int, default=3, help="of the second table: the first so many of each")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--without-first", action="store_true", help="print the second table only")
    arguments = parser.parse_args(record.arguments)
    data = ToscaLowres(arguments.root / "lowres")
    shapes = read(data)
    of = {name: data.category(name) for name in shapes}
    print(f"{machine()}; {len(shapes)} shapes of {len(data.categories)} categories\n")
    if not arguments.without_first:
        table(record, "all shapes", by_eigenvalues(shapes), list(of.values()))
    if arguments.store:
        fellows = {group: [name for name in shapes if of[name] == group] for group in data.categories}
        chosen = {name: shapes[name] for name in sampled(fellows, shapes, arguments.per_category)}
        groups = {name: of[name] for name in chosen}
        squares = by_maps(record, chosen, groups, arguments.store, arguments.workers)
        print(f"\n{len(chosen)} shapes: {', '.join(chosen)}\n")
        measures = {f"`{name}`": square for name, square in squares.items()} | by_eigenvalues(chosen)
        table(record, "shapes that were matched", measures, list(groups.values()))


if __name__ == "__main__":
    with recorded() as record:
        main(record)
