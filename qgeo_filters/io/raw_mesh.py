"""Arrays of a mesh as they came, before anything was checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from qgeo_filters.equal_rows import equal_rows


@dataclass(frozen=True, eq=False)
class RawMesh:
    """Unchecked vertices, triangles and per-vertex attributes, and what was changed to get them.

    Attributes
    ----------
    vertices : array, shape (n, 3)
    faces : array, shape (m, 3)
    attributes : mapping of str to array, shape (n, ...)
    notes : tuple of str
        Sentences for the report of a repair, such as polygons that were triangulated.
    """

    vertices: npt.ArrayLike
    faces: npt.ArrayLike
    attributes: Mapping[str, npt.ArrayLike] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def weld(corners: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Distinct points in order of first appearance, shape (n, 3), and the point of each row."""
    points = corners + 0.0  # -0.0 is 0.0
    number, first = equal_rows(points)
    appearance = np.argsort(first)
    rank = np.empty_like(appearance)
    rank[appearance] = np.arange(len(appearance))
    return points[first[appearance]], rank[number]


def counted(count: int, noun: str, plural: str | None = None) -> str:
    """The count with its noun: ``1 face``, ``2 faces``."""
    return f"{count} {noun if count == 1 else plural or noun + 's'}"
