"""Coarse maps that match the ends of limbs, heads and tails: extrema of the average geodesic distance (AGD)."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.initialization.hypothesis import Hypothesis
from qgeo_filters.matching.maps.map_distance import between_fps, coarse_distortions, displacement, distinct_maps
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem


def agd_extrema(shape: PreparedShape, parameters: MatchingParameters) -> IndexArray:
    """Farthest points that are local maxima of the average distance, by decreasing average, as places in ``fps``."""
    between = shape.fps_distances[:, shape.fps[: len(shape.fps_distances)]]
    mean = between.mean(axis=1)
    highest = np.where(between < parameters.extrema_radius, mean, 0.0).max(axis=1)
    found = np.flatnonzero(mean >= highest)
    return found[np.argsort(-mean[found], kind="stable")][: parameters.extrema_count]


def extrema_maps(problem: MatchProblem) -> list[Hypothesis]:
    """Distinct coarse maps from X to Y by increasing distortion, one for each likely matching of extrema.

    Each point goes to the one whose distances to the matched extrema are the most alike. For a reflection extrema
    are exchanged in pairs, and at most half of them stay.

    References
    ----------
    Kim, Lipman, Chen, Funkhouser, "Möbius transformations for global intrinsic symmetry analysis", SGP 2010, for
    extrema of the average geodesic distance as points that symmetries and isometries keep.
    """
    x, y, given = problem.x, problem.y, problem.parameters
    s = min(given.coarse_points, len(x.fps_distances), len(y.fps_distances))
    points_x, points_y = x.fps[:s], y.fps[:s]
    near_x, near_y = between_fps(x.fps_distances, points_x), between_fps(y.fps_distances, points_y)
    ends_x, ends_y = agd_extrema(x, given), agd_extrema(y, given)
    to_x, to_y = x.fps_distances[ends_x][:, points_x].T, y.fps_distances[ends_y][:, points_y].T
    found: list[IndexArray] = []
    for matching in _matchings(problem, ends_x, ends_y):
        matched = matching >= 0
        if matched.sum() >= given.extrema_fewest:
            left, right = to_x[:, matched], to_y[:, matching[matched]]
            images = np.abs(left[:, None] - right[None]).sum(axis=2).argmin(axis=1)
            if not problem.reflection or displacement(near_y, images) > given.near_identity:
                found.append(images)
    maps = np.array(found, dtype=np.int64).reshape(-1, s)
    distortions = coarse_distortions(near_x, near_y, maps)
    order = np.argsort(distortions, kind="stable")
    kept = order[list(distinct_maps(list(maps[order]), near_y, given.extrema_hypotheses, given))]
    hypotheses = []
    for i in kept:
        number = problem.log.propose("extrema of the average distance", float(distortions[i]))
        hypotheses.append(Hypothesis(points_x, points_y[maps[i]], float(distortions[i]), 0, number))
    return hypotheses


def _matchings(problem: MatchProblem, ends_x: IndexArray, ends_y: IndexArray) -> IndexArray:
    """The cheapest injective matchings (h, len(ends_x)) of extrema, -1 where unmatched, by a beam search."""
    x, y, given = problem.x, problem.y, problem.parameters
    between_x = x.fps_distances[ends_x][:, x.fps[ends_x]]
    between_y = y.fps_distances[ends_y][:, y.fps[ends_y]]
    mean_x, mean_y = x.fps_distances[ends_x].mean(axis=1), y.fps_distances[ends_y].mean(axis=1)
    options = np.arange(-1, len(ends_y))
    chosen = np.zeros((1, 0), dtype=np.int64)
    costs = np.zeros(1)
    for i in range(len(ends_x)):
        before = np.repeat(chosen, len(options), axis=0)
        option = np.tile(options, len(chosen))
        pairs = np.abs(between_x[i, :i] - between_y[option[:, None], before])
        pairs = np.where((before < 0) | (option < 0)[:, None], 0.0, np.minimum(pairs, given.extrema_worst))
        single = np.where(option < 0, given.extrema_unmatched, np.abs(mean_x[i] - mean_y[option]))
        total = np.repeat(costs, len(options)) + pairs.sum(axis=1) + single
        if problem.reflection:
            back = np.where((option >= 0) & (option < i), option, 0)
            broken = (option >= 0) & (option < i) & (before[np.arange(len(before)), back] != i) if i else option < -1
            total[broken | ((before == i) & (option[:, None] != np.arange(i))).any(axis=1)] = np.inf
        total[((before == option[:, None]) & (option >= 0)[:, None]).any(axis=1)] = np.inf
        kept = np.argsort(total, kind="stable")[: given.extrema_beam]
        kept = kept[np.isfinite(total[kept])]
        chosen, costs = np.column_stack([before[kept], option[kept]]), total[kept]
    if problem.reflection:
        stay = (chosen == np.arange(len(ends_x))).sum(axis=1)
        chosen = chosen[2 * stay <= (chosen >= 0).sum(axis=1)]
    return chosen[: given.extrema_matchings]
