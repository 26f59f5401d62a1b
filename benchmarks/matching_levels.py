"""What each choice from coarse to fine does to errors and time of `match`, as a Markdown table.

    python benchmarks/matching_levels.py ROOT --pairs dog0-dog3 cat0-cat1 --only "as it is" [--json FILE]

ROOT as for ``matching.py``; pairs of the tuning categories by default. CPU seconds of all threads, everything included
but reading; errors are direct, mean over the vertices of X, in units of sqrt(area). The last column counts the pairs
for which the quick search left a doubt, so that all metrics and mirrored maps were tried as well.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

import numpy as np
from record import Record, recorded

import qgeo_filters as qg
from qgeo_filters.evaluation import ToscaRemeshed, geodesic_error
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.registration_stages import FINAL

GIVEN = MatchingParameters()
CHOICES = {
    "as it is": GIVEN,
    "search at 1500 vertices": replace(GIVEN, search_vertices=1500),
    "search at 3000 vertices": replace(GIVEN, search_vertices=3000),
    "finished at 2000 vertices": replace(GIVEN, registration_vertices=2000),
    "finished at 8000 vertices": replace(GIVEN, registration_vertices=8000),
    "the last stage alone at the end": replace(GIVEN, final=FINAL[1:]),
    "no quick search": replace(GIVEN, quick=False),
    "everything at full resolution, no quick search": replace(
        GIVEN, quick=False, search_vertices=1_000_000, registration_vertices=1_000_000
    ),
}
PAIRS = ["dog0-dog3", "cat0-cat1", "centaur0-centaur1", "dog6-dog2", "cat3-cat6", "centaur2-centaur4", "cat1-cat3"]
# What only the thorough search proposes.
_FIRST_METRIC = f"signs of eigenfunctions, curvature weight {GIVEN.curvature_weights[0]:g}"


def main(record: Record) -> None:
    """Print a row for each choice; each pair as it is done, as a comment."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--pairs", nargs="+", default=PAIRS, metavar="X-Y")
    parser.add_argument("--only", nargs="+", default=list(CHOICES), choices=list(CHOICES), metavar="CHOICE")
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    qg.warmup()
    rows = []
    for choice in arguments.only:
        errors, seconds, doubts = [], [], 0
        for pair in arguments.pairs:
            one, other = pair.split("-")
            x, y, truth = data.read(one), data.read(other), data.truth(one, other)
            started = time.process_time()
            found = qg.match(x, y, parameters=CHOICES[choice])
            seconds.append(time.process_time() - started)
            errors.append(float(geodesic_error(found.p2p[truth.points], truth.images, y).mean()))
            doubts += any(entry.proposed_by == _FIRST_METRIC for entry in found.log)
            print(f"<!-- {choice}, {pair}: {errors[-1]:.4f}, {seconds[-1]:.1f} s -->", flush=True)
        rows.append((choice, f"{np.mean(errors):.4f}", f"{max(errors):.4f}", f"{np.mean(seconds):.1f}", doubts))
    table = record.table("", "choice", "mean error", "worst pair", "CPU s a pair", "doubts", align="lrrrr")
    for row in rows:
        table.row(*row)
    record.note(f"{len(arguments.pairs)} pairs: {', '.join(arguments.pairs)}.")


if __name__ == "__main__":
    with recorded() as record:
        main(record)
