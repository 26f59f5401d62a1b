"""``qgeo evaluate``: errors of the maps over a data set with known truth."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial as applied
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from qgeo_filters.cli.kept import Cache
from qgeo_filters.cli.options import Json, Output, Pictures, Quiet, Settings, Workers
from qgeo_filters.errors import ParameterError

if TYPE_CHECKING:
    from qgeo_filters.cli.job import Job
    from qgeo_filters.evaluation import Dataset, PairResult, Row
    from qgeo_filters.evaluation.benchmarks import Benchmark
    from qgeo_filters.evaluation.runner import PairFailure
    from qgeo_filters.report.html import Table

# Pairs in the table of the worst.
_WORST = 10

#: Names of `evaluation.benchmarks.BENCHMARKS`.
Name = Literal[
    "tosca", "faust_r", "scape_r", "shrec19_r", "smal_r", "dt4d", "topkids", "shrec16_cuts", "shrec16_holes", "pfarm",
    "kids", "tosca_nonisometric", "teeth", "indexed", "vts", "shrec19",
]  # fmt: skip


def evaluate(
    dataset: Annotated[
        Name,
        typer.Argument(
            metavar="DATASET",
            help="A public benchmark (tosca, faust_r, scape_r, shrec19_r, smal_r, dt4d, topkids, shrec16_cuts, "
            "shrec16_holes, pfarm, kids, tosca_nonisometric, teeth), or a layout: indexed (equal vertex numbers), "
            "vts (off/, corres/), shrec19 (off/, groundtruth/).",
            show_default=False,
        ),
    ],
    root: Annotated[Path, typer.Option("--root", metavar="DIR", help="Folder of the data set.", show_default=False)],
    what: Annotated[Literal["match", "symmetry"], typer.Option("--what", help="The maps that are judged.")] = "match",
    pairs: Annotated[
        int | None, typer.Option("--pairs", metavar="N", help="At most so many pairs, or shapes, of a category.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", help="Of the choice of pairs.")] = 0,
    category: Annotated[list[str] | None, typer.Option("--category", help="Only this one; may be repeated.")] = None,
    processes: Annotated[
        int, typer.Option("--processes", metavar="N", help="Pairs at a time, each in a process of one thread.", min=1)
    ] = 1,
    workers: Workers = None,
    cache: Cache = True,
    output: Output = None,
    pictures: Pictures = True,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Measure the error of matches, or of symmetry maps, against the truth, as a table by category.

    Errors are direct (Princeton protocol), in units of sqrt(area); seconds are CPU time without what belongs to one
    shape alone. Of a public benchmark the test pairs are taken, where the folder holds its test shapes, and published
    errors of others stand beside ours. Parts (shrec16, pfarm) are matched as such: errors are those of points that
    were given an image. Each pair is kept in DIR/pairs once it is finished: the same command goes on where it was
    interrupted. A pair that cannot be measured is named, and the rest goes on; the exit code is then 1.

    The table is also in table.md. result.npz: errors of all points, pair (which pair each belongs to).
    """
    import numpy as np

    from qgeo_filters.cli.job import Job
    from qgeo_filters.evaluation import markdown, rows_by_category
    from qgeo_filters.evaluation.benchmarks import BENCHMARKS
    from qgeo_filters.evaluation.processes import measured_in_processes
    from qgeo_filters.evaluation.runner import PairFailure, PairStore, by_target, measured
    from qgeo_filters.report.curves import plot_error_curve

    if pairs is not None and pairs < 1:
        raise ParameterError(f"--pairs must be at least 1, got {pairs}")
    parameters = {"dataset": dataset, "root": str(root), "what": what, "pairs": pairs, "seed": seed}
    if not root.is_dir():
        raise NotADirectoryError(f"--root: {root} is not a folder")
    benchmark = BENCHMARKS[dataset]
    data = benchmark.read(root)
    job = Job(
        "evaluate",
        Settings(output, quiet, json, pictures=pictures),
        {**parameters, "category": category or "all"},
        inputs=data.files.values(),
        pictures=("error_curve", "worst_map"),
        texts=("table.md",),
        about=(dataset, *(() if what == "match" else (what,))),
    )
    job.subject = f"{what} on {dataset}"
    store = PairStore(job.folder / "pairs")
    found: list[PairResult] = []
    failures: list[PairFailure] = []
    run = measured if processes == 1 else applied(measured_in_processes, workers=processes)
    for name in _categories(data, category):
        every = list(data.pairs(name)) if what == "match" else [(one, one) for one in data.names(name)]
        some = by_target(_chosen(every, pairs, seed))
        with job.stage(name):
            for outcome in run(data, some, what, store, partial=benchmark.partial and what == "match"):
                if isinstance(outcome, PairFailure):
                    failures.append(outcome)
                    typer.echo(f"qgeo: {outcome.name}: {outcome.reason}", err=True)
                else:
                    found.append(outcome)
                    if job.shows_progress:
                        typer.echo(f"  {outcome.name}: mean error {outcome.errors.direct.mean():.4f}", err=True)
    if not found:
        raise failures[0].error if failures else ParameterError(f"{root}: no two shapes of one category")
    if store.reused and not quiet:
        typer.echo(f"{store.reused} of {len(found)} results are those of an earlier run, in {store.folder}", err=True)
    rows = rows_by_category(found)
    direct = [result.errors.direct for result in found]
    results = {
        "pairs": len(found),
        "not_measured": len(failures),
        "mean_error": rows[-1].mean,
        "failed": rows[-1].n_failed,
        "mirrored": rows[-1].n_mirrored if what == "match" and rows[-1].handed else None,
        "auc": rows[-1].auc,
        "coverage": rows[-1].coverage,
        "mapped": rows[-1].mapped,
        "confident": rows[-1].n_confident,
        "published": [asdict(one) for one in benchmark.published] if what == "match" else [],
        "rows": [
            {
                "name": one.name,
                "mean": float(one.errors.direct.mean()),
                "mirrored": one.errors.mirrored if one.handed else None,
                "coverage": one.coverage,
                "mapped": one.mapped,
                "confident": one.confident,
                "seconds": one.seconds,
            }
            for one in found
        ],
        "reasons": [{"name": one.name, "reason": one.reason} for one in failures],
    }
    owner = np.repeat(np.arange(len(found)), [len(errors) for errors in direct])
    job.save(results, {"errors": np.concatenate(direct), "pair": owner})
    job.text("table.md", markdown(rows) + "\n")
    others = benchmark.published if what == "match" else ()
    job.picture(
        "error_curve",
        "Share of all points within an error (PCK curve)"
        + ("; lines: mean errors, of this run and published ones of all test pairs." if others else "."),
        lambda: plot_error_curve(
            np.concatenate(direct), label=f"{what}, AUC {rows[-1].auc:.3f}", mean=rows[-1].mean, published=others
        ),
    )
    _draw_worst(job, data, max(found, key=lambda one: float(one.errors.direct.mean())), what)
    tables = _tables(rows, found, failures, what)
    if what == "match" and benchmark.published:
        tables.insert(1, _beside_others(benchmark, rows[-1]))
    job.finish(tables)
    if failures:
        raise typer.Exit(1)


