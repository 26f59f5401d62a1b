"""``qgeo collection``: many shapes in one store, on this machine, in a job array, or on a Dask cluster."""

from __future__ import annotations

import json as json_module
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from qgeo_filters._typing import RepairOption
from qgeo_filters.cli.collection_common import common, landmarks
from qgeo_filters.cli.collection_report import export, report
from qgeo_filters.cli.errors import OneLineErrors, OneLineWarnings, to_standard_output
from qgeo_filters.cli.options import Force, Json, Quiet, Repair, Wrap, repair_option
from qgeo_filters.errors import ParameterError

if TYPE_CHECKING:
    from qgeo_filters.collection.collection import Collection

app = typer.Typer(cls=OneLineErrors, help="Many shapes: each prepared once, all pairs matched, kept in one store.")

_FAILED = 1

Folder = Annotated[
    list[Path],
    typer.Argument(metavar="DIR", help="A folder of meshes, or mesh files.", show_default=False),
]
StoreFolder = Annotated[Path, typer.Argument(metavar="STORE", help="What build made.", show_default=False)]
Kept = Annotated[
    Path,
    typer.Option(
        "-o", "--output", metavar="STORE", help="Folder of the results, made if missing; continued where it is there."
    ),
]
GroupBy = Annotated[
    str | None,
    typer.Option(
        "--group-by",
        metavar="PATTERN",
        help="Group of a shape: what this regular expression finds in its name, such as '^\\[a-z]+'.",
        show_default=False,
    ),
]
Part = Annotated[
    str,
    typer.Option("--part", metavar="K/N", help="The K-th of N parts of the work, for job arrays that share a store."),
]
Within = Annotated[bool, typer.Option("--within-groups", help="Match shapes of one group only.")]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Dask cluster that takes the work, such as tcp://host:8786; its workers must see the store.",
        show_default=False,
    ),
]
Processes = Annotated[
    int | None,
    typer.Option("--workers", metavar="N", help="Processes at most; all cores if left out.", show_default=False),
]
Backend = Annotated[str, typer.Option("--backend", help="Of joblib, which runs the processes.")]
Normalize = Annotated[bool, typer.Option("--normalize/--no-normalize", help="Compare shapes regardless of their size.")]
Partial = Annotated[
    bool | None,
    typer.Option("--partial/--no-partial", help="Whether shapes are parts of each other.", show_default=False),
]
Mirror = Annotated[
    Literal["auto", "no", "yes"], typer.Option("--mirror", help="Whether a shape may be the mirror image of another.")
]


