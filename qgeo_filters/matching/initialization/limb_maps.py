"""Coarse maps of shapes whose limbs are of other lengths: ends of limbs are matched as the symmetries allow."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, permutations

import numpy as np

from qgeo_filters._typing import IndexArray, SingleArray
from qgeo_filters.jit import njit
from qgeo_filters.matching.initialization.agd_extrema import agd_extrema
from qgeo_filters.matching.initialization.hypothesis import Hypothesis
from qgeo_filters.matching.maps.map_distance import between_fps, coarse_distortions, distinct_maps
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem


def limb_maps(problem: MatchProblem, mirror_x: IndexArray, mirror_y: IndexArray) -> list[Hypothesis]:
    """Distinct coarse maps from X to Y, one for each matching of most ends of limbs that the symmetries allow.

    A point goes to the one that lies alike between each two of the matched ends, in proportion to their distance: to
    the middle of an arm, however long that is. Which side of the body it is on is left open. By increasing distortion,
    which says little of such shapes.

    Parameters
    ----------
    problem : MatchProblem
    mirror_x, mirror_y : (n_x,) int, (n_y,) int
        Vertex nearest to the mirror point of each vertex, see `reflection_of`.
    """
    x, y, given = problem.x, problem.y, problem.parameters
    of_x, of_y = LimbEnds.of(x, mirror_x, given), LimbEnds.of(y, mirror_y, given)
    matchings = symmetric_matchings(of_x.partners, of_y.partners, given.extrema_fewest)
    if not len(matchings):
        return []
    s = min(given.coarse_points, len(x.fps_distances), len(y.fps_distances))
    points_x, points_y = x.fps[:s], y.fps[:s]
    maps = _images(of_x.positions(points_x), of_y.positions(points_y), matchings)
    near_x, near_y = between_fps(x.fps_distances, points_x), between_fps(y.fps_distances, points_y)
    distortions = coarse_distortions(near_x, near_y, maps)
    order = np.argsort(distortions, kind="stable")
    hypotheses = []
    for i in order[list(distinct_maps(list(maps[order]), near_y, given.limb_hypotheses, given))]:
        number = problem.log.propose("ends of limbs, as the symmetries allow", float(distortions[i]))
        hypotheses.append(Hypothesis(points_x, points_y[maps[i]], float(distortions[i]), 0, number))
    return hypotheses


@dataclass(frozen=True, eq=False)
class LimbEnds:
    """Where limbs, head and tail end.

    Attributes
    ----------
    vertices : (e,) int
    distances : (e, n) float32
        From them to all vertices.
    partners : (e,) int
        The end that is the mirror image of each: itself on the axis, -1 if there is none.
    """

    vertices: IndexArray
    distances: SingleArray
    partners: IndexArray

    @classmethod
    def of(cls, shape: PreparedShape, mirror: IndexArray | None, given: MatchingParameters) -> LimbEnds:
        """The extrema of the average distance that are not fingers of one hand; no partners without a mirror."""
        kept: list[int] = []
        for place in agd_extrema(shape, given, count=len(shape.fps)):
            if all(shape.fps_distances[place, shape.fps[k]] > given.limb_ends_apart for k in kept):
                kept.append(int(place))
        ends = np.array(kept[: given.limb_ends], dtype=np.int64)
        vertices, distances = shape.fps[ends], shape.fps_distances[ends]
        if mirror is None:
            return cls(vertices, distances, np.full(len(ends), -1))
        to_images = distances[:, mirror[vertices]]
        near = to_images.min(axis=0) < given.limb_end_mirrored
        return cls(vertices, distances, np.where(near, to_images.argmin(axis=0), -1))

    def positions(self, points: IndexArray) -> SingleArray:
        """Where points lie between each two ends, and how far off, in distances of the two, (e, e, 2, s)."""
        between = self.distances[:, self.vertices]
        np.fill_diagonal(between, 1.0)
        one, other = self.distances[:, None, points], self.distances[None][:, :, points]
        scale = between[:, :, None]
        return np.ascontiguousarray(np.stack([(one - other) / scale, (one + other) / scale - 1], axis=2))


def symmetric_matchings(partners_x: IndexArray, partners_y: IndexArray, fewest: int) -> IndexArray:
    """Injective matchings (h, e_x) of as many ends as can be that go with the symmetries, -1 where unmatched.

    The mirror image of an end goes to the mirror image of where that goes; both are matched, or none.

    Parameters
    ----------
    partners_x, partners_y : (e_x,) int, (e_y,) int
        See `LimbEnds`.
    fewest : int
        Matchings of fewer ends are none.
    """
    for size in range(min(len(partners_x), len(partners_y)), fewest - 1, -1):
        found = [m for m in _matchings(len(partners_x), len(partners_y), size) if _commutes(m, partners_x, partners_y)]
        if found:
            return np.array(found, dtype=np.int64)
    return np.zeros((0, len(partners_x)), dtype=np.int64)


def _matchings(count_x: int, count_y: int, size: int) -> Iterator[list[int]]:
    for some in combinations(range(count_x), size):
        for images in permutations(range(count_y), size):
            matching = [-1] * count_x
            for i, j in zip(some, images, strict=True):
                matching[i] = j
            yield matching


def _commutes(matching: list[int], partners_x: IndexArray, partners_y: IndexArray) -> bool:
    images = set(matching) - {-1}
    for i, j in enumerate(matching):
        across_x, across_y = partners_x[i], -1 if j < 0 else partners_y[j]
        if across_x >= 0 and (j < 0) != (matching[across_x] < 0):
            return False
        if across_y >= 0 and across_y not in images:
            return False
        if across_x >= 0 and across_y >= 0 and matching[across_x] != across_y:
            return False
    return True


@njit()
def _images(positions_x: SingleArray, positions_y: SingleArray, matchings: IndexArray) -> IndexArray:
    """For each matching (h, e) the place in Y's points (t,) that lies most alike, for each of X's (s,): (h, s)."""
    count, e = matchings.shape
    s, t = positions_x.shape[3], positions_y.shape[3]
    found = np.empty((count, s), np.int64)
    gaps = np.empty((s, t), np.float32)
    for k in range(count):
        gaps[:] = 0
        for i in range(1, e):
            for j in range(i):
                a, b = matchings[k, i], matchings[k, j]
                if a < 0 or b < 0:
                    continue
                for part in range(2):
                    here, there = positions_x[i, j, part], positions_y[a, b, part]
                    for p in range(s):
                        for q in range(t):
                            gaps[p, q] += abs(here[p] - there[q])
        for p in range(s):
            found[k, p] = np.argmin(gaps[p])
    return found
