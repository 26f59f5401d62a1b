"""Maps from vertices to points inside triangles, finer than the triangulation of the target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_indices, frozen

_SIDES = ((0, 1), (1, 2), (2, 0))


@dataclass(frozen=True, eq=False)
class BarycentricMap:
    """Point of a triangle of Y for each vertex of X.

    Attributes
    ----------
    faces : (n_x,) int64
        Triangle of Y.
    corners : (n_x, 3) int64
        Its vertices.
    coordinates : (n_x, 3) float64
        Weights of the corners, not negative, with sum 1.
    """

    faces: IndexArray
    corners: IndexArray
    coordinates: FloatArray

    @property
    def nearest_corner(self) -> IndexArray:
        """Corner of largest weight, (n_x,)."""
        return np.take_along_axis(self.corners, self.coordinates.argmax(axis=1)[:, None], axis=1)[:, 0]

    def pulled_back(self, values: npt.ArrayLike) -> np.ndarray:
        """Values of Y, (n_y, ...), at the images of the vertices of X, (n_x, ...).

        Floating-point values are interpolated. Whole numbers (labels, indices) and booleans are taken from the
        nearest corner, since an interpolated label means nothing.
        """
        array = np.asarray(values)
        if array.dtype.kind in "fc":
            return np.einsum("ij,ij...->i...", self.coordinates, array[self.corners])
        return array[self.nearest_corner]


def barycentric_map(positions: npt.ArrayLike, p2p: npt.ArrayLike, y: SurfaceLike, rings: int = 2) -> BarycentricMap:
    """Point of Y nearest to each position, of those around a vertex that is known to be near on the surface.

    Sheets that pass close to each other in space (fingers, a tail on a flank) are kept apart by looking at the
    triangles around the vertex only.

    Parameters
    ----------
    positions : array-like, shape (n_x, 3)
        X deformed onto Y, as in `MatchResult.positions`.
    p2p : array-like of int, shape (n_x,)
        Vertex of Y for each vertex of X.
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
    """
    y = as_surface(y)
    points = np.asarray(positions, dtype=np.float64)
    images = checked_indices(p2p, y.n_vertices, "p2p")
    if points.shape != (len(images), 3):
        raise ParameterError(f"positions have shape {points.shape}, expected ({len(images)}, 3): one for each of p2p")
    if rings < 1:
        raise ParameterError(f"at least one ring of triangles must be looked at, got {rings}")
    around = _faces_around(y, rings)[images]
    count = np.diff(around.indptr)
    if not count.all():
        raise ParameterError(f"vertex {images[count.argmin()]} of Y, to which p2p leads, has no triangle")
    owner, face = np.repeat(np.arange(len(points)), count), around.indices.astype(np.int64)
    weights, gap = nearest_in_triangles(points[owner], y.vertices[y.faces[face]])
    # The nearest triangle of each owner, the first of equals.
    order = np.lexsort((face, gap, owner))
    best = order[np.concatenate([[0], np.cumsum(count)[:-1]])]
    return BarycentricMap(frozen(face[best]), frozen(y.faces[face[best]].astype(np.int64)), frozen(weights[best]))


def _faces_around(y: Surface, rings: int) -> sparse.csr_matrix:
    """Incidence (n, m) of vertices with the triangles of so many rings around them."""
    m = y.n_faces
    corner = np.repeat(np.arange(m), 3)
    incident = sparse.csr_matrix((np.ones(3 * m, dtype=bool), (y.faces.ravel(), corner)), shape=(y.n_vertices, m))
    around = incident
    for _ in range(rings - 1):
        around = (incident @ incident.T) @ around
    return sparse.csr_matrix(around)


def nearest_in_triangles(points: FloatArray, triangles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Barycentric coordinates (k, 3) of the point of each triangle (k, 3, 3) nearest to a point, and its distance."""
    a = triangles[:, 0]
    u, v, w = triangles[:, 1] - a, triangles[:, 2] - a, points - a
    uu, uv, vv = (np.einsum("ij,ij->i", *pair) for pair in ((u, u), (u, v), (v, v)))
    wu, wv = (np.einsum("ij,ij->i", w, side) for side in (u, v))
    determinant = uu * vv - uv * uv
    with np.errstate(divide="ignore", invalid="ignore"):
        s, t = (vv * wu - uv * wv) / determinant, (uu * wv - uv * wu) / determinant
    # A triangle without area has no inside, but sides.
    inside = (s >= 0) & (t >= 0) & (s + t <= 1)
    weights = np.where(inside[:, None], np.column_stack([1 - s - t, s, t]), 0.0)
    least = np.where(inside, -1.0, np.inf)
    for i, j in _SIDES:
        side = triangles[:, j] - triangles[:, i]
        squared = np.einsum("ij,ij->i", side, side)
        along = np.einsum("ij,ij->i", points - triangles[:, i], side) / np.where(squared > 0, squared, 1.0)
        along = np.clip(along, 0.0, 1.0)
        gap = np.linalg.norm(triangles[:, i] + along[:, None] * side - points, axis=1)
        nearer = gap < least
        least[nearer] = gap[nearer]
        weights[nearer] = 0.0
        weights[nearer, i], weights[nearer, j] = 1 - along[nearer], along[nearer]
    return weights, np.linalg.norm(np.einsum("ij,ijk->ik", weights, triangles) - points, axis=1)
