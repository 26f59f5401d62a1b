"""What the maps of a collection say together: which contradict the others, consistent maps, one connectivity."""

from __future__ import annotations

import functools
import time
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import IndexArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.collection.common import CommonShapes, common_shapes
from qgeo_filters.collection.composition import Pair
from qgeo_filters.collection.cycles import THIRDS, TOLERANCE, CycleConsistency, cycle_consistency
from qgeo_filters.collection.landmarks import landmark_table, landmarks_on_all
from qgeo_filters.collection.mending import MendedPair, Registration, mended_maps, registration
from qgeo_filters.collection.pair_arrays import record_of_match
from qgeo_filters.collection.records import Record
from qgeo_filters.collection.results import Results
from qgeo_filters.collection.settings import map_key
from qgeo_filters.collection.spanning_tree import spanning_tree, template_maps, tree_maps
from qgeo_filters.collection.store import mended_place
from qgeo_filters.collection.synchronisation import synchronised_map, synchronised_maps
from qgeo_filters.collection.tasks import PROBLEM
from qgeo_filters.errors import ParameterError, QgeoError, reason, require_package
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.hosts.wrap import Wrap
from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.surface import Surface

#: Which maps: as they were matched, or such as agree with each other.
How = Literal["matched", "mended", "tree", "template", "all ways"]
_HOWS = ("matched", "mended", "tree", "template", "all ways")


