"""What commands keep between each other: the results of their stages, on disk, up to a bound."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

#: Variable that names another folder than the user's cache; nothing is kept where it is empty.
VARIABLE = "QGEO_CACHE_DIR"
#: Bound of the folder in bytes; what was used last stays.
BOUND = 4 << 30


def kept_folder() -> Path | None:
    """Folder in which results are kept; None where the user wants none."""
    import platformdirs

    named = os.environ.get(VARIABLE)
    if named is not None:
        return Path(named) if named else None
    return Path(platformdirs.user_cache_dir("qgeo-filters", appauthor=False)) / "stages"


def _keep(context: typer.Context, wanted: bool) -> bool:
    if wanted and not context.resilient_parsing:
        context.with_resource(_kept(kept_folder()))
    return wanted


@contextmanager
def _kept(folder: Path | None) -> Iterator[None]:
    """Context in which results are kept in a folder, if it can be had; one that was set before stays."""
    from qgeo_filters.caching import cache

    if folder is None or cache.directory is not None:
        yield
        return
    bound = cache.max_disk_bytes
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)  # what is read from it may run code
        cache.configure(directory=folder, max_disk_bytes=BOUND)
    except OSError as error:
        typer.echo(f"qgeo: results are not kept for later commands: {error}", err=True)
    try:
        yield
    finally:
        cache.configure(directory=None, max_disk_bytes=bound)


Cache = Annotated[
    bool,
    typer.Option(
        "--cache/--no-cache",
        help="Keep spectra, matrices and maps for later commands on the same meshes, up to "
        f"{BOUND >> 30} GiB in {VARIABLE} or the user's cache folder; qgeo info --system says where.",
        callback=_keep,
    ),
]
