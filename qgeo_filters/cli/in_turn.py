"""One command on many meshes: each for itself, what is bad is named, and the rest goes on."""

from __future__ import annotations

import errno
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import typer

from qgeo_filters.cli.default_folder import default_folder, free_folder
from qgeo_filters.cli.options import Settings
from qgeo_filters.errors import QgeoError, reason
from qgeo_filters.io.folders import mesh_files

_FAILED = 1


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
    bad = 0
    for path in meshes:
        try:
            files += mesh_files(path)
        except (QgeoError, OSError) as error:
            bad += 1
            _say(path, error)
    count = len(files) + bad
    for number, (name, file) in enumerate(zip(numbered([file.stem for file in files]), files, strict=True), start=1):
        if not (settings.quiet or settings.json):
            typer.echo(f"qgeo: {file} ({number} of {len(files)})", err=True)
        folder = free_folder(below / name, [file]) if settings.output is None else settings.output / name
        try:
            one(file, replace(settings, output=folder))
        except (QgeoError, MemoryError, OSError) as error:
            if isinstance(error, OSError) and _is_of_the_disk(error):
                raise  # it would be so for the rest
            bad += 1
            _say(file, error)
    if bad:
        typer.echo(f"qgeo: {bad} of {count} meshes have no results", err=True)
        raise typer.Exit(_FAILED)


def _is_of_the_disk(error: OSError) -> bool:
    return error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS)


def _say(mesh: Path, error: BaseException) -> None:
    said = reason(error)
    typer.echo(f"qgeo: {said if str(mesh) in said else f'{mesh}: {said}'}", err=True)
