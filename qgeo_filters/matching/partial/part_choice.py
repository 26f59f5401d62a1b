"""Where a part lies on the whole: of several maps the one along which it deforms best."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.matching.known_parts import KnownParts
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.partial.coarse_maps import CoarseMap, CoarseMapper, coarse_orientation
from qgeo_filters.matching.partial.distance_bounds import mean_violation
from qgeo_filters.matching.partial.landmark_search import landmark_maps
from qgeo_filters.matching.partial.local_descriptors import ball_agreement, descriptor_costs
from qgeo_filters.matching.partial.part_hints import hint_costs
from qgeo_filters.matching.partial.part_registration import PartMap, PartRegistration
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.matching.registration_stages import Stages
from qgeo_filters.parallel import concurrently


@dataclass(frozen=True, eq=False)
class PlacedPart:
    """A part registered to the whole, and what that costs.

    Attributes
    ----------
    map : PartMap
    strain : float
        What is not rigid of the deformation, see `ArapSolver.energy`, over the area of the part.
    torn, folded : float
        Shares of edges whose ends are mapped far apart, and of the area that is turned over.
    distortion : float
        Mean violation of the bounds of distances, see `distance_bounds`.
    unlikeness : float
        Mean cost of the descriptors, see `descriptor_costs`.
    orientation : float
        See `orientation`.
    agreement : float
        Correlation of the areas of balls that no cut has changed with those around the images.
    cost : float
        Product of powers of the above, see `PartialParameters.cost_powers`; distances as fractions of the part's size,
        so that it can be compared between sizes. Times what it does to the hints.
    number : int
        In the log.
    penalty : float
        That factor; 1 without any hints.
    """

    map: PartMap
    strain: float
    torn: float
    folded: float
    distortion: float
    unlikeness: float
    orientation: float
    agreement: float
    cost: float
    number: int
    penalty: float = 1.0


@dataclass(frozen=True, eq=False)
class PartDecision:
    """The best place of a part, and how clear the choice was.

    Attributes
    ----------
    best : PlacedPart
    margin : float
        How many times its cost the next different place's is; inf if there is none.
    runner_up : float
        Distortion of that one.
    unhinted : float
        How many times its cost the cheapest different place's would be if there were no hints; inf without any.
    """

    best: PlacedPart
    margin: float
    runner_up: float
    unhinted: float = np.inf


class PartChoice:
    """The search for one part on one whole, with what is known of its place.

    Parameters
    ----------
    x, y : PartShape
    log : MatchLog
    known : KnownParts, optional
    mirror : (n_x,) int, optional
        Vertex nearest to the mirror point of each vertex of X, where that is known: maps that reverse the orientation
        are turned by it.
    """

    def __init__(
        self,
        x: PartShape,
        y: PartShape,
        log: MatchLog,
        known: KnownParts | None = None,
        mirror: IndexArray | None = None,
    ) -> None:
        self.x, self.y, self.log, self.given, self.known, self.mirror = x, y, log, x.given, known, mirror
        self.descriptors, self.hints = descriptor_costs(x, y), hint_costs(known, x, y)
        self.mapper = CoarseMapper(x, y, self.descriptors, self.hints)

    def places(self) -> list[PlacedPart]:
        """Places that keep the orientation, the cheapest first."""
        return sorted(self.placed([(number, c.p2p) for number, c in self.competing()]), key=lambda p: p.cost)

    def decide(self, places: list[PlacedPart]) -> PartDecision:
        """The cheapest of the places, those that compete settled."""
        placed = self.settled(places)
        return self.decided(min(placed, key=lambda p: p.cost), placed)

    def decided(self, best: PlacedPart, placed: list[PlacedPart]) -> PartDecision:
        """That one of the places, and how clear it is beside the others."""
        self.log.choose(best.number)
        apart = [p for p in placed if images_apart(self.y, p.map.p2p, best.map.p2p) > self.given.apart]
        if not apart:
            return PartDecision(best, np.inf, np.inf)
        rival = min(apart, key=lambda p: p.cost)
        unhinted = min(p.cost / p.penalty for p in apart) / (best.cost / best.penalty) if self.known else np.inf
        return PartDecision(best, rival.cost / best.cost, rival.distortion, unhinted)

    def competing(self) -> list[tuple[int, CoarseMap]]:
        """Coarse maps that are worth registering, with their numbers in the log."""
        given = self.given
        starts = list(landmark_maps(self.x, self.y, self.descriptors, self.hints).images)
        if self.known:  # what would win without the hints is tried, too, so that their disagreement can be told
            starts += list(landmark_maps(self.x, self.y, self.descriptors, np.zeros_like(self.hints)).images)
        grown = concurrently(self.mapper.grown, starts)
        if self.mirror is not None:
            grown += [self._twin(c, self.mirror) for c in grown if c.orientation < given.keeps_orientation]
        grown.sort(
            key=lambda c: c.distortion + given.unlikeness_weight * c.unlikeness + given.hint_weight * c.disagreement
        )
        kept: list[tuple[int, CoarseMap]] = []
        turned = all(c.orientation < given.keeps_orientation for c in grown)
        bound = np.inf
        for c in grown:
            number = self.log.propose("landmarks of the part", c.distortion, c.orientation)
            if c.orientation < given.keeps_orientation and not turned:
                self.log.drop(number, "reverses the orientation")
                continue
            bound = min(bound, given.registered_ratio * c.distortion + given.registered_slack)
            like = next((n for n, k in kept if images_apart(self.y, k.p2p, c.p2p) < given.same), None)
            if like is not None:
                self.log.drop(number, f"the same map as #{like}")
            elif c.distortion > bound:
                self.log.drop(number, f"distorts distances by more than {bound:.3f}")
            elif len(kept) == given.registered:
                self.log.drop(number, f"not among the {given.registered} that distort least")
            else:
                kept.append((number, c))
        return kept

    def proposed(self, p2p: IndexArray, source: str) -> int:
        """Number in the log of a map (s,) of X's first farthest points that comes from elsewhere."""
        place = self.y.rows[:, p2p].argmin(axis=0)
        mapper, given = self.mapper, self.given
        there = mapper.between[np.ix_(place, place)]
        distortion = mean_violation(mapper.least, mapper.most, there, given.within_bounds, given.pair_cap)
        return self.log.propose(source, distortion, coarse_orientation(self.x, self.y, p2p))

    def different(self, places: list[PlacedPart], count: int) -> list[PlacedPart]:
        """The cheapest so many that are different from each other."""
        kept: list[PlacedPart] = []
        for place in sorted(places, key=lambda p: p.cost):
            if all(images_apart(self.y, place.map.p2p, k.map.p2p) > self.given.apart for k in kept):
                kept.append(place)
        return kept[:count]

    def settled(self, places: list[PlacedPart]) -> list[PlacedPart]:
        """The places, in order, after the first ones and the first that is different have come to rest."""
        chosen, rest = places[: self.given.settled], places[self.given.settled :]
        apart = (p for p in places if images_apart(self.y, p.map.p2p, places[0].map.p2p) > self.given.apart)
        rival = next(apart, None)
        if rival in rest:
            chosen.append(rival)
            rest.remove(rival)
        points = self.x.fps[: self.mapper.count]
        return self.placed([(p.number, p.map.p2p[points]) for p in chosen], self.given.settling) + rest

    def placed(self, maps: list[tuple[int, IndexArray]], stages: Stages | None = None) -> list[PlacedPart]:
        """Maps of X's first farthest points, registered, with what each costs; in order.

        Parameters
        ----------
        maps : list of (number in the log, vertices of Y)
        stages : Stages, optional
            ``PartialParameters.stages`` by default.
        """
        steps = self.given.stages if stages is None else stages
        registration = PartRegistration(self.x, self.y, self.x.fps[: self.mapper.count], steps, self.known)
        try:
            found = concurrently(lambda m: registration.register(m[1]), maps)
        finally:
            registration.release()
        return [self._measured(number, part) for (number, _), part in zip(maps, found, strict=True)]

    def _twin(self, c: CoarseMap, mirror: IndexArray) -> CoarseMap:
        """The map after X's reflection: it keeps distances as well, and the orientation."""
        points = self.x.fps[: self.mapper.count]
        nearest = self.x.rows[: len(points), mirror[points]].argmin(axis=0)
        return replace(c, p2p=c.p2p[nearest], orientation=-c.orientation)

    def _measured(self, number: int, part: PartMap) -> PlacedPart:
        x, y, given, p2p = self.x, self.y, self.given, part.p2p
        points = x.fps[: self.mapper.count]
        images = p2p[points]
        place = y.rows[:, images].argmin(axis=0)
        distortion = mean_violation(
            self.mapper.least, self.mapper.most, y.rows[place][:, images], given.within_bounds, given.pair_cap
        )
        unlikeness = float(self.descriptors[np.arange(len(points)), place].mean())
        strain = x.arap.energy(part.positions) / x.area
        torn, folded = _torn(x, y, p2p), _folded(x, y, part)
        turned = orientation(x.surface, y.surface, p2p)
        size = float(np.sqrt(x.area))
        measures = (
            max(strain, given.least_strain),
            torn + given.least_torn,
            folded + given.least_folded,
            unlikeness + given.least_unlikeness,
            max(distortion, given.least_distortion) / size,
        )
        cost = float(np.prod(np.power(measures, given.cost_powers)))
        penalty = float(self.known.penalties(np.arange(len(p2p)), p2p)) ** 2 if self.known else 1.0
        cost *= penalty
        agreement = ball_agreement(x, y, place)
        self.log.note(
            number, mean_distortion=distortion, orientation=turned, strain=strain, torn=torn, folded=folded,
            hks_agreement=agreement, end_cost=cost,
        )  # fmt: skip
        return PlacedPart(part, strain, torn, folded, distortion, unlikeness, turned, agreement, cost, number, penalty)


def images_apart(y: PartShape, one: IndexArray, other: IndexArray) -> float:
    """Mean distance on Y between the images of two maps of the same points, nearly."""
    rows = y.rows[: y.given.gap_rows]
    return float(np.abs(rows[:, one] - rows[:, other]).max(axis=0).mean())


def _torn(x: PartShape, y: PartShape, p2p: IndexArray) -> float:
    a, b = p2p[x.surface.edges.T]
    lengths: FloatArray = np.linalg.norm(y.vertices[a] - y.vertices[b], axis=1)
    far = max(3 * x.surface.edge_lengths.mean(), 2 * y.surface.edge_lengths.mean())
    return float((lengths > far).mean())


def _folded(x: PartShape, y: PartShape, part: PartMap) -> float:
    deformed = x.surface.with_vertices(part.positions)
    against = np.einsum("ij,ij->i", deformed.face_normals, y.normals[part.p2p[x.surface.faces]].sum(axis=1)) < 0
    return float(x.surface.face_areas @ against) / x.area
