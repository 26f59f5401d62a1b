"""Filter and Pipeline: objects that take a mesh of any host and return the same kind with more attributes."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, TypeVar

import numpy as np

from qgeo_filters.caching import cache
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.hosts.dispatch import as_surface, is_host_mesh, write_back
from qgeo_filters.hosts.repair import Repair, repair_surface
from qgeo_filters.surface import Surface

FilterType = TypeVar("FilterType", bound="Filter")


class Filter:
    """One step from a mesh to the same mesh with more named per-vertex attributes.

    A subclass takes keyword arguments, stores each unchanged under its own name and does nothing else in
    its constructor (scikit-learn's convention), lists in `outputs` the attributes that it adds, and
    implements `compute`. Results that are not per vertex are left on the filter, under a name that ends
    in an underscore, until the next call.
    """

    outputs: ClassVar[Mapping[str, str]] = {}
    """Attributes that the filter adds: name -> shape, unit and meaning."""

    index_outputs: ClassVar[frozenset[str]] = frozenset()
    """Those of `outputs` whose values are vertex indices of the same mesh."""

    repair_: Repair | None = None
    """What the last call with ``repair=True`` changed."""

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Attributes of the surface, by name; what a subclass implements."""
        raise NotImplementedError(f"{type(self).__name__} must implement compute")

    def apply(self, surface: Surface, progress: bool = False) -> Surface:
        """Surface with the filter's attributes added."""
        return surface.with_attributes(self.compute(surface, progress))

    def __call__(self, mesh: Any, *, repair: bool = False, progress: bool = False) -> Any:
        """Mesh of the same kind with the filter's attributes; the input is not changed.

        Parameters
        ----------
        mesh : mesh object, (V, F) or path
            Whatever `as_surface` takes: a mesh of Open3D, PyMeshLab, PyVista or trimesh, a `Surface`. A legacy
            Open3D mesh comes back as the tensor kind, a ``(V, F)`` pair and a path as a `Surface`.
        repair : bool
            Work on a repaired copy where the mesh is not manifold or not in one piece. Attributes are
            carried back to the vertices of the input (NaN, or -1 for indices, where a vertex had to go);
            ``repair_`` says what was changed. Where not even a `Surface` can hold the input (a pair or file
            with indices out of range, say), the repaired `Surface` is returned.
        progress : bool
            Show progress bars.

        Raises
        ------
        MeshError
            For a mesh that the filter cannot take; the message names what is wrong, where and how often.
        """
        self.repair_ = None
        with cache.held():
            if not repair:
                surface = as_surface(mesh)
                return write_back(mesh, surface, _added(surface, self.apply(surface, progress)))
            self.repair_ = repair_surface(mesh)
            fixed = self.repair_.surface
            added = _added(fixed, self.apply(fixed, progress))
        back = {name: self._carried_back(self.repair_, name, values) for name, values in added.items()}
        try:
            return write_back(mesh, as_surface(mesh), back)
        except MeshError:
            if is_host_mesh(mesh):
                return write_back(mesh, None, back)
            return fixed.with_attributes(added)

    def _carried_back(self, repair: Repair, name: str, values: np.ndarray) -> np.ndarray:
        if name in self.index_outputs:
            values = np.where(values >= 0, repair.origin[np.maximum(values, 0)], -1)
        return repair.map_back(values)

    # -- parameters ---------------------------------------------------------------------------------

    @classmethod
    def _parameter_names(cls) -> list[str]:
        return list(inspect.signature(cls).parameters)

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Constructor arguments by name; ``deep`` is accepted for scikit-learn's sake."""
        return {name: getattr(self, name) for name in self._parameter_names()}

    def set_params(self: FilterType, **params: Any) -> FilterType:
        """The filter with some arguments replaced, in place; unknown names raise ValueError."""
        names = self._parameter_names()
        for name, value in params.items():
            if name not in names:
                raise ParameterError(
                    f"{type(self).__name__} has no parameter {name!r}; it has {', '.join(names) or 'none'}"
                )
            setattr(self, name, value)
        return self

    def clone(self: FilterType) -> FilterType:
        """New filter of equal parameters, without results."""
        return type(self)(**self.get_params())

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.get_params().items())})"

    # -- composition --------------------------------------------------------------------------------

    def __or__(self, other: Filter) -> Any:
        if not isinstance(other, Filter):
            return NotImplemented
        from qgeo_filters.filters.pipeline import Pipeline

        return Pipeline([*_steps(self), *_steps(other)])


def _steps(filter: Filter) -> Iterator[Filter]:
    yield from getattr(filter, "steps", [filter])


def _added(before: Surface, after: Surface) -> dict[str, np.ndarray]:
    """Attributes that are new or replaced."""
    return {name: values for name, values in after.attributes.items() if before.attributes.get(name) is not values}


REGISTRY: dict[str, type[Filter]] = {}
"""Filters by the name under which a saved pipeline refers to them."""


def registered(cls: type[FilterType]) -> type[FilterType]:
    """Class decorator: a saved pipeline may name this filter."""
    REGISTRY[cls.__name__] = cls
    return cls
