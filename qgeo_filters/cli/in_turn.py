"""One command on many meshes: each for itself, what is bad is named, and the rest goes on."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import typer

from qgeo_filters.cli.default_folder import default_folder, free_folder
from qgeo_filters.cli.errors import in_options
from qgeo_filters.cli.options import Settings
from qgeo_filters.errors import QgeoError, reason
from qgeo_filters.io.folders import mesh_files

_FAILED = 1


class Batch:
    """Files of which some may be bad: these are named, and the rest goes on.

    Attributes
    ----------
    bad : list of (Path, str)
        What was named, and why.
    """

    def __init__(self) -> None:
        self.bad: list[tuple[Path, str]] = []

    @contextmanager
    def trying(self, file: Path) -> Iterator[None]:
        """Context that ends early where something is wrong with a file; a full disk, which is so for all, is raised."""
        try:
            yield
        except (QgeoError, MemoryError, OSError) as error:
            if isinstance(error, OSError) and _is_of_the_disk(error):
                raise
            said = in_options(reason(error))
            self.bad.append((file, said))
            typer.echo(f"qgeo: {said if str(file) in said else f'{file}: {said}'}", err=True)

    def leave_out(self, name: str, why: str) -> None:
        """Name something that is no file, such as a shape of a collection."""
        self.bad.append((Path(name), why))
        typer.echo(f"qgeo: {name}: {why}", err=True)

    def for_results(self) -> dict[str, list[dict[str, str]]]:
        """What result.json says of the bad ones: nothing where all were good."""
        return {"left_out": [{"path": str(path), "why": why} for path, why in self.bad]} if self.bad else {}

    def finish(self, count: int, what: str = "meshes have no results") -> None:
        """End the command with exit code 1 if any of so many was bad."""
        if self.bad:
            typer.echo(f"qgeo: {len(self.bad)} of {count} {what}", err=True)
            raise typer.Exit(_FAILED)


def in_turn(
    meshes: Sequence[Path], settings: Settings, one: Callable[[Path, Settings], None], command: str, *about: str
) -> None:
    """Call a function with each mesh file, and with settings that have a folder of its own where there are several.

    Parameters
    ----------
    meshes : sequence of Path
        Files and folders of them.
    settings : Settings
    one : callable
    command, about : str
        What is done, for the name of the folder in which the meshes have theirs where none is given.

    Raises
    ------
    QgeoError, OSError, MemoryError
        What is wrong with a mesh that is the only one; of several it is said, and the command ends with exit code 1.
    """
    if len(meshes) == 1 and not meshes[0].is_dir():
        one(meshes[0], settings)
        return
    from qgeo_filters.cli.job_text import numbered

    below = default_folder(command, [*about, *(path.resolve().stem for path in meshes)])
    files: list[Path] = []
    batch = Batch()
    for path in meshes:
        with batch.trying(path):
            files += mesh_files(path)
    count = len(files) + len(batch.bad)
    for number, (name, file) in enumerate(zip(numbered([file.stem for file in files]), files, strict=True), start=1):
        if not (settings.quiet or settings.json):
            typer.echo(f"qgeo: {file} ({number} of {len(files)})", err=True)
        folder = free_folder(below / name, [file]) if settings.output is None else settings.output / name
        with batch.trying(file):
            one(file, replace(settings, output=folder))
    batch.finish(count)


def _is_of_the_disk(error: OSError) -> bool:
    return error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
