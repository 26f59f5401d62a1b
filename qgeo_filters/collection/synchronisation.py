"""Maps of a collection that agree with each other: each the middle of all ways through a third shape."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.collection.composition import Maps, Pair, checked_maps
from qgeo_filters.collection.cycles import CycleConsistency
from qgeo_filters.matching.maps.barycentric import nearest_around, triangles_around
from qgeo_filters.repair.welding import welded
from qgeo_filters.surface import Surface

# Trust in a map of this inconsistency, in sqrt(area), is 1/e.
_TRUSTED = 0.02
# Of Weiszfeld's algorithm: rounds, and the length in sqrt(area) below which points count as equally far.
_ROUNDS, _NEAR = 6, 2e-3


def synchronised_maps(
    shapes: Mapping[str, Surface], maps: Maps, consistency: CycleConsistency
) -> dict[Pair, BarycentricMap]:
    """Maps that agree with each other better than those that were given.

    Parameters
    ----------
    shapes : mapping of name to Surface
    maps : mapping
        As for `cycle_consistency`. Pairs without a map are given one where there is a way through a third shape.
    consistency : CycleConsistency
        Of these maps: ways count by how far the maps on them are trusted.

    Returns
    -------
    dict of (x, y) to BarycentricMap
        The point of y nearest to the weighted geometric median of the images of each vertex of x, directly and through
        each other shape.

    Notes
    -----
    Errors of different ways differ, so that their middle has less; a wrong map is outvoted. The median is taken in
    space, among images that are near each other if most maps are right.
    """
    checked = checked_maps(shapes, maps)
    found = {}
    for y, target in shapes.items():
        vertices, faces = target.vertices, target.faces
        joined, _ = welded(vertices, faces)
        around = triangles_around(vertices, faces, joined)
        for x in shapes:
            ways = list(_ways(x, y, consistency, checked, target)) if x != y else []
            if ways:
                points, starts = _middle(ways, np.sqrt(target.area))
                found[x, y] = nearest_around(points, starts, vertices, faces, joined, around=around)
    return found


def synchronised_map(
    x: str, y: str, shapes: Mapping[str, Surface], maps: Maps, consistency: CycleConsistency
) -> BarycentricMap | None:
    """One of `synchronised_maps`; None where there is no way from x to y."""
    needed = {pair: place for pair, place in maps.items() if pair[0] == x or pair[1] == y}
    target = shapes[y]
    ways = list(_ways(x, y, consistency, checked_maps(shapes, needed), target))
    if not ways:
        return None
    points, starts = _middle(ways, np.sqrt(target.area))
    return nearest_around(points, starts, target.vertices, target.faces, welded(target.vertices, target.faces)[0])


def _ways(
    x: str, y: str, consistency: CycleConsistency, maps: Mapping[Pair, BarycentricMap], target: Surface
) -> Iterator[tuple[float, FloatArray, IndexArray]]:
    """Trust in each way from x to y, images (n_x, 3), and the vertices near them."""
    names = consistency.names
    trust = np.exp(-np.nan_to_num(consistency.inconsistency, nan=0.0) / _TRUSTED)
    i, j = names.index(x), names.index(y)
    if (x, y) in maps:
        place = maps[x, y]
        yield float(trust[i, j]), place.pulled_back(target.vertices), place.nearest_corner
    for k, z in enumerate(names):
        if k not in (i, j) and (x, z) in maps and (z, y) in maps:
            first, then = maps[x, z], maps[z, y]
            near = first.nearest_corner
            # Not put onto the surface: the middle of all is.
            points = first.pulled_back(then.pulled_back(target.vertices))
            yield float(trust[i, k] * trust[k, j]), points, np.where(near >= 0, then.nearest_corner[near], -1)


def _middle(ways: list[tuple[float, FloatArray, IndexArray]], unit: float) -> tuple[FloatArray, IndexArray]:
    """Weighted geometric median (n, 3) of the images, and the vertex of the way that is nearest to it."""
    points = np.stack([way[1] for way in ways])
    known = np.asarray(np.isfinite(points).all(axis=2))
    weights = np.array([way[0] for way in ways])[:, None] * known
    points = np.where(known[..., None], points, 0.0)
    share = weights
    for _ in range(_ROUNDS):
        total = share.sum(axis=0)
        middle = np.einsum("rn,rni->ni", share, points) / np.where(total > 0, total, np.nan)[:, None]
        gaps = np.linalg.norm(points - middle, axis=2)
        share = weights / np.maximum(gaps, _NEAR * unit)
    nearest = np.where(known, gaps, np.inf).argmin(axis=0)
    starts = np.stack([way[2] for way in ways])[nearest, np.arange(points.shape[1])]
    return middle, np.where(known.any(axis=0), starts, -1)
