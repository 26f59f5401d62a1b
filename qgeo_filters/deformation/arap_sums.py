"""Sums over the edges of a surface that a deformation as rigid as possible needs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.jit import njit


@njit()
def covariances(
    starts: npt.NDArray[np.int64],
    heads: npt.NDArray[np.int64],
    weights: FloatArray,
    edges: FloatArray,
    positions: FloatArray,
) -> FloatArray:
    """Sum of w (p_i - p_j) (x_i - x_j)^T over the neighbours of each vertex, (n, 3, 3).

    The half-edges from vertex i are ``starts[i]:starts[i + 1]``; ``edges`` are x_i - x_j.
    """
    n = len(starts) - 1
    result = np.zeros((n, 3, 3))
    for i in range(n):
        for e in range(starts[i], starts[i + 1]):
            j = heads[e]
            for a in range(3):
                moved = weights[e] * (positions[i, a] - positions[j, a])
                for b in range(3):
                    result[i, a, b] += moved * edges[e, b]
    return result


@njit()
def rotated_edge_sums(
    starts: npt.NDArray[np.int64],
    heads: npt.NDArray[np.int64],
    weights: FloatArray,
    edges: FloatArray,
    rotations: FloatArray,
) -> FloatArray:
    """Sum of w (R_i + R_j) / 2 (x_i - x_j) over the neighbours of each vertex, (n, 3); rotations are (n, 3, 3)."""
    n = len(starts) - 1
    result = np.zeros((n, 3))
    for i in range(n):
        for e in range(starts[i], starts[i + 1]):
            j = heads[e]
            half = 0.5 * weights[e]
            for a in range(3):
                for b in range(3):
                    result[i, a] += half * (rotations[i, a, b] + rotations[j, a, b]) * edges[e, b]
    return result


@njit()
def rotation_misfit(
    starts: npt.NDArray[np.int64],
    heads: npt.NDArray[np.int64],
    weights: FloatArray,
    edges: FloatArray,
    rotations: FloatArray,
    positions: FloatArray,
) -> float:
    """Sum of w |p_i - p_j - R_i (x_i - x_j)|^2 over all half-edges."""
    total = 0.0
    for i in range(len(starts) - 1):
        for e in range(starts[i], starts[i + 1]):
            j = heads[e]
            for a in range(3):
                rest = positions[i, a] - positions[j, a]
                for b in range(3):
                    rest -= rotations[i, a, b] * edges[e, b]
                total += weights[e] * rest * rest
    return total
