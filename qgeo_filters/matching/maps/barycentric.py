"""Maps from vertices to points inside triangles, finer than the triangulation of the target."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse

from qgeo_filters._typing import FloatArray, IndexArray, IntArray
from qgeo_filters.array_likes import as_array
from qgeo_filters.barycentric import BarycentricMap, nearest_in_triangles
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.repair.welding import welded
from qgeo_filters.validation import checked_indices, frozen

_PAIRS = 1 << 18  # of a point and a triangle that are measured at once: some hundred bytes each


def barycentric_map(positions: npt.ArrayLike, p2p: npt.ArrayLike, y: SurfaceLike, rings: int = 2) -> BarycentricMap:
    """Point of Y nearest to each position, of those around a vertex that is known to be near on the surface.

    Sheets that pass close to each other in space (fingers, a tail on a flank) are kept apart by looking at the
    triangles around the vertex only; across a seam where the mesh is not welded these are looked at all the same.

    Parameters
    ----------
    positions : array-like, shape (n_x, 3)
        X deformed onto Y, as in `MatchResult.positions`.
    p2p : array-like of int, shape (n_x,)
        Vertex of Y for each vertex of X; -1: none, and no point is looked for.
    y : Surface, or whatever `as_surface` takes
    rings : int
        How many rings of triangles around the vertex are looked at.

    Returns
    -------
    BarycentricMap

    Raises
    ------
    ValueError
        Shapes that do not match, vertices out of range or without triangles, fewer than one ring.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> found = qg.barycentric_map(x.vertices + 0.001, np.arange(162), x)
    >>> np.allclose(found.pulled_back(x.vertices), x.vertices, atol=0.002)
    True
    """
    y = as_surface(y)
    points = as_array(positions).astype(np.float64)
    images = checked_indices(p2p, y.n_vertices, "p2p", missing=True)
    if points.shape != (len(images), 3):
        raise ParameterError(f"positions have shape {points.shape}, expected ({len(images)}, 3): one for each of p2p")
    if rings < 1:
        raise ParameterError(f"at least one ring of triangles must be looked at, got {rings}")
    without = np.flatnonzero((images >= 0) & np.isin(images, y.unreferenced_vertices))
    if without.size:
        raise ParameterError(f"vertex {images[without[0]]} of Y, to which p2p leads, has no triangle")
    return nearest_around(points, images, y.vertices, y.faces, welded(y.vertices, y.faces)[0], rings)


def nearest_around(
    points: FloatArray,
    starts: IndexArray,
    vertices: FloatArray,
    faces: IntArray,
    joined: IndexArray,
    rings: int = 2,
    around: sparse.csr_matrix | None = None,
) -> BarycentricMap:
    """Nearest point to each point, (k, 3), in the rings of triangles around a vertex that is given for each, (k,).

    Parameters
    ----------
    vertices : (n, 3) float64
        Triangles with a corner that is not finite are no triangles.
    joined : (n,) int64
        Vertices of one place, see `welded`: the rings go across seams.
    around : (n, m) sparse matrix, optional
        `triangles_around` of the same, where nearest points are looked for many times.

    Notes
    -----
    No point where the start is -1, the point is not finite, or there is no triangle around the start.
    """
    if around is None:
        around = triangles_around(vertices, faces, joined, rings)
    looked = np.flatnonzero((starts >= 0) & np.isfinite(points).all(axis=1))
    count = np.diff(around.indptr)[joined[starts[looked]]]
    looked, count = looked[count > 0], count[count > 0]
    place = BarycentricMap.unknown(len(points))
    piece = (np.cumsum(count) - 1) // _PAIRS
    for chosen in np.split(looked, np.flatnonzero(np.diff(piece)) + 1) if looked.size else []:
        rows = around[joined[starts[chosen]]]
        owner, face = np.repeat(np.arange(len(chosen)), np.diff(rows.indptr)), rows.indices.astype(np.int64)
        weights, gap = nearest_in_triangles(points[chosen][owner], vertices[faces[face]])
        # The nearest triangle of each owner, the first of equals.
        best = np.lexsort((face, gap, owner))[rows.indptr[:-1]]
        place.faces[chosen] = face[best]
        place.coordinates[chosen] = weights[best]
    known = place.faces >= 0
    place.corners[known] = faces[place.faces[known]]
    return BarycentricMap(frozen(place.faces), frozen(place.corners), frozen(place.coordinates))


def triangles_around(vertices: FloatArray, faces: IntArray, joined: IndexArray, rings: int = 2) -> sparse.csr_matrix:
    """Incidence (n, m) of vertices with the triangles of so many rings around them, see `nearest_around`."""
    n, m = len(vertices), len(faces)
    usable = np.asarray(np.isfinite(vertices).all(axis=1))[faces].all(axis=1)
    corner = np.repeat(np.arange(m), 3)
    incident = sparse.csr_matrix((np.repeat(usable, 3), (joined[faces].ravel(), corner)), shape=(n, m))
    incident.eliminate_zeros()
    around: Any = incident
    for _ in range(rings - 1):
        around = (incident @ incident.T) @ around
    return sparse.csr_matrix(around)
