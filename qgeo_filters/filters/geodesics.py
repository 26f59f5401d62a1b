"""Filters of the lifted metric: the base of all that need it, and distances from chosen vertices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, get_args

import numpy as np

from qgeo_filters.defaults import CURVATURE_WEIGHT
from qgeo_filters.differential.scalar import Scalar
from qgeo_filters.errors import ParameterError
from qgeo_filters.filters import stages
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.registry import registered
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.geodesics.metric import LiftedMetric
from qgeo_filters.geodesics.path.geodesic_path import GeodesicPath
from qgeo_filters.geodesics.path.paths import quasi_geodesic
from qgeo_filters.surface import Surface

PathMethod = Literal["exact", "edges"]
PATH_METHODS = get_args(PathMethod)


class MetricFilter(Filter):
    """A filter that measures in the lifted metric.

    Parameters
    ----------
    scalar : str, array-like of shape (n,), or callable
        f, see `surface_scalar`.
    curvature_weight : float
        lambda, a fraction of sqrt(area) for each standard deviation of f; 0 is the Cartesian metric.
    smoothing : float
        Length over which f is averaged, as a fraction of sqrt(area).
    method : str
        How distances are computed: ``"graph"``, ``"exact"``, ``"edges"`` or a method of `register_method`.
    accuracy : float
        Relative error bound of the graph method.
    """

    value_parameters = frozenset({"scalar"})

    metric_: LiftedMetric
    """The metric of the last call."""

    def __init__(
        self,
        *,
        scalar: Scalar = "mean_curvature",
        curvature_weight: float = CURVATURE_WEIGHT,
        smoothing: float = 0.0,
        method: str = "graph",
        accuracy: float = 1e-3,
    ) -> None:
        self.scalar = scalar
        self.curvature_weight = curvature_weight
        self.smoothing = smoothing
        self.method = method
        self.accuracy = accuracy

    def _metric(self, surface: Surface) -> LiftedMetric:
        self.metric_ = stages.metric_of(surface, self.scalar, self.curvature_weight, self.smoothing)
        return self.metric_


@registered
class QuasiGeodesicDistances(MetricFilter):
    """Adds quasi-geodesic distances from chosen vertices.

    Parameters
    ----------
    sources : int or sequence of int
        Vertices to measure from. One index gives one value per vertex, a sequence one column per source.
    scalar, curvature_weight, smoothing, method, accuracy
        See `MetricFilter`.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> qg.QuasiGeodesicDistances(sources=[0, 7])(surface).attributes["qgeo_distance"].shape
    (162, 2)
    >>> qg.QuasiGeodesicDistances(sources=0)(surface).attributes["qgeo_distance"].shape
    (162,)
    """

    outputs = {"qgeo_distance": "(n,) or (n, s), length: quasi-geodesic distance to each source; inf between pieces"}

    index_parameters = frozenset({"sources"})

    def __init__(
        self,
        *,
        sources: int | Sequence[int] = 0,
        scalar: Scalar = "mean_curvature",
        curvature_weight: float = CURVATURE_WEIGHT,
        smoothing: float = 0.0,
        method: str = "graph",
        accuracy: float = 1e-3,
    ) -> None:
        super().__init__(
            scalar=scalar, curvature_weight=curvature_weight, smoothing=smoothing, method=method, accuracy=accuracy
        )
        self.sources = sources

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Distances by attribute name."""
        field = distances(
            surface,
            np.atleast_1d(self.sources),
            self._metric(surface),
            self.method,
            accuracy=self.accuracy,
            progress=progress,
        )
        return {"qgeo_distance": field[0] if np.ndim(self.sources) == 0 else field.T}


@registered
class QuasiGeodesicPath(MetricFilter):
    """Finds the quasi-geodesic path between two vertices and marks the triangles that it crosses.

    The path itself, its length and its geodesic curvature, is on the filter as ``path_``.

    Parameters
    ----------
    start, end : int
        Vertices.
    scalar, curvature_weight, smoothing
        See `MetricFilter`.
    method : {"exact", "edges"}
        How the first path is found that is then straightened: down the exact distance, which gives the shortest path of
        all; or along edges, much faster, which in some cases straightens to one that is only locally shortest.
    tolerance : float
        Largest geodesic curvature, radians, that counts as straight. It takes the place of the `accuracy` of distances.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> filter = qg.QuasiGeodesicPath(start=0, end=50)
    >>> out = filter(surface)
    >>> int(out.attributes["qgeo_path"].sum()) > 3, filter.path_.converged
    (True, True)
    """

    outputs = {"qgeo_path": "(n,) int32: 1 at the corners of the triangles that the path crosses, 0 elsewhere"}

    index_parameters = frozenset({"start", "end"})

    path_: GeodesicPath
    """The path of the last call."""

    @classmethod
    def example(cls, surface: Surface) -> Filter:
        """From the first vertex to the last."""
        return cls(end=surface.n_vertices - 1)

    def __init__(
        self,
        *,
        start: int = 0,
        end: int = 1,
        scalar: Scalar = "mean_curvature",
        curvature_weight: float = CURVATURE_WEIGHT,
        smoothing: float = 0.0,
        method: PathMethod = "exact",
        tolerance: float = 1e-6,
    ) -> None:
        self.start = start
        self.end = end
        self.scalar = scalar
        self.curvature_weight = curvature_weight
        self.smoothing = smoothing
        self.method = method
        self.tolerance = tolerance

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Marks by attribute name."""
        if self.method not in PATH_METHODS:
            known = ", ".join(map(repr, PATH_METHODS))
            raise ParameterError(f"QuasiGeodesicPath: method must be one of {known}, got {self.method!r}")
        metric = self._metric(surface)
        self.path_ = quasi_geodesic(
            surface, self.start, self.end, metric, initial=self.method, tolerance=self.tolerance
        )
        marks = np.zeros(surface.n_vertices, dtype=np.int32)
        marks[surface.faces[self.path_.faces]] = 1
        return {"qgeo_path": marks}
