"""Which of several maps between all vertices is the best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters.matching.initialization.candidates import Candidate, between
from qgeo_filters.matching.initialization.sign_search import DISTINCT
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.selection.cost import Contender, contenders, settled, taken_further
from qgeo_filters.matching.selection.fixed_limbs import leaves_limbs
from qgeo_filters.matching.selection.part_icp import turned_parts
from qgeo_filters.matching.smooth_shells import ENDING, SETTLING, TRIAL, Finished, finished

# Of the contenders at most so many are taken further, if they cost no more than this many times the cheapest; and of
# those whose images are this near in the mean, in sqrt(area), at most so many.
_CLOSEST, _CLOSE = 4, 6.0
_KIN, _MOST_KIN = 0.1, 2
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


def decided(
    x: PreparedShape, y: PreparedShape, pool: list[Candidate], apart: float = DISTINCT, *, mirror: bool = False
) -> Decision:
    """The best of the maps, finished on all vertices: of those that cost little on trial the one that ends cheapest.

    Rivals are contenders whose images are ``apart`` in the mean, in sqrt(area), from those of the best.
    With ``mirror``, Y is X's mirror image of the same vertices.
    """
    try:
        return _decided(x, y, pool, apart, mirror)
    finally:
        x.rigidity.release()


def _decided(x: PreparedShape, y: PreparedShape, pool: list[Candidate], apart: float, mirror: bool) -> Decision:
    ranked = contenders(x, y, pool)
    if mirror:
        ranked = _reflections(x, ranked)
    close = _close(y, ranked)
    ends = settled(x, y, [c.result.p2p for c in close])
    order = sorted(range(len(close)), key=lambda i: ends[i].end_cost)
    best, trial = ends[order[0]], close[order[0]]

    def elsewhere(c: Contender) -> bool:
        return float(between(y, c.result.p2p, best.result.p2p).mean()) > apart

    # A rival that was taken further is compared there, the others as they were on trial.
    rivals = [(ends[i].end_cost / best.end_cost, ends[i]) for i in order[1:] if elsewhere(ends[i])]
    rivals += [(c.cost / trial.cost, c) for c in ranked if not any(c is t for t in close) and elsewhere(c)]
    margin, rival = min(rivals, key=lambda pair: pair[0], default=(np.inf, None))
    if mirror:
        best = _turned(x, y, best)
    result = finished(x, y, best.result.p2p, ENDING)
    return Decision(result, best.distortion, margin, rival.distortion if rival else np.inf)


def _close(y: PreparedShape, ranked: list[Contender]) -> list[Contender]:
    """Those whose cost on trial is near the least, not too many of one kind."""
    close: list[Contender] = []
    for c in ranked:
        near = len(close) < _CLOSEST and c.cost <= _CLOSE * ranked[0].cost
        kin = [t for t in close if between(y, c.result.p2p, t.result.p2p).mean() < _KIN]
        if near and len(kin) < _MOST_KIN:
            close.append(c)
    return close


def _reflections(x: PreparedShape, ranked: list[Contender]) -> list[Contender]:
    """Those contenders for a reflection of X that may be one, in the same order."""
    alike = [c for c in ranked if c.likeness > _ALIKE] or ranked

    def in_place(c: Contender) -> bool:
        whole = [o for o in alike if o is not c and o.cost < _AT_REST * c.cost and o.likeness > _MORE_ALIKE]
        return any(leaves_limbs(x, c.result.p2p, o.result.p2p) for o in whole)

    return [c for c in alike if not in_place(c)] or alike


def _turned(x: PreparedShape, y: PreparedShape, best: Contender) -> Contender:
    """The contender, or a cheaper one in which parts are turned."""
    last = best
    for _ in range(_TURNED):
        ends = taken_further(x, y, turned_parts(x, y, last.result)[:_MOST_PARTS], TRIAL + SETTLING)
        # A part that was turned for nothing has turned back; of the others the one that fits best is gone on with.
        ends = [c for c in ends if float(between(y, c.result.p2p, last.result.p2p).mean()) > _TURNED_BACK]
        best = min(best, *ends, key=lambda c: c.cost) if ends else best
        if not ends or ends[0].cost > _PATIENCE * best.cost:
            break
        last = ends[0]
    return best
