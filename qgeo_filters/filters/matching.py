"""Filters of the self-symmetry and of the correspondence with another shape."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from qgeo_filters._typing import MirrorOption, PartialOption
from qgeo_filters.defaults import CURVATURE_WEIGHT, SYMMETRY_K0
from qgeo_filters.differential.scalar import Scalar
from qgeo_filters.errors import ParameterError
from qgeo_filters.filters import stages
from qgeo_filters.filters.base import Filter
from qgeo_filters.filters.geodesics import MetricFilter
from qgeo_filters.filters.registry import registered
from qgeo_filters.filters.repaired import other_mesh, repair_now
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.symmetry_measure import Reading, symmetry_epsilon, symmetry_regions, symmetry_sum
from qgeo_filters.matching.symmetry_result import Symmetry
from qgeo_filters.spectral.spectrum import Spectrum
from qgeo_filters.surface import Surface


@registered
class SelfSymmetry(MetricFilter):
    """Adds the mirror vertex and the side of each vertex, and the paper's measure of self-symmetry, eq. (3).

    The map is found with no initial guess, see `self_symmetry`; the measure tells which points may be mirror images of
    each other by the value of one function. A shape without a left/right symmetry keeps each vertex as its own mirror:
    ``symmetry_.found`` and ``symmetry_.reason`` say so.

    Parameters
    ----------
    k0 : int
        Number of eigenfunctions in the sum; the paper takes at most 20.
    n_regions : int
        Number of regions, of equal area.
    reading : {"absolute", "even", "printed"}
        How the sum is read, see `symmetry_sum`.
    scalar, curvature_weight, smoothing, method, accuracy
        See `MetricFilter`.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> ball = surface.vertices / [1.4, 1, 0.8]
    >>> ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    >>> radius = 1 + 0.3 * ball[:, [1]] + 0.25 * ball[:, [1]] * ball[:, [2]]
    >>> body = surface.with_vertices(ball * [1, 1.6, 0.7] * radius)  # its own mirror image in x = 0
    >>> filter = qg.SelfSymmetry()
    >>> out = filter(body)
    >>> filter.symmetry_.found, np.unique(out.attributes["qgeo_side"])
    (True, array([-1,  0,  1], dtype=int32))
    """

    outputs = {
        "qgeo_symmetry": "(n,) int: vertex at the mirror point, an involution; itself on the axis or if there is none",
        "qgeo_side": "(n,) int32: 1 and -1 on the two sides, 0 on the axis",
        "qgeo_asymmetry": "(n,), sqrt(area): mean difference of distances from the point and from its mirror point; "
        "NaN if there is none",
        "qgeo_symmetry_sum": "(n,), no unit: sum of eq. (3); mirror images have nearly equal values",
        "qgeo_symmetry_region": "(n,) int32 from 0: band of equal area of that sum",
    }

    index_outputs = frozenset({"qgeo_symmetry"})

    symmetry_: Symmetry
    """The symmetry of the last call."""

    spectrum_: Spectrum
    """Spectrum of the last call."""

    epsilon_: float
    """Root mean square difference of the sum over all pairs of points, see `symmetry_epsilon`; that between mirror
    points is ``symmetry_.epsilon``."""

    def __init__(
        self,
        *,
        k0: int = SYMMETRY_K0,
        n_regions: int = 8,
        reading: Reading = "absolute",
        scalar: Scalar = "mean_curvature",
        curvature_weight: float = CURVATURE_WEIGHT,
        smoothing: float = 0.0,
        method: str = "graph",
        accuracy: float = 1e-3,
    ) -> None:
        super().__init__(
            scalar=scalar, curvature_weight=curvature_weight, smoothing=smoothing, method=method, accuracy=accuracy
        )
        self.k0 = k0
        self.n_regions = n_regions
        self.reading = reading

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Measure and regions by attribute name."""
        self.spectrum_ = stages.spectrum_of(
            self._metric(surface), self.k0, "area", "auto", self.method, self.accuracy, progress
        )
        self.symmetry_ = stages.symmetry_of(surface, progress)
        self.epsilon_ = symmetry_epsilon(self.spectrum_, k0=self.k0, reading=self.reading)
        return {
            "qgeo_symmetry": self.symmetry_.p2p,
            "qgeo_side": self.symmetry_.side.astype(np.int32),
            "qgeo_asymmetry": self.symmetry_.asymmetry,
            "qgeo_symmetry_sum": symmetry_sum(self.spectrum_, self.k0, self.reading),
            "qgeo_symmetry_region": symmetry_regions(self.spectrum_, self.n_regions, k0=self.k0, reading=self.reading),
        }


