"""Errors of the map-free correspondence on independently triangulated poses of TOSCA, as a Markdown table.

    python benchmarks/matching.py ROOT --categories cat dog centaur --pairs 6

ROOT holds ``remeshed``, ``ground_truth`` and ``symmetry`` (see `ToscaRemeshed`). With ``--pairs`` a random subset of
each category, the same in each run, is measured; all pairs without. Errors are direct, in units of sqrt(area).
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from qgeo_filters.evaluation import PairResult, ToscaRemeshed, markdown, rows_by_category, symmetric_errors
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.descriptor import Descriptor

TUNING = ("cat", "dog", "centaur")
TEST = ("horse", "michael", "victoria", "wolf")


def main() -> None:
    """Print a row for each category and pool; each pair as it is done, as a comment."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--categories", nargs="+", default=[*TUNING, *TEST])
    parser.add_argument("--pairs", type=int, help="pairs of each category, drawn at random (seed 0); all by default")
    arguments = parser.parse_args()
    data = ToscaRemeshed(arguments.root)
    results = []
    for category in arguments.categories:
        pairs = list(data.pairs(category))
        np.random.default_rng(0).shuffle(pairs)
        shapes: dict[str, Descriptor] = {}
        for x, y in pairs[: arguments.pairs]:
            for name in (x, y):
                if name not in shapes:
                    shapes[name] = Descriptor(data.read(name)).prepared()
            start = time.process_time()
            found = match(shapes[x], shapes[y])
            seconds = time.process_time() - start
            truth, mirror = data.truth(x, y), data.symmetry(y)
            errors = symmetric_errors(found.p2p[truth.points], truth.images, mirror.images, shapes[y].surface)
            results.append(PairResult(f"{x} - {y}", category, errors, found.confident, seconds))
            print(f"<!-- {x} - {y}: {errors.direct.mean():.4f}, {found.explanation} -->", flush=True)
    print(markdown(rows_by_category(results, {"tuning": TUNING, "test": TEST})))


if __name__ == "__main__":
    main()
