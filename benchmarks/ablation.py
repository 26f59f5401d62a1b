"""What each part of `match` is worth: a row for each, without it, on a fixed sample of all sets.

    python benchmarks/ablation.py DATA --tosca ROOT --processes 2 [--pairs cat10-cat3 1-4]
        [--variants everything "one metric"] [--store DIR] [--json FILE]

DATA and ROOT as for ``sets.py``. The pairs are those of `SAMPLE`, easy ones and such as had been wrong, or those that
are named, of `MORE` as well: the means say what a part does there, not how good the maps are. Errors are direct, mean
over the points of truth, in units of sqrt(area of Y); wrong is a mean above .1, worse and better an error that differs
from that of everything by more than .005. Seconds are CPU time of the match alone, on one thread, self-symmetries
included. What is measured is kept in DIR, one for each version, and not measured again.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from record import Record, machine, recorded
from sets import FOLDERS

import qgeo_filters as qg
from qgeo_filters.evaluation import BENCHMARKS, geodesic_error
from qgeo_filters.matching.parameters import MatchingParameters

SAMPLE = [
    ("tosca_nonisometric", "8_woman_02", "8_gorilla_05"), ("shrec19_r", "4", "14"), ("tosca", "cat10", "cat3"),
    ("faust_r", "tr_reg_000", "tr_reg_051"), ("smal_r", "fox_alph", "MaleLion800"), ("scape_r", "mesh055", "mesh058"),
    ("teeth", "H19", "J07"), ("kids_r", "0001.null.0", "0002.isometry.5"), ("topkids_like", "kid_5", "null"),
    ("tosca_nonisometric", "8_woman_07", "8_gorilla_01"), ("tosca", "dog6", "dog2"),
]  # fmt: skip
MORE = [
    ("tosca", "cat3", "cat6"), ("tosca", "centaur0", "centaur1"), ("shrec19_r", "1", "4"), ("shrec19_r", "4", "30"),
    ("smal_r", "lion_yawn", "Brown-And-White-Akita-Dog_alph"), ("tosca_nonisometric", "8_gorilla_01", "8_man_06"),
    ("tosca_nonisometric", "8_woman_07", "8_gorilla_05"), ("tosca_nonisometric", "8_woman_11", "8_gorilla_01"),
    ("tosca_nonisometric", "8_gorilla_05", "8_woman_07"),
]  # fmt: skip

ALL = MatchingParameters()
VARIANTS = {
    "everything": ALL,
    "the quick search alone": replace(
        ALL, quick_margin=0.0, quick_alike=-9.0, quick_relief=-9.0, quick_distortion=9.0, quick_other_hand=0.0
    ),
    "one metric": replace(ALL, curvature_weights=ALL.curvature_weights[-1:]),
    "unlike surroundings do not count in rankings": replace(ALL, unlike_counts=0.0),
    "the relief does not count in costs": replace(ALL, end_powers=(*ALL.end_powers[:2], 0.0, *ALL.end_powers[3:])),
    "rivals on trial not taken to their end": replace(ALL, doubtful_count=0),
    "ends of limbs not matched": replace(ALL, limb_margin=0.0),
    "contenders not guided by heat kernels": replace(ALL, hks_guided=ALL.coarse_to_fine),
    "what heat kernels led astray not taken back": replace(ALL, led_astray=float("inf")),
    "no quick search first": replace(ALL, quick=False),
}

Measured = tuple[float, bool, float]


def main(record: Record) -> None:
    """Print a row for each variant."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--tosca", type=Path, required=True)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--pairs", nargs="+", metavar="X-Y", help="these pairs alone, of both lists")
    parser.add_argument("--variants", nargs="+", choices=VARIANTS, default=list(VARIANTS), metavar="VARIANT")
    parser.add_argument("--store", type=Path)
    arguments = parser.parse_args(record.arguments)
    pairs = SAMPLE
    if arguments.pairs is not None:
        pairs = [pair for pair in SAMPLE + MORE if "-".join(pair[1:]) in arguments.pairs]
    print(f"{machine()}\n")
    folders = [arguments.tosca if name == "tosca" else arguments.data / name for name, *_ in pairs]
    alike = [[one] * len(pairs) for one in (arguments.variants, arguments.store)]
    with ProcessPoolExecutor(arguments.processes, mp_context=get_context("spawn")) as pool:
        rows = []
        for pair, row in zip(pairs, pool.map(measured, folders, pairs, *alike), strict=True):
            rows.append(row)
            print(f"<!-- {'-'.join(pair)}: {', '.join(f'{error:.4f}' for error, *_ in row)} -->", flush=True)
    table = np.array(rows, dtype=float)
    names = ["-".join(pair[1:]) for pair in pairs]
    each = record.table("each pair", "", *names, align="l" + "r" * len(names))
    for place, name in enumerate(arguments.variants):
        each.row(name, *(f"{row[place][0]:.4f} {'sure' if row[place][1] else 'unsure'}" for row in rows))
    columns = ("mean error", "wrong", "sure", "sure and wrong", "worse", "better", "CPU s")
    found = record.table("all of them", "", *columns, align="l" + "r" * len(columns))
    for place, name in enumerate(arguments.variants):
        error, sure, seconds = table[:, place].T
        wrong, change = error > 0.1, error - table[:, 0, 0]
        counts = (wrong, sure > 0, wrong & (sure > 0), change > 0.005, change < -0.005)
        found.row(name, f"{error.mean():.4f}", *(int(one.sum()) for one in counts), f"{seconds.mean():.1f}")


def measured(folder: Path, pair: tuple[str, str, str], variants: list[str], store: Path | None) -> list[Measured]:
    """Error, whether it is sure of it, and seconds of each variant."""
    file = None if store is None else store / f"{'-'.join(pair)}.json"
    kept = json.loads(file.read_text(encoding="utf-8")) if file is not None and file.is_file() else {}
    missing = [name for name in variants if name not in kept]
    for name, found in zip(missing, _measured(folder, pair, missing), strict=True):
        kept[name] = found
        if file is not None:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(json.dumps(kept), encoding="utf-8")
    return [tuple(kept[name]) for name in variants]


def _measured(folder: Path, pair: tuple[str, str, str], variants: list[str]) -> Iterator[Measured]:
    data = BENCHMARKS[FOLDERS.get(pair[0], pair[0])].read(folder)
    truth = data.truth(*pair[1:])
    given = [qg.PreparedShape(data.read(name)) for name in pair[1:]]
    surfaces = [one.full for one in given]
    there = [np.arange(one.given.n_vertices) if one.repair is None else one.repair.vertex_of_original for one in given]
    points, images = there[0][truth.points], there[1][truth.images]
    known = (points >= 0) & (images >= 0)
    shapes: dict[tuple[object, ...], list[qg.PreparedShape]] = {}
    qg.warmup()
    for name in variants:
        parameters = VARIANTS[name]
        alike = tuple(parameters.of_shape().values())
        if alike not in shapes:
            shapes[alike] = [qg.PreparedShape(one, parameters=parameters).prepare() for one in surfaces]
        start = time.process_time()
        found = qg.match(*shapes[alike], parameters=parameters, partial=False, workers=1)
        seconds = time.process_time() - start
        error = geodesic_error(found.p2p[points[known]], images[known], surfaces[1], workers=1).mean()
        yield float(error), bool(found.confident), seconds


if __name__ == "__main__":
    with recorded() as record:
        main(record)
