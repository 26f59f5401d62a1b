"""Which of several maps between all vertices is the best: each is tried as a deformation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters.matching.candidates import Candidate, between, distortion
from qgeo_filters.matching.concurrency import concurrently
from qgeo_filters.matching.descriptor import Descriptor
from qgeo_filters.matching.finish import ENDING, RECONSIDERING, SETTLING, TRIAL, Finished, Pass, factorised, finished
from qgeo_filters.matching.likeness import likeness
from qgeo_filters.matching.limbs import leaves_limbs
from qgeo_filters.matching.parts import turned_parts
from qgeo_filters.matching.search import DISTINCT, differ

IndexArray = npt.NDArray[np.int64]

# Contenders that are tried, and how much more than the best they may distort distances.
_CONTENDERS = 10
_CONTENDING = 1.7
# Of these, at most so many are taken further, if they cost no more than this many times the cheapest; and of those
# whose images are this near in the mean, in sqrt(area), at most so many.
_CLOSEST, _CLOSE = 4, 6.0
_KIN, _MOST_KIN = 0.1, 2
# And of those so many are reconsidered.
_RECONSIDERED = 2
# An edge is torn if its ends are mapped this many mean edges apart.
_TORN = 3.0
# Shares of torn edges and folded triangles, strains and distortions below these do not tell maps apart.
_LEAST_TORN, _LEAST_FOLDED, _LEAST_STRAIN, _LEAST_DISTORTION = 1e-3, 5e-4, 1e-3, 1e-4
_LEAST_UNLIKE = 5e-3
# Maps of a shape to its mirror image that relate parts as different as that, its front to its back, are no reflections.
_ALIKE = 0.9
# A map that leaves limbs in place, which another one exchanges, is none, unless that one costs this many times as much
# or is less alike.
_AT_REST, _MORE_ALIKE = 30.0, 0.96
# Times that parts of the best map are turned, as long as it costs no more than this many times the cheapest (a part
# that is right in the large may need another turn to fit), and most parts at a time.
_TURNED, _PATIENCE, _MOST_PARTS = 3, 1.5, 2
# Mean distance between images, in sqrt(area), up to which maps are the same.
_TURNED_BACK = 0.01


@dataclass(frozen=True, eq=False)
class Contender:
    """A candidate after a trial, or further on.

    Attributes
    ----------
    result : Finished
    distortion : float
        As of a candidate, after the trial.
    strain : float
        What is not rigid of the deformation of X along the map, see `Rigidity.strain`.
    torn : float
        Share of X's edges whose ends are mapped far apart.
    folded : float
        Share of X's area that the deformation turns over.
    likeness : float
        See `likeness`.
    """

    result: Finished
    distortion: float
    strain: float
    torn: float
    folded: float
    likeness: float

    @property
    def cost(self) -> float:
        """Product of strain, torn and folded shares, and root of the distortion: larger for a map wrong in a part."""
        torn, folded = max(self.torn, _LEAST_TORN), self.folded + _LEAST_FOLDED
        strain, unlike = max(self.strain, _LEAST_STRAIN), 1 - self.likeness + _LEAST_UNLIKE
        return strain * torn * folded * unlike * np.sqrt(max(self.distortion, _LEAST_DISTORTION))


@dataclass(frozen=True, eq=False)
class Decision:
    """The best map, and how clear the choice was.

    Attributes
    ----------
    result : Finished
    distortion : float
        See `Candidate`.
    margin : float
        How many times its cost the next different contender's is; inf if there is none.
    runner_up : float
        Distortion of that one.
    """

    result: Finished
    distortion: float
    margin: float
    runner_up: float


def contenders(x: Descriptor, y: Descriptor, pool: list[Candidate]) -> list[Contender]:
    """The best different candidates, deformed onto Y on trial, the cheapest first.

    A map that is right in one part and wrong in another, such as one that swaps two legs, can keep distances better
    than the right one does between two poses; but a deformation that follows it has to tear, fold or twist the surface
    in between. The maps must keep the orientation.
    """
    ranked = sorted(pool, key=lambda c: c.distortion)
    best = ranked[0].distortion
    tried: list[Candidate] = []
    for c in ranked:
        near = len(tried) < _CONTENDERS and c.distortion <= _CONTENDING * best + 0.01
        if near and all(differ(between(y, c.p2p, t.p2p)) for t in tried):
            tried.append(c)
    return sorted(_taken_further(x, y, [c.p2p for c in tried], TRIAL), key=lambda c: c.cost)


def decided(
    x: Descriptor, y: Descriptor, pool: list[Candidate], apart: float = DISTINCT, *, mirror: bool = False
) -> Decision:
    """The best of the maps, finished on all vertices: of those that cost little on trial the one that ends cheapest.

    Rivals are contenders whose images are ``apart`` in the mean, in sqrt(area), from those of the best.
    With ``mirror``, Y is X's mirror image of the same vertices.
    """
    ranked = contenders(x, y, pool)
    if mirror:
        ranked = _reflections(x, ranked)
    close: list[Contender] = []
    for c in ranked:
        near = len(close) < _CLOSEST and c.cost <= _CLOSE * ranked[0].cost
        kin = [t for t in close if between(y, c.result.p2p, t.result.p2p).mean() < _KIN]
        if near and len(kin) < _MOST_KIN:
            close.append(c)
    ends = _taken_further(x, y, [c.result.p2p for c in close], SETTLING)
    first = sorted(range(len(close)), key=lambda i: ends[i].cost)[:_RECONSIDERED]
    again = _taken_further(x, y, [ends[i].result.p2p for i in first], RECONSIDERING)
    for i, c in zip(first, again, strict=True):
        ends[i] = min(ends[i], c, key=lambda c: c.cost)
    order = sorted(range(len(close)), key=lambda i: ends[i].cost)
    best, trial = ends[order[0]], close[order[0]]

    def elsewhere(c: Contender) -> bool:
        return float(between(y, c.result.p2p, best.result.p2p).mean()) > apart

    # A rival that was taken further is compared there, the others as they were on trial.
    rivals = [(ends[i].cost / best.cost, ends[i]) for i in order[1:] if elsewhere(ends[i])]
    rivals += [(c.cost / trial.cost, c) for c in ranked if not any(c is t for t in close) and elsewhere(c)]
    margin, rival = min(rivals, key=lambda pair: pair[0], default=(np.inf, None))
    if mirror:
        best = _turned(x, y, best)
    result = finished(x, y, best.result.p2p, ENDING)
    x.rigidity.release()
    return Decision(result, best.distortion, margin, rival.distortion if rival else np.inf)


def _reflections(x: Descriptor, ranked: list[Contender]) -> list[Contender]:
    """Those contenders for a reflection of X that may be one, in the same order."""
    alike = [c for c in ranked if c.likeness > _ALIKE] or ranked

    def in_place(c: Contender) -> bool:
        whole = [o for o in alike if o is not c and o.cost < _AT_REST * c.cost and o.likeness > _MORE_ALIKE]
        return any(leaves_limbs(x, c.result.p2p, o.result.p2p) for o in whole)

    return [c for c in alike if not in_place(c)] or alike


def _turned(x: Descriptor, y: Descriptor, best: Contender) -> Contender:
    """The contender, or a cheaper one in which parts are turned."""
    last = best
    for _ in range(_TURNED):
        ends = _taken_further(x, y, turned_parts(x, y, last.result)[:_MOST_PARTS], TRIAL + SETTLING)
        # A part that was turned for nothing has turned back; of the others the one that fits best is gone on with.
        ends = [c for c in ends if float(between(y, c.result.p2p, last.result.p2p).mean()) > _TURNED_BACK]
        best = min(best, *ends, key=lambda c: c.cost) if ends else best
        if not ends or ends[0].cost > _PATIENCE * best.cost:
            break
        last = ends[0]
    return best


def _taken_further(x: Descriptor, y: Descriptor, maps: list[IndexArray], passes: tuple[Pass, ...]) -> list[Contender]:
    factorised(x, y, passes)
    return concurrently(lambda p2p: _contender(x, y, finished(x, y, p2p, passes)), maps)


def _contender(x: Descriptor, y: Descriptor, result: Finished) -> Contender:
    p2p = result.p2p
    a, b = p2p[x.unit.edges.T]
    lengths = np.linalg.norm(y.unit.vertices[a] - y.unit.vertices[b], axis=1)
    torn = float((lengths > _TORN * x.unit.edge_lengths.mean()).mean())
    deformed = x.unit.with_vertices(result.positions)
    against = np.einsum("ij,ij->i", deformed.face_normals, y.normals[p2p[x.unit.faces]].sum(axis=1)) < 0
    folded = float(x.unit.face_areas @ against) / x.unit.area
    return Contender(
        result, distortion(x, y, p2p), x.rigidity.strain(result.positions), torn, folded, likeness(x, y, p2p)
    )
