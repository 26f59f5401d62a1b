"""Many shapes: each prepared once, any pairs matched on demand, everything kept in one store."""

from __future__ import annotations

import os
import shutil
import tempfile
import warnings
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path

from qgeo_filters._typing import MirrorOption, PartialOption, RepairOption
from qgeo_filters.collection.consistent import Consistent
from qgeo_filters.collection.matrices import Matrices
from qgeo_filters.collection.members import Groups, Problem, Shapes, groups_of, named_shapes, path_of
from qgeo_filters.collection.runs import Runs
from qgeo_filters.collection.settings import Settings, surface_key
from qgeo_filters.collection.store import Entry, Store
from qgeo_filters.errors import MeshError, ParameterError, QgeoError, reason
from qgeo_filters.hosts.dispatch import as_given
from qgeo_filters.matching.parameters import MatchingParameters


class Collection(Runs, Consistent, Matrices):
    """Shapes with names, all that is known of them and of their pairs, in a store that outlives the process.

    Parameters
    ----------
    shapes : path of a folder, sequence of paths or meshes, or mapping of str to either
        Whatever `as_surface` takes. Of a folder, the files with a mesh's suffix.
    store : path, optional
        Folder of the results, ``shapes.zarr`` say, made where it is missing. What is in it is not computed again, a
        file that changed is. Without one, results live in a temporary folder as long as this object.
    names : sequence of str, optional
        By default the stems of the files.
    groups : sequence of str, mapping of str to str, or callable, optional
        Group of each shape: in their order, by name, or a function of the name.
    parameters : MatchingParameters, optional
    normalize, partial, mirror, repair
        See `match`; the same for all pairs.

    Attributes
    ----------
    names : tuple of str
    groups : dict of str to str
        Group of each name; "" without any.
    settings : Settings
    store : Store

    Raises
    ------
    ParameterError
        Names that occur twice, groups that do not fit; a store that is something else, or of another version.
    MeshError
        No shape that can be read.
    MissingPackageError
        Without the extra ``collections``.

    Notes
    -----
    Files that cannot be read, and meshes that cannot be prepared, are named in `problems`, and the rest goes on.
    Attributes of meshes are not kept. Results are kept by the content of the meshes, the parameters and the version of
    the package: a store that several processes fill at once has each of them once.

    Examples
    --------
    >>> pose = qg.testing.sample_surface()
    >>> poses = {"low": pose, "high": pose.with_vertices(pose.vertices * [1, 1, 1.1])}
    >>> collection = qg.Collection(poses, groups=lambda name: name[0])  # store="poses.zarr" keeps what is found
    >>> collection.names, collection.groups
    (('low', 'high'), {'low': 'l', 'high': 'h'})
    >>> collection.status().pairs  # .match(progress=True) finds their maps, .table() has a row for each
    1
    """

    # A temporary folder goes with the collection that made it, which must outlive a part of it.
    _whole: Collection | None = None

    def __init__(
        self,
        shapes: Shapes,
        store: str | os.PathLike[str] | None = None,
        *,
        names: Sequence[str] | None = None,
        groups: Groups | None = None,
        parameters: MatchingParameters | None = None,
        normalize: bool = True,
        partial: PartialOption = "auto",
        mirror: MirrorOption = "auto",
        repair: RepairOption = "auto",
    ) -> None:
        chosen = MatchingParameters() if parameters is None else parameters
        settings = Settings(chosen, normalize, partial, mirror, repair)
        given = named_shapes(shapes, names)
        group_of = dict(zip(given, groups_of(list(given), groups), strict=True))
        place = Store(self._temporary() if store is None else store)
        entries: list[Entry] = []
        unread: dict[str, str] = {}
        for name, shape in given.items():
            try:
                surface, notes = as_given(shape, repair)
            except (QgeoError, OSError) as error:
                unread[name] = reason(error)
                continue
            key = surface_key(surface)
            place.write_surface(key, surface)
            entries.append(Entry(name, group_of[name], key, path_of(shape), notes))
        if not entries:
            name, why = next(iter(unread.items()))
            raise MeshError(f"none of the {len(given)} shapes can be read; the first, {name}: {why}")
        place.write_index(entries, settings, unread)
        super().__init__(place, settings, entries)
        self._found = _found(entries, unread)
        if copies := _copies(entries):
            warnings.warn(f"{copies[0]} ({len(copies)} such shapes)", stacklevel=2)

    @classmethod
    def open(cls, store: str | os.PathLike[str]) -> Collection:
        """The collection that a store was last built for, with its settings; no mesh file is looked at.

        Raises
        ------
        FileNotFoundError, ParameterError
            No store, one of another version, or one that holds no shapes.
        """
        known = Store(store, create=False)
        entries, settings, unread = known.read_index()
        self = cls.__new__(cls)
        super(Collection, self).__init__(known, settings, entries)
        self._found = _found(entries, unread)
        return self

    def only(self, names: Sequence[str]) -> Collection:
        """The collection of some of the shapes, in the same store: what is found for one is found for the other.

        Parameters
        ----------
        names : sequence of str

        Raises
        ------
        ParameterError
            No shape called so, or a name twice.
        """
        if twice := [name for place, name in enumerate(names) if name in names[:place]]:
            raise ParameterError(f"{twice[0]!r} is named twice")
        entries = [self._entry(name) for name in names]
        some = Collection.__new__(Collection)
        super(Collection, some).__init__(self.store, self.settings, entries)
        some._found = _found(entries, {})
        some._whole = self
        return some

    def _temporary(self) -> Path:
        folder = Path(tempfile.mkdtemp(prefix="qgeo-collection-"))
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        return folder


def _copies(entries: Sequence[Entry]) -> list[Problem]:
    """Shapes that hold the mesh of an earlier one."""
    first: dict[str, str] = {}
    for entry in entries:
        first.setdefault(entry.surface, entry.name)
    copies = [one for one in entries if first[one.surface] != one.name]
    return [Problem(one.name, f"holds the same mesh as {first[one.surface]}", lost=False) for one in copies]


def _found(entries: Sequence[Entry], unread: Mapping[str, str]) -> list[Problem]:
    """Files that cannot be read, copies, and what had to be left out of meshes."""
    left_out = [Problem(one.name, note, lost=False) for one in entries for note in one.notes]
    return [*(Problem(name, why) for name, why in unread.items()), *_copies(entries), *left_out]
