"""Geodesic distance between the two vertices of each of many pairs."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.geodesics.solver import GeodesicSolver
from qgeo_filters.surface import Surface


def paired_distances(
    surface: Surface, one: IndexArray, other: IndexArray, *, workers: int | None = None, held: int = 1 << 25
) -> FloatArray:
    """Geodesic distance between each vertex and its partner, shape (k,), in the unit of the vertices.

    Parameters
    ----------
    surface : Surface
    one, other : (k,) int64
        Vertices, in range.
    workers : int, optional
        Threads; all cores by default. The distances do not depend on it.
    held : int
        How many distances are held in memory at once, at least those of one source to all vertices.

    Notes
    -----
    From as few sources as one side of the pairs has, with some of the rows held at a time.
    """
    found = np.zeros(len(one))
    apart = np.flatnonzero(one != other)
    if not apart.size:
        return found
    ends = sorted((one[apart], other[apart]), key=lambda side: len(np.unique(side)))
    sources, row = np.unique(ends[0], return_inverse=True)
    solver = GeodesicSolver(surface, "cartesian", "graph", workers=workers)
    at_once = max(1, held // surface.n_vertices)
    order = np.argsort(row, kind="stable")
    for start in range(0, len(sources), at_once):
        lengths = solver.distances(sources[start : start + at_once])
        chosen = order[slice(*np.searchsorted(row[order], (start, start + at_once)))]
        found[apart[chosen]] = lengths[row[chosen] - start, ends[1][chosen]]
    return found
