"""``qgeo fetch``: public data sets with known truth, for ``qgeo evaluate``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from qgeo_filters.cli.options import Quiet
from qgeo_filters.errors import ParameterError


def fetch(
    dataset: Annotated[
        str | None,
        typer.Argument(metavar="DATASET", help="Which one; all are listed without it.", show_default=False),
    ] = None,
    root: Annotated[
        Path | None,
        typer.Option(
            "--root",
            metavar="DIR",
            help="Where data sets go, each into a folder of its name; the user's cache if left out.",
        ),
    ] = None,
    sha256: Annotated[
        list[str] | None,
        typer.Option(
            "--sha256", metavar="HASH", help="Of the archive; once for each, in their order, if there are more."
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """List the public data sets that can be downloaded, or download one.

    Mind the terms of each. No hashes of their archives are published: the one that came is told, to be given as
    --sha256 from then on. An archive that is already there is not downloaded again.
    """
    import sys
    import warnings

    from qgeo_filters import evaluation
    from qgeo_filters.cli.outputs import writable_folder
    from qgeo_filters.errors import require_package
    from qgeo_filters.evaluation.download import SOURCES

    if dataset is None:
        for name, source in SOURCES.items():
            typer.echo(f"{name:<16}{source.terms}")
        return
    if dataset not in SOURCES:
        raise ParameterError(f"no data set {dataset!r}: there are {', '.join(SOURCES)}")
    urls = SOURCES[dataset].urls
    if sha256 and len(sha256) != len(urls):
        raise ParameterError(f"--sha256: {dataset} comes in {len(urls)} archives, {len(sha256)} hashes are given")
    known = dict(zip(urls, sha256 or (), strict=False))
    folder = None if root is None else writable_folder(root)
    # It would tell the hash as well, in terms of its own.
    require_package("pooch", "download", "fetching a data set").get_logger().setLevel("WARNING")
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always", UserWarning)
        data = evaluation.fetch(dataset, folder, known_hash=known, progress=not quiet and sys.stderr.isatty())
    if quiet:
        return
    for note in notes:
        typer.echo(f"qgeo: {str(note.message).replace('known_hash', '--sha256')}", err=True)
    layout = SOURCES[dataset].benchmark or ("vts" if isinstance(data, evaluation.VtsDataset) else "indexed")
    typer.echo(f"{dataset}: {len(data.names())} shapes in {data.root} ({SOURCES[dataset].terms})")
    typer.echo(f"maps on it are measured by: qgeo evaluate {layout} --root {data.root}")
