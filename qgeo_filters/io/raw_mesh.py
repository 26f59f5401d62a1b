"""Arrays of a mesh as they came, before anything was checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import MeshError


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


def triangles(polygons: Sequence[Any] | np.ndarray, repair: bool) -> tuple[np.ndarray, tuple[str, ...]]:
    """Triangles of a list of faces, and a note where polygons were split.

    Parameters
    ----------
    polygons : sequence of m index sequences, or array (m, c)
        Corners of each face.
    repair : bool
        Split a face of c corners into the c - 2 triangles of the fan at its first corner.

    Returns
    -------
    faces : (k, 3) array
    notes : tuple of str

    Raises
    ------
    MeshError
        A face of fewer than three corners; more than three and not `repair`.
    """
    sizes = np.fromiter(map(len, polygons), dtype=np.int64, count=len(polygons))
    few = np.flatnonzero(sizes < 3)
    if few.size:
        raise MeshError(f"face {few[0]} has {sizes[few[0]]} corners ({few.size} faces with fewer than three)")
    many = np.flatnonzero(sizes > 3)
    if not many.size:
        return np.array(list(polygons)).reshape(-1, 3), ()
    if not repair:
        raise MeshError(
            f"face {many[0]} has {sizes[many[0]]} corners ({many.size} of {len(sizes)} faces are polygons, not "
            "triangles); triangulate the mesh first, or pass repair=True"
        )
    first = np.repeat([polygon[0] for polygon in polygons], sizes - 2)
    second = np.concatenate([polygon[1:-1] for polygon in polygons])
    third = np.concatenate([polygon[2:] for polygon in polygons])
    note = f"{counted(many.size, 'polygon')} split into {int((sizes[many] - 2).sum())} triangles"
    return np.column_stack([first, second, third]), (note,)


def weld(corners: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Distinct points in order of first appearance, shape (n, 3), and the point of each row."""
    points, first, inverse = np.unique(corners + 0.0, axis=0, return_index=True, return_inverse=True)  # -0.0 is 0.0
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return points[order], rank[inverse.ravel()]


def counted(count: int, noun: str, plural: str | None = None) -> str:
    """The count with its noun: ``1 face``, ``2 faces``."""
    return f"{count} {noun if count == 1 else plural or noun + 's'}"
