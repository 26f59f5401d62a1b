"""How far apart two maps are, how far one is from the identity, and how much maps distort distances.

All distances are in units of sqrt(area). A coarse map is given by the images of X's first farthest points.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.jit import njit
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem

# Farthest points whose distances bound that between two others.
_LANDMARKS = 100


def landmark_lower_bound(y: PreparedShape, one: IndexArray, other: IndexArray) -> SingleArray:
    """Distances on Y between the images of two maps, (n,): a close lower bound.

    Distances to a landmark differ by at most the distance, and by nearly as much for one landmark of many.
    """
    rows = y.fps_distances[:_LANDMARKS]
    return np.abs(rows[:, one] - rows[:, other]).max(axis=0)


def are_different(gaps: SingleArray, parameters: MatchingParameters) -> bool:
    """Whether two maps are different ones, by the distances between their images: in the mean, or in a limb."""
    in_a_limb = float((gaps > parameters.different_limb).mean()) > parameters.different_share
    return float(gaps.mean()) > parameters.different_mean or in_a_limb


def distinct_maps(
    maps: list[IndexArray], distances: SingleArray, limit: int, parameters: MatchingParameters
) -> Iterator[int]:
    """Places of the first maps that differ from all before them; ``distances[a, b]`` is between images a and b."""
    kept: list[IndexArray] = []
    for place, images in enumerate(maps):
        if all(are_different(distances[images, other], parameters) for other in kept):
            kept.append(images)
            yield place
            if len(kept) == limit:
                return


def displacement(distances: SingleArray, images: IndexArray) -> float:
    """Mean distance of a map of a shape to itself from the identity."""
    return float(distances[images, np.arange(len(images))].mean())


def between_fps(fps_distances: SingleArray, points: IndexArray) -> SingleArray:
    """Distances (s, s) among the first farthest points."""
    return np.ascontiguousarray(fps_distances[: len(points), points])


def mean_distortion(problem: MatchProblem, images: IndexArray) -> float:
    """Mean |d_X(p, q) - d_Y(Tp, Tq)| over pairs of farthest points.

    One image of each pair is taken to the nearest farthest point of Y, from which distances are at hand.

    Parameters
    ----------
    images : (s,) int
        Of X's first farthest points: of how many, does not matter if they are at least 300.
    """
    x, y = problem.x, problem.y
    s = min(problem.parameters.coarse_points, len(x.fps_distances))
    images = images[:s]
    near = y.nearest_fps[images]
    return float(np.abs(x.fps_distances[:s, x.fps[:s]] - y.fps_distances[near[:, None], images]).mean())


@njit()
def coarse_distortions(near_x: SingleArray, near_y: SingleArray, maps: IndexArray) -> FloatArray:
    """Mean |d_X(p, q) - d_Y(Tp, Tq)| over all pairs of points, for each map T (..., s) of the rows of maps.

    ``near_x`` (s, s) and ``near_y`` (m, m) are the symmetric distances among the points of either shape.
    """
    count, s = maps.shape
    result = np.empty(count)
    for k in range(count):
        images = maps[k]
        total = 0.0
        for p in range(1, s):
            row_x, row_y = near_x[p], near_y[images[p]]
            for q in range(p):
                total += abs(row_x[q] - row_y[images[q]])
        result[k] = 2 * total / (s * s)
    return result
