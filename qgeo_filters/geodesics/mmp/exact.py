"""Exact geodesic distances from vertices, on side lengths alone."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.geodesics.metric import IntrinsicMesh
from qgeo_filters.geodesics.mmp.window_propagation import propagate
from qgeo_filters.geodesics.unfolding import unfolded
from qgeo_filters.parallel import in_threads
from qgeo_filters.validation import checked_indices


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
    Ordered propagation of windows (Mitchell, Mount, Papadimitriou 1987); see `propagation`. A path that
    merely touches two faces' common vertex may cross there.
    """
    indices = checked_indices(sources, mesh.n_vertices, "sources")
    flat = unfolded(mesh)
    distances = np.empty((len(indices), mesh.n_vertices))

    def fill(row: int) -> None:
        propagate(indices[row], -1, flat, distances[row])

    in_threads(fill, range(len(indices)), workers, progress=progress, description="exact distances", unit="source")
    return distances
