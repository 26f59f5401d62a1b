"""Ends of limbs, heads and tails: extrema of the average geodesic distance (AGD)."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape


def agd_extrema(shape: PreparedShape, parameters: MatchingParameters, count: int | None = None) -> IndexArray:
    """Farthest points that are local maxima of the average distance, by decreasing average, as places in ``fps``.

    At most ``count`` of them, ``extrema_count`` by default.

    References
    ----------
    Kim, Lipman, Chen, Funkhouser, "Möbius transformations for global intrinsic symmetry analysis", SGP 2010, for
    extrema of the average geodesic distance as points that symmetries and isometries keep.
    """
    between = shape.fps_distances[:, shape.fps[: len(shape.fps_distances)]]
    mean = between.mean(axis=1)
    highest = np.where(between < parameters.extrema_radius, mean, 0.0).max(axis=1)
    found = np.flatnonzero(mean >= highest)
    return found[np.argsort(-mean[found], kind="stable")][: parameters.extrema_count if count is None else count]
