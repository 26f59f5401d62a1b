"""A plan for a collection of many shapes: what it costs, moves and keeps, and which pairs need not be matched.

    python benchmarks/collection_plan.py ROOT [--shapes 5] [--many 10000] [--workers 64] [--nearest 20] [--landmarks 20]
        [--json FILE]

ROOT is a folder of meshes, of which a few, evenly drawn, are prepared and matched with all parameters as they are, in
this process and one thread; what one shape and one pair cost is then multiplied. "Composed" is C_XY along the maps
through a landmark shape, which needs no match of the pair: with all shapes matched to L landmark shapes, those pairs
are matched whose composed C_XY is among the nearest of either shape. The triangle inequality gives a bound from
below for a distance; C_XY is measured along a map and need not be one: the script counts how often it holds. It also
counts how many of the nearest shapes in C_XY are met by the nearest ones of each cheap measure.
"""

from __future__ import annotations

import argparse
import itertools
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from record import Record, recorded

import qgeo_filters as qg
from qgeo_filters.collection.measures import spectral_distances
from qgeo_filters.io.folders import mesh_files
from qgeo_filters.parallel import default_workers, single_threaded_blas
from qgeo_filters.spectral.commutative import commutative_eigenspectra

DAY = 86_400


def bytes_in(folder: Path) -> tuple[int, int]:
    """Bytes and number of all files below a folder."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    return sum(path.stat().st_size for path in files), len(files)


def timed(action: Callable[[], Any]) -> tuple[Any, float]:
    """Result and CPU seconds of this process."""
    started = time.process_time()
    result = action()
    return result, time.process_time() - started


def nearest(square: np.ndarray, k: int) -> np.ndarray:
    """Whether each shape is among the k nearest of another, (m, m)."""
    found = np.zeros(square.shape, bool)
    order = np.argsort(square + np.where(np.eye(len(square), dtype=bool), np.inf, 0), axis=1)[:, :k]
    np.put_along_axis(found, order, True, axis=1)
    return found


def composed_c_xy(collection: qg.Collection, landmark: str) -> tuple[np.ndarray, float]:
    """C_XY of each two shapes along their maps through another one, (m, m), and CPU seconds a pair."""
    names = [name for name in collection.names if name != landmark]
    spectra = [collection.shape(name).full_spectrum for name in names]
    to = [collection.map(landmark, name) for name in names]
    found, seconds = np.zeros((len(names), len(names))), []
    for i, j in itertools.combinations(range(len(names)), 2):
        p2p = to[j].p2p[to[i].inverse]
        pair, cost = timed(lambda i=i, j=j, p2p=p2p: commutative_eigenspectra(spectra[i], spectra[j], p2p))
        found[i, j] = found[j, i] = pair.c_xy
        seconds.append(cost)
    return found, float(np.mean(seconds))


def measure(record: Record, files: list[Path], root: Path) -> dict[str, float]:
    """Costs of a shape and of a pair, measured on these; notes how well cheap measures stand for C_XY."""
    collection = qg.Collection(files, root / "store.zarr")
    m, pairs = len(collection), len(collection) * (len(collection) - 1) // 2
    per: dict[str, float] = {}
    _, seconds = timed(lambda: collection.prepare(workers=1))
    per["prepare"] = seconds / m
    per["shape bytes"], per["shape files"] = (v / m for v in bytes_in(collection.store.root / "shapes"))
    per["mesh bytes"] = bytes_in(collection.store.root / "surfaces")[0] / m
    _, seconds = timed(lambda: [collection.shape(name) for name in collection.names])
    per["restore"] = seconds / m
    collection.match(workers=1)
    first = collection.names[0]
    per["match"] = float(collection.table(seconds=True)["seconds"].mean())
    records = collection.store.root / "pairs"
    per["pair bytes"], per["pair files"] = (v / pairs for v in bytes_in(records))
    direct = collection.distances("c_xy").to_numpy()[1:, 1:]
    composed, per["composed"] = composed_c_xy(collection, first)
    values = list(np.random.default_rng(0).random((1000, 21)))  # whatever they are, they cost the same
    _, seconds = timed(lambda: spectral_distances("shape_dna", values))
    per["map-free"] = seconds / (len(values) * (len(values) - 1) / 2)
    upper = np.triu_indices(m - 1, 1)
    to_first = collection.distances("c_xy").to_numpy()[0, 1:]
    bound = np.abs(to_first[:, None] - to_first)
    sizes = [collection.surface(name).n_vertices for name in collection.names]
    record.note(f"Measured on {m} shapes of {min(sizes)} to {max(sizes)} vertices and their {pairs} pairs, one thread.")
    record.note(f"The bound |C_XL - C_YL| <= C_XY holds for {(bound <= direct)[upper].mean():.0%} of the pairs, and is "
                f"{np.median((bound / direct)[upper]):.2f} of C_XY in the median.")  # fmt: skip
    ratio = np.median((composed / direct)[upper])
    record.note(f"C_XY composed through {first} is {ratio:.2f} times that of the match in the median.")
    wanted = nearest(direct, 1)
    cheap = {"composed": composed, "bound": bound}
    cheap |= {name: collection.distances(name).to_numpy()[1:, 1:] for name in ("eigenvalues", "shape_dna")}
    table = record.table(
        "cheap measures", "nearest shape in C_XY", "is the nearest", "among the two nearest", align="lrr"
    )
    for name, square in cheap.items():
        met = [f"{(wanted & nearest(square, k)).sum() / wanted.sum():.0%}" for k in (1, 2)]
        table.row(f"by {name}", *met)
    return per


def plan(record: Record, per: dict[str, float], many: int, workers: int, k: int, landmarks: int) -> None:
    """A table of what so many shapes take: matched in all pairs, and where cheap measures come first."""
    pairs = many * (many - 1) // 2
    through = landmarks * many
    near = min(pairs, k * many)
    rows = [
        ("prepare shapes", many, per["prepare"], per["shape bytes"] + per["mesh bytes"], per["mesh bytes"]),
        ("map-free distances, all pairs", pairs, per["map-free"], 0.0, 0.0),
        ("match all pairs", pairs, per["match"], per["pair bytes"], traffic(per)),
        (f"match to {landmarks} landmark shapes", through, per["match"], per["pair bytes"], traffic(per)),
        ("C_XY composed through one of them, all pairs", pairs, per["composed"], 0.0, 0.0),
        (f"match the {k} nearest of each", near, per["match"], per["pair bytes"], traffic(per)),
    ]
    columns = ("tasks", "CPU s each", "CPU days", "days of the clock", "store", "traffic")
    table = record.table("plan", f"{many} shapes, {workers} workers", *columns, align="lrrrrrr")
    totals = {"all": np.zeros(3), "near": np.zeros(3)}
    for number, (what, tasks, each, kept, moved) in enumerate(rows):
        cost = np.array([tasks * each / DAY, tasks * kept, tasks * moved])
        days = (f"{cost[0]:.3g}", f"{cost[0] / workers:.3g}")
        table.row(what, f"{tasks:.3g}", f"{each:.3g}", *days, size(cost[1]), size(cost[2]))
        totals["all"] += cost * (number in (0, 2))
        totals["near"] += cost * (number != 2)
    for name, total in totals.items():
        what = "everything" if name == "all" else "the nearest only"
        days = (f"{total[0]:.3g}", f"{total[0] / workers:.3g}")
        table.row(f"**{what}**", "", "", *days, size(total[1]), size(total[2]))
    share = 1 - (through + near) / pairs
    record.note(f"{share:.1%} of the pairs need not be matched. A task of 8 pairs takes {8 * per['match']:.0f} s; "
                f"the scheduler sees two keys a pair ({64 * pairs / 1e9:.2g} GB for all), arrays go through the store. "
                f"Files: {per['shape files']:.0f} a shape, {per['pair files']:.0f} a pair.")  # fmt: skip


def traffic(per: dict[str, float]) -> float:
    """Bytes that a worker reads for a pair: its X, an eighth of the target that eight pairs share; and writes."""
    return (1 + 1 / 8) * (per["shape bytes"] + per["mesh bytes"]) + per["pair bytes"]


def size(count: float) -> str:
    """Bytes in a unit that is read easily."""
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if count < 1000 or unit == "TB":
            return f"{count:.3g} {unit}"
        count /= 1000
    raise AssertionError


def main(record: Record) -> None:
    """Measure, and print the plan."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path)
    parser.add_argument("--shapes", type=int, default=5)
    parser.add_argument("--many", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=64)
    parser.add_argument("--nearest", type=int, default=20)
    parser.add_argument("--landmarks", type=int, default=20)
    given = parser.parse_args(record.arguments)
    files = mesh_files(given.root)
    chosen = [files[number] for number in np.linspace(0, len(files) - 1, given.shapes).round().astype(int)]
    with tempfile.TemporaryDirectory() as folder, default_workers(1), single_threaded_blas, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        per = measure(record, chosen, Path(folder))
    print({name: float(f"{value:.3g}") for name, value in per.items()})
    plan(record, per, given.many, given.workers, given.nearest, given.landmarks)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
