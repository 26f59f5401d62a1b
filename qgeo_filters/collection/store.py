"""The store of a collection: one Zarr group with the meshes, all that was computed of them, and of their pairs.

========================  ==========================================================================================
``surfaces/KEY/``         vertices and faces of a mesh, by their content
``shapes/KEY/``           the same prepared, by the key of its surface, the parameters and the code (`shape_arrays`)
``pairs/HOW/KEY/KEY/``    the match of two prepared shapes; HOW stands for the options of `match`
``mended/HOW/KEY/KEY/``   the same from a map that others say, one for each such map and its rival, by their content
``matrices/KEY/``         distances between all vertices of a mesh
``unfinished/``           what is being written
========================  ==========================================================================================

The attributes of the root are the index: the names, groups, files and keys of the shapes, and the settings. Every
record is written aside and moved into place, so that processes may share a store and be killed at any time. Zarr
alone reads all of it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from qgeo_filters.collection.records import (
    METADATA,
    UNFINISHED,
    DamagedRecord,
    Record,
    read_record,
    read_values,
    set_aside,
    sweep,
    write_group,
    write_record,
    zarr_package,
)
from qgeo_filters.collection.settings import FORMAT, Settings
from qgeo_filters.errors import ParameterError
from qgeo_filters.surface import Surface

_MARK = "qgeo_collection"
#: Folder of the matches that began at what the maps of other pairs say.
MENDED = "mended"
_FOLDERS = ("surfaces", "shapes", "pairs", MENDED, "matrices", UNFINISHED)
_ADVICE = "choose another folder, or delete it"


@dataclass(frozen=True)
class Entry:
    """A shape as the index knows it.

    Attributes
    ----------
    name, group : str
    surface : str
        Key of its mesh.
    path : str
        File that it came from; empty for a mesh from memory.
    notes : tuple of str
        What was left out to hold it, a sentence each.
    """

    name: str
    group: str
    surface: str
    path: str = ""
    notes: tuple[str, ...] = ()


class Store:
    """Records of a collection in a folder.

    Parameters
    ----------
    root : path
        A store, or a folder that is made one: it must not exist, or be empty.
    create : bool
        Whether to make one where there is none.

    Raises
    ------
    ParameterError
        A folder that is something else, or a store of another version of the format.
    FileNotFoundError
        No store, and none is to be made.
    """

    def __init__(self, root: str | os.PathLike[str], *, create: bool = True) -> None:
        zarr_package()
        self.root = Path(root)
        if not (self.root / METADATA).exists():
            self._create(create)
        content = self._content()
        if content["format"] != FORMAT:
            raise ParameterError(
                f"{self.root} is a collection of format {content['format']}, and this version of the package reads "
                f"format {FORMAT}: {_ADVICE}"
            )
        for name in _FOLDERS:  # those that a process was killed over
            if not (self.root / name / METADATA).exists():
                write_group(self.root / name, {})
        sweep(self.root)

    def __repr__(self) -> str:
        return f"Store({str(self.root)!r})"

    def _create(self, create: bool) -> None:
        if self.root.exists() and (not self.root.is_dir() or any(map(_foreign, self.root.iterdir()))):
            raise ParameterError(f"{self.root} is there and is no collection of shapes: {_ADVICE}")
        if not create:
            raise FileNotFoundError(f"no such collection: {self.root}")
        if not self.root.parent.is_dir():
            raise FileNotFoundError(f"cannot make {self.root}: {self.root.parent} is not a folder")
        write_group(self.root, {_MARK: {"format": FORMAT, "settings": None, "shapes": [], "unread": {}}})

    def _content(self) -> dict[str, Any]:
        try:
            content = json.loads((self.root / METADATA).read_bytes())["attributes"][_MARK]
            known: dict[str, Any] = {"format": content["format"], **content}
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise ParameterError(f"{self.root} is there and is no collection of shapes: {_ADVICE}") from error
        return known

    # -- the index ----------------------------------------------------------------------------------

    def write_index(self, entries: Sequence[Entry], settings: Settings, unread: Mapping[str, str]) -> None:
        """Say which shapes the collection has now, and why others could not be read; records of others stay."""
        shapes = [asdict(one) for one in entries]
        content = {"format": FORMAT, "settings": settings.to_json(), "shapes": shapes, "unread": dict(unread)}
        if self._content() != json.loads(json.dumps(content)):
            write_group(self.root, {_MARK: content})

    def read_index(self) -> tuple[list[Entry], Settings, dict[str, str]]:
        """The shapes that the collection has, how they are matched, and why others could not be read.

        Raises
        ------
        ParameterError
            A store without shapes, or one whose index is damaged.
        """
        content = self._content()
        try:
            entries = [Entry(**{**one, "notes": tuple(one["notes"])}) for one in content["shapes"]]
            unread = {str(name): str(why) for name, why in content["unread"].items()}
        except (KeyError, TypeError, AttributeError) as error:
            raise ParameterError(f"the index of {self.root} is damaged: build the collection again") from error
        if not entries:
            raise ParameterError(f"the collection {self.root} has no shapes yet: build it from a folder of meshes")
        return entries, Settings.from_json(content["settings"]), unread

    # -- records ------------------------------------------------------------------------------------

    def has(self, place: str) -> bool:
        """Whether there is a record; one with damaged attributes is set aside first."""
        return self.values(place) is not None

    def values(self, place: str) -> dict[str, Any] | None:
        """Attributes of a record; None where there is none, or where it was damaged and is set aside."""
        try:
            return read_values(self.root, place)
        except DamagedRecord as error:
            set_aside(self.root, place, str(error))
            return None

    def read(self, place: str, only: Collection[str] | None = None) -> Record | None:
        """A record, or some of its arrays; None where there is none, or where it was damaged and is set aside."""
        try:
            return read_record(self.root, place, only)
        except DamagedRecord as error:
            set_aside(self.root, place, str(error))
            return None

    def write(self, place: str, arrays: dict[str, Any], values: dict[str, Any]) -> bool:
        """Write a record, whole or not at all; False where another process was quicker."""
        return write_record(self.root, place, arrays, values)

    def write_surface(self, key: str, surface: Surface) -> None:
        """Keep the mesh of a shape."""
        self.write(f"surfaces/{key}", {"vertices": surface.vertices, "faces": surface.faces}, {})

    def surface(self, key: str) -> Surface:
        """The mesh of a shape.

        Raises
        ------
        ParameterError
            It is gone, or damaged.
        """
        record = self.read(f"surfaces/{key}")
        if record is None:
            raise ParameterError(f"the mesh {key} is missing in {self.root}: build the collection again")
        return Surface(record.arrays["vertices"], record.arrays["faces"])

    def pairs_of(self, how: str, x: str, folder: str = "pairs") -> Iterator[str]:
        """Keys of the shapes that one was matched to (or, of `MENDED`, matched to again), in no order."""
        try:
            with os.scandir(self.root / folder / how / x) as found:
                yield from (one.name for one in found if one.is_dir())
        except (FileNotFoundError, NotADirectoryError):
            return


def _foreign(path: Path) -> bool:
    """Whether it is anything but what another process has begun the same store with."""
    return not path.name.startswith(".zarr-")


def shape_place(key: str) -> str:
    """Where a prepared shape is kept."""
    return f"shapes/{key}"


def pair_place(settings: Settings, x: str, y: str) -> str:
    """Where the match of two prepared shapes is kept."""
    return f"pairs/{settings.how}/{x}/{y}"


def mended_place(settings: Settings, x: str, y: str, maps: str) -> str:
    """Where the match of two prepared shapes is kept that began at a map, by the key of that map and its rival."""
    return f"{MENDED}/{settings.how}/{x}/{y}/{maps}"