@app.command(cls=OneLineWarnings)
def build(
    shapes: Folder,
    output: Kept = Path("shapes.zarr"),
    group_by: GroupBy = None,
    normalize: Normalize = True,
    partial: Partial = None,
    mirror: Mirror = "auto",
    part: Part = "1/1",
    workers: Processes = None,
    backend: Backend = "loky",
    scheduler: Scheduler = None,
    repair: Repair = None,
    force: Force = False,
    wrap: Wrap = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Read meshes into a store and prepare each: spectra, symmetry, what matching takes from it.

    What is in the store already is not computed again; a file that changed is. Files that cannot be read are named, and
    the rest goes on; the exit code is then 1.
    """
    collection = _built(shapes, output, group_by, normalize, partial, mirror, repair_option(repair, force, wrap))
    options = _engine(workers, backend, scheduler, quiet)
    collection.prepare(part=checked_text(part), **options)
    _end(collection, json, quiet)


@app.command(cls=OneLineWarnings)
def status(store: StoreFolder, json: Json = False, quiet: Quiet = False) -> None:
    """Say how far the work has come, and what is wrong with which shape."""
    _end(_opened(store), json, quiet, failing=False)


@app.command(cls=OneLineWarnings)
def match(
    store: StoreFolder,
    within_groups: Within = False,
    part: Part = "1/1",
    workers: Processes = None,
    backend: Backend = "loky",
    scheduler: Scheduler = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Match all pairs of a store that are not matched yet.

    It may be killed, and called again; several calls may share a store. Pairs that fail are named, and the rest goes
    on; the exit code is then 1.
    """
    collection = _opened(store)
    _matched(collection, within_groups, part, _engine(workers, backend, scheduler, quiet))
    _end(collection, json, quiet)


@app.command(cls=OneLineWarnings)
def run(
    shapes: Folder,
    output: Kept = Path("shapes.zarr"),
    group_by: GroupBy = None,
    within_groups: Within = False,
    normalize: Normalize = True,
    partial: Partial = None,
    mirror: Mirror = "auto",
    part: Part = "1/1",
    workers: Processes = None,
    backend: Backend = "loky",
    scheduler: Scheduler = None,
    repair: Repair = None,
    force: Force = False,
    wrap: Wrap = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Build a store and match its pairs: each task of a job array may call this with its own --part."""
    collection = _built(shapes, output, group_by, normalize, partial, mirror, repair_option(repair, force, wrap))
    _matched(collection, within_groups, part, _engine(workers, backend, scheduler, quiet))
    _end(collection, json, quiet)


app.command(cls=OneLineWarnings)(report)
app.command(cls=OneLineWarnings)(export)
app.command(cls=OneLineWarnings)(landmarks)
app.command(cls=OneLineWarnings)(common)


def _built(
    shapes: Sequence[Path],
    store: Path,
    pattern: str | None,
    normalize: bool,
    partial: bool | None,
    mirror: Literal["auto", "no", "yes"],
    repair: RepairOption,
) -> Collection:
    from qgeo_filters.collection.collection import Collection

    single = len(shapes) == 1 and shapes[0].is_dir()
    return Collection(
        shapes[0] if single else list(shapes),
        store,
        groups=None if pattern is None else grouped_by(pattern),
        normalize=normalize,
        partial="auto" if partial is None else partial,
        mirror=mirror,
        repair=repair,
    )


def _opened(store: Path) -> Collection:
    from qgeo_filters.collection.collection import Collection

    return Collection.open(store)


def _engine(workers: int | None, backend: str, scheduler: str | None, quiet: bool) -> dict[str, Any]:
    progress = not quiet and sys.stderr.isatty()
    return {"workers": workers, "backend": backend, "scheduler": scheduler, "progress": progress}


def _matched(collection: Collection, within_groups: bool, part: str, engine: dict[str, Any]) -> None:
    collection.match("within groups" if within_groups else "all", part=checked_text(part), **engine)


def checked_text(part: str) -> tuple[int, int]:
    """Two numbers from a text such as 3/40, the third of forty parts."""
    found = re.fullmatch(r"(\d+)/(\d+)", part)
    if found is None:
        raise ParameterError(f"--part must be K/N, such as 3/40, got {part!r}")
    return int(found[1]), int(found[2])


def grouped_by(pattern: str) -> Callable[[str], str]:
    """Function from a name to what the pattern finds in it, or its first group; "" where it finds nothing."""
    try:
        expression = re.compile(pattern)
    except re.error as error:
        raise ParameterError(f"--group-by: {pattern!r} is no regular expression: {error}") from error

    def group(name: str) -> str:
        found = expression.search(name)
        return (found[expression.groups and 1] or "") if found else ""

    return group


def _end(collection: Collection, json: bool, quiet: bool, *, failing: bool = True) -> None:
    """Say where things stand, name what is wrong, and leave with 1 where something is lost."""
    problems, found = collection.problems, asdict(collection.status())
    for problem in problems:
        if not quiet or problem.lost:
            typer.echo(f"qgeo: {problem}", err=True)
    with to_standard_output():
        if json:
            told = [asdict(problem) for problem in problems]
            typer.echo(json_module.dumps({"store": str(collection.store.root), **found, "problems": told}, indent=2))
        elif not quiet:
            shapes = f"{found['prepared']} of {found['shapes']} shapes prepared"
            pairs = f"{found['matched']} of {found['pairs']} pairs matched, {found['confident']} of them surely"
            again = f", {found['matched_again']} matched again" if found["matched_again"] else ""
            typer.echo(f"{collection.store.root}: {shapes}, {pairs}{again}")
    if failing and any(problem.lost for problem in problems):
        raise typer.Exit(_FAILED)
