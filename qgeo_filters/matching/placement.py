"""Places of one shape on another that need not keep distances: they may be shorter there, near any point."""

from __future__ import annotations

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.known_parts import KnownParts
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.partial.coarse_maps import CoarseMap
from qgeo_filters.matching.partial.part_choice import PartChoice, images_apart
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.symmetry import reflection_of


class Placement:
    """The search for places of X on Y, between the coarse shapes of a problem; ``compared`` is where they compete.

    As that for a part on a whole: landmarks one after the other, by what surrounds them and by distances within bounds.
    """

    def __init__(self, problem: MatchProblem, given: PartialParameters) -> None:
        x, y = problem.x, problem.y
        self.given, self.known, self.log = given, problem.known, problem.log
        self.mirror = reflection_of(x, problem.parameters)
        self.x = PartShape(x.unit, 1.0, x.n_vertices, given.part_points, given)
        self.y = PartShape(y.unit, 1.0, y.n_vertices, given.whole_points, given)
        self.compared = self._choice(given.compared_reach, self.log, problem.known)

    def proposed(self) -> list[tuple[int, IndexArray]]:
        """Different maps of X's first farthest points, with their numbers in the log.

        Where something is known of the place, those that are found without it compete: it may lead the search astray.
        """
        kept: list[CoarseMap] = []
        for known in dict.fromkeys((self.known, None)):
            for reach in self.given.shortcut_reaches:
                for _, c in self._choice(reach, MatchLog(), known).competing():
                    if all(images_apart(self.y, c.p2p, other.p2p) > self.given.same for other in kept):
                        kept.append(c)
        name = "place where distances may be shorter"
        return [(self.log.propose(name, c.distortion, c.orientation), c.p2p) for c in kept]

    def at_points(self, p2p: IndexArray) -> IndexArray:
        """Images of X's first farthest points by a map of all its vertices."""
        return p2p[self.x.fps[: self.compared.mapper.count]]

    def _choice(self, reach: float, log: MatchLog, known: KnownParts | None) -> PartChoice:
        return PartChoice(self.x.with_shortcuts(reach), self.y, log, known, self.mirror)
