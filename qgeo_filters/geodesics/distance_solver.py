"""What a method of geodesic distances implements, and the loops over many sources that all methods share."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import IndexArray, SingleArray
from qgeo_filters.parallel import run_tasks


class DistanceSolver(ABC):
    """Distances of one metric by one method, with all that is prepared only once.

    A method is a subclass, or a function ``(metric, accuracy, workers)`` that returns one: see `register_method`.

    Examples
    --------
    >>> from qgeo_filters.geodesics.methods import METHODS
    >>> surface = qg.testing.sample_surface()
    >>> solver = METHODS["edges"](qg.lifted_metric(surface), 1e-3, None)
    >>> isinstance(solver, qg.DistanceSolver)
    True
    """

    #: Sources that one task takes.
    group: int = 1
    #: Whether distances are the same from either end, bit for bit; if not, matrices are made symmetric afterwards.
    symmetric: bool = False

    @property
    @abstractmethod
    def n_vertices(self) -> int:
        """Number of vertices, those without faces included."""

    @abstractmethod
    def distances_into(self, out: np.ndarray, rows: IndexArray, sources: IndexArray) -> None:
        """Distances from each source into its row of ``out`` (., n), float32 or float64; ``inf`` where no path is.

        Called from several threads at once.
        """

    @property
    def source_order(self) -> IndexArray:
        """All vertices in the order in which this method is quickest with them as sources, shape (n,)."""
        return np.arange(self.n_vertices)


def distances_from(
    solver: DistanceSolver, sources: IndexArray, workers: int | None, progress: bool, dtype: npt.DTypeLike = np.float64
) -> np.ndarray:
    """Distances (s, n) from vertices in any order, repeated ones too."""
    result = np.empty((len(sources), solver.n_vertices), dtype)
    place = np.empty(solver.n_vertices, np.int64)
    place[solver.source_order] = np.arange(solver.n_vertices)
    together = np.argsort(place[sources], kind="stable")

    def task(first: int) -> None:
        part = together[first : first + solver.group]
        solver.distances_into(result, part, sources[part])

    run_tasks(task, range(0, len(sources), solver.group), workers, progress)
    return result


def all_distances(solver: DistanceSolver, workers: int | None, progress: bool) -> SingleArray:
    """Distances (n, n) between all vertices, symmetric."""
    n = solver.n_vertices
    order = solver.source_order
    matrix = np.empty((n, n), np.float32)

    def task(first: int) -> None:
        sources = order[first : first + solver.group]
        solver.distances_into(matrix, sources, sources)

    run_tasks(task, range(0, n, solver.group), workers, progress)
    if not solver.symmetric:
        _symmetrise(matrix)
    return matrix


def _symmetrise(matrix: SingleArray, size: int = 512) -> None:
    """Put the smaller of both directions into either, in place: they differ by rounding only."""
    for i in range(0, len(matrix), size):
        for j in range(0, i + 1, size):
            lower, upper = matrix[i : i + size, j : j + size], matrix[j : j + size, i : i + size]
            least = np.minimum(lower, upper.T)
            lower[...], upper[...] = least, least.T
