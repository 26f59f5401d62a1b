"""Coarse reflections of a shape that exchange the ends of its limbs."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray, SingleArray
from qgeo_filters.matching.initialization.agd_extrema import agd_extrema
from qgeo_filters.matching.initialization.hypothesis import Hypothesis
from qgeo_filters.matching.maps.map_distance import between_fps, coarse_distortions, displacement, distinct_maps
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.problem import MatchProblem


def extrema_reflections(problem: MatchProblem) -> list[Hypothesis]:
    """Distinct coarse reflections of X by increasing distortion, one for each likely matching of its extrema.

    Each point goes to the one whose distances to the matched extrema are the most alike. Extrema are exchanged in
    pairs, and at most half of them stay. Of a wolf without a leg none that signs of eigenfunctions propose is as near;
    maps to another shape need none of these (benchmarks/README.md, the ablation).
    """
    x, given = problem.x, problem.parameters
    s = min(given.coarse_points, len(x.fps_distances))
    points = x.fps[:s]
    near = between_fps(x.fps_distances, points)
    places = agd_extrema(x, given)
    to_ends = x.fps_distances[places]
    left = to_ends[:, points].T
    found: list[IndexArray] = []
    for matching in _exchanges(to_ends[:, x.fps[places]], to_ends.mean(axis=1), given):
        matched = matching >= 0
        if matched.sum() >= given.extrema_fewest:
            images = np.abs(left[:, None, matched] - left[None][:, :, matching[matched]]).sum(axis=2).argmin(axis=1)
            if displacement(near, images) > given.near_identity:
                found.append(images)
    maps = np.array(found, dtype=np.int64).reshape(-1, s)
    distortions = coarse_distortions(near, near, maps)
    order = np.argsort(distortions * problem.dearness(points, points[maps]), kind="stable")
    kept = order[list(distinct_maps(list(maps[order]), near, given.extrema_hypotheses, given))]
    hypotheses = []
    for i in kept:
        number = problem.log.propose("extrema of the average distance", float(distortions[i]))
        hypotheses.append(Hypothesis(points, points[maps[i]], float(distortions[i]), 0, number))
    return hypotheses


def _exchanges(between: SingleArray, mean: SingleArray, given: MatchingParameters) -> IndexArray:
    """The cheapest matchings (h, e) of extrema with each other, -1 where unmatched, by a beam search.

    Parameters
    ----------
    between : (e, e) float32
        Distances between the extrema.
    mean : (e,) float32
        Average distance of each.
    """
    count = len(mean)
    chosen = np.zeros((1, 0), dtype=np.int64)
    costs = np.zeros(1)
    options = np.arange(-1, count)
    for i in range(count):
        before = np.repeat(chosen, len(options), axis=0)
        option = np.tile(options, len(chosen))
        pairs = np.abs(between[i, :i] - between[option[:, None], before])
        pairs = np.where((before < 0) | (option < 0)[:, None], 0.0, np.minimum(pairs, given.extrema_worst))
        single = np.where(option < 0, given.extrema_unmatched, np.abs(mean[i] - mean[option]))
        total = np.repeat(costs, len(options)) + pairs.sum(axis=1) + single
        back = np.where((option >= 0) & (option < i), option, 0)
        broken = (option >= 0) & (option < i) & (before[np.arange(len(before)), back] != i) if i else option < -1
        total[broken | ((before == i) & (option[:, None] != np.arange(i))).any(axis=1)] = np.inf
        total[((before == option[:, None]) & (option >= 0)[:, None]).any(axis=1)] = np.inf
        kept = np.argsort(total, kind="stable")[: given.extrema_beam]
        kept = kept[np.isfinite(total[kept])]
        chosen, costs = np.column_stack([before[kept], option[kept]]), total[kept]
    stay = (chosen == np.arange(count)).sum(axis=1)
    chosen = chosen[2 * stay <= (chosen >= 0).sum(axis=1)]
    return chosen[: given.extrema_matchings]