def _tables(rows: list[Row], found: list[PairResult], failures: list[PairFailure], what: str) -> list[Table]:
    """Errors by category, those of the worst pairs, and what could not be measured."""
    from qgeo_filters.evaluation.errors import AUC_UP_TO, FAILED, THRESHOLDS
    from qgeo_filters.report.html import Table

    number = "pairs" if what == "match" else "shapes"
    within = [f"≤ {threshold:g}" for threshold in THRESHOLDS]
    columns = ("category", number, "mean", "median", *within, "AUC", "coverage", "mirrored", "failed", "sure", "CPU s")
    lines = [
        (
            row.label,
            row.n_pairs,
            f"{row.mean:.4f}",
            f"{row.points.median:.4f}",
            *(f"{share:.1%}" for share in row.points.below),
            f"{row.auc:.3f}",
            f"{row.coverage:.1%}",
            row.n_mirrored if what == "match" and row.handed else None,
            row.n_failed,
            row.n_confident,
            f"{row.seconds:.1f}",
        )
        for row in rows
    ]
    note = (
        f"Shares are of all points; AUC: area under their curve up to {AUC_UP_TO:g}; coverage: share of the area of Y "
        f"that is reached. Mirrored, failed (a mean above {FAILED:g}), sure: numbers of {number}."
    )
    tables = [Table("Errors in units of sqrt(area)", lines, columns, note)]
    worst = sorted(found, key=lambda one: -float(one.errors.direct.mean()))[:_WORST]
    sure = "confident" if what == "match" else "found"
    tables.append(
        Table(
            f"The worst {number}",
            [
                (one.name, f"{one.errors.direct.mean():.4f}", f"{one.errors.direct.max():.3f}", one.confident)
                for one in worst
            ],
            (number[:-1], "mean", "largest", sure),
        )
    )
    if failures:
        reasons = [(one.name, one.reason) for one in failures]
        tables.append(Table("Not measured", reasons, (number[:-1], "reason")))
    return tables


