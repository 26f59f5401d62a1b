"""Curvatures of a triangle mesh at its vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.differential.coordinates import (
    differential_coordinates,
    mixed_voronoi_areas,
    spread_to_neighbours,
)
from qgeo_filters.differential.jet_fitting import Jets, fitted_jets
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.html_repr import card, shown, span
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
        Whether the neighbourhood determines a quadric; elsewhere the curvatures are the neighbours' mean.

    Examples
    --------
    >>> found = qg.principal_curvatures(qg.testing.sample_surface())
    >>> bool((found.k1 >= found.k2).all()), found.d1.shape, bool(found.fitted.all())
    (True, (162, 3), True)
    """

    k1: FloatArray
    k2: FloatArray
    d1: FloatArray
    d2: FloatArray
    fitted: npt.NDArray[np.bool_]

    def __repr__(self) -> str:
        return (
            f"PrincipalCurvatures({len(self.k1)} vertices, k1 from {self.k1.min():.4g} to {self.k1.max():.4g}, "
            f"k2 from {self.k2.min():.4g} to {self.k2.max():.4g})"
        )

    def _repr_html_(self) -> str:
        facts = {
            name: f"{span(values)}, median {shown(float(np.median(values)))}"
            for name, values in (("k1", self.k1), ("k2", self.k2), ("curvedness", self.curvedness))
        }
        facts["not fitted"] = f"{int((~self.fitted).sum())} vertices"
        return card(f"PrincipalCurvatures of {len(self.k1)} vertices, 1 / length", facts)

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
    """Principal curvatures and directions of jets fitted to the neighbourhood of each vertex.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    radius : int
        Rings of neighbours that a jet is fitted to at most, at least 2. From four on a second jet is fitted to three
        rings, and counts where the wide one misses its points by more than noise would: detail of a few edges is kept,
        and noise is averaged. Two rings follow the finest detail, and all noise.

    Returns
    -------
    PrincipalCurvatures

    Raises
    ------
    MeshError
        If neighbouring faces disagree on the outside, or no neighbourhood determines a quadric (six vertices on
        the same side of the surface, not all on one conic).

    Notes
    -----
    The height over the tangent plane is a polynomial of fourth order, fitted by least squares, in which a neighbour
    weighs the less the more its normal turns away (`fitted_jets`); the curvatures are those of its shape operator. On a
    smooth surface the error falls with the square of the edge length. A boundary vertex is fitted from one side.

    k1 k2 and `gaussian_curvature`, or (k1 + k2) / 2 and `mean_curvature`, estimate the same thing in two ways and
    differ by the errors of both. The fit converges on irregular triangles too and averages noise; angle defects and
    cotangents see one ring, and what they add up to over a region is right (Gauss and Bonnet).

    References
    ----------
    Cazals, Pouget, "Estimating differential quantities using polynomial fitting of osculating jets", 2005.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> ball = surface.vertices / [1.4, 1, 0.8]
    >>> ball = surface.with_vertices(2 * ball / np.linalg.norm(ball, axis=1, keepdims=True))
    >>> found = qg.principal_curvatures(ball)
    >>> bool(abs(found.k1.mean() - 0.5) < 0.03), bool(abs(found.k2.mean() - 0.5) < 0.04)  # 1 / radius
    (True, True)
    """
    surface = as_surface(surface)
    if not isinstance(radius, (int, np.integer)) or radius < 2:
        raise ParameterError(f"radius is a number of rings, at least 2, got {radius!r}")
    _require_orientation(surface, "the sign of the principal curvatures")
    if not surface.area > 0:
        raise MeshError("the principal curvatures need a surface of positive area; all triangles are degenerate")
    jets = fitted_jets(surface, int(radius))
    fitted = jets.fitted
    if not fitted.any():
        raise MeshError(
            f"the principal curvatures fit quadrics to six vertices or more, and no vertex of the {surface.n_vertices} "
            f"has as many within {radius} rings on its side of the surface; refine the mesh, or use another scalar"
        )
    (k2, k1), (d2, d1) = _principal(jets)
    k1, k2 = (spread_to_neighbours(surface, k, fitted) for k in (k1, k2))
    d1, d2 = (np.where(fitted[:, None], d, 0.0) for d in (d1, d2))
    return PrincipalCurvatures(*(frozen(values) for values in (k1, k2, d1, d2, fitted)))


def _principal(jets: Jets) -> tuple[FloatArray, FloatArray]:
    """Eigenvalues (2, n) of the shape operator in increasing order, and its directions (2, n, 3)."""
    slope = jets.gradients[:, :, None] * jets.gradients[:, None, :]
    # First and second fundamental form of the graph; curvatures are positive where it bends down, away from the normal.
    first = np.eye(2) + slope
    second = -jets.hessians / np.sqrt(1 + np.einsum("nii->n", slope))[:, None, None]
    # Coordinates v = B u with B' I B = 1: in u the operator is symmetric, and unit vectors are unit tangents.
    b = np.linalg.inv(np.linalg.cholesky(first)).transpose(0, 2, 1)
    curvatures, u = np.linalg.eigh(b.transpose(0, 2, 1) @ second @ b)
    tangents = jets.frames[:, :2] + jets.gradients[:, :, None] * jets.frames[:, 2:]
    return curvatures.T, ((b @ u).transpose(0, 2, 1) @ tangents).transpose(1, 0, 2)


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
