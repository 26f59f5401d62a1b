"""What a collection has: maps, tables, distances, and what is wrong with which shape."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.collection.measures import (
    OF_MAPS,
    OF_SHAPES,
    c_xy_by_vertex_order,
    checked_measure,
    spectral_distances,
)
from qgeo_filters.collection.members import Problem
from qgeo_filters.collection.pair_arrays import match_of_record
from qgeo_filters.collection.records import Record
from qgeo_filters.collection.store import MENDED
from qgeo_filters.collection.stored_shapes import StoredShapes
from qgeo_filters.collection.tables import pair_table, square
from qgeo_filters.collection.tasks import PROBLEM, pair_task
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.compatibility import Compatibility
from qgeo_filters.matching.compatibility import compatibility as compatibility_of
from qgeo_filters.matching.match_result import MatchResult

#: True vertex of Y for each vertex of X: by names, or from a function of them; None where it is not known.
Truth = Mapping[tuple[str, str], npt.ArrayLike] | Callable[[str, str], npt.ArrayLike | None]

# A shape none of so many maps of which is sure may belong elsewhere.
_DOUBTFUL = 2


@dataclass(frozen=True)
class Status:
    """How far the work on a collection has come.

    Attributes
    ----------
    shapes, prepared, unprepared : int
        All; those that are ready; those that cannot be.
    pairs, matched, confident, failed : int
        All; those with a map; sure maps; those that cannot be matched.
    seconds : float
        CPU time of the maps.
    matched_again : int
        Pairs that `Collection.mended` matched again, because they contradicted all others.
    """

    shapes: int
    prepared: int
    unprepared: int
    pairs: int
    matched: int
    confident: int
    failed: int
    seconds: float
    matched_again: int = 0


class Results(StoredShapes):
    """Shapes and pairs whose results are read from a store."""

    def map(self, x: str, y: str) -> MatchResult:
        """The match of two shapes, see `match`; found now where it is not kept yet.

        Parameters
        ----------
        x, y : str
            Names, in this order: the map from y to x is another one.

        Raises
        ------
        QgeoError
            The pair cannot be matched: why.
        """
        place = self._pair_place(x, y)
        record = self.store.read(place)
        if record is None:
            keys = self._entry(x).surface, self._entry(y).surface
            for failure in pair_task(str(self.store.root), self.settings, [keys], workers=None):
                raise ParameterError(f"{x} - {y}: {failure.reason}")
            record = self.store.read(place)
        return self._match_in(record, place, x, y)

    def table(self, truth: Truth | None = None, *, seconds: bool = False) -> Any:
        """A row for each pair that was matched, in the order of the names.

        Parameters
        ----------
        truth : mapping of (str, str) to array-like, or callable, optional
            True vertex of Y for each vertex of X (-1: not known): adds the column ``error``, the mean geodesic error in
            sqrt(area) of Y, NaN for pairs without.
        seconds : bool
            Whether to add the CPU time of each match, which is another one in each run.

        Returns
        -------
        pandas.DataFrame
            Columns x, y, group_x, group_y, c_xy, d_s, distortion, confident, margin, orientation, hks_agreement,
            overlap_x, overlap_y, explanation and problem: why a pair cannot be matched, empty if it was.
        """
        rows = list(self._pairs())
        extra = ["seconds"] if seconds else []
        if truth is not None:
            rows = [(x, y, {**values, "error": self._error(x, y, values, truth)}) for x, y, values in rows]
            extra.append("error")
        return pair_table(rows, self.groups, extra)

    def distances(self, measure: str = "c_xy", *, by_vertex_order: bool = False) -> Any:
        """How far each two shapes are apart, as a labelled square.

        Parameters
        ----------
        measure : {"c_xy", "d_s", "distortion", "eigenvalues", "shape_dna"}
            See `collection.measures`. The last two need no maps.
        by_vertex_order : bool
            For "c_xy" of the poses of one mesh: vertex i is the same point of all, and no map is needed.

        Returns
        -------
        pandas.DataFrame
            Symmetric, zero on the diagonal; NaN for pairs that are not matched. Where a pair is matched both ways, the
            map from the earlier shape counts.

        Raises
        ------
        ParameterError
            An unknown measure; shapes of different triangles by vertex order.
        """
        checked_measure(measure)
        if by_vertex_order:
            if measure != "c_xy":
                raise ParameterError(f"by vertex order there is 'c_xy' only, not {measure!r}")
            return square(c_xy_by_vertex_order([self.shape(name) for name in self.names], self.names), self.names)
        if measure in OF_SHAPES:
            return square(spectral_distances(measure, self._eigenvalues(measure)), self.names)
        found = np.full((len(self), len(self)), np.nan)
        np.fill_diagonal(found, 0.0)
        place = {name: number for number, name in enumerate(self.names)}
        # Those from the later shape first: the others replace them.
        for x, y, values in sorted(self._pairs(), key=lambda row: place[row[0]] < place[row[1]]):
            value = values.get(OF_MAPS[measure])
            found[place[x], place[y]] = found[place[y], place[x]] = np.nan if value is None else value
        return square(found, self.names)

    def compatibility(
        self, names: Sequence[str] | None = None, baselines: tuple[int, int] = (0, 1), *, k: int = 20
    ) -> Compatibility:
        """D(S) of some shapes, all by default, along the maps from the first baseline, see `compatibility`."""
        chosen = list(self.names if names is None else names)
        if not 0 <= baselines[0] < len(chosen):
            raise ParameterError(f"baselines must be numbers of two of the {len(chosen)} shapes, got {baselines!r}")
        surfaces, first = [self.surface(name) for name in chosen], chosen[baselines[0]]
        maps = [
            np.arange(surface.n_vertices) if name == first else self.map(first, name).p2p
            for name, surface in zip(chosen, surfaces, strict=True)
        ]
        return compatibility_of(surfaces, baselines, k=k, maps=maps, repair=self.settings.repair)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """What is wrong with which shape or pair: files that cannot be read, copies, shapes that cannot be prepared.

        And pairs that cannot be matched, and shapes of which no map is sure: they may not belong with the others.
        """
        found = [*self._found, *self._failed]
        found += [Problem(name, said) for name in self.names if (said := self._problem_of(name))]
        sure: dict[str, list[bool]] = {name: [] for name in self.names}
        for x, y, values in self._pairs():
            if PROBLEM in values:
                found.append(Problem(f"{x} - {y}", values[PROBLEM]))
                continue
            for name in (x, y):
                sure[name].append(bool(values["confident"]))
        for name, flags in sure.items():
            if len(flags) >= _DOUBTFUL and not any(flags):
                said = f"none of its {len(flags)} maps is sure: it may not belong with the others"
                found.append(Problem(name, said, lost=False))
        return tuple(dict.fromkeys(found))

    def status(self) -> Status:
        """How far the work has come; all pairs of two shapes are counted."""
        known = [self.store.values(self._shape_place(name)) for name in self.names]
        ready = [PROBLEM not in values for values in known if values is not None]
        rows = [values for _, _, values in self._pairs()]
        matched = [values for values in rows if PROBLEM not in values]
        return Status(
            len(self),
            sum(ready),
            len(ready) - sum(ready),
            len(self) * (len(self) - 1) // 2,
            len(matched),
            sum(bool(values["confident"]) for values in matched),
            len(rows) - len(matched),
            float(sum(values["seconds"] for values in matched)),
            self._matched_again(),
        )

    def _match_in(self, record: Record | None, place: str, x: str, y: str) -> MatchResult:
        """The match of two shapes that a record holds which must be there."""
        if record is None:
            raise OSError(f"{self.store.root / place} cannot be read after it was written")
        if PROBLEM in record.values:
            raise ParameterError(f"{x} - {y}: {record.values[PROBLEM]}")
        return match_of_record(record, self.surface(x), self.surface(y))

    def _matched_again(self) -> int:
        """Number of pairs that `mended` has found a map for, right or not, from where the others say."""
        keys = {self._key(name) for name in self.names}
        return sum(len(keys.intersection(self.store.pairs_of(self.settings.how, key, MENDED))) for key in keys)

    def _pairs(self) -> Iterator[tuple[str, str, dict[str, Any]]]:
        """Names of the pairs that the store has, and the values of their records."""
        keys = {name: self._key(name) for name in self.names}
        for place, x in enumerate(self.names):
            there = set(self.store.pairs_of(self.settings.how, keys[x]))
            for other, y in enumerate(self.names):
                # Copies of one mesh share the record of both directions.
                if keys[y] in there and (place < other or keys[x] != keys[y]):
                    values = self.store.values(self._pair_place(x, y))
                    if values is not None:
                        yield x, y, values

    def _eigenvalues(self, measure: str) -> list[np.ndarray]:
        name = OF_SHAPES[measure].format(last=len(self.settings.parameters.curvature_weights) - 1)
        found = []
        for shape in self.names:
            record = self.store.read(self._shape_place(shape), [name])
            if record is None:
                raise ParameterError(f"{shape} is not prepared yet: call prepare() first")
            found.append(record.arrays.get(name, np.zeros(0)))
        return found

    def _error(self, x: str, y: str, values: Mapping[str, Any], truth: Truth) -> float:
        target = truth(x, y) if callable(truth) else truth.get((x, y))
        if target is None or PROBLEM in values:
            return float("nan")
        errors = self.map(x, y).error(target)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of a mean of nothing
            return float(np.nanmean(errors))
