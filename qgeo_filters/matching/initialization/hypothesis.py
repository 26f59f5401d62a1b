"""A coarse map as the searches propose it."""

from __future__ import annotations

from dataclasses import dataclass

from qgeo_filters._typing import IndexArray


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A map of a few farthest points.

    Attributes
    ----------
    points : (s,) int
        Vertices of X.
    p2p : (s,) int
        Vertex of Y for each of them.
    mean_distortion : float
        Mean |d_X(p, q) - d_Y(Tp, Tq)| over them, in units of sqrt(area), in the first metric.
    metric : int
        Whose eigenfunctions proposed it; 0 for what only distances proposed.
    number : int
        In the log of the problem.
    """

    points: IndexArray
    p2p: IndexArray
    mean_distortion: float
    metric: int
    number: int
