"""What a filter does to a surface, and the same done to a mesh of any host."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.hosts.dispatch import with_positions, write_back
from qgeo_filters.surface import Surface


@dataclass(frozen=True, eq=False)
class Changes:
    """Attributes, new or replaced, and how far each vertex is moved, if at all.

    Attributes
    ----------
    added : dict of str to (n, ...) array
    shift : (n, 3) float64 or None
    """

    added: dict[str, np.ndarray]
    shift: FloatArray | None

    @classmethod
    def between(cls, before: Surface, after: Surface) -> Changes:
        """What was changed of the one surface where the other is it, changed."""
        added = {name: values for name, values in after.attributes.items() if before.attributes.get(name) is not values}
        return cls(added, None if after.vertices is before.vertices else after.vertices - before.vertices)

    def made_on(self, mesh: Any, surface: Surface) -> Any:
        """The mesh of any host, with ``as_surface(mesh)`` given, after the changes."""
        if self.shift is not None:
            surface = surface.with_vertices(surface.vertices + self.shift)
            mesh = with_positions(mesh, surface.vertices)
        return write_back(mesh, surface, self.added)
