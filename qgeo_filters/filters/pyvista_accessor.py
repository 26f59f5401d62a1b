"""``mesh.qgeo`` on every PyVista surface: found by PyVista itself through an entry point (PyVista >= 0.48).

>>> import pyvista
>>> out = pyvista.Sphere().qgeo.quasi_geodesic_spectrum(k=20)  # doctest: +SKIP
>>> out = pyvista.Sphere().qgeo.apply(pipeline)  # doctest: +SKIP
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any

import pyvista

from qgeo_filters._typing import RepairOption
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.registry import registered_filters
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.surface import Surface


@pyvista.register_dataset_accessor("qgeo", pyvista.PolyData)
class QgeoAccessor:
    """The package's filters as methods of a surface, named in lower case with underscores.

    Each takes the filter's parameters by name, and ``repair``, ``progress`` and ``workers`` as every filter's call
    does, and returns a new PolyData with the filter's attributes in its ``point_data``.
    """

    def __init__(self, mesh: pyvista.PolyData) -> None:
        self._mesh = mesh

    @property
    def surface(self) -> Surface:
        """The mesh as a `Surface`, for the functions that take and give arrays."""
        return as_surface(self._mesh)

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
            raise AttributeError(f"mesh.qgeo has no filter {name!r}; it has {', '.join(known)}")
        filter_class = known[name]

        def method(
            *, repair: RepairOption = "auto", progress: bool = False, workers: int | None = None, **parameters: Any
        ) -> pyvista.PolyData:
            return self.apply(filter_class(**parameters), repair=repair, progress=progress, workers=workers)

        method.__name__ = name
        method.__doc__ = inspect.getdoc(filter_class)
        return method

    def __dir__(self) -> list[str]:
        return ["apply", "surface", *_filters()]


def _filters() -> dict[str, type[Filter]]:
    """Filters by method name."""
    return {_method_name(name): cls for name, cls in registered_filters().items()}


def _method_name(class_name: str) -> str:
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", class_name).lower()
