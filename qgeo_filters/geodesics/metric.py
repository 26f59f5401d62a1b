"""The lifted metric: edge lengths of the surface seen as the graph of a curvature scalar (paper, sec. 3 and 4)."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from qgeo_filters._deprecation import renamed_parameters
from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.defaults import CURVATURE_WEIGHT
from qgeo_filters.differential.scalar import Scalar, surface_scalar
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.html_repr import card, shown, span
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen


class IntrinsicMesh(NamedTuple):
    """All that a geodesic kernel sees of a surface: triangles, side lengths, neighbours; no coordinates.

    Side k of face f runs from ``faces[f, k]`` to ``faces[f, (k + 1) % 3]``. The twin of a side is
    ``3 g + j`` for side j of face g, -1 on the boundary. Neighbouring faces may disagree on orientation
    (a Moebius band has geodesics too): match vertices across a side by their index.
    """

    faces: IntArray  # (m, 3)
    lengths: FloatArray  # (m, 3)
    twins: IntArray  # (m, 3)
    n_vertices: int


@dataclass(frozen=True, eq=False)
class LiftedMetric:
    r"""Edge lengths :math:`l_{ij}^2 = |x_i - x_j|^2 + (\lambda \sqrt A)^2 (f_i - f_j)^2`.

    This is the metric that the surface inherits as the graph :math:`(x, \lambda \sqrt A f(x))` in R^4, so
    that every lifted triangle is a triangle and every intrinsic algorithm applies unchanged. A path is
    short when it is short and f varies little along it.

    Attributes
    ----------
    surface : Surface
    scalar : (n,) float64
        f, without unit (scaled to unit standard deviation by `surface_scalar`).
    curvature_weight : float
        :math:`\lambda`, a fraction of sqrt(area) for each unit of f. 0 is the Cartesian metric.
    edge_lengths : (E,) float64
        In the unit of the vertices, for ``surface.edges``.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> metric = qg.lifted_metric(surface, curvature_weight=0.1)
    >>> bool((metric.edge_lengths >= surface.edge_lengths).all())
    True
    >>> np.allclose(qg.lifted_metric(surface, curvature_weight=0).edge_lengths, surface.edge_lengths)
    True
    """

    surface: Surface
    scalar: FloatArray
    curvature_weight: float
    edge_lengths: FloatArray

    def __repr__(self) -> str:
        return f"LiftedMetric({self.surface!r}, curvature_weight={self.curvature_weight:g})"

    def _repr_html_(self) -> str:
        stretch = self.edge_lengths / np.maximum(self.surface.edge_lengths, np.finfo(float).tiny)
        facts = {
            "surface": repr(self.surface),
            "curvature_weight": self.curvature_weight,
            "scalar f": span(self.scalar),
            "edges are longer by": f"{shown(100 * float(np.median(stretch) - 1))} % (median)",
        }
        return card("LiftedMetric", facts)

    @property
    def weight(self) -> float:
        """The old name of `curvature_weight`."""
        warnings.warn(
            "LiftedMetric.weight is now called curvature_weight; the old name goes with the next release",
            DeprecationWarning,
            stacklevel=2,
        )
        return self.curvature_weight

    def intrinsic(self, purpose: str = "the geodesic distance") -> IntrinsicMesh:
        """What the kernels work on; raises `NonManifoldError` for what is not a surface."""
        self.surface.require_manifold(purpose)
        return IntrinsicMesh(
            self.surface.faces,
            self.edge_lengths[self.surface.face_edges],
            self.surface.twins,
            self.surface.n_vertices,
        )


#: What every argument ``metric`` takes: a metric of the surface, or one of the two by name.
Metric = LiftedMetric | Literal["cartesian", "lifted"]


def cartesian_metric(surface: SurfaceLike) -> LiftedMetric:
    """The metric of the surface itself: weight 0, the paper's baseline [47]."""
    surface = as_surface(surface)
    return LiftedMetric(surface, np.zeros(surface.n_vertices), 0.0, surface.edge_lengths)


