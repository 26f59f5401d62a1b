"""Filters of the differential geometry: coordinates, normals, curvatures and the scalar of the metric."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from qgeo_filters.differential.coordinates import differential_coordinates
from qgeo_filters.differential.curvature import gaussian_curvature, mean_curvature, principal_curvatures
from qgeo_filters.differential.normals import vertex_normals
from qgeo_filters.differential.scalar import Scalar, surface_scalar
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.registry import registered
from qgeo_filters.surface import Surface


@registered
class DifferentialCoordinates(Filter):
    """Adds the differential coordinate of each vertex, see `differential_coordinates`.

    Parameters
    ----------
    weights : {"uniform", "cotangent"}
        The paper's umbrella, or the form that does not depend on the sampling.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> qg.DifferentialCoordinates()(surface).attributes["qgeo_delta"].shape
    (162, 3)
    """

    outputs = {"qgeo_delta": "(n, 3), length (uniform) or 1/length (cotangent): differential coordinate"}

    def __init__(self, *, weights: Literal["uniform", "cotangent"] = "uniform") -> None:
        self.weights = weights

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Differential coordinates by attribute name."""
        return {"qgeo_delta": differential_coordinates(surface, self.weights)}


@registered
class CorrectedNormals(Filter):
    """Adds vertex normals that stay inside the cone of the incident face normals, see `vertex_normals`.

    Parameters
    ----------
    corrected : bool
        False gives the angle-weighted normals.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> qg.CorrectedNormals()(surface).attributes["qgeo_normal"].shape
    (162, 3)
    """

    outputs = {"qgeo_normal": "(n, 3), unit vectors: normal of each vertex (paper, Fig. 2d)"}

    def __init__(self, *, corrected: bool = True) -> None:
        self.corrected = corrected

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Normals by attribute name."""
        return {"qgeo_normal": vertex_normals(surface, corrected=self.corrected)}


@registered
class Curvatures(Filter):
    """Adds mean, Gaussian and principal curvatures with their directions.

    Parameters
    ----------
    radius : int
        Rings of neighbours that the principal curvatures are fitted to at most, see `principal_curvatures`.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> out = qg.Curvatures()(surface)
    >>> sorted(out.attributes)
    ['qgeo_d1', 'qgeo_d2', 'qgeo_gaussian_curvature', 'qgeo_k1', 'qgeo_k2', 'qgeo_mean_curvature']
    """

    outputs = {
        "qgeo_mean_curvature": "(n,), 1/length: mean curvature, positive on a sphere with outward normals",
        "qgeo_gaussian_curvature": "(n,), 1/length^2: Gaussian curvature (angle defect over area)",
        "qgeo_k1": "(n,), 1/length: larger principal curvature",
        "qgeo_k2": "(n,), 1/length: smaller principal curvature",
        "qgeo_d1": "(n, 3), unit vectors: direction of the larger principal curvature",
        "qgeo_d2": "(n, 3), unit vectors: direction of the smaller principal curvature",
    }

    def __init__(self, *, radius: int = 5) -> None:
        self.radius = radius

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Curvatures by attribute name."""
        principal = principal_curvatures(surface, self.radius)
        return {
            "qgeo_mean_curvature": mean_curvature(surface),
            "qgeo_gaussian_curvature": gaussian_curvature(surface),
            "qgeo_k1": principal.k1,
            "qgeo_k2": principal.k2,
            "qgeo_d1": principal.d1,
            "qgeo_d2": principal.d2,
        }


@registered
class SurfaceScalar(Filter):
    """Adds the scalar f that bends the metric, see `surface_scalar`.

    Parameters
    ----------
    scalar : str, array-like of shape (n,), or callable
        A built-in, an attribute of the mesh, values, or a function of the differential coordinates.
    clip : (float, float), optional
        Percentiles to which values are limited.
    smoothing : float
        Length over which values are averaged, as a fraction of sqrt(area).

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> qg.SurfaceScalar(scalar="curvedness")(surface).attributes["qgeo_scalar"].shape
    (162,)
    """

    value_parameters = frozenset({"scalar"})

    outputs = {"qgeo_scalar": "(n,), no unit, unit standard deviation: scalar f of the lifted metric"}

    def __init__(
        self,
        *,
        scalar: Scalar = "mean_curvature",
        clip: tuple[float, float] | None = (2, 98),
        smoothing: float = 0.0,
    ) -> None:
        self.scalar = scalar
        self.clip = clip
        self.smoothing = smoothing

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Scalar by attribute name."""
        return {"qgeo_scalar": surface_scalar(surface, self.scalar, clip=self.clip, smoothing=self.smoothing)}