def _beside_others(benchmark: Benchmark, row: Row) -> Table:
    """Our mean error beside published ones, in the unit of the field."""
    from qgeo_filters.report.html import Table

    others = sorted(benchmark.published, key=lambda one: (one.learned, -one.error))
    lines = [(one.method, "trained" if one.learned else "not trained", f"{one.error:.1f}") for one in others]
    lines.append(("this run", "not trained", f"{100 * row.mean:.1f}"))
    note = f"{benchmark.title}. Published figures are those of all of its test pairs; this run took {row.n_pairs}."
    return Table("Mean geodesic error over sqrt(area), x 100", lines, ("method", "on shapes of the set", "error"), note)


def _draw_worst(job: Job, data: Dataset, worst: PairResult, what: str) -> None:
    """Picture of the map with the largest mean error."""
    from qgeo_filters.cli.job_text import as_title
    from qgeo_filters.report.maps import plot_correspondence, plot_symmetry, view_alike
    from qgeo_filters.report.view import best_view

    caption = f"The worst map, {worst.name}: mean error {worst.errors.direct.mean():.4f}. Points of one colour match."
    if what == "symmetry":
        surface = data.read(worst.name.removeprefix("symmetry of "))
        job.picture("worst_map", caption, applied(plot_symmetry, surface, p2p=worst.p2p))
        return
    names = next(pair for pair in data.pairs(worst.category) if " - ".join(pair) == worst.name)
    x, y = (data.read(name) for name in names)
    view = best_view(x.vertices, x.faces)
    views = view, view_alike(x, view, y, worst.p2p)
    titles = as_title(names[0]), as_title(names[1])
    job.picture("worst_map", caption, applied(plot_correspondence, x, y, worst.p2p, names=titles, views=views))


def _categories(data: Dataset, wanted: list[str] | None) -> list[str]:
    unknown = [name for name in wanted or [] if name not in data.categories]
    if unknown:
        raise ParameterError(f"no category {unknown[0]!r} in {data.root}: there are {', '.join(data.categories)}")
    return wanted or list(data.categories)


def _chosen(pairs: list[tuple[str, str]], count: int | None, seed: int) -> list[tuple[str, str]]:
    """Some of the pairs, in their order, the same for the same seed."""
    import numpy as np

    if count is None or count >= len(pairs):
        return pairs
    some = np.random.default_rng(seed).choice(len(pairs), count, replace=False)
    return [pairs[index] for index in sorted(some)]
