"""The size of a part: where sizes do not count, several are tried, and the cheapest place of all is taken."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.partial.distance_bounds import distance_bounds
from qgeo_filters.matching.partial.part_choice import PartChoice, PartDecision, PlacedPart, images_apart
from qgeo_filters.matching.partial.part_pair import PartPair


@dataclass(frozen=True, eq=False)
class SizedPart:
    """Places of a part of some size, the cheapest first, with a log of their own."""

    pair: PartPair
    choice: PartChoice
    places: list[PlacedPart]

    @classmethod
    def of(cls, pair: PartPair, log: MatchLog) -> SizedPart:
        choice = PartChoice(pair.part, pair.whole, log, pair.known)
        return cls(pair, choice, choice.places())

    @property
    def cost(self) -> float:
        """What the cheapest place costs, before it comes to rest."""
        return self.places[0].cost

    @property
    def relative_size(self) -> float:
        """How many times the part's size its image has, by distances that no cut has changed; 1 if there are none."""
        part, whole, p2p = self.pair.part, self.pair.whole, self.places[0].map.p2p
        points = part.fps[: part.given.coarse_points]
        least, most = distance_bounds(part, len(points))
        place = whole.rows[:, p2p[points]].argmin(axis=0)
        there = whole.rows[place][:, p2p[points]]
        told = (least >= most) & (most > part.given.least_distance)
        return float(np.median(there[told] / most[told])) if told.any() else 1.0


def decided(pair: PartPair, log: MatchLog, normalize: bool) -> tuple[PartPair, PartDecision]:
    """The cheapest place of the part; at several sizes, if sizes do not count, and at the one that distances tell.

    The margin is also that over different places at other sizes.
    """
    if not normalize:
        only = SizedPart.of(pair, log)
        return pair, only.choice.decide(only.places)
    given = pair.part.given
    possible = (size for size in given.sizes if size == 1 or pair.part.area * size**2 < given.most_area)
    tried = [SizedPart.of(pair.resized(size), MatchLog()) for size in possible]
    best = min(tried, key=lambda t: t.cost)
    size = best.relative_size
    if abs(np.log(size)) > np.log(given.same_size):
        tried.append(SizedPart.of(best.pair.resized(size), MatchLog()))
        best = min(tried, key=lambda t: t.cost)
    decision = best.choice.decide(best.places)
    log.maps = best.choice.log.maps
    here = decision.best.map.p2p
    apart = [t.places[0] for t in tried if images_apart(pair.whole, t.places[0].map.p2p, here) > given.apart]
    rival = min(apart, key=lambda p: p.cost, default=None)
    # Neither has come to rest.
    if rival is not None and rival.cost < decision.margin * best.cost:
        decision = replace(decision, margin=rival.cost / best.cost, runner_up=rival.distortion)
    return best.pair, decision
