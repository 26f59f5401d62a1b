"""The lifted metric: edge lengths of the surface seen as the graph of a curvature scalar (paper, sec. 3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.surface import Surface


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
    weight : float
        :math:`\lambda`, a fraction of sqrt(area) for each unit of f. 0 is the Cartesian metric.
    edge_lengths : (E,) float64
        In the unit of the vertices, for ``surface.edges``.
    """

    surface: Surface
    scalar: FloatArray
    weight: float
    edge_lengths: FloatArray

    def intrinsic(self, purpose: str = "the geodesic distance") -> IntrinsicMesh:
        """What the kernels work on; raises `NonManifoldError` for what is not a surface."""
        self.surface.require_manifold(purpose)
        return IntrinsicMesh(
            self.surface.faces,
            self.edge_lengths[self.surface.face_edges],
            self.surface.twins,
            self.surface.n_vertices,
        )


def cartesian_metric(surface: Surface) -> LiftedMetric:
    """The metric of the surface itself: weight 0, the paper's baseline [47]."""
    return LiftedMetric(surface, np.zeros(surface.n_vertices), 0.0, surface.edge_lengths)
