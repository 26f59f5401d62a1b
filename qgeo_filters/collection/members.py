"""The shapes of a collection by name, from files or memory, with their groups; what cannot be read is named."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike
from qgeo_filters.io.folders import mesh_files

#: What a `Collection` takes: a folder, meshes or files, or those by name.
Shapes = str | os.PathLike[str] | Sequence[SurfaceLike] | Mapping[str, SurfaceLike]
Groups = Sequence[str] | Mapping[str, str] | Callable[[str], str]


@dataclass(frozen=True)
class Problem:
    """What is wrong with a shape or a pair; the rest goes on.

    Attributes
    ----------
    subject : str
        Name of the shape, or "x - y".
    reason : str
    lost : bool
        Whether nothing is there for it; False for what is worth a look.
    """

    subject: str
    reason: str
    lost: bool = True

    def __str__(self) -> str:
        # The reason of a file begins with its path.
        return f"{self.subject}: {self.reason}"


def named_shapes(shapes: Shapes, names: Sequence[str] | None = None) -> dict[str, SurfaceLike]:
    """Meshes or paths by name: given ones, or stems of files.

    Raises
    ------
    ParameterError
        Names that do not fit or occur twice, with the files; a mesh from memory without a name; no shape at all.
    MeshError
        A folder without meshes.
    FileNotFoundError, NotADirectoryError
        The folder is none.
    """
    if isinstance(shapes, Mapping):
        if names is not None:
            raise ParameterError("shapes that come by name have names already: leave out names=")
        found = {_checked_name(name): shape for name, shape in shapes.items()}
        if not found:
            raise ParameterError("a collection needs a shape at least, got an empty mapping")
        return found
    given = _files(Path(shapes)) if isinstance(shapes, (str, os.PathLike)) else list(shapes)
    if not given:
        raise ParameterError("a collection needs a shape at least, got an empty list")
    chosen = [_stem(shape, number) for number, shape in enumerate(given)] if names is None else list(names)
    if len(chosen) != len(given):
        raise ParameterError(f"names must hold one for each of the {len(given)} shapes, got {len(chosen)}")
    found = {}
    for number, (name, shape) in enumerate(zip(chosen, given, strict=True)):
        if name in found:
            raise ParameterError(
                f"two shapes are called {name!r}, {_called(found[name], chosen.index(name))} and "
                f"{_called(shape, number)}: tell them apart by names="
            )
        found[_checked_name(name)] = shape
    return found


def groups_of(names: Sequence[str], groups: Groups | None) -> list[str]:
    """Group of each shape: in the order of the names, by name, or what a function says of the name; "" without any.

    Raises
    ------
    ParameterError
        Not one for each shape.
    """
    if groups is None:
        return [""] * len(names)
    if isinstance(groups, Mapping):
        lacking = [name for name in names if name not in groups]
        if lacking:
            raise ParameterError(f"groups has none for {lacking[0]!r} ({len(lacking)} such shapes)")
        return [str(groups[name]) for name in names]
    if callable(groups):
        return [str(groups(name)) for name in names]
    if isinstance(groups, str) or len(groups) != len(names):
        count = "a text" if isinstance(groups, str) else len(groups)
        raise ParameterError(f"groups must hold one for each of the {len(names)} shapes, got {count}")
    return [str(group) for group in groups]


def path_of(shape: Any) -> str:
    """File of a shape; empty for one from memory."""
    return str(Path(shape).resolve()) if isinstance(shape, (str, os.PathLike)) else ""


def unique(names: Iterable[str]) -> list[str]:
    """The names, each once, in the order of their first occurrence."""
    return list(dict.fromkeys(names))


def _files(folder: Path) -> list[Path]:
    if not folder.is_dir():
        kind = NotADirectoryError if folder.exists() else FileNotFoundError
        raise kind(f"{folder} is not a folder of meshes")
    return mesh_files(folder)


def _stem(shape: SurfaceLike, number: int) -> str:
    if isinstance(shape, (str, os.PathLike)):
        return Path(shape).stem
    raise ParameterError(f"shapes[{number}] comes from memory and has no name: give names=, or a mapping of names")


def _called(shape: SurfaceLike, number: int) -> str:
    return str(shape) if isinstance(shape, (str, os.PathLike)) else f"shapes[{number}]"


def _checked_name(name: Any) -> str:
    if not isinstance(name, str) or not name:
        raise ParameterError(f"the name of a shape must be a text that is not empty, got {name!r}")
    return name
