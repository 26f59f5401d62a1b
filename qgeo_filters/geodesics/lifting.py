"""From a surface and a scalar on it to the lifted metric (paper, sec. 3 and 4)."""

from __future__ import annotations

import numpy as np

from qgeo_filters.defaults import CURVATURE_WEIGHT
from qgeo_filters.differential.scalar import Scalar, surface_scalar
from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.metric import LiftedMetric, cartesian_metric
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen


def lifted_metric(
    surface: Surface,
    scalar: Scalar = "mean_curvature",
    weight: float = CURVATURE_WEIGHT,
    *,
    smoothing: float = 0.0,
) -> LiftedMetric:
    r"""Metric of the surface lifted by a scalar, :math:`l_{ij}^2 = |x_i - x_j|^2 + (\lambda \sqrt A)^2 (f_i - f_j)^2`.

    Parameters
    ----------
    surface : Surface
    scalar : str, array-like of shape (n,), or callable
        f, see `surface_scalar`: clipped, and scaled to unit standard deviation over the area.
    weight : float
        :math:`\lambda`, 0 or more: the climb for one standard deviation of f, as a fraction of
        :math:`\sqrt A`. With 0 the result is the metric of the surface itself and f is not evaluated.
    smoothing : float
        Length over which f is averaged, as a fraction of :math:`\sqrt A`; see `surface_scalar`.

    Returns
    -------
    LiftedMetric
        No edge is shorter than in the surface itself.

    Raises
    ------
    ValueError
        Weight negative or not finite, or what `surface_scalar` refuses.
    """
    if not 0 <= weight < np.inf:
        raise ParameterError(f"the weight of the scalar in the metric must be a number, 0 or more, got {weight!r}")
    if weight == 0:
        return cartesian_metric(surface)
    f = surface_scalar(surface, scalar, smoothing=smoothing)
    a, b = surface.edges.T
    climb = weight * np.sqrt(surface.area) * (f[a] - f[b])
    return LiftedMetric(surface, frozen(f), float(weight), frozen(np.hypot(surface.edge_lengths, climb)))
