"""What each part of `match` is worth: a row for each, without it, on a fixed sample of all sets.

    python benchmarks/ablation.py DATA --tosca ROOT --processes 2 [--pairs cat10-cat3 1-4]
        [--variants everything "one metric"] [--json FILE]

DATA and ROOT as for ``sets.py``. The pairs are those of `PAIRS`, easy ones and such as had been wrong: the means say
what a part does there, not how good the maps are. Errors are direct, mean over the points of truth, in units of
sqrt(area of Y); wrong is a mean above .1. Seconds are CPU time of the match alone, on one thread, self-symmetries
included.
"""

from __future__ import annotations

import argparse
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from record import Record, machine, recorded

import qgeo_filters as qg
from qgeo_filters.evaluation import ToscaRemeshed, VtsDataset, geodesic_error
from qgeo_filters.matching.parameters import MatchingParameters

PAIRS = [
    ("tosca", "dog6", "dog2"), ("tosca", "cat3", "cat6"), ("tosca", "cat10", "cat3"), ("tosca", "centaur0", "centaur1"),
    ("smal_r", "fox_alph", "MaleLion800"), ("smal_r", "lion_yawn", "Brown-And-White-Akita-Dog_alph"),
    ("tosca_nonisometric", "8_woman_02", "8_gorilla_05"), ("tosca_nonisometric", "8_gorilla_01", "8_man_06"),
    ("shrec19_r", "1", "4"), ("scape_r", "mesh055", "mesh058"), ("faust_r", "tr_reg_000", "tr_reg_051"),
    ("kids_r", "0001.null.0", "0002.isometry.5"), ("tosca_nonisometric", "8_woman_07", "8_gorilla_01"),
    ("tosca_nonisometric", "8_woman_07", "8_gorilla_05"), ("tosca_nonisometric", "8_woman_11", "8_gorilla_01"),
    ("tosca_nonisometric", "8_gorilla_05", "8_woman_07"), ("shrec19_r", "4", "30"),
]  # fmt: skip

ALL = MatchingParameters()
VARIANTS = {
    "everything": ALL,
    "no quick search first": replace(ALL, quick=False),
    "the quick search alone": replace(
        ALL, quick_margin=0.0, quick_alike=-9.0, quick_relief=-9.0, quick_distortion=9.0, quick_other_hand=0.0
    ),
    "one metric": replace(ALL, curvature_weights=ALL.curvature_weights[-1:]),
    "no matchings of extrema": replace(ALL, extrema_hypotheses=0),
    "unlike surroundings do not count in rankings": replace(ALL, unlike_counts=0.0),
    "costs at the end with the powers of before": replace(ALL, end_powers=ALL.reflection_end_powers),
    "rivals on trial not taken to their end": replace(ALL, doubtful_count=0),
    "ends of limbs not matched": replace(ALL, limb_margin=0.0),
    "contenders not guided by heat kernels": replace(ALL, hks_guided=ALL.coarse_to_fine),
}


def main(record: Record) -> None:
    """Print a row for each variant."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--tosca", type=Path, required=True)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--pairs", nargs="+", metavar="X-Y", help="these of the sample alone")
    parser.add_argument("--variants", nargs="+", choices=VARIANTS, default=list(VARIANTS), metavar="VARIANT")
    arguments = parser.parse_args(record.arguments)
    pairs = [pair for pair in PAIRS if arguments.pairs is None or "-".join(pair[1:]) in arguments.pairs]
    print(f"{machine()}\n")
    folders = [arguments.tosca if name == "tosca" else arguments.data / name for name, *_ in pairs]
    with ProcessPoolExecutor(arguments.processes, mp_context=get_context("spawn")) as pool:
        rows = []
        several = pool.map(measured, folders, pairs, [arguments.variants] * len(pairs))
        for pair, row in zip(pairs, several, strict=True):
            rows.append(row)
            print(f"<!-- {'-'.join(pair)}: {', '.join(f'{error:.4f}' for error, *_ in row)} -->", flush=True)
    table = np.array(rows, dtype=float)
    each = record.table("each pair", "pair", *arguments.variants, align="l" + "r" * len(arguments.variants))
    for pair, row in zip(pairs, rows, strict=True):
        each.row("-".join(pair[1:]), *(f"{error:.4f} {'sure' if sure else 'unsure'}" for error, sure, _ in row))
    found = record.table("all of them", "", "mean error", "wrong", "sure", "sure and wrong", "CPU s", align="lrrrrr")
    for place, name in enumerate(arguments.variants):
        error, sure, seconds = table[:, place].T
        wrong = error > 0.1
        cells = [name, f"{error.mean():.4f}", wrong.sum(), int(sure.sum()), int((wrong & (sure > 0)).sum())]
        found.row(*cells, f"{seconds.mean():.1f}")


def measured(folder: Path, pair: tuple[str, str, str], variants: list[str]) -> list[tuple[float, bool, float]]:
    """Error, whether it is sure of it, and seconds of each variant."""
    data = ToscaRemeshed(folder) if pair[0] == "tosca" else VtsDataset(folder)
    truth = data.truth(*pair[1:])
    given = [qg.PreparedShape(data.read(name)) for name in pair[1:]]
    surfaces = [one.full for one in given]
    there = [np.arange(one.given.n_vertices) if one.repair is None else one.repair.vertex_of_original for one in given]
    points, images = there[0][truth.points], there[1][truth.images]
    known = (points >= 0) & (images >= 0)
    rows = []
    for name in variants:
        x, y = (qg.PreparedShape(one, parameters=VARIANTS[name]).prepare() for one in surfaces)
        start = time.process_time()
        found = qg.match(x, y, partial=False, workers=1)
        seconds = time.process_time() - start
        error = geodesic_error(found.p2p[points[known]], images[known], surfaces[1], workers=1).mean()
        rows.append((float(error), found.confident, seconds))
    return rows


if __name__ == "__main__":
    with recorded() as record:
        main(record)
