"""How far the maps of a collection contradict each other: a map beside those through a third shape."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence, Set
from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.collection.composition import Maps, Pair, checked_maps
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.map_errors import map_errors
from qgeo_filters.sampling import farthest_in_embedding
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

#: Above which a pair is wrong: what its triangles are apart that is not the fault of others, in sqrt(area). Measured by
#: benchmarks/consistent_maps.py.
TOLERANCE = 0.05
# Points of each shape by which maps are compared.
_POINTS = 80
#: Third shapes by which each map is judged, of larger collections as many at random: work grows with the number of maps
#: then, not with its power 3/2. Message passing takes more than half of the triangles of a map to be right; of 48 at
#: random that is so where two in three are, but for one map in a hundred.
THIRDS = 48
# Of cycle-edge message passing: reliance on the other two sides of a triangle, 1 / sqrt(area), round by round.
_RELIANCE = (5.0, 10.0, 20.0, 40.0, 80.0)


@dataclass(frozen=True, eq=False)
class CycleConsistency:
    """What the maps of a collection say of each other.

    Attributes
    ----------
    names : tuple of str
        The m shapes.
    triangles : (t, 3) int64
        Numbers of three shapes i, j, k: a map i - j, and that through the third shape, i - k - j.
    gaps : (t,) float64
        Mean geodesic distance on shape j between the images of points of i under the two, in sqrt(area) of j; NaN where
        no point has both.
    inconsistency : (m, m) float64
        What each map is apart from the others that is not their fault; symmetric, NaN where there is none, or no
        triangle to judge it by.
    share : float
        Part of all triangles that was looked at: below 1 they are a sample.
    """

    names: tuple[str, ...]
    triangles: IndexArray
    gaps: FloatArray
    inconsistency: FloatArray
    share: float = 1.0

    def __repr__(self) -> str:
        sampled = f", {100 * self.share:.2g} % of all" if self.share < 1 else ""
        counts = f"{len(self.names)} shapes, {len(self.triangles)} triangles{sampled}"
        return f"{type(self).__name__}({counts}, {len(self.wrong())} wrong pairs)"

    def wrong(self, tolerance: float = TOLERANCE) -> list[Pair]:
        """Pairs of more inconsistency, the worst first, each in the order of the names."""
        return [pair for pair, gap in self.ranked() if gap > tolerance]

    def ranked(self) -> list[tuple[Pair, float]]:
        """Pairs with their inconsistency, the worst first."""
        i, j = np.nonzero(np.triu(np.isfinite(self.inconsistency), 1))
        gaps = self.inconsistency[i, j]
        order = np.argsort(-gaps, kind="stable")
        return [((self.names[i[o]], self.names[j[o]]), float(gaps[o])) for o in order]

    def of(self, x: str, y: str) -> float:
        """Inconsistency of one pair."""
        for name in (x, y):
            if name not in self.names:
                raise ParameterError(f"there is no shape called {name!r}, only {', '.join(self.names)}")
        return float(self.inconsistency[self.names.index(x), self.names.index(y)])


def cycle_consistency(
    shapes: Mapping[str, Surface],
    maps: Maps,
    *,
    points: int = _POINTS,
    thirds: int | None = THIRDS,
    seed: int = 0,
    repairs: Mapping[str, Repair] | None = None,
    workers: int | None = None,
) -> CycleConsistency:
    """How far each map is from those through a third shape, and which of them is to blame.

    Parameters
    ----------
    shapes : mapping of name to Surface
    maps : mapping of (x, y) to BarycentricMap or array-like of int, shape (n_x,)
        For each vertex of x the point, or vertex (-1: none), of y. Not every pair need have one, nor both directions.
    points : int
        Farthest points of each shape by which maps are compared.
    thirds : int, optional
        How many third shapes each map is judged by at most; of more that many are taken at random, and the result says
        which share of all triangles that was. None: all, m (m - 1) (m - 2) triangles of m shapes.
    seed : int
        Of that choice.
    repairs : mapping of name to Repair, optional
        What was matched in place of some of the shapes: gaps are measured on it.
    workers : int, optional
        Threads; all cores by default. The result does not depend on it.

    Returns
    -------
    CycleConsistency

    Raises
    ------
    ParameterError, MeshError
        Maps that do not fit their shapes; the message names the pair.

    Notes
    -----
    Images are rounded to vertices: of right maps triangles are an edge or two apart. Which side of a triangle is to
    blame is found by cycle-edge message passing: triangles count by how far their other two sides are trusted, which
    is known from the round before [1]_. It is found as long as for each map most triangles of right maps are among
    those that agree best. What all maps of a shape have in common, such as its left taken for its right in all of them,
    shows in no triangle.

    References
    ----------
    .. [1] Lerman and Shi, "Robust group synchronization via cycle-edge message passing", Found. Comput. Math. 22, 2022.
    """
    if thirds is not None and thirds < 1:
        raise ParameterError(f"thirds must be at least 1, or None for all, got {thirds}")
    checked = checked_maps(shapes, maps)
    names = tuple(shapes)
    images = {pair: place.nearest_corner for pair, place in checked.items() if pair[0] != pair[1]}
    triangles, share = chosen_triangles(names, set(images), thirds, seed)
    samples = {name: farthest_in_embedding(s.vertices, min(points, s.n_vertices)) for name, s in shapes.items()}
    gaps = np.full(len(triangles), np.nan)
    for j, y in enumerate(names):
        here = np.flatnonzero(triangles[:, 1] == j)
        if here.size:
            gaps[here] = _gaps(names, triangles[here], shapes[y], (repairs or {}).get(y), samples, images, workers)
    blame = message_passing(len(names), triangles, gaps)
    return CycleConsistency(names, frozen(triangles), frozen(gaps), frozen(blame), share)


def message_passing(count: int, triangles: IndexArray, gaps: FloatArray) -> FloatArray:
    """Inconsistency (m, m) of each pair of m shapes from the gaps of the triangles over it, see `cycle_consistency`."""
    known = np.isfinite(gaps)
    first, last = np.sort(triangles[known, :2], axis=1).T
    # Both directions of a map have the same third shapes, and count as one.
    keys, of = np.unique((first * count + last) * count + triangles[known, 2], return_inverse=True)
    gap = np.bincount(of, gaps[known]) / np.bincount(of)
    pair, k = np.divmod(keys, count)
    i, j = np.divmod(pair, count)

    def blamed(weights: FloatArray) -> FloatArray:
        total, sums = (np.bincount(pair, values, count * count) for values in (weights, weights * gap))
        half = np.divide(sums, total, out=np.zeros(count * count), where=total > 0).reshape(count, count)
        return np.asarray(half + half.T)

    judged = np.bincount(pair, minlength=count * count).reshape(count, count) > 0
    judged |= judged.T
    blame = blamed(np.ones(len(keys)))
    for reliance in _RELIANCE:
        trust = np.where(judged, np.exp(-reliance * blame), 0.0)
        blame = blamed(trust[i, k] * trust[k, j])
    return np.where(judged, blame, np.nan)


def chosen_triangles(
    names: Sequence[Hashable], pairs: Set[tuple[Hashable, Hashable]], thirds: int | None, seed: int
) -> tuple[IndexArray, float]:
    """Triangles (t, 3) of the maps that there are, see `cycle_consistency`, and their share of all."""
    there = np.array([[(x, y) in pairs for y in names] for x in names], dtype=bool)
    rng, found, total = np.random.default_rng(seed), [np.zeros((0, 3), dtype=np.int64)], 0
    for i, j in np.argwhere(np.triu(there | there.T, 1)):
        ways = np.stack([there[a] & there[:, b] & there[a, b] for a, b in ((i, j), (j, i))])
        total += int(ways.sum())
        chosen = np.flatnonzero(ways.any(axis=0))
        if thirds is not None and len(chosen) > thirds:
            chosen = np.sort(rng.choice(chosen, thirds, replace=False))
        for (a, b), through in zip(((i, j), (j, i)), ways, strict=True):
            k = chosen[through[chosen]]
            found.append(np.column_stack([np.full(len(k), a), np.full(len(k), b), k]))
    triangles = np.concatenate(found)
    return triangles, len(triangles) / total if total else 1.0


def _gaps(
    names: tuple[str, ...],
    triangles: IndexArray,
    target: Surface,
    repair: Repair | None,
    samples: dict[str, IndexArray],
    images: dict[Pair, IndexArray],
    workers: int | None,
) -> FloatArray:
    """Gap of each triangle, all of maps to one shape: all distances on it are asked for at once."""
    ends = []
    for x, y, z in (tuple(names[number] for number in row) for row in triangles):
        between = images[x, z][samples[x]]
        ends.append((images[x, y][samples[x]], np.where(between >= 0, images[z, y][between], -1)))
    one, other = (np.concatenate(side) for side in zip(*ends, strict=True))
    triangle = np.repeat(np.arange(len(ends)), [len(direct) for direct, _ in ends])
    lengths = map_errors(target, one, other, False, repair, workers)
    reached = np.isfinite(lengths)
    sums, counts = (np.bincount(triangle[reached], of, len(ends)) for of in (lengths[reached], None))
    return np.divide(sums, counts, out=np.full(len(ends), np.nan), where=counts > 0)