@registered
class Correspondence(Filter):
    """Adds, for each vertex, the vertex of another shape that it corresponds to, found with no initial map.

    Parameters
    ----------
    target : mesh of any kind, or path
        The other shape: another pose, in any triangulation and position. Repaired where something is wrong with it; the
        vertices that are named are its own all the same.
    normalize : bool
        Whether to compare the shapes regardless of size.
    partial : bool, "auto"
        Whether one shape is a part of the other, see `match`: -1 and NaN where there is no partner.
    mirror : {"auto", "no", "yes"}
        Whether the map may reverse the orientation, see `match`.
    landmarks, labels : optional
        What is known of the map, see `match`: pairs (vertex of the mesh, vertex of the target) or points, and the part
        of each vertex of the mesh and of the target.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> target = surface.with_vertices(2 * surface.vertices)
    >>> out = qg.Correspondence(target=target)(surface)
    >>> out.attributes["qgeo_correspondence"][:5], bool(out.attributes["qgeo_distortion"].max() < 0.01)
    (array([0, 1, 2, 3, 4]), True)
    """

    outputs = {
        "qgeo_correspondence": "(n,) int: corresponding vertex of the target, -1: none",
        "qgeo_distortion": "(n,), sqrt(area): mean difference of distances from the point and from its image",
        "qgeo_region": "(n,) int32: region, of equal number on the target",
    }

    correspondence_: MatchResult
    """The correspondence of the last call, on the vertices that were given, with ``confident``, ``score`` and
    ``regions_y`` of the target."""

    @classmethod
    def example(cls, surface: Surface) -> Filter:
        """With itself."""
        return cls(target=surface)

    def __init__(
        self,
        *,
        target: Any = None,
        normalize: bool = True,
        partial: PartialOption = "auto",
        mirror: MirrorOption = "auto",
        landmarks: Any = None,
        labels: Any = None,
    ) -> None:
        self.target = target
        self.normalize = normalize
        self.partial = partial
        self.mirror = mirror
        self.landmarks = landmarks
        self.labels = labels

    def compute(self, surface: Surface, progress: bool = False) -> Mapping[str, np.ndarray]:
        """Map, distortion and regions by attribute name."""
        if self.target is None:
            raise ParameterError("Correspondence needs the other shape: Correspondence(target=mesh)")
        target, repair_target = other_mesh(self.target, self.repair_)
        shape = repair_now(self.repair_, surface)
        found = stages.correspondence_of(
            shape,
            target,
            self.normalize,
            progress,
            repair_x=False,
            repair_y=repair_target,
            partial=self.partial,
            mirror=self.mirror,
            landmarks=self.landmarks,
            labels=self.labels,
        )
        self.correspondence_ = found
        here = shape.origin if isinstance(shape, Repair) else slice(None)
        return {name: values[here] for name, values in _attributes(found).items()}

    def on_given(self, repair: Repair, added: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """What the match says of the vertices that were given."""
        return {name: values for name, values in _attributes(self.correspondence_).items() if name in added}


def _attributes(found: MatchResult) -> dict[str, np.ndarray]:
    return {"qgeo_correspondence": found.p2p, "qgeo_distortion": found.distortion, "qgeo_region": found.regions_x}
