"""How far each point is from what a user knows, and how well a map agrees with that.

A landmark and a labelled part are one thing here: a part of X and a part of Y that belong together, a single vertex
or many. Distances from them are all that matching takes from hints: no map has to go through a landmark, so that one
that is a little off, or a border of labels that is drawn by eye, does no harm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.hints import NEAR_THE_SURFACE, Hints
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.validation import frozen, listed


@dataclass(frozen=True, eq=False)
class KnownParts:
    """Parts of X and of Y that belong together.

    Attributes
    ----------
    landmarks : (k, 2) int64
        Vertices of the prepared X and Y; the first k parts.
    labels : (l,) int64
        Numbers of the labelled parts, which follow.
    to_x, to_y : (k + l, n_x), (k + l, n_y) float32
        Distance from each part to each vertex, in sqrt(area).
    parameters : MatchingParameters
    merged : int
        1 where X may have grown together with itself, so that distances on it may be shorter, -1 where Y may; else 0.
    """

    landmarks: IndexArray
    labels: IndexArray
    to_x: SingleArray
    to_y: SingleArray
    parameters: MatchingParameters
    merged: int = 0

    @classmethod
    def of(cls, hints: Hints, x: PreparedShape, y: PreparedShape, parameters: MatchingParameters) -> KnownParts:
        """Parts of two prepared shapes."""
        landmarks = np.column_stack(
            [working_vertices(shape, hints.landmarks[:, side]) for side, shape in enumerate((x, y))]
        )
        numbers = [working_labels(shape, hints.labels[side]) for side, shape in enumerate((x, y))]
        # Some may have been on what a repair removed.
        labels = np.intersect1d(numbers[0], numbers[1])
        labels, distances = labels[labels >= 0], []
        for side, shape in enumerate((x, y)):
            rows = [shape.distances(landmarks[:, side]), *(_from_part(shape, numbers[side] == n)[None] for n in labels)]
            distances.append(frozen(np.concatenate(rows).astype(np.float32)))
        return cls(frozen(landmarks), labels, distances[0], distances[1], parameters)

    def errors(self, points: IndexArray, p2p: IndexArray) -> FloatArray:
        """How far a map takes the surroundings of each part from where it belongs, (..., k + l), in sqrt(area).

        Mean over the points within a part or near it of how much farther their images are from its partner than they
        from it. The surroundings count and not the landmark alone, since a registration may pull that out like a
        spike.

        Parameters
        ----------
        points : (s,) int
            Vertices of X.
        p2p : (..., s) int
            Vertex of Y for each of them; of one map or of several.
        """
        return np.stack([self._error(part, points, p2p) for part in range(len(self.to_x))], axis=-1)

    def penalties(self, points: IndexArray, p2p: IndexArray) -> FloatArray:
        """Factor (...) by which disagreement with the hints makes maps dearer: 1 for none. Arguments as in `errors`."""
        return 1 + self.errors(points, p2p).sum(axis=-1) / self.parameters.hint_scale

    def landmark_errors(self, p2p: IndexArray) -> FloatArray:
        """Distance (k,) on Y between the image of each landmark and its partner, in sqrt(area); ``p2p`` is (n_x,)."""
        return self.to_y[np.arange(len(self.landmarks)), p2p[self.landmarks[:, 0]]].astype(np.float64)

    def contradicted(self, p2p: IndexArray) -> npt.NDArray[np.bool_]:
        """Which parts (k + l,) a map of all vertices takes elsewhere."""
        given = self.parameters
        found = self.errors(np.arange(len(p2p)), p2p) > given.hint_contradicts
        found[: len(self.landmarks)] |= self.landmark_errors(p2p) > given.hint_contradicts + given.hint_softness
        return found

    def agreeing(self, p2p: IndexArray) -> KnownParts | None:
        """The parts that a map of all vertices does not contradict; None if there is none."""
        kept = ~self.contradicted(p2p)
        k = len(self.landmarks)
        if not kept.any():
            return None
        return replace(
            self,
            landmarks=self.landmarks[kept[:k]],
            labels=self.labels[kept[k:]],
            to_x=self.to_x[kept],
            to_y=self.to_y[kept],
        )

    def swapped(self) -> KnownParts:
        """The same parts, of Y and X."""
        return replace(self, landmarks=self.landmarks[:, ::-1], to_x=self.to_y, to_y=self.to_x, merged=-self.merged)

    @cached_property
    def profiles(self) -> tuple[SingleArray, SingleArray]:
        """Distances (n_x, k + l) and (n_y, k + l) from all parts, saturated: far away they tell nothing.

        Of shapes that do not keep distances exactly those far from a landmark are not to be moved by it, and a wrong
        landmark pulls no more than this. Where a hand has grown onto a leg, the leg is near what the hand is near.
        """
        given = self.parameters
        reach = given.grown_hint_reach if self.merged else given.hint_reach
        one, other = (-reach * np.expm1(-to.T / reach) for to in (self.to_x, self.to_y))
        return one.astype(np.float32), other.astype(np.float32)

    def _error(self, part: int, points: IndexArray, p2p: IndexArray) -> FloatArray:
        given, here = self.parameters, self.to_x[part, points]
        if self.merged > 0:
            return self._error_from_merged(here, self.to_y[part][p2p])
        near = np.flatnonzero(here <= max(given.hint_surroundings, float(here.min())))
        farther = self.to_y[part][p2p[..., near]] - here[near]
        return np.maximum(farther - given.hint_softness, 0.0).mean(axis=-1, dtype=np.float64)

    def _error_from_merged(self, here: SingleArray, there: SingleArray) -> FloatArray:
        """The same where X has grown together: points of it may be near that were not, so those near on Y are asked.

        And how far from the partner the nearest image is.
        """
        given, least = self.parameters, there.min(axis=-1)
        near = there <= np.maximum(given.hint_surroundings, least)[..., None]
        farther = np.maximum(here - there - given.hint_softness, 0.0)
        missed = np.maximum(least - given.hint_surroundings, 0.0)
        return np.asarray(farther.mean(axis=-1, where=near, dtype=np.float64) + missed)


def working_vertices(shape: PreparedShape, vertices: IndexArray) -> IndexArray:
    """Vertices of the coarse shape nearest to vertices of the one that was given, also to lost ones."""
    return shape.vertex_of_full[full_vertices(shape, vertices)]


def working_labels(shape: PreparedShape, labels: IndexArray) -> IndexArray:
    """Label of each vertex of the coarse shape, from those of the surface that was given."""
    return full_labels(shape, labels)[shape.full_vertices] if len(labels) else labels


def require_landmarks_left(hints: Hints, x: PreparedShape, y: PreparedShape) -> None:
    """Raise `ParameterError` for a landmark on what the repair removed, far from all that is left."""
    for side, (name, shape) in enumerate((("X", x), ("Y", y))):
        if shape.repair is not None:
            landmarks_left(shape.repair, hints.landmarks[:, side], name)


def landmarks_left(repair: Repair, vertices: IndexArray, name: str) -> IndexArray:
    """Vertices of the repaired surface for landmarks on the one that was given, the nearest for lost ones near it.

    A vertex near the surface stands for the nearest one there: hints need be right to within a few edges only.

    Raises
    ------
    ParameterError
        One on what the repair removed, far from all that is left.
    """
    found, gaps = _nearest_left(repair, vertices)
    far = np.flatnonzero(gaps > NEAR_THE_SURFACE * np.sqrt(repair.surface.area))
    if far.size:
        first = far[0]
        raise ParameterError(
            f"landmark {first} is vertex {vertices[first]} of {name}, which had to go when that was repaired, and "
            f"is {gaps[first]:.4g} from what is left of it ({far.size} such: {listed(far)}): give "
            "landmarks on what is matched"
        )
    return found


def full_vertices(shape: PreparedShape, vertices: IndexArray) -> IndexArray:
    """Vertices of the repaired surface for some of the one that was given, the nearest for lost ones."""
    return vertices if shape.repair is None else _nearest_left(shape.repair, vertices)[0]


def _nearest_left(repair: Repair, vertices: IndexArray) -> tuple[IndexArray, FloatArray]:
    """Vertices of the repaired surface, the nearest for lost ones, and how far those are; 0 for the others."""
    found = repair.vertex_of_original[vertices].astype(np.int64)
    gaps, lost = np.zeros(len(found)), found < 0
    if lost.any():
        gaps[lost], found[lost] = cKDTree(repair.surface.vertices).query(repair.given.vertices[vertices[lost]])
    return found, gaps


def full_labels(shape: PreparedShape, labels: IndexArray) -> IndexArray:
    """Label of each vertex of the repaired surface."""
    return labels if shape.repair is None else labels[shape.repair.origin]


def _from_part(shape: PreparedShape, inside: np.ndarray) -> FloatArray:
    """Distance (n,) of each vertex from the nearest of some, to within the spacing of farthest points; 0 in it."""
    rows = shape.fps_distances
    some = inside[shape.fps[: len(rows)]]
    if some.any():
        nearest = rows[some].min(axis=0).astype(np.float64)
    else:  # a part so small that no farthest point lies in it
        nearest = shape.distances(np.flatnonzero(inside)).min(axis=0)
    nearest[inside] = 0.0
    return nearest
