"""From a few landmarks to a map of some hundred points, and whether that keeps the orientation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.matching.partial.distance_bounds import distance_bounds, mean_violation, profile_costs
from qgeo_filters.matching.partial.part_shape import PartShape

# Neighbours of a point that span triangles with it, and the least sine of their angle.
_NEIGHBOURS = 8
_LEAST_SINE = 0.4


@dataclass(frozen=True, eq=False)
class CoarseMap:
    """A map of the first farthest points of X.

    Attributes
    ----------
    p2p : (s,) int
        Vertex of Y for each.
    distortion : float
        Mean violation of the bounds of distances.
    unlikeness : float
        Mean cost of the descriptors.
    disagreement : float
        Mean cost of what is known, see `hint_costs`.
    orientation : float
        1 if triangles of neighbouring points keep their side, -1 if they are turned over.
    """

    p2p: IndexArray
    distortion: float
    unlikeness: float
    disagreement: float
    orientation: float


class CoarseMapper:
    """Maps of X's first farthest points to Y's, from those of landmarks."""

    def __init__(self, x: PartShape, y: PartShape, descriptors: SingleArray, hints: SingleArray) -> None:
        self.x, self.y, self.given = x, y, x.given
        self.count = min(self.given.coarse_points, len(x.fps))
        self.least, self.most = distance_bounds(x, self.count)
        between = y.rows[:, y.fps]
        self.between = np.maximum(between, between.T)
        self.descriptors = descriptors[: self.count].astype(np.float64)
        self.hints = hints[: self.count].astype(np.float64)
        self.alone = self.given.dense_descriptor_weight * self.descriptors + self.given.hint_weight * self.hints
        self.closeness = (np.exp(-self.most / self.given.locality) + 0.05).astype(np.float32)

    def grown(self, images: IndexArray) -> CoarseMap:
        """The map whose distances to the landmarks' images fit best, found again from itself a few times."""
        given = self.given
        some = np.arange(len(images))
        for _ in range(given.rounds):
            costs = profile_costs(
                np.ascontiguousarray(self.least[:, some]),
                np.ascontiguousarray(self.most[:, some]),
                np.ascontiguousarray(self.closeness[:, some]),
                self.between,
                images,
                given.within_bounds,
                given.pair_cap,
            )
            before, images = images, (costs + self.alone).argmin(axis=1)
            if np.array_equal(before, images):
                break
            some = np.arange(self.count)
        distortion = mean_violation(
            self.least, self.most, self.between[np.ix_(images, images)], given.within_bounds, given.pair_cap
        )
        unlikeness, disagreement = (float(costs[some, images].mean()) for costs in (self.descriptors, self.hints))
        p2p = self.y.fps[images]
        return CoarseMap(p2p, distortion, unlikeness, disagreement, coarse_orientation(self.x, self.y, p2p))


def coarse_orientation(x: PartShape, y: PartShape, p2p: IndexArray) -> float:
    """Whether triangles of neighbouring farthest points lie on the same side after a map (s,), -1 to 1."""
    points = x.fps[: len(p2p)]
    near = x.rows[: len(p2p)][:, points]
    neighbours = np.argsort(near, axis=1, kind="stable")[:, 1 : _NEIGHBOURS + 1]
    first, second = np.triu_indices(neighbours.shape[1], 1)
    one, other = neighbours[:, first], neighbours[:, second]
    here = _sines(x.vertices, x.normals, points, one, other)
    there = _sines(y.vertices, y.normals, p2p, one, other)
    told = np.abs(here) > _LEAST_SINE
    total = float(np.abs(here[told]).sum())
    return float((np.sign(here) * there)[told].sum()) / total if total else 0.0


def _sines(
    vertices: FloatArray, normals: FloatArray, points: IndexArray, one: IndexArray, other: IndexArray
) -> FloatArray:
    """Sine of the angle from one neighbour to the other about the normal of each point, (s, t)."""
    centre = vertices[points][:, None]
    u, v = vertices[points[one]] - centre, vertices[points[other]] - centre
    size = np.linalg.norm(u, axis=2) * np.linalg.norm(v, axis=2)
    sines = np.einsum("ijk,ik->ij", np.cross(u, v), normals[points])
    return np.divide(sines, size, out=np.zeros_like(sines), where=size > 0)
