"""Where on the whole a few landmarks of a part may lie: a beam search over their distances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.matching.partial.distance_bounds import added_costs, distance_bounds
from qgeo_filters.matching.partial.part_shape import PartShape


@dataclass(frozen=True, eq=False)
class LandmarkMaps:
    """Hypotheses, the cheapest first.

    Attributes
    ----------
    images : (h, l) int
        Place among Y's farthest points of each of the first l farthest points of X.
    costs : (h,) float64
    """

    images: IndexArray
    costs: FloatArray


def landmark_maps(x: PartShape, y: PartShape, descriptors: SingleArray, hints: SingleArray) -> LandmarkMaps:
    """Different maps of the first farthest points of X to those of Y, which keep distances and surroundings best.

    The landmarks lie far from the rim of X and from each other. They are added one after the other; hypotheses are kept
    that violate the bounds of distances least, not too many of one kind.
    """
    given = x.given
    targets = min(given.landmark_targets, len(y.fps))
    between = np.ascontiguousarray(y.rows[:targets][:, y.fps[:targets]])
    between = np.maximum(between, between.T)
    count = min(given.landmarks, len(x.fps))
    least, most = distance_bounds(x, count)
    kind = between[: given.kinds].argmin(axis=0)
    alone = given.descriptor_weight * descriptors[:count, :targets] + given.hint_weight * hints[:count, :targets]
    alone = alone.astype(np.float64)
    chosen, costs = np.arange(targets)[:, None], alone[0]
    for i in range(1, count):
        added = added_costs(least[i, :i], most[i, :i], between, chosen, given.within_bounds, given.pair_cap)
        # Each landmark counts as much as the other, however many pairs it is in.
        total = costs[:, None] + alone[i] + added * (min(1.0, 2.0 / i) if i > 2 else 1.0)
        order = least_costs(total.ravel(), given.beam)
        chosen = np.column_stack([chosen[order // targets], order % targets])
        costs = total.ravel()[order]
        if i > 1:
            kept = _few_of_a_kind(kind[chosen], given.per_kind)
            chosen, costs = chosen[kept], costs[kept]
    kept = _different(chosen, between, given.different, given.hypotheses)
    return LandmarkMaps(chosen[kept], costs[kept])


def least_costs(costs: FloatArray, count: int) -> IndexArray:
    """Places of so many least costs, in order; of equal ones the first."""
    if count >= len(costs):
        return np.argsort(costs, kind="stable")
    low = np.flatnonzero(costs <= np.partition(costs, count - 1)[count - 1])
    return low[np.argsort(costs[low], kind="stable")][:count]


def _few_of_a_kind(kinds: IndexArray, limit: int) -> IndexArray:
    """Places of the first ``limit`` rows of each kind, in order."""
    _, label = np.unique(kinds, axis=0, return_inverse=True)
    order = np.argsort(label.ravel(), kind="stable")
    ordered = label.ravel()[order]
    first = np.searchsorted(ordered, ordered)
    return np.sort(order[np.arange(len(order)) - first < limit])


def _different(chosen: IndexArray, between: SingleArray, apart: float, limit: int) -> IndexArray:
    kept: list[int] = []
    for h in range(len(chosen)):
        if all(between[chosen[h], chosen[k]].mean() > apart for k in kept):
            kept.append(h)
            if len(kept) == limit:
                break
    return np.array(kept, dtype=np.int64)
