"""The mesh files of a folder."""

from __future__ import annotations

import re
from pathlib import Path

from qgeo_filters.errors import MeshError
from qgeo_filters.io.formats import SUFFIXES


def mesh_files(path: Path) -> list[Path]:
    """The file, or the mesh files of a folder, numbers in their names in the order of numbers.

    Raises
    ------
    MeshError
        A folder without any.
    FileNotFoundError
        No such file: said before anything is computed.
    """
    if not path.is_dir():
        if not (path.exists() or path.with_name(f"{path.name}.vert").exists()):
            raise FileNotFoundError(f"no such file: {path}")
        return [path]
    # A link that leads nowhere is a file that cannot be read, which is said.
    found = [
        file for file in path.iterdir() if file.suffix.lower() in SUFFIXES and (file.is_file() or not file.exists())
    ]
    if not found:
        raise MeshError(f"{path}: a folder without mesh files")
    return sorted(found, key=_natural)


def _natural(path: Path) -> list[tuple[int, int, str]]:
    parts = re.split(r"(\d+)", path.name.casefold())
    return [(0, int(part), "") if part.isdecimal() else (1, 0, part) for part in parts]
