"""The shortest path between two vertices, and the one that is reached by straightening a path along edges."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from qgeo_filters.geodesics.metric import LiftedMetric
from qgeo_filters.geodesics.path.geodesic_path import GeodesicPath
from qgeo_filters.geodesics.path.paths import PathFinder

_TOLERANCE = 1e-6  # radians, as in `quasi_geodesic`


@dataclass(frozen=True, eq=False)
class PathPair:
    """Two locally shortest paths with equal ends.

    Attributes
    ----------
    shortest : GeodesicPath
        Down the exact distance: no path is shorter.
    from_edges : GeodesicPath
        From the shortest path along edges, straightened: it may stay on the wrong side of a bump.
    """

    shortest: GeodesicPath
    from_edges: GeodesicPath


class PathPairs:
    """Pairs of paths in one metric, which is unfolded once: a second pair takes a fraction of the time."""

    def __init__(self, metric: LiftedMetric) -> None:
        self.metric = metric

    def between(self, source: int, target: int) -> PathPair:
        """The two paths from one vertex to another."""
        return PathPair(self._exact(source, target), self._edges(source, target))

    @cached_property
    def _exact(self) -> PathFinder:
        return PathFinder(self.metric.surface, self.metric, "exact", _TOLERANCE)

    @cached_property
    def _edges(self) -> PathFinder:
        return PathFinder(self.metric.surface, self.metric, "edges", _TOLERANCE)