@renamed_parameters(weight="curvature_weight")
def lifted_metric(
    surface: SurfaceLike,
    scalar: Scalar = "mean_curvature",
    curvature_weight: float = CURVATURE_WEIGHT,
    *,
    smoothing: float = 0.0,
) -> LiftedMetric:
    r"""Metric of the surface lifted by a scalar, :math:`l_{ij}^2 = |x_i - x_j|^2 + (\lambda \sqrt A)^2 (f_i - f_j)^2`.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    scalar : str, array-like of shape (n,), or callable
        f, see `surface_scalar`: clipped, and scaled to unit standard deviation over the area.
    curvature_weight : float
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
    ParameterError
        Weight negative or not finite, or what `surface_scalar` refuses.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> metric = qg.lifted_metric(surface, curvature_weight=0.1)
    >>> plain, bent = qg.distances(surface, 0), qg.distances(surface, 0, metric)
    >>> bool((bent >= plain * (1 - 1e-3)).all())
    True
    >>> qg.lifted_metric(surface, "gaussian_curvature", 0.03).curvature_weight
    0.03
    """
    surface = as_surface(surface)
    if not 0 <= curvature_weight < np.inf:
        raise ParameterError(
            f"the weight of the scalar in the metric must be a number, 0 or more, got {curvature_weight!r}"
        )
    if curvature_weight == 0:
        return cartesian_metric(surface)
    f = surface_scalar(surface, scalar, smoothing=smoothing)
    a, b = surface.edges.T
    climb = curvature_weight * np.sqrt(surface.area) * (f[a] - f[b])
    return LiftedMetric(surface, frozen(f), float(curvature_weight), frozen(np.hypot(surface.edge_lengths, climb)))


def metric_for(surface: Surface, metric: Metric | None, default: Literal["cartesian", "lifted"]) -> LiftedMetric:
    """The metric that an argument ``metric`` means for a surface.

    Parameters
    ----------
    surface : Surface
    metric : LiftedMetric, "cartesian", "lifted" or None
        ``"lifted"`` is `lifted_metric` as it is. None is the default, and deprecated.
    default : {"cartesian", "lifted"}
        Of the function that has the argument.

    Raises
    ------
    ParameterError
        The metric of another surface (other vertices or faces; attributes do not count), or an unknown name.
    """
    if metric is None:
        warnings.warn(
            f'metric=None is deprecated: say metric="{default}", which is what it means here',
            DeprecationWarning,
            stacklevel=3,
        )
        metric = default
    if isinstance(metric, LiftedMetric):
        if difference := _difference(metric.surface, surface):
            raise ParameterError(
                f"the metric belongs to {difference}; make it of this surface: lifted_metric(surface, ...)"
            )
        return metric
    if isinstance(metric, str) and metric == "cartesian":
        return cartesian_metric(surface)
    if isinstance(metric, str) and metric == "lifted":
        return lifted_metric(surface)
    raise ParameterError(f'metric must be a LiftedMetric, "cartesian" or "lifted", got {metric!r}')


def _difference(theirs: Surface, ours: Surface) -> str:
    """What tells the first surface from the second, empty if they are the same."""
    if theirs is ours or (theirs.vertices is ours.vertices and theirs.faces is ours.faces):
        return ""
    if theirs.n_vertices != ours.n_vertices:
        return f"a surface of {theirs.n_vertices} vertices, this one has {ours.n_vertices}"
    if theirs.n_faces != ours.n_faces:
        return f"a surface of {theirs.n_faces} faces, this one has {ours.n_faces}"
    for name, there, here in (("faces", theirs.faces, ours.faces), ("vertices", theirs.vertices, ours.vertices)):
        other = np.flatnonzero((there != here).any(axis=1))
        if other.size:
            k = other[0]
            return (
                f"another surface: {name}[{k}] is {there[k].tolist()} there and {here[k].tolist()} here "
                f"({other.size} of {len(here)} {name} differ)"
            )
    return ""
