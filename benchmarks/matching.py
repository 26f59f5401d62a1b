"""Errors of the map-free correspondence on independently triangulated poses of TOSCA, as a Markdown table.

    python benchmarks/matching.py ROOT --categories cat dog centaur --pairs 6 --store DIR [--json FILE]

ROOT holds ``remeshed``, ``ground_truth`` and ``symmetry`` (see `ToscaRemeshed`). With ``--pairs`` a random subset of
each category, the same in each run, is measured; all pairs without. With ``--store`` finished pairs are kept there,
and a run that was interrupted goes on. Errors are direct, in units of sqrt(area).
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from record import Record, recorded

from qgeo_filters.evaluation import ToscaRemeshed, markdown, rows_by_category
from qgeo_filters.evaluation.runner import PairFailure, PairStore, by_target, measured

TUNING = ("cat", "dog", "centaur")
TEST = ("horse", "michael", "victoria", "wolf")


def main(record: Record) -> None:
    """Print a row for each category and pool; each pair as it is done, as a comment."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--categories", nargs="+", default=[*TUNING, *TEST])
    parser.add_argument("--pairs", type=int, help="pairs of each category, drawn at random (seed 0); all by default")
    parser.add_argument("--store", type=Path, help="folder in which finished pairs are kept")
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    store = PairStore(arguments.store) if arguments.store else None
    results = []
    for category in arguments.categories:
        pairs = list(data.pairs(category))
        np.random.default_rng(0).shuffle(pairs)
        for result in measured(data, by_target(pairs[: arguments.pairs]), "match", store):
            if isinstance(result, PairFailure):
                raise result.error
            results.append(result)
            sure = "" if result.confident else ", not confident"
            print(f"<!-- {result.name}: {result.errors.direct.mean():.4f}{sure} -->", flush=True)
    record.markdown("", markdown(rows_by_category(results, {"tuning": TUNING, "test": TEST})))


if __name__ == "__main__":
    with recorded() as record:
        main(record)
