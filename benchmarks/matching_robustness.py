"""The map-free correspondence when one of the two poses is damaged or meshed otherwise, as a Markdown table.

    python benchmarks/matching_robustness.py ROOT --pairs cat0-cat3 dog0-dog3 centaur0-centaur2 [--json FILE]

ROOT as for ``matching.py``. X is a pose, Y another one of it, triangulated independently, and then changed (see
`matching_changes`). Errors are measured on Y before the change and in units of its sqrt(area), so that the ruler is
one for all rows; images are taken back there through the known origin of each vertex. Vertices of X whose
counterpart was cut away are not counted.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
from geodesics_common import cpu
from matching_changes import CHANGES, INVARIANT, Changed
from record import Record, recorded

import qgeo_filters as qg
from qgeo_filters.evaluation import ErrorSummary, ToscaRemeshed, symmetric_errors

#: A map that is worse than this and called confident is a fault of `qg.match`.
WRONG = 0.1


@dataclass(frozen=True, eq=False)
class Cell:
    """One match: for the table, for the log, and the image of each vertex of X on Y before the change."""

    text: str
    comment: str
    images: np.ndarray | None = None


def measured(x: qg.PreparedShape, y: qg.Surface, changed: Changed, truth: np.ndarray, mirror: np.ndarray) -> Cell:
    """Error of the map to the changed mesh, measured on the mesh before, and what `match` says of it."""
    try:
        found, seconds = cpu(lambda: qg.match(x, changed.surface))
    except (qg.MeshError, ValueError) as error:
        return Cell("refused", str(error))
    counted = np.flatnonzero(changed.there[truth])
    images = changed.origin[found.p2p[counted]]
    errors = symmetric_errors(images, truth[counted], mirror, y)
    summary = ErrorSummary.of(errors.direct)
    sure = "sure" if found.confident else "unsure"
    text = f"{summary.mean:.4f}, {100 * summary.below[0]:.1f} %, {found.score:.3f}, {sure}"
    # The best that any map could do, since the true image may not be a vertex.
    origins = np.unique(changed.origin)
    if len(origins) < len(changed.there):
        least = qg.distances(y, origins).min(axis=0)[truth[counted]].mean() / np.sqrt(y.area)
        text += f" (least possible {least:.4f})" if least > 1e-3 else ""
    if errors.mirrored:
        text += ", mirrored"
    if found.confident and summary.mean > WRONG:
        text += ", **wrongly sure**"
    comment = f"{found.explanation}; margin {found.margin:.2f}, {seconds:.1f} CPU s; {changed.note}"
    return Cell(text, comment, changed.origin[found.p2p])


def main(record: Record) -> None:
    """Print each match as it is done, as a comment; then a row for each change and a column for each pair."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root")
    parser.add_argument("--pairs", nargs="+", default=["cat0-cat3", "dog0-dog3", "centaur0-centaur2"])
    parser.add_argument("--changes", nargs="+", choices=CHANGES, default=list(CHANGES), metavar="CHANGE")
    arguments = parser.parse_args(record.arguments)
    data = ToscaRemeshed(arguments.root)
    table: dict[str, list[str]] = {name: [] for name in arguments.changes}
    for pair in arguments.pairs:
        one, other = pair.split("-")
        x, y = qg.PreparedShape(data.read(one)), data.read(other)
        truth, mirror = data.truth(one, other).images, data.symmetry(other).images
        first = None
        for seed, (name, change) in enumerate(CHANGES.items()):
            if name not in table:
                continue
            changed = change(y, np.random.default_rng(seed))
            cell = measured(x, y, changed, truth, mirror)
            first = cell.images if name == "unchanged" else first
            text = cell.text
            if name in INVARIANT and first is not None and cell.images is not None:
                text += f", {100 * (cell.images == first).mean():.1f} % the same"
            table[name].append(text)
            print(f"<!-- {pair}, {name}: {text}; {cell.comment} -->", flush=True)
    found = record.table("", "change of Y", *arguments.pairs)
    for name, cells in table.items():
        found.row(name, *cells)


if __name__ == "__main__":
    with recorded() as record:
        main(record)
