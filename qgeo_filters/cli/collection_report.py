"""``qgeo collection report`` and ``export``: the tables of a store, with each pair one click away."""

from __future__ import annotations

import math
import re
from functools import partial as applied
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from qgeo_filters.cli.options import Json, Output, Pictures, Quiet, Settings
from qgeo_filters.errors import ParameterError

if TYPE_CHECKING:
    from qgeo_filters.cli.job import Job
    from qgeo_filters.collection.collection import Collection

_TABLE, _PAGE = "table.csv", "pair_{}.html"
_MOST_PAGES = 200
# Shapes up to which maps are compared with those through all others: a minute or two.
_COMPARED = 30
_SHOWN = ("c_xy", "d_s", "distortion", "confident", "margin")


def report(
    store: Annotated[Path, typer.Argument(metavar="STORE", help="What build made.", show_default=False)],
    pages: Annotated[
        int, typer.Option("--pages", metavar="N", help="Pairs that get a page of their own: the least sure first.")
    ] = _MOST_PAGES,
    output: Output = None,
    pictures: Pictures = True,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Write report.html: the table of all pairs, distances of the shapes, and a page for each pair with its pictures.

    table.csv: a row for each pair. result.npz: c_xy (m, m), d_s (m, m), distortion (m, m), eigenvalues (m, m),
    shape_dna (m, m), names (m,), NaN where a pair is not matched.
    """
    from qgeo_filters.cli.job import Job
    from qgeo_filters.collection.collection import Collection
    from qgeo_filters.report.html import Table

    collection = Collection.open(store)
    table = collection.table()
    if pages < 0:
        raise ParameterError(f"--pages must not be negative, got {pages}")
    # The least sure ones first: who reads the report looks for those.
    order = table.assign(_margin=table["margin"].fillna(-math.inf)).sort_values(["confident", "_margin"], kind="stable")
    chosen = [(row.x, row.y) for row in order.itertuples() if not row.problem][:pages]
    names = _page_names(chosen)
    parameters = {"store": str(store), "pages": pages, **collection.settings.to_json()}
    settings = Settings(output, quiet, json, pictures=pictures)
    drawn = _collection_pictures(collection)
    texts = (_TABLE, *names.values())
    job = Job("collection report", settings, parameters, pictures=drawn, texts=texts, about=[store.stem])
    job.subject = f"{len(collection)} shapes in {store}"
    squares = _squares(collection)
    _save(job, collection, squares)
    for name, (caption, draw) in drawn.items():
        job.picture(name, caption, draw)
    for pair in chosen:
        with job.stage(f"{pair[0]} - {pair[1]}"):
            _write_page(job, collection, pair, names[pair], pictures)
    job.seconds = {"all pages": round(sum(job.seconds.values()), 3)}
    rows = [_row(row, names.get((row["x"], row["y"]))) for row in order.to_dict("records")]
    left = len(rows) - len(names)
    note = f"{left} pairs have no page: --pages takes more, or they cannot be matched." if left else ""
    with job.stage("maps through third shapes"):
        against = _contradictions(collection)
    contradictions = Table(
        "Maps that contradict those through other shapes, in √area",
        against,
        note="Collection.mended() matches them again, and keeps what it finds in the store.",
    )
    wrong = [(problem.subject, problem.reason) for problem in collection.problems]
    job.finish(
        [
            Table("Pairs, the least sure first", rows, ("pair", *_SHOWN, "why"), note),
            *([contradictions] if against else []),
            *([Table("Worth a look", wrong)] if wrong else []),
        ]
    )


def _row(row: dict[str, Any], page: str | None) -> tuple[Any, ...]:
    """Cells of a pair in the table of the report."""
    from qgeo_filters.report.html import Link

    title = f"{row['x']}\u00a0- {row['y']}"
    values = (row[name] if isinstance(row[name], bool) else _number(row[name]) for name in _SHOWN)
    return (Link(title, page) if page else title, *values, row["problem"] or row["explanation"])


def export(
    store: Annotated[Path, typer.Argument(metavar="STORE", help="What build made.", show_default=False)],
    output: Output = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Write the tables of a store as CSV: a row for each pair, and the distances of the shapes as labelled squares.

    table.csv, c_xy.csv, d_s.csv, distortion.csv, and, of prepared shapes, eigenvalues.csv and shape_dna.csv.
    """
    from qgeo_filters.cli.job import Job
    from qgeo_filters.collection.collection import Collection

    collection = Collection.open(store)
    squares = _squares(collection)
    files = [_TABLE, *(f"{name}.csv" for name in squares)]
    settings = Settings(output, quiet, json, pictures=False)
    job = Job("collection export", settings, {"store": str(store), **collection.settings.to_json()}, texts=files)
    job.subject = f"{len(collection)} shapes in {store}"
    _save(job, collection, squares)
    for name, square in squares.items():
        job.text(f"{name}.csv", square.to_csv())
    job.finish()


def _squares(collection: Collection) -> dict[str, Any]:
    """Labelled squares of all measures that the store has the shapes for."""
    from qgeo_filters.collection.measures import MEASURES, OF_MAPS

    ready = collection.status()
    prepared = ready.prepared + ready.unprepared == ready.shapes
    return {name: collection.distances(name) for name in MEASURES if name in OF_MAPS or prepared}


def _save(job: Job, collection: Collection, squares: dict[str, Any]) -> None:
    import numpy as np

    status = collection.status()
    results = {
        "shapes": status.shapes,
        "groups": len(set(collection.groups.values()) - {""}),
        "prepared": status.prepared,
        "pairs": status.pairs,
        "matched": status.matched,
        "confident": status.confident,
        "not_matched": status.failed,
        "matched_again": status.matched_again,
        "cpu_seconds": status.seconds,
    }
    arrays = {name: square.to_numpy() for name, square in squares.items()}
    job.save(results, {**arrays, "names": np.array(collection.names)})
    job.text(_TABLE, collection.table().to_csv(index=False))


def _collection_pictures(collection: Collection) -> dict[str, tuple[str, Any]]:
    """Pictures of the whole collection: name, caption and what draws it."""
    from qgeo_filters.report.collection_charts import plot_dendrogram, plot_embedding, plot_heat_map

    groups = collection.groups if any(collection.groups.values()) else None
    square = collection.distances("c_xy")
    label = "C_XY (no unit)"
    meaning = "C_XY of each two shapes: 0 where they have the same eigenfunctions"
    drawn: dict[str, tuple[str, Any]] = {
        "c_xy": (f"{meaning}; grey: not matched.", applied(plot_heat_map, square, groups, label=label))
    }
    if len(square) < 3:
        return drawn
    by = "C_XY"
    if square.isna().to_numpy().any():
        ready = collection.status()
        if ready.prepared < ready.shapes:
            return drawn
        # Of pairs that are not matched there is what needs no map.
        square, by = collection.distances("shape_dna"), "eigenvalues of the Laplacian (not all pairs are matched)"
        label = "distance of eigenvalues (no unit)"
    caption = f"The shapes by {by}: those that join early are near to each other."
    drawn["dendrogram"] = (caption, applied(plot_dendrogram, square, groups, label=label))
    caption = f"The shapes in the plane, as far from each other as {by} says, as well as can be."
    drawn["embedding"] = (caption, applied(plot_embedding, square, groups, label=label))
    return drawn


def _contradictions(collection: Collection) -> list[tuple[str, float]]:
    """Pairs whose map contradicts those through other shapes, and how much; none for what would take hours."""
    if not 2 < len(collection) <= _COMPARED:
        return []
    consistency = collection.consistency()
    return [(f"{x}\u00a0- {y}", consistency.of(x, y)) for x, y in consistency.wrong()]


def _page_names(pairs: list[tuple[str, str]]) -> dict[tuple[str, str], str]:
    """File of each pair: its names, as far as files can be called so."""
    from qgeo_filters.cli.job_text import numbered

    plain = [re.sub(r"[^\w.-]+", "_", f"{x}--{y}") for x, y in pairs]
    return dict(zip(pairs, (_PAGE.format(name) for name in numbered(plain)), strict=True))


def _write_page(job: Job, collection: Collection, pair: tuple[str, str], name: str, pictures: bool) -> None:
    from qgeo_filters import __version__
    from qgeo_filters.cli.match import match_results
    from qgeo_filters.cli.match_pictures import map_pictures
    from qgeo_filters.report.html import Link, Table, write_report

    found = collection.map(*pair)
    drawn = map_pictures(found, pair) if pictures else []
    with job.file(name) as temporary:
        write_report(
            temporary,
            f"{pair[0]} - {pair[1]}",
            subtitle=f"A pair of {collection.store.root}",
            pictures=drawn,
            tables=[
                Table.explained("Results", match_results(found)),
                Table.of("Collection", {"all pairs": Link("report.html", "report.html")}),
            ],
            footer=f"qgeo-filters {__version__}. The map itself: Collection.open(...).map({pair[0]!r}, {pair[1]!r}).",
        )


def _number(value: Any) -> float | None:
    return None if math.isnan(value) else float(value)
