"""The correspondence without hints, with one landmark, and with three, as a Markdown table.

    python benchmarks/matching_hints.py ROOT --pairs tosca_nonisometric/8_gorilla_01-8_man_01 [--json FILE]

ROOT holds folders of shapes, NAME.off, with ``corres/NAME.vts``: a line for each point of truth, its vertex from 1; 0
where there is none. The pair is then FOLDER/X-Y, and line k of X corresponds to line k of Y. The landmarks are the
points of truth that are farthest on X: first the one of largest mean distance from the others, then each time the one
farthest from those before it, which for an animal are ends of limbs. Errors are geodesic, on Y, in units of sqrt(area),
over all points of truth; those of the landmarks themselves are a few of hundreds.

With ``--vertices N`` shapes are decimated first; a point of truth then is the nearest vertex that is left.
"""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

import numpy as np
from geodesics_common import cpu
from record import Record, machine, recorded
from scipy.spatial import cKDTree

import qgeo_filters as qg
from qgeo_filters.decimation import decimated
from qgeo_filters.evaluation import geodesic_error

#: Pairs on which a map that was found without hints is wrong, doubted, or neither.
PAIRS = [
    "tosca_nonisometric/8_gorilla_01-8_man_01",
    "tosca_nonisometric/8_gorilla_05-8_woman_07",
    "tosca_nonisometric/8_man_03-8_gorilla_05",
    "topkids_like/kid_3-null",
    "topkids_like/kid_14-null",
    "teeth/H16-J07",
    "teeth/Q04-x03",
    "shrec19_r/1-10",
]
#: A map whose mean error is above this is wrong.
WRONG = 0.1


def read(folder: Path, name: str, vertices: int | None) -> tuple[qg.Surface, np.ndarray]:
    """A shape, and its points of truth, (t,); -1 where there is none."""
    surface = qg.Surface.read(folder / f"{name}.off")
    points = np.loadtxt(folder / "corres" / f"{name}.vts", dtype=np.int64) - 1
    if vertices is None or surface.n_vertices <= vertices:
        return surface, points
    small = decimated(surface, vertices).surface
    nearest = cKDTree(small.vertices).query(surface.vertices)[1]
    return small, np.where(points >= 0, nearest[points], -1)


def ends(x: qg.Surface, points: np.ndarray, count: int) -> np.ndarray:
    """Places of the farthest points among those of truth."""
    between = qg.distances(x, points)[:, points]
    chosen = [int(between.mean(axis=1).argmax())]
    while len(chosen) < count:
        chosen.append(int(between[chosen].min(axis=0).argmax()))
    return np.array(chosen)


def main(record: Record) -> None:
    """Print a row for each pair."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path)
    parser.add_argument("--pairs", nargs="+", default=PAIRS, metavar="FOLDER/X-Y")
    parser.add_argument("--landmarks", nargs="+", type=int, default=[0, 1, 3], metavar="COUNT")
    parser.add_argument("--vertices", type=int, metavar="N")
    arguments = parser.parse_args(record.arguments)
    print(f"{machine()}\n")
    heads = [f"{count} landmark{'' if count == 1 else 's'}" if count else "no hints" for count in arguments.landmarks]
    table = record.table("", "pair", *heads, align="l" + len(heads) * "r")
    for pair in arguments.pairs:
        folder, _, names = pair.rpartition("/")
        cells, comments = [], []
        (x, here), (y, there) = (read(arguments.root / folder, name, arguments.vertices) for name in names.split("-"))
        known = (here >= 0) & (there >= 0)
        here, there = here[known], there[known]
        shapes = qg.PreparedShape(x), qg.PreparedShape(y)
        for shape in shapes:
            shape.prepare()
        places = ends(x, here, max(arguments.landmarks)) if max(arguments.landmarks) else np.zeros(0, dtype=np.int64)
        for count in arguments.landmarks:
            pairs = np.unique(np.column_stack([here, there])[places[:count]], axis=0)
            found, seconds = cpu(partial(qg.match, *shapes, landmarks=pairs if len(pairs) else None))
            errors = geodesic_error(found.p2p[here], there, y)
            mean = f"**{errors.mean():.3f}**" if errors.mean() > WRONG else f"{errors.mean():.3f}"
            cells.append(f"{mean} {'sure' if found.confident else 'unsure'}")
            comments.append(f"<!-- {pair}, {count}: {found.explanation}; {seconds:.1f} CPU s -->")
        table.row(pair, *cells)
        print("\n".join(comments), flush=True)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
