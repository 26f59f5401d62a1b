"""Curvatures of a triangle mesh at its vertices."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.differential.coordinates import (
    differential_coordinates,
    mixed_voronoi_areas,
    spread_to_neighbours,
)
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen


@dataclass(frozen=True, eq=False)
class PrincipalCurvatures:
    """Principal curvatures and their directions at each vertex.

    Attributes
    ----------
    k1, k2 : (n,) float64
        Largest and smallest normal curvature, ``k1 >= k2``, in units of 1 / length; positive where the surface bends
        away from its normal, as on a sphere with outward normals.
    d1, d2 : (n, 3) float64
        Unit directions, each up to sign; zero where ``fitted`` is False.
    fitted : (n,) bool
        Whether the neighbourhood was large enough for a quadric; elsewhere the curvatures are the
        neighbours' mean.
    """

    k1: FloatArray
    k2: FloatArray
    d1: FloatArray
    d2: FloatArray
    fitted: npt.NDArray[np.bool_]

    @property
    def curvedness(self) -> FloatArray:
        """sqrt((k1^2 + k2^2) / 2), shape (n,), in units of 1 / length (Koenderink and van Doorn 1992)."""
        return np.hypot(self.k1, self.k2) / np.sqrt(2)

    @property
    def shape_index(self) -> FloatArray:
        """(2 / pi) atan((k1 + k2) / (k1 - k2)) in [-1, 1], shape (n,): 1 a cap, 0 a saddle or plane, -1 a cup."""
        return np.arctan2(self.k1 + self.k2, self.k1 - self.k2) * (2 / np.pi)


def mean_curvature(surface: Surface) -> FloatArray:
    """Mean curvature of each vertex, shape (n,), in units of 1 / length: half of <delta^cot, n>.

    n is the angle-weighted normal: positive on a sphere with outward normals. A boundary vertex sees
    one side only and takes the mean of its inner neighbours.

    Raises
    ------
    MeshError
        If neighbouring faces disagree on the outside, for then the sign has no meaning.
    """
    _require_orientation(surface, "the sign of the mean curvature")
    delta = differential_coordinates(surface, "cotangent")
    return from_inside(surface, 0.5 * np.einsum("ij,ij->i", delta, surface.vertex_normals))


def gaussian_curvature(surface: Surface) -> FloatArray:
    """Gaussian curvature of each vertex, shape (n,), in units of 1 / area: angle defect over mixed Voronoi area.

    On a closed surface the product with `mixed_voronoi_areas` sums to 2 pi times the Euler characteristic. A boundary
    vertex takes the mean of its inner neighbours.
    """
    angles = np.bincount(surface.faces.ravel(), surface.corner_angles.ravel(), minlength=surface.n_vertices)
    areas = mixed_voronoi_areas(surface)
    defect = np.divide(2 * np.pi - angles, areas, out=np.zeros_like(areas), where=areas > 0)
    return from_inside(surface, defect)


def principal_curvatures(surface: SurfaceLike, radius: int = 5) -> PrincipalCurvatures:
    """Principal curvatures and directions of quadrics fitted to neighbourhoods, by libigl.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    radius : int
        Rings of neighbours that a quadric is fitted to, at least 2.

    Returns
    -------
    PrincipalCurvatures

    Raises
    ------
    MeshError
        If neighbouring faces disagree on the outside, if no neighbourhood is large enough for a quadric
        (six vertices), or if the fit is not finite.

    Notes
    -----
    libigl's fit depends on the numbering of the vertices, by some percent of the curvature on a coarse
    mesh; `mean_curvature` and `gaussian_curvature` do not.

    References
    ----------
    Panozzo, Puppo, Rocca, "Efficient multi-scale curvature and crease estimation", 2010 (`igl.principal_curvature`).
    """
    surface = as_surface(surface)
    if not isinstance(radius, (int, np.integer)) or radius < 2:
        raise ParameterError(f"radius is a number of rings, at least 2, got {radius!r}")
    _require_orientation(surface, "the sign of the principal curvatures")
    # libigl compares with absolute tolerances: give it a surface of unit area about the origin.
    unit = np.sqrt(surface.area)
    if not unit > 0:
        raise MeshError("the principal curvatures need a surface of positive area; all triangles are degenerate")
    unitless = (surface.vertices - surface.vertices.mean(axis=0)) / unit
    d1, d2, k1, k2, bad = igl.principal_curvature(unitless, surface.faces.astype(np.int64), int(radius), True)
    fitted = np.ones(surface.n_vertices, dtype=bool)
    fitted[bad] = False
    fitted[surface.unreferenced_vertices] = False
    if not fitted.any():
        raise MeshError(
            f"the principal curvatures fit quadrics to six vertices or more, and no vertex of the {surface.n_vertices} "
            f"has as many within {radius} rings; refine the mesh, or use another scalar"
        )
    wrong = np.flatnonzero(fitted & ~np.isfinite(np.column_stack([k1, k2])).all(axis=1))
    if wrong.size:
        raise MeshError(
            f"the principal curvatures at vertex {wrong[0]} are not finite ({wrong.size} such vertices); "
            "remove degenerate triangles, or use another scalar"
        )
    swap = k1 < k2
    k1, k2 = np.where(swap, k2, k1), np.where(swap, k1, k2)
    d1, d2 = np.where(swap[:, None], d2, d1), np.where(swap[:, None], d1, d2)
    k1, k2 = (spread_to_neighbours(surface, k / unit, fitted) for k in (k1, k2))
    d1, d2 = (np.where(fitted[:, None], d, 0.0) for d in (d1, d2))
    return PrincipalCurvatures(*(frozen(values) for values in (k1, k2, d1, d2, fitted)))


def from_inside(surface: Surface, values: FloatArray) -> FloatArray:
    """Values (n,) with those at the boundary and at vertices without area spread from the inner neighbours."""
    known = surface.vertex_areas > 0
    known[surface.boundary_vertices] = False
    return spread_to_neighbours(surface, values, known)


def _require_orientation(surface: Surface, purpose: str) -> None:
    if not surface.is_oriented:
        raise MeshError(
            f"{purpose} needs neighbouring faces that agree on which side is out; orient them with repair=True, "
            "or, on a one-sided surface, use a scalar without a sign (differential_norm, gaussian_curvature)"
        )
