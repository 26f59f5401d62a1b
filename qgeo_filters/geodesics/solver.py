"""A solver object for distances and paths of one surface in one metric, which keeps what it prepares."""

from __future__ import annotations

import os
import warnings
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, SingleArray
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.geodesics.distance_solver import DistanceSolver, all_distances, distances_from
from qgeo_filters.geodesics.methods import method_named
from qgeo_filters.geodesics.metric import Metric, metric_for
from qgeo_filters.geodesics.path.geodesic_path import GeodesicPath
from qgeo_filters.geodesics.path.paths import PathFinder
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.memory import require_memory
from qgeo_filters.parallel import worker_count
from qgeo_filters.repair.welding import not_welded
from qgeo_filters.validation import checked_index, checked_indices


class GeodesicSolver:
    """Distances and paths over a surface, prepared on first use and then kept: for many calls one after the other.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        Manifold, in any number of pieces, orientable or not.
    metric : LiftedMetric, "cartesian" or "lifted"
        By name: the surface's own metric, or `lifted_metric` as it is.
    method : str
        How distances are computed, see `qgeo_filters.distances`.
    accuracy : float
        Bound on the relative error of the graph method.
    workers : int, optional
        Threads; all cores by default. No result depends on it.

    Raises
    ------
    NonManifoldError
        Three faces on an edge, or several fans at a vertex.
    ParameterError
        Unknown method, the metric of another surface, no worker.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> solver = qg.GeodesicSolver(surface, metric="lifted")
    >>> solver.distances([0, 5]).shape  # its graph is kept for what follows
    (2, 162)
    >>> bool(abs(solver.path(0, 5).length / solver.distances(0)[0, 5] - 1) < 1e-3)
    True
    """

    def __init__(
        self,
        surface: SurfaceLike,
        metric: Metric = "cartesian",
        method: str = "graph",
        *,
        accuracy: float = 1e-3,
        workers: int | None = None,
    ) -> None:
        surface = as_surface(surface)
        self.surface = surface
        self.metric = metric_for(surface, metric, "cartesian")
        self.method = method
        self.accuracy = accuracy
        worker_count(workers)  # refuses what is no number of threads
        self.workers = workers
        self._make = method_named(method)
        surface.require_manifold("the geodesic distance")

    def __repr__(self) -> str:
        return (
            f"GeodesicSolver({self.surface!r}, curvature_weight={self.metric.curvature_weight:g}, "
            f"method={self.method!r}, accuracy={self.accuracy:g})"
        )

    @cached_property
    def _solver(self) -> DistanceSolver:
        pieces = self.surface.components[0]
        if pieces > 1 and self.surface.unwelded_vertices.size:
            warnings.warn(
                f"distances between the {pieces} pieces of the mesh are inf, but "
                f"{not_welded(self.surface.unwelded_vertices.size)}",
                stacklevel=5,
            )
        return self._make(self.metric, self.accuracy, self.workers)

    def distances(self, sources: npt.ArrayLike, *, progress: bool = False) -> FloatArray:
        """Distances (s, n) from some vertices to all, see `qgeo_filters.distances`."""
        return self._rows(sources, np.dtype(np.float64), progress)

    def single_distances(self, sources: npt.ArrayLike, *, progress: bool = False) -> SingleArray:
        """The same in float32: half the memory, for rows of many vertices."""
        return self._rows(sources, np.dtype(np.float32), progress)

    def _rows(self, sources: npt.ArrayLike, dtype: np.dtype, progress: bool) -> np.ndarray:
        n = self.surface.n_vertices
        chosen = checked_indices(sources, n, "sources")
        require_memory(
            dtype.itemsize * n * len(chosen),
            f"the distances from {len(chosen)} to all {n} vertices",
            "take fewer sources at a time",
        )
        return distances_from(self._solver, chosen, self.workers, progress, dtype)

    def distance_matrix(self, *, out: str | os.PathLike[str] | None = None, progress: bool = False) -> Any:
        """Distances (n, n) between all vertices, in memory or on disk, see `qgeo_filters.distance_matrix`."""
        extent = float(self.metric.edge_lengths.sum())
        if extent and not 1e-30 < extent < 1e35:
            raise MeshError(
                f"edges of {extent:g} units in total: float32 does not hold such distances; rescale the mesh"
            )
        if out is None:
            require_matrix(self.surface.n_vertices)
            return all_distances(self._solver, self.workers, progress)
        if self.method != "graph":
            raise ParameterError(f"out= is written by the graph method only, not by {self.method!r}")
        # Not at the top: storage needs the package zarr only where it is used.
        from qgeo_filters.geodesics.storage import stored_matrix

        return stored_matrix(
            Path(out), self.metric.intrinsic(), lambda: self._solver, self.accuracy, self.workers, progress
        )

    def path(self, i: int, j: int, *, initial: str = "exact", tolerance: float = 1e-6) -> GeodesicPath:
        """Locally shortest path between two vertices, see `qgeo_filters.quasi_geodesic`."""
        n = self.surface.n_vertices
        finder = self._finders.get((initial, tolerance))
        if finder is None:
            finder = self._finders[initial, tolerance] = PathFinder(self.surface, self.metric, initial, tolerance)
        return finder(checked_index(i, n, "i"), checked_index(j, n, "j"))

    @cached_property
    def _finders(self) -> dict[tuple[str, float], PathFinder]:
        return {}


def require_matrix(n: int) -> None:
    """Raise `TooLargeError` unless the distances between n vertices, in float32, fit into the memory that is free."""
    require_memory(
        4 * n * n,
        f"the distances between all {n} vertices",
        "write them to disk with distance_matrix(..., out='FILE.zarr'), measure from some vertices with distances(), "
        "multiply by DistanceOperator, which stores nothing, or take a spectrum with landmarks=",
    )
