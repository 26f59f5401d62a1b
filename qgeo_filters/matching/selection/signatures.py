"""Whether a map relates points of like surroundings: a second opinion, since search and finish look at distances."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.matching.prepared_shape import PreparedShape

# Of the times of heat the last ones: the first one tells right maps from wrong ones, but varies between poses.
_TIMES = slice(1, None)


def likeness(x: PreparedShape, y: PreparedShape, p2p: npt.NDArray[np.int64]) -> float:
    """Agreement of the logarithm of the heat kernel h(t; p, p) with that at the images, 1 if they are equal.

    One minus half the mean squared difference over the variance on X, the smallest over the times: the correlation,
    for maps that keep mean and variance.

    References
    ----------
    Sun, Ovsjanikov, Guibas, "A concise and provably informative multi-scale signature based on heat diffusion",
    SGP 2009.
    """
    here, there = x.heat_kernels[:, _TIMES], y.heat_kernels[p2p][:, _TIMES]
    return min(_agreement(one, other, x.areas) for one, other in zip(here.T, there.T, strict=True))


def relief_likeness(x: PreparedShape, y: PreparedShape, p2p: npt.NDArray[np.int64]) -> float:
    """Agreement of the smoothed mean curvature with that at the images, 1 if it is equal; measured as `likeness`.

    Unlike the heat kernels it knows inside from outside: a breast is not like a back.
    """
    return _agreement(x.relief, y.relief[p2p], x.areas)


def _agreement(one: FloatArray, other: FloatArray, areas: FloatArray) -> float:
    variance = float(areas @ (one - areas @ one) ** 2)
    return 1 - 0.5 * float(areas @ (one - other) ** 2) / variance if variance > 0 else 1.0
