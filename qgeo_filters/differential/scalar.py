"""The scalar f that bends the metric: a curvature, or any function on the surface, without unit (paper, sec. 4)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import robust_laplacian
from scipy import sparse
from scipy.sparse.linalg import splu

from qgeo_filters._typing import FloatArray
from qgeo_filters.array_likes import as_array
from qgeo_filters.differential.coordinates import differential_coordinates
from qgeo_filters.differential.curvature import (
    from_inside,
    gaussian_curvature,
    mean_curvature,
    principal_curvatures,
)
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.surface import Surface
from qgeo_filters.validation import listed

Scalar = str | npt.ArrayLike | Callable[[FloatArray], npt.ArrayLike]

#: Names of the built-in scalars.
BUILT_IN = (
    "mean_curvature",
    "differential_norm",
    "gaussian_curvature",
    "curvedness",
    "shape_index",
    "principal_1",
    "principal_2",
)

# What varies by less is the noise of the triangulation and not a shape: 5 % of the root mean square curvature
# (a sphere, H on a minimal surface, K on a cylinder), or a curvature of 1e-3 / sqrt(area) (a plane, also in
# float32: a dent of 1e-4 sqrt(area)).
_NOISE, _FLAT = 0.05, 1e-3
# Given values are taken at their word, down to rounding.
_ROUNDING = 1e-10


def surface_scalar(
    surface: SurfaceLike,
    scalar: Scalar = "mean_curvature",
    *,
    clip: tuple[float, float] | None = (2, 98),
    smoothing: float = 0.0,
) -> FloatArray:
    r"""Scalar f of each vertex, shape (n,), clipped, smoothed and scaled to unit standard deviation; without unit.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    scalar : str, array-like of shape (n,), or callable
        One of

        * ``"mean_curvature"``: :math:`\frac12\langle\delta^{cot}, n\rangle\sqrt A`, positive on a sphere with outward
          normals;
        * ``"differential_norm"``: :math:`|\delta|/\sqrt A` of the uniform differential coordinate, the paper's
          choice; it depends on the sampling;
        * ``"gaussian_curvature"``, ``"curvedness"``, ``"principal_1"``, ``"principal_2"``: each times the power of
          :math:`\sqrt A` that frees it from its unit; ``"shape_index"``: 0 where the surface is flat;
        * the name of an attribute of the surface, or values;
        * a function that maps the uniform differential coordinates, (n, 3) and divided by :math:`\sqrt A`, to
          values (n,).
    clip : (float, float), optional
        Percentiles of the surface's area to which values are limited; None keeps all.
    smoothing : float
        Length, as a fraction of :math:`\sqrt A`, over which one implicit heat step of duration
        :math:`t = (\text{smoothing} \sqrt A)^2` averages; 0 for none.

    Returns
    -------
    (n,) float64
        Percentiles and deviation are those over the *area*, so that two triangulations of one surface agree; the
        mean is left in place. All zero where the scalar is constant: for a built-in curvature, where it
        deviates by less than 5 % of :math:`\kappa` (Gaussian: of :math:`\kappa^2`) with :math:`\kappa^2` the mean of
        :math:`2 H^2 - K = (k_1^2 + k_2^2) / 2`, or is flat (:math:`10^{-3} / \sqrt A`), since to scale that up
        would show the triangulation; for given values, where they are equal up to rounding.

    Raises
    ------
    ValueError
        Unknown name, percentiles out of order, negative smoothing, values of a wrong shape or not finite, values
        that vary but are constant after clipping.
    MeshError
        A surface without area, or one on which the scalar is not defined (see `mean_curvature`).

    Notes
    -----
    Vertices at the boundary, which see one side only, take built-in values from inside (`from_inside`).

    The values depend neither on the scale nor on the numbering of the vertices, but for rounding, with one exception:
    where several vertices of different area have one value, as on a symmetric surface, and a percentile falls between
    that and the next, the numbering decides where, by at most the share of one such vertex in the area. That is nothing
    on a fine mesh, and some per cent of the deviation on one of a few dozen vertices; ``clip=None`` avoids it.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> f = qg.surface_scalar(surface, "mean_curvature")
    >>> weights = surface.vertex_areas / surface.area
    >>> round(float(np.sqrt(weights @ (f - weights @ f) ** 2)), 6)
    1.0
    >>> qg.surface_scalar(surface, surface.vertices[:, 0]).shape  # any values will do
    (162,)
    """
    surface = as_surface(surface)
    if not surface.area > 0:
        raise MeshError("a surface scalar needs a surface of positive area; all triangles are degenerate")
    if not 0 <= smoothing < np.inf:
        raise ParameterError(f"smoothing is a length as a fraction of sqrt(area), 0 or more, got {smoothing!r}")
    built_in = isinstance(scalar, str) and scalar in BUILT_IN
    values, floor = _built_in(surface, str(scalar)) if built_in else _given(surface, scalar)
    weights = surface.vertex_areas / surface.area
    if clip is not None:
        varies = _deviation(values, weights) > floor
        values = np.clip(values, *_percentiles(values, weights, clip))
        if varies and not built_in and _deviation(values, weights) <= floor:
            raise ParameterError(
                f"the scalar varies only beyond the percentiles {tuple(clip)} of the area, so that clipping leaves "
                "a constant; pass clip=None"
            )
    # The floor is one for what came in: what a smoothing leaves is the scalar asked for, however faint.
    if smoothing and _deviation(values, weights) > floor:
        floor = _ROUNDING * float(np.abs(values).max())
        values = heat_smoothed(surface, values, smoothing)
    deviation = _deviation(values, weights)
    return values / deviation if deviation > floor else np.zeros(surface.n_vertices)


def heat_smoothed(surface: Surface, values: npt.ArrayLike, smoothing: float) -> FloatArray:
    """Values (n,) after one implicit heat step over the length ``smoothing * sqrt(area)``.

    Solves (M + t L) g = M f with the intrinsic Delaunay Laplacian of `robust_laplacian` and t the squared length; the
    mean over the area (as M measures it) is kept. Vertices without faces keep their value.
    """
    used = np.ones(surface.n_vertices, dtype=bool)
    used[surface.unreferenced_vertices] = False
    number = np.cumsum(used) - 1
    # In units of sqrt(area), so that the mollification and the duration do not depend on the scale.
    unitless = surface.vertices[used] / np.sqrt(surface.area)
    stiffness, mass = robust_laplacian.mesh_laplacian(unitless, number[surface.faces])
    smooth = np.array(values, dtype=np.float64)
    system = sparse.csc_matrix(mass + smoothing**2 * stiffness)
    smooth[used] = splu(system).solve(mass @ smooth[used])
    return smooth


def _built_in(surface: Surface, name: str) -> tuple[FloatArray, float]:
    """Values (n,) of a built-in scalar, without unit, and the deviation below which they are noise."""
    unit = float(np.sqrt(surface.area))
    if name == "differential_norm":
        norm = from_inside(surface, np.linalg.norm(differential_coordinates(surface), axis=1) / unit)
        return norm, max(_NOISE * _root_mean_square(surface, norm), _ROUNDING)
    kappa = _typical_curvature(surface, unit)
    floor = max(_NOISE * kappa, _FLAT)
    if name == "mean_curvature":
        return mean_curvature(surface) * unit, floor
    if name == "gaussian_curvature":
        return gaussian_curvature(surface) * unit**2, max(_NOISE * kappa**2, _FLAT**2)
    principal = principal_curvatures(surface)
    if name == "shape_index":
        flat = principal.curvedness * unit < _FLAT
        return np.where(flat, 0.0, principal.shape_index), _NOISE
    values = {"curvedness": principal.curvedness, "principal_1": principal.k1, "principal_2": principal.k2}[name]
    return values * unit, floor


def _typical_curvature(surface: Surface, unit: float) -> float:
    """Root mean square of the curvedness, without unit, from H and K alone."""
    double = np.linalg.norm(differential_coordinates(surface, "cotangent"), axis=1) * unit
    squared = from_inside(surface, double**2 / 2) - gaussian_curvature(surface) * unit**2
    weights = surface.vertex_areas / surface.area
    squared = np.clip(squared, *_percentiles(squared, weights, (2, 98)))
    return float(np.sqrt(max(float(weights @ squared), 0.0)))


def _given(surface: Surface, scalar: Scalar) -> tuple[FloatArray, float]:
    """Values (n,) of an attribute, an array or a function, and the size of their rounding."""
    if isinstance(scalar, str):
        if scalar not in surface.attributes:
            raise ParameterError(
                f"unknown scalar {scalar!r}; built in are {', '.join(BUILT_IN)}; the attributes of this surface are "
                f"{', '.join(sorted(surface.attributes)) or 'none'}"
            )
        values, name = np.asarray(surface.attributes[scalar]), f"attribute {scalar!r}"
    elif callable(scalar):
        unitless = differential_coordinates(surface) / np.sqrt(surface.area)
        values, name = as_array(scalar(unitless)), "the result of the scalar function"
    else:
        values, name = as_array(scalar), "the scalar"
    n = surface.n_vertices
    if values.shape not in ((n,), (n, 1)) or values.dtype.kind not in "biuf":
        raise ParameterError(
            f"{name} has {values.dtype} values of shape {values.shape}, expected real ones of shape ({n},)"
        )
    values = values.reshape(n).astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise ParameterError(f"{name} is not finite at {bad.size} of {n} vertices: {listed(bad)}")
    return values, _ROUNDING * float(np.abs(values).max())


def _root_mean_square(surface: Surface, values: FloatArray) -> float:
    return float(np.sqrt(surface.vertex_areas @ values**2 / surface.area))


def _deviation(values: FloatArray, weights: FloatArray) -> float:
    """Standard deviation under weights that sum to one."""
    return float(np.sqrt(weights @ (values - weights @ values) ** 2))


def _percentiles(values: FloatArray, weights: FloatArray, clip: tuple[float, float]) -> tuple[float, float]:
    """Values below which the two percentages of the weight lie, linear in between."""
    low, high = clip
    if not 0 <= low < high <= 100:
        raise ParameterError(f"clip must be two percentiles 0 <= low < high <= 100, got {clip!r}")
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    middle = below - weights[order] / 2
    return float(np.interp(low / 100, middle, values[order])), float(np.interp(high / 100, middle, values[order]))
