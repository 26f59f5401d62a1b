"""Filters by the name under which saved pipelines and PyVista's accessor know them."""

from __future__ import annotations

import importlib
import pkgutil
import reprlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from qgeo_filters import filters
from qgeo_filters.errors import ParameterError

if TYPE_CHECKING:
    from qgeo_filters.filters.base import Filter

F = TypeVar("F", bound="type[Filter]")

# Modules without filters, which need the host that they are for.
_DOORS = ("meshlab_in_place", "meshlab_matching", "meshlab_methods", "pyvista_accessor")

REGISTRY: dict[str, type[Filter]] = {}
"""Filters whose module is loaded, by class name; `registered_filters` loads the package's own first."""


def registered(cls: F) -> F:
    """Class decorator: saved pipelines and ``mesh.qgeo`` of PyVista know this filter by its class name.

    Raises
    ------
    ParameterError
        If there is another filter of this name. The same class again, as when a cell is run twice, replaces itself.

    Examples
    --------
    >>> @qg.registered
    ... class Height(qg.Filter):
    ...     outputs = {"height": "(n,), length: z"}
    ...
    ...     def compute(self, surface, progress=False):
    ...         return {"height": surface.vertices[:, 2].copy()}
    >>> qg.Pipeline([Height()]).to_yaml().splitlines()[0]
    'qgeo_pipeline: 1'
    >>> from qgeo_filters.filters.registry import REGISTRY
    >>> _ = REGISTRY.pop("Height")
    """
    other = REGISTRY.get(cls.__name__, cls)
    if (other.__module__, other.__qualname__) != (cls.__module__, cls.__qualname__):
        raise ParameterError(f"there is a filter {cls.__name__} already, in {other.__module__}: take another name")
    REGISTRY[cls.__name__] = cls
    return cls


def registered_filters() -> dict[str, type[Filter]]:
    """All filters by class name: those of this package, and others whose module is loaded."""
    for module in pkgutil.iter_modules(filters.__path__):
        if module.name not in _DOORS:
            importlib.import_module(f"{filters.__name__}.{module.name}")
    return dict(REGISTRY)


def filter_by_name(name: str, parameters: Mapping[str, Any]) -> Filter:
    """Filter of this class name with these parameters, lists made tuples where the default is one.

    Raises
    ------
    ParameterError
        An unknown filter, or a parameter that it does not have.
    """
    known = registered_filters()
    if name not in known:
        raise ParameterError(f"unknown filter {reprlib.repr(name)}; known are {', '.join(sorted(known))}")
    filter = known[name]()
    defaults = filter.get_params()
    for key, value in parameters.items():
        if isinstance(value, list) and isinstance(defaults.get(key), tuple):  # YAML has no tuples
            value = tuple(value)
        filter.set_params(**{key: value})
    return filter
