"""Exact geodesic distances from vertices, on side lengths alone."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.geodesics.distance_solver import DistanceSolver, distances_from
from qgeo_filters.geodesics.metric import IntrinsicMesh, LiftedMetric
from qgeo_filters.geodesics.mmp.window_propagation import propagate
from qgeo_filters.geodesics.unfolding import unfolded
from qgeo_filters.validation import checked_indices


class WindowPropagation(DistanceSolver):
    """Exact distances of a metric, whose triangles are kept laid flat; each source is propagated on its own."""

    def __init__(self, mesh: IntrinsicMesh) -> None:
        self.flat = unfolded(mesh)

    @classmethod
    def of(cls, metric: LiftedMetric, accuracy: float, workers: int | None) -> WindowPropagation:
        """Solver of a metric; there is nothing that the accuracy could allow."""
        return cls(metric.intrinsic())

    @property
    def n_vertices(self) -> int:
        """Number of vertices, those without faces included."""
        return len(self.flat.angles)

    def distances_into(self, out: np.ndarray, rows: IndexArray, sources: IndexArray) -> None:
        """Distances from each source into its row of ``out`` (., n)."""
        distance = np.empty(self.n_vertices)
        for row, source in zip(rows, sources, strict=True):
            propagate(source, -1, self.flat, distance)
            out[row] = distance


def exact_distances(
    mesh: IntrinsicMesh, sources: npt.ArrayLike, *, workers: int | None = None, progress: bool = False
) -> FloatArray:
    """Length of the shortest path over the triangles from each source to every vertex.

    Parameters
    ----------
    mesh : IntrinsicMesh
        A manifold, with or without boundary, orientable or not, in any number of pieces; see
        `LiftedMetric.intrinsic`. Only its side lengths matter, they need not come from coordinates.
    sources : array-like of int, shape (s,)
        Vertices, from each of which the distance is measured on its own.
    workers : int, optional
        Threads; each takes one source at a time. All cores by default.
    progress : bool
        Show a progress bar.

    Returns
    -------
    (s, n) float64
        In the unit of the side lengths, exact up to rounding; ``inf`` where there is no path.

    Raises
    ------
    MeshError
        A source that is no vertex of the mesh.

    Notes
    -----
    Ordered propagation of windows (Mitchell, Mount, Papadimitriou 1987); see `window_propagation`. A path that
    merely touches two faces' common vertex may cross there. Triangles without area, or needles, are faces like any
    other; sides that cannot be told from those of three points on a line, within rounding, lie on one.
    """
    chosen = checked_indices(sources, mesh.n_vertices, "sources")
    return distances_from(WindowPropagation(mesh), chosen, workers, progress)
