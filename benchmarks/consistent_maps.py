"""Errors of all maps of shapes before and after synchronisation, and which pairs were found wrong, as Markdown.

    python benchmarks/consistent_maps.py ROOT --category victoria --store DIR [--json FILE]
    python benchmarks/consistent_maps.py faust_r --shapes 6 --store DIR

ROOT as for ``matching.py``, of which a category is taken; or a set of shapes that share a template (``NAME.off`` and
``corres/NAME.vts``). Of either at most so many shapes are taken, in the order of their names. Each pair is matched
once, the map back being that of the same match; finished matches are kept in DIR. Rows: maps as they were matched;
after wrong pairs were matched again (`mended_maps`); along the tree of least inconsistency; through the shape that
disagrees least; the middle of all ways (`synchronised_maps`) of the maps as matched. Errors are direct, in units of
sqrt(area), at nearest vertices; "wrong" is a mean above .1; "better" is the share of the maps with a lower error than
as matched.
"""

from __future__ import annotations

import argparse
import time
from itertools import combinations
from pathlib import Path

import numpy as np
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.collection.composition import Pair
from qgeo_filters.collection.cycles import cycle_consistency
from qgeo_filters.collection.mending import mended_maps
from qgeo_filters.collection.spanning_tree import spanning_tree, template_maps, tree_maps
from qgeo_filters.collection.synchronisation import synchronised_maps
from qgeo_filters.evaluation import ToscaRemeshed, geodesic_error
from qgeo_filters.evaluation.datasets import Dataset
from qgeo_filters.evaluation.template_datasets import VtsDataset

WRONG = 0.1


def opened(root: Path, category: str) -> tuple[Dataset, list[str]]:
    """A data set, and the shapes of it."""
    if (root / "remeshed").is_dir():
        tosca = ToscaRemeshed(root)
        return tosca, tosca.names(category)
    others = VtsDataset(root)
    return others, others.names()


def matched(data: Dataset, names: list[str], store: Path) -> dict[Pair, BarycentricMap]:
    """Maps in both directions of each pair, from the store or matched now."""
    store.mkdir(parents=True, exist_ok=True)
    prepared: dict[str, qg.PreparedShape] = {}
    maps = {}
    for x, y in combinations(names, 2):
        file = store / f"{x}-{y}.npz"
        if not file.is_file():
            for name in (x, y):
                if name not in prepared:
                    prepared[name] = qg.PreparedShape(data.read(name))
            qg.match(prepared[x], prepared[y]).to_npz(file)
        found = qg.MatchResult.from_npz(file)
        maps[x, y], maps[y, x] = found.barycentric, found.inverse_barycentric
    return maps


def errors(
    data: Dataset, names: list[str], shapes: dict[str, qg.Surface], rows: dict[str, dict[Pair, BarycentricMap]]
) -> dict[str, dict[Pair, float]]:
    """Mean error of each map of each row."""
    found: dict[str, dict[Pair, float]] = {row: {} for row in rows}
    for y in names:
        matrix = qg.distance_matrix(shapes[y])
        for x in names:
            if x != y:
                truth = data.truth(x, y)
                for row, maps in rows.items():
                    images = maps[x, y].nearest_corner[truth.points]
                    found[row][x, y] = float(geodesic_error(images, truth.images, shapes[y], matrix=matrix).mean())
    return found


def main(record: Record) -> None:
    """Print the table, and a line for each pair that was found wrong, or was wrong and not found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path)
    parser.add_argument("--category", default="victoria")
    parser.add_argument("--shapes", type=int)
    parser.add_argument("--store", type=Path, required=True)
    arguments = parser.parse_args(record.arguments)
    data, names = opened(arguments.root, arguments.category)
    names = sorted(names[: arguments.shapes])
    shapes = {name: data.read(name) for name in names}
    maps = matched(data, names, arguments.store)
    started = time.process_time()
    consistency = cycle_consistency(shapes, maps)
    print(f"<!-- cycles: {time.process_time() - started:.0f} CPU s -->", flush=True)
    mended, report = mended_maps(shapes, maps, consistency)
    print(f"<!-- and mending: {time.process_time() - started:.0f} CPU s -->", flush=True)
    tree = spanning_tree(names, dict(consistency.ranked()))
    middle = names[int(np.nanmean(consistency.inconsistency, axis=1).argmin())]
    rows = {
        "as matched": maps,
        "wrong pairs matched again": mended,
        "along the tree": tree_maps(shapes, maps, tree),
        f"through {middle}": template_maps(shapes, maps, middle),
        "middle of all ways": synchronised_maps(shapes, maps, consistency),
    }
    print(f"<!-- and all else: {time.process_time() - started:.0f} CPU s -->", flush=True)
    found = errors(data, names, shapes, rows)
    print(f"{machine()}; {names[0]} to {names[-1]}, {len(names)} shapes, {len(maps)} maps\n")
    table = record.table("", "maps", "mean", "median", "worst", "wrong", "better", align="lrrrrr")
    before = np.array(list(found["as matched"].values()))
    for row, of in found.items():
        values = np.array(list(of.values()))
        better = f"{100 * (values < before).mean():.0f} %" if row != "as matched" else ""
        cells = (f"{values.mean():.4f}", f"{np.median(values):.4f}", f"{values.max():.4f}")
        table.row(row, *cells, int((values > WRONG).sum()), better)
    print()
    for pair in report:
        key = pair.x, pair.y
        print(
            f"- {pair.x}-{pair.y}: inconsistency {pair.inconsistency:.3f}, error {found['as matched'][key]:.4f}; "
            f"{'mended' if pair.mended else 'named'}: {pair.explanation}, {pair.dearer:.2f} times the cost; "
            f"error {found['wrong pairs matched again'][key]:.4f}"
        )
    named = {frozenset((pair.x, pair.y)) for pair in report}
    missed = [k for k, error in found["as matched"].items() if error > WRONG and frozenset(k) not in named]
    print(f"- wrong and not found: {', '.join('-'.join(k) for k in missed) or 'none'}")
    right = [gap for pair, gap in consistency.ranked() if frozenset(pair) not in named]
    print(f"- largest inconsistency of the others: {max(right):.4f}")


if __name__ == "__main__":
    with recorded() as record:
        main(record)
