"""Coarse maps that match the ends of limbs, heads and tails."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.initialization.distortion import point_distortions
from qgeo_filters.matching.initialization.sign_search import (
    NEAR_IDENTITY,
    Hypothesis,
    between_samples,
    displacement,
    distinct,
)
from qgeo_filters.matching.prepared_shape import PreparedShape

# Farthest points on either shape.
_POINTS = 300
# An extremity is farther from the rest, in the mean, than everything within this distance, in sqrt(area).
_RADIUS = 0.1
# The most prominent ones take part.
_MOST = 10
# Matchings that are kept while one extremity after another is added, and at the end.
_BEAM = 2000
_KEPT = 100
# Fewest matched extremities that tell points apart.
_FEWEST = 4
# Cost of leaving one unmatched, and the most that one pair of distances may cost, in sqrt(area).
_UNMATCHED = 0.24
_WORST = 0.5


def extremities(shape: PreparedShape) -> IndexArray:
    """Farthest points that are local maxima of the mean distance, by decreasing mean, as places in ``samples``."""
    between = shape.rows[:, shape.samples[: len(shape.rows)]]
    mean = between.mean(axis=1)
    highest = np.where(between < _RADIUS, mean, 0.0).max(axis=1)
    found = np.flatnonzero(mean >= highest)
    return found[np.argsort(-mean[found], kind="stable")][:_MOST]


def extremity_maps(x: PreparedShape, y: PreparedShape, limit: int = 6, *, identity: bool = True) -> list[Hypothesis]:
    """Distinct coarse maps from X to Y by increasing distortion, one for each likely matching of extremities.

    Each point goes to the one whose distances to the matched extremities are the most alike. With ``identity=False``,
    for two shapes of equal vertices, extremities are exchanged in pairs, and at most half of them stay.
    """
    s = min(_POINTS, len(x.rows), len(y.rows))
    points_x, points_y = x.samples[:s], y.samples[:s]
    near_x, near_y = between_samples(x.rows, points_x), between_samples(y.rows, points_y)
    ends_x, ends_y = extremities(x), extremities(y)
    to_x, to_y = x.rows[ends_x][:, points_x].T, y.rows[ends_y][:, points_y].T
    found: list[IndexArray] = []
    for matching in _matchings(x, y, ends_x, ends_y, identity):
        matched = matching >= 0
        if matched.sum() >= _FEWEST:
            left, right = to_x[:, matched], to_y[:, matching[matched]]
            images = np.abs(left[:, None] - right[None]).sum(axis=2).argmin(axis=1)
            if identity or displacement(near_y, images) > NEAR_IDENTITY:
                found.append(images)
    maps = np.array(found, dtype=np.int64).reshape(-1, s)
    distortions = point_distortions(near_x, near_y, maps)
    order = np.argsort(distortions, kind="stable")
    kept = order[distinct(list(maps[order]), near_y, limit)]
    return [Hypothesis(points_x, points_y[maps[i]], float(distortions[i]), 0) for i in kept]


def _matchings(
    x: PreparedShape, y: PreparedShape, ends_x: IndexArray, ends_y: IndexArray, identity: bool
) -> IndexArray:
    """The cheapest injective matchings (h, len(ends_x)) of extremities, -1 where unmatched, by a beam search."""
    between_x = x.rows[ends_x][:, x.samples[ends_x]]
    between_y = y.rows[ends_y][:, y.samples[ends_y]]
    mean_x, mean_y = x.rows[ends_x].mean(axis=1), y.rows[ends_y].mean(axis=1)
    options = np.arange(-1, len(ends_y))
    chosen = np.zeros((1, 0), dtype=np.int64)
    costs = np.zeros(1)
    for i in range(len(ends_x)):
        before = np.repeat(chosen, len(options), axis=0)
        option = np.tile(options, len(chosen))
        pairs = np.abs(between_x[i, :i] - between_y[option[:, None], before])
        pairs = np.where((before < 0) | (option < 0)[:, None], 0.0, np.minimum(pairs, _WORST))
        single = np.where(option < 0, _UNMATCHED, np.abs(mean_x[i] - mean_y[option]))
        total = np.repeat(costs, len(options)) + pairs.sum(axis=1) + single
        if not identity:
            back = np.where((option >= 0) & (option < i), option, 0)
            broken = (option >= 0) & (option < i) & (before[np.arange(len(before)), back] != i) if i else option < -1
            total[broken | ((before == i) & (option[:, None] != np.arange(i))).any(axis=1)] = np.inf
        total[((before == option[:, None]) & (option >= 0)[:, None]).any(axis=1)] = np.inf
        kept = np.argsort(total, kind="stable")[:_BEAM]
        kept = kept[np.isfinite(total[kept])]
        chosen, costs = np.column_stack([before[kept], option[kept]]), total[kept]
    if not identity:
        stay = (chosen == np.arange(len(ends_x))).sum(axis=1)
        chosen = chosen[2 * stay <= (chosen >= 0).sum(axis=1)]
    return chosen[:_KEPT]
