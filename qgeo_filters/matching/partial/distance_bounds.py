"""What distances on a part say about those on the whole.

A path that leaves the part crosses its rim twice, so that the distance on the whole between two of its points is at
least the smaller of their distance on the part and the sum of their distances to the rim; and it is at most their
distance on the part. Where the sum is the larger, the two distances are equal.

References
----------
Bracha, Dages, Kimmel, "On partial shape correspondence and functional maps", 2023, and "Wormhole loss for partial shape
matching", NeurIPS 2024: pairs of points whose distance a cut cannot have changed.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import IndexArray, SingleArray
from qgeo_filters.jit import inner, njit
from qgeo_filters.matching.partial.part_shape import PartShape


def distance_bounds(shape: PartShape, count: int) -> tuple[SingleArray, SingleArray]:
    """Bounds (s, s) of the distances on the whole between the first farthest points of a part: least and most."""
    points = shape.fps[:count]
    most = np.ascontiguousarray(shape.rows[:count][:, points])
    most = np.maximum(most, most.T)
    rim = shape.rim[points].astype(np.float32)
    return np.minimum(most, rim[:, None] + rim[None]), most


@inner
def _violation(
    least: np.float32, most: np.float32, there: np.float32, within: np.float32, cap: np.float32
) -> np.float32:
    """How far a distance lies outside its bounds, and a little for what it is short of the upper one."""
    # Without branches, and in single precision throughout: the loops that call this are vectorised.
    beyond = max(there - most, np.float32(0)) + max(least - there, np.float32(0))
    return min(beyond + within * abs(most - there), cap)


@njit()
def added_costs(
    least: SingleArray, most: SingleArray, between: SingleArray, chosen: IndexArray, within: float, cap: float
) -> SingleArray:
    """Sum over landmarks of the violations (h, m) of the bounds to a new one, for each point that it may go to.

    Parameters
    ----------
    least, most : (i,) float32
        Bounds from the new landmark to those before it.
    between : (m, m) float32
        Distances between the points of Y.
    chosen : (h, i) int
        Of each hypothesis the points of Y that these landmarks go to.
    """
    count, m = len(chosen), len(between)
    short, most_each = np.float32(within), np.float32(cap)
    result = np.zeros((count, m), np.float32)
    for h in range(count):
        for j in range(chosen.shape[1]):
            row = between[chosen[h, j]]
            for q in range(m):
                result[h, q] += _violation(least[j], most[j], row[q], short, most_each)
    return result


@njit()
def profile_costs(
    least: SingleArray,
    most: SingleArray,
    weights: SingleArray,
    between: SingleArray,
    images: IndexArray,
    within: float,
    cap: float,
) -> SingleArray:
    """Weighted mean violation (s, m) of the bounds from each point to some, if it goes to each of the points of Y.

    Parameters
    ----------
    least, most, weights : (s, l) float32
        Bounds between s points of X and l of them that are mapped, and how much each counts.
    between : (m, m) float32
        Distances between the points of Y.
    images : (l,) int
        Where those are mapped.
    """
    s, m = len(least), len(between)
    short, most_each = np.float32(within), np.float32(cap)
    result = np.zeros((s, m), np.float32)
    for p in range(s):
        total = np.float32(0)
        for j in range(len(images)):
            weight = weights[p, j]
            total += weight
            row = between[images[j]]
            for q in range(m):
                result[p, q] += weight * _violation(least[p, j], most[p, j], row[q], short, most_each)
        result[p] /= total
    return result


def violations(least: npt.NDArray, most: npt.NDArray, there: npt.NDArray) -> npt.NDArray:
    """How far distances lie outside their bounds, of one shape."""
    return np.maximum(there - most, 0) + np.maximum(least - there, 0)


def mean_violation(least: SingleArray, most: SingleArray, there: SingleArray, within: float, cap: float) -> float:
    """Mean violation of bounds (s, s) by distances (s, s), as the searches count it."""
    cost = np.minimum(violations(least, most, there) + within * np.abs(most - there), cap)
    return float(cost.mean())
