"""Coarse maps that match the ends of limbs, heads and tails: extrema of the average geodesic distance (AGD)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import IndexArray, SingleArray
from qgeo_filters.matching.initialization.hypothesis import Hypothesis
from qgeo_filters.matching.maps.map_distance import between_fps, coarse_distortions, displacement, distinct_maps
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem


def agd_extrema(shape: PreparedShape, parameters: MatchingParameters, count: int | None = None) -> IndexArray:
    """Farthest points that are local maxima of the average distance, by decreasing average, as places in ``fps``.

    At most ``count`` of them, those that are matched by default.
    """
    between = shape.fps_distances[:, shape.fps[: len(shape.fps_distances)]]
    mean = between.mean(axis=1)
    highest = np.where(between < parameters.extrema_radius, mean, 0.0).max(axis=1)
    found = np.flatnonzero(mean >= highest)
    return found[np.argsort(-mean[found], kind="stable")][: parameters.extrema_count if count is None else count]


def extrema_maps(problem: MatchProblem) -> list[Hypothesis]:
    """Distinct coarse maps from X to Y by increasing distortion, one for each likely matching of extrema.

    Each point goes to the one whose distances to the matched extrema are the most alike. Landmarks count as extrema
    whose partners are known. For a reflection extrema are exchanged in pairs, and at most half of them stay.

    References
    ----------
    Kim, Lipman, Chen, Funkhouser, "Möbius transformations for global intrinsic symmetry analysis", SGP 2010, for
    extrema of the average geodesic distance as points that symmetries and isometries keep.
    """
    x, y, given = problem.x, problem.y, problem.parameters
    s = min(given.coarse_points, len(x.fps_distances), len(y.fps_distances))
    points_x, points_y = x.fps[:s], y.fps[:s]
    near_x, near_y = between_fps(x.fps_distances, points_x), between_fps(y.fps_distances, points_y)
    ends_x, ends_y, fixed = _ends(problem)
    to_x, to_y = ends_x.distances[:, points_x].T, ends_y.distances[:, points_y].T
    found: list[IndexArray] = []
    for matching in _matchings(problem, ends_x, ends_y, fixed):
        matched = matching >= 0
        if matched.sum() >= given.extrema_fewest:
            left, right = to_x[:, matched], to_y[:, matching[matched]]
            images = np.abs(left[:, None] - right[None]).sum(axis=2).argmin(axis=1)
            if not problem.reflection or displacement(near_y, images) > given.near_identity:
                found.append(images)
    maps = np.array(found, dtype=np.int64).reshape(-1, s)
    distortions = coarse_distortions(near_x, near_y, maps)
    order = np.argsort(distortions * problem.dearness(points_x, points_y[maps]), kind="stable")
    kept = order[list(distinct_maps(list(maps[order]), near_y, given.extrema_hypotheses, given))]
    hypotheses = []
    for i in kept:
        number = problem.log.propose("extrema of the average distance", float(distortions[i]))
        hypotheses.append(Hypothesis(points_x, points_y[maps[i]], float(distortions[i]), 0, number))
    return hypotheses


@dataclass(frozen=True, eq=False)
class _Ends:
    """Points that are matched: their vertices (e,), and their distances to all vertices, (e, n)."""

    vertices: IndexArray
    distances: SingleArray


def _ends(problem: MatchProblem) -> tuple[_Ends, _Ends, int]:
    """Points of X and of Y to be matched, and how many of them, the first ones, are landmarks: partners by number."""
    known, ends = problem.known, []
    fixed = len(known.landmarks) if known else 0
    for side, shape in enumerate((problem.x, problem.y)):
        places = agd_extrema(shape, problem.parameters)
        vertices, distances = shape.fps[places], shape.fps_distances[places]
        if known and fixed:
            to_landmarks = (known.to_x, known.to_y)[side][:fixed]
            others = to_landmarks[:, vertices].min(axis=0) > problem.parameters.extrema_radius
            vertices = np.concatenate([known.landmarks[:, side], vertices[others]])
            distances = np.concatenate([to_landmarks, distances[others]])
        ends.append(_Ends(vertices, distances))
    return ends[0], ends[1], fixed


def _matchings(problem: MatchProblem, ends_x: _Ends, ends_y: _Ends, fixed: int) -> IndexArray:
    """The cheapest injective matchings (h, e) of extrema, -1 where unmatched, by a beam search."""
    given, count = problem.parameters, len(ends_x.vertices)
    between_x, between_y = (ends.distances[:, ends.vertices] for ends in (ends_x, ends_y))
    mean_x, mean_y = ends_x.distances.mean(axis=1), ends_y.distances.mean(axis=1)
    chosen = np.zeros((1, 0), dtype=np.int64)
    costs = np.zeros(1)
    for i in range(count):
        options = np.array([i]) if i < fixed else np.arange(-1, len(ends_y.vertices))
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
        stay = (chosen == np.arange(count)).sum(axis=1)
        chosen = chosen[2 * stay <= (chosen >= 0).sum(axis=1)]
    return chosen[: given.extrema_matchings]
