"""The paper's Tables 1, 2 and 3 and Figures 1, 5, 6 and 7, printed beside measured, and ten maps, in one folder.

    python benchmarks/paper.py --data ROOT --out DIR [--quick] [--parts table2 figure6 ...] [--json FILE]

ROOT holds TOSCA's ``remeshed``, ``ground_truth`` and ``symmetry`` and, for Table 1, ``lowres``. DIR gets ``paper.md``
and ``paper.html``, ``figures``, and ``stored``: results as they come, so that a run that was stopped goes on where it
was, and the pages grow with each part. After a change of the code take a new DIR. ``--quick``: two poses of cat, dog
and centaur, weights 0 and .01.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from paper_figures import fifth_figure, first_figure, seventh_figure, sixth_figure, ten_maps
from paper_maps import third_table
from paper_page import recorded_tables, write_page
from paper_study import GUIDED, TUNING, Study
from paper_tables import first_table, second_table
from record import Record, recorded

PARTS = {
    "table1": first_table,
    "table2": second_table,
    "figure1": first_figure,
    "figure5": fifth_figure,
    "figure7": seventh_figure,
    "table3": third_table,
    "figure6": sixth_figure,
    "maps": ten_maps,
}
CATEGORIES = (*TUNING, "horse", "victoria", "michael", "wolf")
WEIGHTS = (0.0, GUIDED, 0.03, 0.1)
SCALARS = ("curvedness", "gaussian_curvature", "shape_index", "differential_norm")
SCALAR_WEIGHTS = (0.01, 0.03, 0.1)


def main(record: Record) -> None:
    """Make the parts in turn, and the pages after each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, metavar="ROOT")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--quick", action="store_true", help="few poses and weights")
    parser.add_argument("--poses", type=int, default=3, help="of each category, evenly spread")
    parser.add_argument("--categories", nargs="+", default=list(CATEGORIES))
    parser.add_argument("--matches", type=Path, metavar="STORE", help="pairs kept by matching.py --store")
    parser.add_argument("--parts", nargs="+", choices=list(PARTS), default=list(PARTS))
    options = parser.parse_args(record.arguments)
    if options.quick:
        study = Study(options.data, options.out, TUNING, 2, (0.0, GUIDED), matches=options.matches)
    else:
        categories = tuple(options.categories)
        sweep = WEIGHTS, SCALARS, SCALAR_WEIGHTS
        study = Study(options.data, options.out, categories, options.poses, *sweep, options.matches)
    setting = (
        f"TOSCA, {study.poses} poses of each of {', '.join(study.categories)}, triangulated independently; made by "
        "benchmarks/paper.py."
    )
    parts = []
    for name in PARTS:
        if name in options.parts:
            parts.append(PARTS[name](study))
            write_page(options.out, parts, setting)
            print(f"{name}: {options.out / 'paper.html'}", flush=True)
    recorded_tables(record, parts)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
