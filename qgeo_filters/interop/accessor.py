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

from qgeo_filters.surface import Surface


@pyvista.register_dataset_accessor("qgeo", pyvista.PolyData)
class QgeoAccessor:
    """The package's filters as methods of a surface, named in lower case with underscores.

    Each takes the filter's parameters by name, and ``repair`` and ``progress`` as every filter's call does,
    and returns a new PolyData with the filter's attributes in its ``point_data``.
    """

    def __init__(self, mesh: pyvista.PolyData) -> None:
        self._mesh = mesh

    @property
    def surface(self) -> Surface:
        """The mesh as a `Surface`, for the functions that take and give arrays."""
        from qgeo_filters.interop import as_surface

        return as_surface(self._mesh)

    def apply(
        self, filter: Callable[..., pyvista.PolyData], *, repair: bool = False, progress: bool = False
    ) -> pyvista.PolyData:
        """New PolyData with the attributes of a filter or pipeline."""
        return filter(self._mesh, repair=repair, progress=progress)

    def __getattr__(self, name: str) -> Callable[..., pyvista.PolyData]:
        filter_class = None if name.startswith("_") else _filters().get(name)
        if filter_class is None:
            raise AttributeError(f"mesh.qgeo has no filter {name!r}; it has {', '.join(_filters())}")

        def method(*, repair: bool = False, progress: bool = False, **parameters: Any) -> pyvista.PolyData:
            return self.apply(filter_class(**parameters), repair=repair, progress=progress)

        method.__name__ = name
        method.__doc__ = inspect.getdoc(filter_class)
        return method

    def __dir__(self) -> list[str]:
        return ["apply", "surface", *_filters()]


def _filters() -> dict[str, type]:
    """Public filters by method name."""
    import qgeo_filters
    from qgeo_filters.filters.base import Filter

    classes = {}
    for name in qgeo_filters.__all__:
        # Functions and modules of the package are in lower case, exceptions and results are no filters.
        value = getattr(qgeo_filters, name) if name[0].isupper() else None
        if inspect.isclass(value) and issubclass(value, Filter) and name not in ("Filter", "Pipeline"):
            classes[re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()] = value
    return classes
