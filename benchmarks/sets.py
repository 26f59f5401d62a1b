"""Errors of `match` on all sets that are there, beside published ones, and whether it knows when it is wrong.

    python benchmarks/sets.py DATA --pairs 20 --processes 2 --store DIR [--sets smal_r faust_r] [--json FILE]

DATA holds a folder for each set, named as in `qgeo evaluate` (``faust_r``, ``pfarm`` ...; or ``topkids_like``,
``mouse_skulls_wrapped``), or ``tosca`` may be given by ``--tosca ROOT``. Of each category at most so many pairs are
taken, at random but always the same ones; each finished pair is kept in DIR. Errors are direct: mean geodesic distance
on Y to the true point over sqrt(area of Y), times 100 in the first table. "Mirrored": nearer to the mirrored truth,
where that is known. "Wrong" is a mean error above .1, "right" one below; the last table says how often each was called
sure. CPU seconds are those of the match alone, its shapes prepared, on one thread.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from record import Record, Table, machine, recorded

from qgeo_filters.evaluation import BENCHMARKS, PairFailure, PairResult, PairStore, Row, measured_in_processes
from qgeo_filters.evaluation.benchmarks import Benchmark
from qgeo_filters.evaluation.runner import by_target

#: Folders that are named otherwise than their benchmark.
FOLDERS = {"topkids_like": "topkids", "kids_r": "kids", "mouse_skulls_wrapped": "vts"}


def main(record: Record) -> None:
    """Print a row for each set as it is done, and at the end how far its own judgement can be trusted."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--tosca", type=Path)
    parser.add_argument("--sets", nargs="+")
    parser.add_argument("--pairs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--store", type=Path, required=True)
    arguments = parser.parse_args(record.arguments)
    print(f"{machine()}\n")
    errors = ("mean x 100", "median", "worst", "AUC", "coverage", "mirrored", "wrong", "sure", "CPU s")
    columns = ("set", "pairs", *errors, "published, no training: best", "trained: best")
    table = record.table("each set", *columns, align="l" + 12 * "r")
    everything: list[PairResult] = []
    for folder, benchmark in _sets(arguments.data, arguments.tosca).items():
        if arguments.sets is None or folder.name in arguments.sets:
            everything += _row(table, folder, benchmark, arguments)
    _reliability(record, everything)


def _sets(data: Path, tosca: Path | None) -> dict[Path, Benchmark]:
    """The folders that are sets, and what they are."""
    found = {tosca: BENCHMARKS["tosca"]} if tosca else {}
    for folder in sorted(data.iterdir()):
        name = FOLDERS.get(folder.name, folder.name)
        if folder.is_dir() and name in BENCHMARKS:
            found[folder] = BENCHMARKS[name]
    return found


def _row(table: Table, folder: Path, benchmark: Benchmark, arguments: argparse.Namespace) -> list[PairResult]:
    data = benchmark.read(folder)
    random = np.random.default_rng(arguments.seed)
    chosen = []
    for category in data.categories:
        pairs = list(data.pairs(category))
        some = random.choice(len(pairs), min(arguments.pairs, len(pairs)), replace=False)
        chosen += [pairs[i] for i in sorted(some)]
    store = PairStore(arguments.store / folder.name)
    results = []
    for outcome in measured_in_processes(
        data, by_target(chosen), store=store, partial=benchmark.partial, workers=arguments.processes
    ):
        if isinstance(outcome, PairFailure):
            print(f"<!-- {folder.name}, {outcome.name}: {outcome.reason} -->", flush=True)
            continue
        results.append(outcome)
        mean, sure = outcome.errors.direct.mean(), "sure" if outcome.confident else "not sure"
        print(f"<!-- {folder.name}, {outcome.name}: {mean:.4f}, {sure}, {outcome.seconds:.1f} s -->", flush=True)
    if not results:
        return []
    row = Row.of(folder.name, results)
    others = [min((one.error for one in benchmark.published if one.learned == kind), default=None)
              for kind in (False, True)]  # fmt: skip
    published = ["-" if error is None else f"{error:.1f}" for error in others]
    mirrored = str(row.n_mirrored) if row.handed else "?"
    found = (f"{100 * row.mean:.2f}", f"{100 * row.points.median:.2f}", f"{100 * row.worst:.1f}", f"{row.auc:.3f}",
             f"{100 * row.coverage:.0f} %", mirrored, row.n_failed, row.n_confident, f"{row.seconds:.1f}")  # fmt: skip
    table.row(folder.name, row.n_pairs, *found, *published)
    return results


def _reliability(record: Record, results: list[PairResult]) -> None:
    """How many of the maps called sure are wrong, and how many of the right ones are called sure."""
    wrong = np.array([result.failed for result in results])
    sure = np.array([result.confident for result in results])
    table = record.table("its own judgement", "called", "right", "wrong", "share that is wrong", align="lrrr")
    for name, called in (("sure", sure), ("not sure", ~sure)):
        share = f"{100 * wrong[called].mean():.1f} %" if called.any() else "-"
        table.row(name, int((called & ~wrong).sum()), int((called & wrong).sum()), share)
    if (~wrong).any():
        record.note(f"Of the right maps {100 * sure[~wrong].mean():.1f} % are called sure.")


if __name__ == "__main__":
    with recorded() as record:
        main(record)
