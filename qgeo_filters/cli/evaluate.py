"""``qgeo evaluate``: errors of the maps over a data set with known truth."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from qgeo_filters.cli.options import DEFAULT_OUTPUT, Json, Output, Pictures, Quiet, Settings

if TYPE_CHECKING:
    from collections.abc import Callable

    from qgeo_filters.evaluation import Dataset, PairResult


def evaluate(
    dataset: Annotated[
        Literal["tosca", "indexed", "vts", "shrec19"],
        typer.Argument(
            metavar="DATASET",
            help="Layout: tosca (remeshed/, ground_truth/, symmetry/), indexed (equal vertex numbers), vts, shrec19.",
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
    output: Output = DEFAULT_OUTPUT,
    pictures: Pictures = True,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Measure the error of matches, or of symmetry maps, against the truth, as a table by category.

    Errors are direct (Princeton protocol), in units of sqrt(area); seconds are CPU time without what belongs to one
    shape alone. The table is also in table.md. result.npz: errors of all points, pair (which pair each belongs to).
    """
    import numpy as np

    from qgeo_filters.cli.job import Job
    from qgeo_filters.evaluation import markdown, rows_by_category
    from qgeo_filters.evaluation.errors import THRESHOLDS
    from qgeo_filters.report.curves import plot_error_curve
    from qgeo_filters.report.html import Table

    if pairs is not None and pairs < 1:
        raise ValueError(f"--pairs must be at least 1, got {pairs}")
    parameters = {"dataset": dataset, "root": str(root), "what": what, "pairs": pairs, "seed": seed}
    job = Job(
        "evaluate", Settings(output, quiet, json, pictures=pictures), {**parameters, "category": category or "all"}
    )
    job.subject = f"{what} on {dataset}"
    data = _dataset(dataset, root)
    found: list[PairResult] = []
    for name in _categories(data, category):
        chosen = _chosen(
            list(data.pairs(name)) if what == "match" else [(one, one) for one in data.names(name)], pairs, seed
        )
        with job.stage(name):
            found += _symmetries(data, [one for one, _ in chosen]) if what == "symmetry" else _matches(data, chosen)
    if not found:
        raise ValueError(f"{root}: no two shapes of one category")
    rows = rows_by_category(found)
    direct = [result.errors.direct for result in found]
    results = {
        "pairs": len(found),
        "mean_error": rows[-1].direct.mean,
        "failed": rows[-1].failed,
        "mirrored": rows[-1].mirrored if what == "match" else None,
        "rows": [
            {
                "name": one.name,
                "mean": float(one.errors.direct.mean()),
                "confident": one.confident,
                "seconds": one.seconds,
            }
            for one in found
        ],
    }
    owner = np.repeat(np.arange(len(found)), [len(errors) for errors in direct])
    job.save(results, {"errors": np.concatenate(direct), "pair": owner})
    job.text("table.md", markdown(rows) + "\n")
    job.picture(
        "error_curve",
        "Share of all points within an error.",
        lambda: plot_error_curve(np.concatenate(direct), label=what),
    )
    lines = [
        (
            row.label,
            row.pairs,
            row.direct.mean,
            row.direct.median,
            *(100 * share for share in row.direct.below),
            100 * row.mirrored / row.pairs if what == "match" else None,
            row.failed,
            row.seconds,
        )
        for row in rows
    ]
    within = [f"within {threshold:g} (%)" for threshold in THRESHOLDS]
    number = "pairs" if what == "match" else "shapes"
    columns = ("category", number, "mean", "median", *within, "mirrored (%)", "failed", "CPU s")
    job.finish([Table("Errors in units of sqrt(area)", lines, columns, "Failed: a mean above 0.1.")])


def _dataset(layout: str, root: Path) -> Dataset:
    from qgeo_filters import evaluation

    if not root.is_dir():
        raise NotADirectoryError(f"--root: {root} is not a folder")
    kinds: dict[str, Callable[[Path], Dataset]] = {
        "tosca": evaluation.ToscaRemeshed,
        "indexed": evaluation.IndexedDataset,
        "vts": evaluation.VtsDataset,
        "shrec19": evaluation.Shrec19,
    }
    return kinds[layout](root)


def _categories(data: Dataset, wanted: list[str] | None) -> list[str]:
    unknown = [name for name in wanted or [] if name not in data.categories]
    if unknown:
        raise ValueError(f"no category {unknown[0]!r} in {data.root}: there are {', '.join(data.categories)}")
    return wanted or list(data.categories)


def _chosen(pairs: list[tuple[str, str]], count: int | None, seed: int) -> list[tuple[str, str]]:
    """Some of the pairs, in their order, the same for the same seed."""
    import numpy as np

    if count is None or count >= len(pairs):
        return pairs
    some = np.random.default_rng(seed).choice(len(pairs), count, replace=False)
    return [pairs[index] for index in sorted(some)]


def _matches(data: Dataset, pairs: list[tuple[str, str]]) -> list[PairResult]:
    """Errors of the matches of these pairs, each shape prepared once."""
    from qgeo_filters.evaluation import PairResult, SymmetricErrors, geodesic_error, symmetric_errors
    from qgeo_filters.matching.correspondence import match
    from qgeo_filters.matching.descriptor import Descriptor

    shapes: dict[str, Descriptor] = {}
    found = []
    for x, y in pairs:
        for name in (x, y):
            if name not in shapes:
                shapes[name] = Descriptor(data.read(name)).prepared()
        truth = data.truth(x, y)
        started = time.process_time()
        result = match(shapes[x], shapes[y])
        seconds = time.process_time() - started
        image = result.p2p[truth.points]
        target = shapes[y].surface
        try:
            mirror = data.symmetry(y).images
        except LookupError:  # without it a mirrored map cannot be told from a wrong one
            direct = geodesic_error(image, truth.images, target)
            errors = SymmetricErrors(direct, direct)
        else:
            errors = symmetric_errors(image, truth.images, mirror, target)
        found.append(PairResult(f"{x} - {y}", data.category(x), errors, result.confident, seconds))
    return found


def _symmetries(data: Dataset, names: list[str]) -> list[PairResult]:
    """Errors of the symmetry maps of these shapes; where none was found, those of the identity."""
    from qgeo_filters.evaluation import PairResult, SymmetricErrors, geodesic_error
    from qgeo_filters.matching.descriptor import Descriptor
    from qgeo_filters.matching.symmetry import self_symmetry

    found = []
    for name in names:
        truth = data.symmetry(name)
        shape = Descriptor(data.read(name)).prepared()
        started = time.process_time()
        result = self_symmetry(shape)
        seconds = time.process_time() - started
        errors = geodesic_error(result.nearest[truth.points], truth.images, shape.surface)
        found.append(PairResult(name, data.category(name), SymmetricErrors(errors, errors), result.found, seconds))
    return found
