"""A coarse map from parts that are known to belong together."""

from __future__ import annotations

import numpy as np

from qgeo_filters.matching.initialization.hypothesis import Hypothesis
from qgeo_filters.matching.maps.map_distance import between_fps, coarse_distortions
from qgeo_filters.matching.problem import MatchProblem


def landmark_maps(problem: MatchProblem) -> list[Hypothesis]:
    """The map that takes each point to the one whose distances from the known parts are the most alike.

    None if fewer parts are known than tell the points of a surface apart.
    """
    known, given, x, y = problem.known, problem.parameters, problem.x, problem.y
    if known is None or len(known.to_x) < given.hints_that_locate:
        return []
    s = min(given.coarse_points, len(x.fps_distances), len(y.fps_distances))
    points_x, points_y = x.fps[:s], y.fps[:s]
    left, right = known.to_x[:, points_x].T, known.to_y[:, points_y].T
    images = np.abs(left[:, None] - right[None]).sum(axis=2).argmin(axis=1)
    near_x, near_y = between_fps(x.fps_distances, points_x), between_fps(y.fps_distances, points_y)
    distortion = float(coarse_distortions(near_x, near_y, images[None])[0])
    number = problem.log.propose("distances from what is known", distortion)
    return [Hypothesis(points_x, points_y[images], distortion, 0, number)]
