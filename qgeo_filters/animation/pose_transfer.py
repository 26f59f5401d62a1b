"""What carries poses of X over to Y: made once of two references and the map between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray, RepairOption
from qgeo_filters.animation.places import MapLike, Places, places_on
from qgeo_filters.animation.poses import given_shape
from qgeo_filters.animation.sequence import Animation
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.deformation.pose import posed
from qgeo_filters.deformation.similarity import Similarity
from qgeo_filters.deformation.transfer import GradientTransfer
from qgeo_filters.hosts.dispatch import SurfaceLike
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.surface import Surface

# Lengths in sqrt(area), measured by benchmarks/deformation.py: above the first positions of X count rather than
# gradients; the others are those of `posed`, for one body and for two.
_LENGTH, SAME_BODY, OTHER_BODY = 0.2, (0.05, 0.05), (0.1, 1.0)
# References that are farther apart, in sqrt(area) and the best similarity taken off, stand in different poses.
_APART = 0.11


@dataclass(frozen=True, eq=False, repr=False)
class Transfer(Animation):
    """The poses of Y, and where they come from.

    Attributes
    ----------
    surface, positions, times, notes
        See `Animation`: Y and its poses.
    source : Animation
        X and its poses as they were followed, in the frame and size of Y.
    correspondence : MatchResult or None
        The match along which they were carried, None where the map was given as an array.
    place : BarycentricMap or None
        Point of X for each vertex of Y: what `correspondence` says, or was given.
    apart : float
        Root mean square distance between the references in corresponding points, the best similarity taken off, in
        sqrt(area): how far they are from standing in one pose.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> y = x.with_vertices(2 * x.vertices)
    >>> moved = qg.transfer_deformation(x, [x.vertices * [1, 1, 1.2]], y, np.arange(162))
    >>> moved.positions.shape, moved.source.positions.shape, round(moved.apart, 6)
    ((1, 162, 3), (1, 162, 3), 0.0)
    """

    source: Animation | None = None
    correspondence: MatchResult | None = None
    place: BarycentricMap | None = None
    apart: float = 0.0


@dataclass(frozen=True, eq=False)
class PoseTransfer:
    """What is the same for all poses: made once, then `moved` for each, and `result` of all."""

    x: Surface
    y: Surface
    aligned_x: Surface
    frame: Similarity
    places: Places
    transfer: GradientTransfer
    apart: float
    notes: tuple[str, ...]
    doubts: tuple[str, ...]

    @classmethod
    def of(
        cls,
        x_reference: SurfaceLike,
        y_reference: SurfaceLike,
        correspondence: MapLike | None,
        *,
        same_pose: bool,
        same_body: bool,
        align: bool,
        accept_unsure: bool,
        repair: RepairOption = "auto",
    ) -> PoseTransfer:
        """From the arguments of `transfer_deformation`."""
        x, left_x = given_shape(x_reference, "X")
        y, left_y = given_shape(y_reference, "Y")
        places = places_on(x, y, correspondence, accept_unsure, repair=repair)
        points = places.on_x.pulled_back(x.vertices)
        known = np.isfinite(points).all(axis=1)
        weights = y.vertex_areas[known]
        best = Similarity.between(points[known], y.vertices[known], weights)
        gaps = np.linalg.norm(best(points[known]) - y.vertices[known], axis=1)
        apart = float(np.sqrt(weights @ gaps**2 / weights.sum() / y.area))
        if not align:
            frame = Similarity.identity()
        elif same_pose:
            frame = best
        else:  # what bends changes the size that fits best, not the area
            frame = Similarity.between(points[known], y.vertices[known], weights, places.size)
        doubts = places.doubts
        if same_pose and apart > _APART:
            doubts += (
                f"the references are {apart:.2f} sqrt(area) apart in corresponding points: if they stand in different "
                "poses, say same_pose=False",
            )
        aligned = x.with_vertices(frame(x.vertices))
        rest = y
        if not same_pose:
            lengths = SAME_BODY if same_body else OTHER_BODY
            rest = y.with_vertices(posed(y, places.on_x.pulled_back(aligned.vertices), *lengths))
        transfer = GradientTransfer(aligned, rest, places.on_x, _LENGTH)
        return cls(x, y, aligned, frame, places, transfer, apart, (*left_x, *left_y, *places.notes), doubts)

    def moved(self, pose: FloatArray) -> FloatArray:
        """Positions of Y in a pose of X."""
        return self.transfer(self.frame(pose))

    def result(self, followed: Sequence[FloatArray], moved: Sequence[FloatArray]) -> Transfer:
        """All of it, from the poses of X in the frame of Y, and those of Y."""
        return Transfer(
            surface=self.y,
            positions=np.stack(moved),
            notes=(*self.notes, *self.doubts),
            source=Animation(self.aligned_x, np.stack(followed)),
            correspondence=self.places.match,
            place=self.places.on_x,
            apart=self.apart,
        )
