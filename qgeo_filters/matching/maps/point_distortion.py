"""How much a map distorts the distances from each point."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.matching.problem import MatchProblem

# Points whose distances are interpolated at a time: bounds memory at a million vertices.
_AT_ONCE = 16


def point_distortions(problem: MatchProblem, p2p: IndexArray) -> FloatArray:
    """Mean over some points q of |d_X(p, q) - d_Y(Tp, Tq)|, (n,), in sqrt(area), for a map of all vertices.

    Distances are those of the coarse level, interpolated.

    Parameters
    ----------
    p2p : (n,) int
        Between the vertices at full resolution.
    """
    x, y = problem.x, problem.y
    probes = x.fps[: problem.parameters.probes]
    images = y.interpolation[p2p[x.full_vertices[probes]]]
    sources = np.unique(images.indices)
    there = images[:, sources] @ y.distances(sources)
    here = x.fps_distances[: len(probes)].astype(np.float64)
    total = np.zeros(len(p2p))
    for first in range(0, len(probes), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        gaps = x.interpolation @ here[some].T - (y.interpolation @ there[some].T)[p2p]
        total += np.abs(gaps, out=gaps).sum(axis=1)
    return total / len(probes)