class Consistent(Results):
    """Shapes and pairs whose maps are looked at together."""

    def surfaces(self) -> dict[str, Surface]:
        """The meshes of all shapes, by name."""
        return {name: self.surface(name) for name in self.names}

    def maps(self, how: How = "matched", *, template: str | None = None) -> dict[Pair, BarycentricMap]:
        """Maps between shapes, as points in triangles.

        Parameters
        ----------
        how : {"matched", "mended", "tree", "template", "all ways"}
            As they were matched, that from y to x of the same match where there is no other; with those that contradict
            all others matched again (`mended`); along the tree of the pairs that contradict the others least; through a
            template; or the middle of all ways through a third shape, see `synchronised_maps`, which had the least
            error in benchmarks/README.md, "Consistent maps".
        template : str, optional
            For "template"; by default the shape that contradicts the others least.

        Raises
        ------
        ParameterError
            Pairs that are not matched, but needed: which.
        """
        _checked(how)
        if how == "mended":
            return self.mended()[0]
        surfaces, matched = self.surfaces(), self._matched()
        if how == "matched":
            return matched
        consistency = self._consistency(matched)
        if how == "tree":
            return tree_maps(surfaces, matched, spanning_tree(self.names, dict(consistency.ranked())))
        if how == "template":
            return template_maps(surfaces, matched, template or _middle(consistency))
        return synchronised_maps(surfaces, matched, consistency)

    def maps_from(self, name: str, how: How = "matched") -> dict[str, BarycentricMap]:
        """Maps from one shape to every other, see `maps`; as matched, those that are missing are found now."""
        return {y: place for (_, y), place in self._along(name, [(name, y) for y in self._others(name)], how).items()}

    def maps_to(
        self, name: str, how: How = "matched", *, names: Sequence[str] | None = None
    ) -> dict[str, BarycentricMap]:
        """Maps to one shape, as `maps_from`: from every other, or those named. They bring its values to the others."""
        pairs = [(x, name) for x in self._others(name) if names is None or x in names]
        return {x: place for (x, _), place in self._along(name, pairs, how).items()}

    def consistency(self, *, thirds: int | None = THIRDS, seed: int = 0) -> CycleConsistency:
        """How far each map contradicts those through a third shape; takes three shapes, all of them matched.

        Parameters
        ----------
        thirds : int, optional
            How many third shapes each map is judged by at most, at random beyond that; None: all, see
            `cycle_consistency`.
        seed : int
        """
        return self._consistency(self._matched(), thirds=thirds, seed=seed)

    def mended(self, *, tolerance: float = TOLERANCE) -> tuple[dict[Pair, BarycentricMap], list[MendedPair]]:
        """The maps with wrong ones matched again from where all others say, and what became of each wrong pair.

        What is found is kept in the store, and found again as long as the others say the same.
        """
        surfaces, matched, repairs = self.surfaces(), self._matched(), self._repairs()
        consistency = cycle_consistency(surfaces, matched, repairs=repairs)
        register = self._kept_registration()
        return mended_maps(surfaces, matched, consistency, tolerance=tolerance, register=register, repairs=repairs)

    def common(self, template: str, *, how: How = "matched", accept_unsure: bool = False) -> CommonShapes:
        """All shapes with the triangles of one of them, for means, modes and statistics, see `remesh_like`.

        Parameters
        ----------
        template : str
            Name of a shape.
        how : str
            Which maps, see `maps`; as matched, the template is matched with each shape now where it was not.
        accept_unsure : bool
            Whether maps that are not sure are used, with a warning; those that agree with the others count as sure.

        Raises
        ------
        ParameterError
            No such shape, a map that is not sure, shapes without a way from the template.
        """
        found: Mapping[str, Any]
        if how == "matched":  # a match says whether it is sure, and what was wrapped
            found, wraps = {other: self._match_of(template, other)[0] for other in self._others(template)}, {}
        else:
            found = self.maps_from(template, how)
            wraps = {name: repair for name, repair in self._repairs().items() if isinstance(repair, Wrap)}
        surfaces = self.surfaces()
        return common_shapes(surfaces[template], surfaces, found, accept_unsure=accept_unsure, wraps=wraps)

    def landmarks(
        self, landmarks: Landmarks | npt.ArrayLike, on: str, *, how: How = "matched", tolerance: float = 0.05
    ) -> dict[str, Landmarks]:
        """Landmarks that were placed on one shape, on all; parameters as in `common` and `landmarks_on_all`."""
        along = {(on, other): place for other, place in self.maps_from(on, how).items()}
        return landmarks_on_all(landmarks, on, self.surfaces(), along, tolerance=tolerance)

    def landmark_table(self, landmarks: Landmarks | npt.ArrayLike, on: str, *, how: How = "matched") -> Any:
        """The same as a pandas DataFrame with columns shape, landmark, x, y, z; NaN where one has no image."""
        pandas = require_package("pandas", "collections", "Collection.landmark_table")
        return pandas.DataFrame(landmark_table(self.landmarks(landmarks, on, how=how)))

    def _consistency(self, matched: Mapping[Pair, BarycentricMap], **chosen: Any) -> CycleConsistency:
        return cycle_consistency(self.surfaces(), matched, repairs=self._repairs(), **chosen)

    def _repairs(self) -> dict[str, Repair]:
        """What was matched in place of the shapes that were repaired."""
        mended = [name for name in self.names if "repair" in (self.store.values(self._shape_place(name)) or {})]
        found = {name: self.shape(name).repair for name in mended}
        return {name: repair for name, repair in found.items() if repair is not None}

    def _kept_registration(self) -> Registration:
        """Matches from maps that are known in the large, each found once, and kept by these maps' content."""
        shape_of = functools.cache(self.shape)
        match_again = registration(shape_of)

        def register(x: str, y: str, start: IndexArray, rival: IndexArray | None) -> MatchResult:
            place = mended_place(self.settings, self._key(x), self._key(y), map_key(start, rival))
            record = self.store.read(place)
            if record is None:
                started = time.process_time()
                try:
                    found = match_again(x, y, start, rival)
                    new = record_of_match(found, shape_of(x), shape_of(y), time.process_time() - started)
                except QgeoError as error:  # of these two shapes: it would come again
                    new = Record({}, {PROBLEM: reason(error)})
                self.store.write(place, new.arrays, new.values)
                record = self.store.read(place)
            return self._match_in(record, place, x, y)

        return register

    def _matched(self) -> dict[Pair, BarycentricMap]:
        """Maps of all pairs that the store has; both ways of one match where the other way has none of its own."""
        found: dict[Pair, BarycentricMap] = {}
        back: dict[Pair, BarycentricMap] = {}
        for x, y, values in self._pairs():
            if PROBLEM not in values:
                one = self.map(x, y)
                found[x, y], back[y, x] = one.barycentric, one.inverse_barycentric
        return {**back, **found}

    def _along(self, name: str, pairs: Sequence[Pair], how: How) -> dict[Pair, BarycentricMap]:
        """Maps of some pairs, through this shape where they go through one; none where there is no way."""
        _checked(how)
        if how == "matched":
            return {pair: self._place(*pair) for pair in pairs}
        if how == "all ways":  # no maps of other pairs are needed
            surfaces, matched = self.surfaces(), self._matched()
            consistency = self._consistency(matched)
            known = {pair: synchronised_map(*pair, surfaces, matched, consistency) for pair in pairs}
        else:
            known = {**self.maps(how, template=name if how == "template" else None)}
        return {pair: place for pair in pairs if (place := known.get(pair)) is not None}

    def _place(self, x: str, y: str) -> BarycentricMap:
        found, ahead = self._match_of(x, y)
        return found.barycentric if ahead else found.inverse_barycentric

    def _match_of(self, x: str, y: str) -> tuple[MatchResult, bool]:
        """The match of two shapes in whichever direction there is one, and whether from x; found now if in neither."""
        ahead = self.store.has(self._pair_place(x, y)) or not self.store.has(self._pair_place(y, x))
        return self.map(x, y) if ahead else self.map(y, x), ahead

    def _others(self, name: str) -> list[str]:
        self._entry(name)
        return [other for other in self.names if other != name]


def _checked(how: str) -> None:
    if how not in _HOWS:
        raise ParameterError(f"how must be one of {', '.join(map(repr, _HOWS))}, got {how!r}")


def _middle(consistency: CycleConsistency) -> str:
    return consistency.names[int(np.nanmean(consistency.inconsistency, axis=1).argmin())]
