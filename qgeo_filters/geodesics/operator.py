"""The distance matrix as an operator that is never stored."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse.linalg import LinearOperator

from qgeo_filters.geodesics.dgg.graph import graph_of
from qgeo_filters.geodesics.metric import Metric, metric_for
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.parallel import GROUP, run_tasks, worker_count


class DistanceOperator(LinearOperator):
    """Symmetric linear operator v -> D v, D the (n, n) matrix of geodesic distances, in O(n) memory.

    Every product computes the rows of D afresh, a group of sources at a time: take the products of many
    vectors in one call (``operator @ X``, as block methods do), they cost hardly more than one. Vectors in
    float32 are multiplied in float32, twice as fast; the products are float64 either way.

    Parameters
    ----------
    surface : Surface
        Manifold and in one piece.
    metric : LiftedMetric, "cartesian" or "lifted"
        By name: the surface's own metric, or `lifted_metric` as it is.
    accuracy : float
        Bound on the relative error of each entry.
    workers : int, optional
        Threads; all cores by default.
    progress : bool
        Show a progress bar for every product.

    Raises
    ------
    DisconnectedError
        A mesh in several pieces, or vertices without faces: their distances are infinite, and products not defined.
    NonManifoldError
        Three faces on an edge, or several fans at a vertex.
    ParameterError
        The metric of another surface, accuracy out of range.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> operator = qg.DistanceOperator(surface)
    >>> operator.shape
    (162, 162)
    >>> np.allclose(operator @ np.ones(162), qg.distance_matrix(surface) @ np.ones(162), rtol=1e-5)
    True
    """

    def __init__(
        self,
        surface: SurfaceLike,
        metric: Metric | None = "cartesian",
        *,
        accuracy: float = 1e-3,
        workers: int | None = None,
        progress: bool = False,
    ) -> None:
        surface = as_surface(surface)
        chosen = metric_for(surface, metric, "cartesian")
        surface.require_connected("the distance operator")
        self.workers = worker_count(workers)
        self.progress = progress
        self.graph = graph_of(chosen, accuracy, self.workers)
        super().__init__(np.dtype(np.float64), (surface.n_vertices, surface.n_vertices))  # type: ignore[call-arg]

    def _matmat(self, x: npt.ArrayLike) -> npt.NDArray[np.float64]:
        x = np.asarray(x)
        n, order = self.graph.n_vertices, self.graph.source_order
        product = np.empty((n, x.shape[1]), np.result_type(x.dtype, np.float64))
        entries = np.float32 if x.dtype == np.float32 else np.float64

        def task(first: int) -> None:
            sources = order[first : first + GROUP]
            rows = np.empty((len(sources), n), entries)
            self.graph.distances_into(rows, np.arange(len(sources)), sources)
            product[sources] = rows @ x

        run_tasks(task, range(0, n, GROUP), self.workers, self.progress)
        return product

    def _matvec(self, x: npt.ArrayLike) -> npt.NDArray[np.float64]:
        return self._matmat(np.reshape(x, (-1, 1))).ravel()

    def _adjoint(self) -> Any:
        return self

    def _transpose(self) -> Any:
        return self
