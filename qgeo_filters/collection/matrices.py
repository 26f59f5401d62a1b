"""Distances between all vertices of one large shape: blocks of rows are tasks, the store holds the array."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from functools import partial as applied
from pathlib import Path
from typing import Any

from qgeo_filters.collection.engines import run_chunks
from qgeo_filters.collection.store import Store
from qgeo_filters.collection.stored_shapes import StoredShapes
from qgeo_filters.geodesics.distance_solver import DistanceSolver
from qgeo_filters.geodesics.methods import method_named
from qgeo_filters.geodesics.metric import LiftedMetric, lifted_metric
from qgeo_filters.geodesics.storage import stored_matrix, write_rows
from qgeo_filters.parallel import default_workers
from qgeo_filters.surface import Surface

# Groups of sources that a worker takes at once: seconds of work, so that the graph of the shape is worth its while.
_GROUPS = 8


class Matrices(StoredShapes):
    """Shapes whose distance matrices are kept."""

    def distance_matrix(
        self,
        name: str,
        *,
        curvature_weight: float = 0.0,
        accuracy: float = 1e-3,
        workers: int | None = None,
        backend: str = "loky",
        scheduler: Any = None,
        progress: bool = False,
    ) -> Any:
        """Geodesic distances between all vertices of a shape, see `distance_matrix`, in the store.

        Parameters
        ----------
        name : str
        curvature_weight : float
            Of mean curvature in the metric, see `lifted_metric`; 0: the surface's own metric.
        accuracy : float
            Bound on the relative error of each entry.
        workers, backend, scheduler, progress
            As in `match`: blocks of rows are tasks, and leave their rows in the array.

        Returns
        -------
        (n, n) float32 zarr.Array
            Bit for bit that of ``distance_matrix(surface, lifted_metric(surface, curvature_weight=...))``. It takes the
            place of a matrix in `distance_spectrum`, which reads it a block of rows at a time. Rows that are there are
            not computed again.

        Raises
        ------
        OSError, WorkersLostError
            As in `match`; rows that are finished stay.
        """
        key = self._entry(name).surface
        metric = _metric(self.store.surface(key), curvature_weight)
        self.settings.check_code()
        digest = hashlib.sha256(f"{self.settings.code} {key} {curvature_weight!r} {accuracy!r}".encode()).hexdigest()
        path = self.store.root.resolve() / "matrices" / digest[:32]
        job = applied(rows_task, str(self.store.root.resolve()), path, key, curvature_weight, accuracy)

        def run(groups: list[int], finished: Callable[[int], None]) -> None:
            chunks = [groups[first : first + _GROUPS] for first in range(0, len(groups), _GROUPS)]
            options: dict[str, Any] = {"workers": workers, "backend": backend, "scheduler": scheduler}
            done: Iterator[int] = run_chunks(job, chunks, progress=progress, unit="group", **options)
            for first in done:
                finished(first)

        return stored_matrix(
            path, metric.intrinsic(), lambda: _solver_of(metric, accuracy), accuracy, workers, progress, run
        )


def rows_task(
    root: str,
    path: Path,
    surface: str,
    curvature_weight: float,
    accuracy: float,
    groups: Sequence[int],
    workers: int | None = 1,
) -> list[int]:
    """Write groups of rows of a distance matrix into its array; returns those that are there now."""
    with default_workers(workers):
        solver = _solver(root, surface, curvature_weight, accuracy)
        for first in groups:
            write_rows(path, solver, first)
    return list(groups)


@lru_cache(maxsize=1)
def _solver(root: str, surface: str, curvature_weight: float, accuracy: float) -> DistanceSolver:
    return _solver_of(_metric(Store(root, create=False).surface(surface), curvature_weight), accuracy)


def _solver_of(metric: LiftedMetric, accuracy: float) -> DistanceSolver:
    return method_named("graph")(metric, accuracy, None)


def _metric(surface: Surface, curvature_weight: float) -> LiftedMetric:
    surface.require_manifold("the geodesic distance")
    return lifted_metric(surface, curvature_weight=curvature_weight)
