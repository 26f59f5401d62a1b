"""A part and a whole as a partial match works on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters.matching.hints import Hints
from qgeo_filters.matching.known_parts import KnownParts
from qgeo_filters.matching.partial.part_hints import known_of_part, resized
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.matching.prepared_shape import PreparedShape


@dataclass(frozen=True, eq=False)
class PartPair:
    """Both shapes in units of sqrt(area) of the whole, and what is known of the part's place."""

    part: PartShape
    whole: PartShape
    known: KnownParts | None

    @classmethod
    def of(
        cls, part: PreparedShape, whole: PreparedShape, given: PartialParameters, hints: Hints | None, side: int
    ) -> PartPair:
        unit = float(np.sqrt(whole.full.area))
        shapes = (
            PartShape(part.oriented, unit, given.part_vertices, given.part_points, given),
            PartShape(whole.oriented, unit, given.whole_vertices, given.whole_points, given),
        )
        return cls(*shapes, known_of_part(hints, (part, whole), shapes, side) if hints else None)

    def resized(self, ratio: float) -> PartPair:
        """The same, the part so many times as large."""
        return PartPair(self.part.resized(ratio), self.whole, resized(self.known, ratio) if self.known else None)
