"""The shapes of a collection as its store has them: by name, meshes and prepared ones."""

from __future__ import annotations

from collections.abc import Sequence

from qgeo_filters.collection.members import Problem
from qgeo_filters.collection.settings import Settings
from qgeo_filters.collection.store import Entry, Store, pair_place, shape_place
from qgeo_filters.collection.tasks import PROBLEM, restored_shape
from qgeo_filters.errors import ParameterError
from qgeo_filters.html_repr import card
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.matching.symmetry_result import Symmetry
from qgeo_filters.surface import Surface


class StoredShapes:
    """Names, groups and keys of shapes whose results a store keeps.

    Parameters
    ----------
    store : Store
    settings : Settings
    entries : sequence of Entry
    """

    def __init__(self, store: Store, settings: Settings, entries: Sequence[Entry]) -> None:
        self.store, self.settings = store, settings
        self.names = tuple(entry.name for entry in entries)
        self.groups = {entry.name: entry.group for entry in entries}
        self._entries = {entry.name: entry for entry in entries}
        self._found: list[Problem] = []  # when files were read
        self._failed: list[Problem] = []  # in the last run

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        groups = len(set(self.groups.values()) - {""})
        within = f" in {groups} groups" if groups else ""
        return f"{type(self).__name__}({len(self)} shapes{within}, {str(self.store.root)!r})"

    def _repr_html_(self) -> str:
        groups = sorted(set(self.groups.values()) - {""})
        facts = {"store": str(self.store.root), "groups": groups or None, "shapes": list(self.names)}
        return card(f"{type(self).__name__} of {len(self)} shapes", facts)

    def surface(self, name: str) -> Surface:
        """The mesh of a shape, as it was given."""
        return self.store.surface(self._entry(name).surface)

    def shape(self, name: str) -> PreparedShape:
        """A shape prepared for matching, as the store has it; prepared now where it is not.

        Raises
        ------
        QgeoError
            It cannot be prepared: why.
        """
        return restored_shape(self.store, self.settings, self._entry(name).surface)

    def symmetry(self, name: str) -> Symmetry:
        """The self-symmetry of a shape, see `self_symmetry`."""
        return self_symmetry(self.shape(name))

    def _entry(self, name: str) -> Entry:
        if name not in self._entries:
            known = ", ".join(self.names[:5]) + (", ..." if len(self) > 5 else "")
            raise ParameterError(f"no shape is called {name!r}; there are {known}")
        return self._entries[name]

    def _key(self, name: str) -> str:
        return self.settings.shape_key(self._entry(name).surface)

    def _shape_place(self, name: str) -> str:
        return shape_place(self._key(name))

    def _pair_place(self, x: str, y: str) -> str:
        return pair_place(self.settings, self._key(x), self._key(y))

    def _problem_of(self, name: str) -> str:
        """Why a shape cannot be prepared; empty if it can, or if that was not tried yet."""
        values = self.store.values(self._shape_place(name))
        return str((values or {}).get(PROBLEM, ""))
