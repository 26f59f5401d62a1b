"""How far the maps of a collection contradict each other: a map beside those through a third shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.collection.composition import Maps, Pair, checked_maps
from qgeo_filters.errors import ParameterError
from qgeo_filters.geodesics.pairs import paired_distances
from qgeo_filters.sampling import farthest_in_embedding
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

#: Above which a pair is wrong: what its triangles are apart that is not the fault of others, in sqrt(area). Measured by
#: benchmarks/consistent_maps.py.
TOLERANCE = 0.05
# Points of each shape by which maps are compared.
_POINTS = 80
# Of cycle-edge message passing: reliance on the other two sides of a triangle, 1 / sqrt(area), round by round.
_RELIANCE = (5.0, 10.0, 20.0, 40.0, 80.0)


@dataclass(frozen=True, eq=False)
class CycleConsistency:
    """What the maps of a collection say of each other.

    Attributes
    ----------
    names : tuple of str
        The m shapes.
    triangles : (m, m, m) float64
        At [i, j, k] the mean geodesic distance on shape j between the images of points of i under the map i - j and
        under i - k - j, in sqrt(area) of j; NaN where a map is not there, and where two of the shapes are one.
    inconsistency : (m, m) float64
        What each map is apart from the others that is not their fault; symmetric, NaN where there is none, or no
        triangle to judge it by.
    """

    names: tuple[str, ...]
    triangles: FloatArray
    inconsistency: FloatArray

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
    shapes: Mapping[str, Surface], maps: Maps, *, points: int = _POINTS, workers: int | None = None
) -> CycleConsistency:
    """How far each map is from those through a third shape, and which of them is to blame.

    Parameters
    ----------
    shapes : mapping of name to Surface
    maps : mapping of (x, y) to BarycentricMap or array-like of int, shape (n_x,)
        For each vertex of x the point, or vertex (-1: none), of y. Not every pair need have one, nor both directions.
    points : int
        Farthest points of each shape by which maps are compared.
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
    checked = checked_maps(shapes, maps)
    names = tuple(shapes)
    images = {pair: place.nearest_corner for pair, place in checked.items() if pair[0] != pair[1]}
    triangles = np.full((len(names),) * 3, np.nan)
    samples = {name: farthest_in_embedding(s.vertices, min(points, s.n_vertices)) for name, s in shapes.items()}
    for j, y in enumerate(names):
        _compare(names, j, shapes[y], samples, images, triangles, workers)
    return CycleConsistency(names, frozen(triangles), frozen(message_passing(triangles)))


def message_passing(triangles: FloatArray) -> FloatArray:
    """Inconsistency (m, m) of each pair from the gaps (m, m, m) of the triangles over it, see `cycle_consistency`."""
    with np.errstate(invalid="ignore"):
        both = np.where(np.isnan(triangles), triangles.transpose(1, 0, 2), triangles)
        gaps = 0.5 * (both + both.transpose(1, 0, 2))
    known = np.isfinite(gaps)
    filled = np.where(known, gaps, 0.0)
    count = known.sum(axis=2)
    blame = _means(filled, known.astype(float))
    for reliance in _RELIANCE:
        trust = np.exp(-reliance * np.where(count > 0, blame, np.inf))
        blame = _means(filled, known * trust[:, None, :] * trust.T[None, :, :])
    return np.where(count > 0, blame, np.nan)


def _compare(
    names: tuple[str, ...],
    j: int,
    target: Surface,
    samples: dict[str, IndexArray],
    images: dict[Pair, IndexArray],
    triangles: FloatArray,
    workers: int | None,
) -> None:
    """Fill in the triangles of the maps to one shape: all distances on it are asked for at once."""
    y, one, other, at = names[j], [], [], []
    for i, x in enumerate(names):
        if (x, y) not in images:
            continue
        direct = images[x, y][samples[x]]
        for k, z in enumerate(names):
            if len({i, j, k}) == 3 and (x, z) in images and (z, y) in images:
                between = images[x, z][samples[x]]
                through = np.where(between >= 0, images[z, y][between], -1)
                one.append(direct)
                other.append(through)
                at.append((i, k))
    if not at:
        return
    ends = np.concatenate(one), np.concatenate(other)
    known = (ends[0] >= 0) & (ends[1] >= 0)
    gaps = np.full(len(known), np.nan)
    gaps[known] = paired_distances(target, ends[0][known], ends[1][known], workers=workers) / np.sqrt(target.area)
    starts = np.cumsum([0, *(len(part) for part in one)])
    for (i, k), start, end in zip(at, starts, starts[1:], strict=False):
        part = gaps[start:end]
        triangles[i, j, k] = part[np.isfinite(part)].mean() if np.isfinite(part).any() else np.nan


def _means(values: FloatArray, weights: FloatArray) -> FloatArray:
    total = weights.sum(axis=2)
    return np.asarray((values * weights).sum(axis=2) / np.where(total > 0, total, 1.0))
