"""A path over a surface, and what is known of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.html_repr import card, shown


@dataclass(frozen=True, eq=False)
class GeodesicPath:
    r"""A path over the surface from vertex to vertex, straight inside triangles.

    Attributes
    ----------
    points : (p, 3) float64
        Start, crossings of edges, vertices passed through, end, in the surface's own coordinates.
    faces : (p,) int32
        Triangle that holds the points k and k + 1; the last one is repeated.
    barycentric : (p, 3) float64
        Coordinates of point k in ``faces[k]``.
    vertices : (p,) int32
        Vertex that the point is, -1 on an edge.
    length : float
        In the metric that the path was sought in, in the unit of the vertices.
    left_angle, right_angle : (p - 2,) float64
        Angle of the surface to the left and right of the path at each interior point, radians, in that
        metric. Left as seen from the side that the first triangle's normal points to.
    kappa_g : (p - 2,) float64
        Discrete geodesic curvature, eq. (1): :math:`(2\pi/\theta)(\theta/2 - \theta_r)` of the total
        angle :math:`\theta` and the right angle :math:`\theta_r`, radians; positive where the path turns right.
    converged : bool
        Certificate that the path is locally shortest: at each interior point :math:`|\kappa_g|` is
        below the tolerance, or the point is a vertex where both angles are at least :math:`\pi`, on the
        boundary the one angle away from it.
    initial_points : (q, 3) float64
        The first path, before it was straightened.
    lengths : (rounds,) float64
        Length of the first path, then after each round of straightening, never increasing.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> path = qg.quasi_geodesic(surface, 0, 50)
    >>> steps = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
    >>> bool(np.isclose(steps.sum(), path.length))
    True
    >>> at = np.einsum("pi,pij->pj", path.barycentric, surface.vertices[surface.faces[path.faces]])
    >>> np.allclose(at, path.points)
    True
    """

    points: FloatArray
    faces: IntArray
    barycentric: FloatArray
    vertices: IntArray
    length: float
    left_angle: FloatArray
    right_angle: FloatArray
    kappa_g: FloatArray
    converged: bool
    initial_points: FloatArray
    lengths: FloatArray

    def __repr__(self) -> str:
        state = "converged" if self.converged else "not converged"
        return f"GeodesicPath({len(self.points)} points, length {self.length:.6g}, {state})"

    def _repr_html_(self) -> str:
        facts = {
            "length": self.length,
            "points": len(self.points),
            "through vertices": int((self.vertices >= 0).sum()),
            "converged": self.converged,
            "largest geodesic curvature": f"{shown(float(np.abs(self.kappa_g).max(initial=0.0)))} rad",
            "first path was longer by": f"{shown(100 * (float(self.lengths[0]) / self.length - 1))} %"
            if self.length > 0
            else None,
        }
        return card("GeodesicPath", facts)
