"""Where the results of a command go that is not told so: a folder of its own for each command and its meshes."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from qgeo_filters.cli.outputs import LISTING

#: Folder of all results, where the command is called.
RESULTS = Path("qgeo-out")
_MOST_NAMES, _LONGEST = 3, 60


def default_folder(command: str, names: Sequence[str], meshes: Sequence[Path] = ()) -> Path:
    """Folder such as ``qgeo-out/match-cat0-cat3``, with a number behind where that holds results of other files.

    Parameters
    ----------
    command : str
    names : sequence of str
        What the results are of; of many the first ones, and how many more.
    meshes : sequence of Path
        Files that are read: results of the same command on the same files are replaced.
    """
    shown = list(names)
    if len(shown) > _MOST_NAMES:
        shown = [*shown[: _MOST_NAMES - 1], f"and-{len(shown) - _MOST_NAMES + 1}-more"]
    return free_folder(RESULTS / "-".join([command.replace(" ", "-"), *map(_short, shown)]), meshes)


def free_folder(folder: Path, meshes: Sequence[Path]) -> Path:
    """The folder, or the first with a number behind its name, that holds no results of other meshes than these."""
    here = [os.path.abspath(mesh) for mesh in meshes]
    numbers = itertools.chain([folder], (folder.with_name(f"{folder.name}-{k}") for k in itertools.count(2)))
    return next(one for one in numbers if _of_meshes(one) in (None, here) or not here)


def _short(name: str) -> str:
    """The name, cut where it is so long that systems refuse it."""
    return name.encode("utf-8", "surrogateescape")[:_LONGEST].decode("utf-8", "ignore")


def _of_meshes(folder: Path) -> list[str] | None:
    """Files of the meshes of the results in a folder; None where there are no results."""
    try:
        content: Any = json.loads((folder / LISTING).read_bytes())
        return [os.path.abspath(path) for path in _paths(content)]
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None


def _paths(content: Any) -> Iterator[str]:
    for mesh in content["meshes"] if "meshes" in content else [content["mesh"]]:
        yield mesh["path"]
