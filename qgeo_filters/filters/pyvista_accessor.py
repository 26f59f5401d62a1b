"""``mesh.qgeo`` on every PyVista surface: found by PyVista itself through an entry point (PyVista >= 0.48).

>>> import pyvista
>>> out = pyvista.Sphere().qgeo.quasi_geodesic_spectrum(k=20)  # doctest: +SKIP
>>> out = pyvista.Sphere().qgeo.apply(pipeline)  # doctest: +SKIP
>>> found = mesh.qgeo.match(other)  # doctest: +SKIP
>>> line = mesh.qgeo.path(0, 1200)  # doctest: +SKIP
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista

from qgeo_filters._typing import FloatArray, RepairOption
from qgeo_filters.array_likes import as_array
from qgeo_filters.errors import ParameterError
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.registry import registered_filters
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.geodesics.metric import Metric
from qgeo_filters.geodesics.path.paths import quasi_geodesic
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.hosts.lines import polylines
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.matching.symmetry_result import Symmetry
from qgeo_filters.surface import Surface

_OWN = ("apply", "distances", "match", "path", "surface", "symmetry")


@pyvista.register_dataset_accessor("qgeo", pyvista.PolyData)
class QgeoAccessor:
    """The package's filters as methods of a surface, named in lower case with underscores.

    Each takes the filter's parameters by name, and ``repair``, ``progress`` and ``workers`` as every filter's call
    does, and returns a new PolyData with the filter's attributes in its ``point_data``. Beside them `match`,
    `symmetry`, `path` and `distances` are the functions of these names.
    """

    def __init__(self, mesh: pyvista.PolyData) -> None:
        self._mesh = mesh

    @property
    def surface(self) -> Surface:
        """The mesh as a `Surface`, for the functions that take and give arrays."""
        return as_surface(self._mesh)

    def match(self, other: SurfaceLike, **options: Any) -> MatchResult:
        """Correspondence with another shape, with no initial map; what `qgeo_filters.match` gives and takes."""
        found: MatchResult = match(self._mesh, other, **options)
        return found

    def symmetry(self, **options: Any) -> Symmetry:
        """Self-symmetry of the mesh; what `qgeo_filters.self_symmetry` gives and takes."""
        found: Symmetry = self_symmetry(self._mesh, **options)
        return found

    def distances(self, sources: npt.ArrayLike, **options: Any) -> FloatArray:
        """Geodesic distances (s, n) from some vertices to all; what `qgeo_filters.distances` gives and takes."""
        return distances(self._mesh, sources, **options)

    def path(
        self, i: Any, j: Any, metric: Metric | None = "cartesian", *, initial: str = "exact", tolerance: float = 1e-6
    ) -> pyvista.PolyData:
        """Polyline of the quasi-geodesic between two vertices.

        Parameters
        ----------
        i, j : int or (3,) array-like
            Vertices; or points, such as ``plotter.picked_point``, which stand for the vertex nearest to them.
        metric, initial, tolerance
            See `qgeo_filters.quasi_geodesic`.

        Returns
        -------
        pyvista.PolyData
            One line, with ``qgeo_arc_length`` (from the start, mesh units) and ``qgeo_geodesic_curvature`` (radians, 0
            at both ends) in its ``point_data``, and ``qgeo_length``, in the metric, and ``qgeo_converged`` in its
            ``field_data``.
        """
        ends = [self._vertex(name, value) for name, value in (("i", i), ("j", j))]
        found = quasi_geodesic(self._mesh, ends[0], ends[1], metric, initial=initial, tolerance=tolerance)
        line = polylines(found, "pyvista")
        steps = np.linalg.norm(np.diff(found.points, axis=0), axis=1)
        line.point_data["qgeo_arc_length"] = np.concatenate([[0.0], np.cumsum(steps)])
        curvature = np.zeros(len(found.points))
        curvature[1:-1] = found.kappa_g
        line.point_data["qgeo_geodesic_curvature"] = curvature
        line.field_data["qgeo_length"] = [found.length]
        line.field_data["qgeo_converged"] = [int(found.converged)]
        return line

    def _vertex(self, name: str, value: Any) -> Any:
        if np.ndim(value) == 0:
            return value
        point = as_array(value).astype(np.float64)
        if point.shape != (3,) or not np.isfinite(point).all():
            raise ParameterError(f"{name} must be a vertex or a point with three finite coordinates, got {value!r}")
        return int(self._mesh.find_closest_point(point))

    def apply(
        self,
        filter: Callable[..., pyvista.PolyData],
        *,
        repair: RepairOption = "auto",
        progress: bool = False,
        workers: int | None = None,
    ) -> pyvista.PolyData:
        """New PolyData with the attributes of a filter or pipeline."""
        return filter(self._mesh, repair=repair, progress=progress, workers=workers)

    def __getattr__(self, name: str) -> Callable[..., pyvista.PolyData]:
        if name.startswith("_"):
            raise AttributeError(name)
        known = _filters()
        if name not in known:
            raise AttributeError(f"mesh.qgeo has no filter {name!r}; it has {', '.join(self.__dir__())}")
        filter_class = known[name]

        def method(
            *, repair: RepairOption = "auto", progress: bool = False, workers: int | None = None, **parameters: Any
        ) -> pyvista.PolyData:
            return self.apply(filter_class(**parameters), repair=repair, progress=progress, workers=workers)

        method.__name__ = name
        method.__doc__ = inspect.getdoc(filter_class)
        return method

    def __dir__(self) -> list[str]:
        return sorted([*_OWN, *_filters()])


def _filters() -> dict[str, type[Filter]]:
    """Filters by method name."""
    return {_method_name(name): cls for name, cls in registered_filters().items()}


def _method_name(class_name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", class_name).lower()
