"""Coarse maps between two shapes with no initial map: every sign of the first eigenfunctions is tried."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, SingleArray
from qgeo_filters.matching.initialization.distortion import point_distortions
from qgeo_filters.matching.maps.functional_map import nearest, orthogonal
from qgeo_filters.matching.prepared_shape import MetricView, PreparedShape
from qgeo_filters.parallel import concurrently

# Eigenfunctions whose signs are enumerated, and at the end of the growth.
_ENUMERATED = 8
_GROWN = 20
# Farthest points on either shape, enough for functions this smooth.
_POINTS = 300
# Neighbouring eigenvalues closer than this, relatively, may come in either order on the other shape.
_SWAP_GAP = 0.06
# Hypotheses that are grown, by distortion before the growth, and those that survive its checks.
_BEAM = 256
_SURVIVORS = 24
_CHECKED_AT = (10, 13)
#: Two maps whose images are this far apart in the mean, in units of sqrt(area), are different maps.
DISTINCT = 0.04
# So are two maps that differ by this much in this share of the points, such as the tip of a limb.
_ELSEWHERE, _LIMB = 0.2, 0.015
#: Maps that move points by less than this in the mean are the identity, or the identity with a limb displaced.
NEAR_IDENTITY = 0.1


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A coarse map.

    Attributes
    ----------
    points : (s,) int
        Vertices of X.
    p2p : (s,) int
        Vertex of Y for each of them.
    distortion : float
        Mean |d_X(p, q) - d_Y(Tp, Tq)| over them, in units of sqrt(area), in the first metric.
    metric : int
        Which metric proposed it.
    """

    points: IndexArray
    p2p: IndexArray
    distortion: float
    metric: int


def search(x: PreparedShape, y: PreparedShape, limit: int = 24, *, identity: bool = True) -> list[Hypothesis]:
    """Distinct coarse maps from X to Y by increasing geodesic distortion, at most ``limit``.

    An isometry takes each eigenfunction of the distances to one of the other shape with the same eigenvalue, up to
    its sign; nearly equal eigenvalues may come in either order. For each choice of signs (and orders) of the first
    functions the points are mapped to their nearest neighbours in the space of these functions; then one
    more function after another is added, with the functional map that the point map gives. Choices that distort
    distances most are dropped on the way. The signs that a solver happens to return do not matter.

    Each metric proposes its own maps, all are compared in the first one. With ``identity=False``, for two shapes of
    equal vertices, maps near the identity are left out.
    """
    s = min(_POINTS, len(x.samples), len(y.samples))
    near = between_samples(x.rows, x.samples[:s]), between_samples(y.rows, y.samples[:s])
    found: list[Hypothesis] = []
    views = zip(x.views, y.views, strict=False)
    grown = concurrently(lambda pair: _grown_maps(*pair, x.samples[:s], y.samples[:s], identity), views)
    for metric, maps in enumerate(grown):
        for images, distortion in zip(maps, point_distortions(*near, maps), strict=True):
            found.append(Hypothesis(x.samples[:s], y.samples[images], float(distortion), metric))
    found.sort(key=lambda hypothesis: hypothesis.distortion)
    place = np.zeros(y.n_vertices, dtype=np.int64)
    place[y.samples[:s]] = np.arange(s)
    if not identity:
        moved = [float(near[1][place[hypothesis.p2p], np.arange(s)].mean()) for hypothesis in found]
        found = [hypothesis for hypothesis, far in zip(found, moved, strict=True) if far > NEAR_IDENTITY]
    return [found[i] for i in distinct([place[hypothesis.p2p] for hypothesis in found], near[1], limit)]


def distinct(maps: list[IndexArray], distances: SingleArray, limit: int) -> list[int]:
    """Places of the maps that differ from all kept before them; ``distances[a, b]`` is between images a and b."""
    kept: list[int] = []
    for i, images in enumerate(maps):
        if all(differ(distances[images, maps[j]]) for j in kept):
            kept.append(i)
            if len(kept) == limit:
                break
    return kept


def differ(between: SingleArray) -> bool:
    """Whether two maps are different ones, by the distances between their images: in the mean, or in a limb."""
    return float(between.mean()) > DISTINCT or float((between > _ELSEWHERE).mean()) > _LIMB


def orders(values_x: FloatArray, values_y: FloatArray, count: int) -> Iterator[tuple[int, ...]]:
    """Orders of the first ``count`` eigenfunctions: as they are, and with nearly equal neighbours swapped."""
    swaps = [
        i
        for i in range(1, count - 1)
        if min(abs(abs(values[i]) - abs(values[i + 1])) / abs(values[i]) for values in (values_x, values_y)) < _SWAP_GAP
    ]
    seen = set()
    for chosen in itertools.product((False, True), repeat=len(swaps)):
        order = list(range(count))
        for i, swap in zip(swaps, chosen, strict=True):
            if swap:
                order[i], order[i + 1] = order[i + 1], order[i]
        if tuple(order) not in seen:
            seen.add(tuple(order))
            yield tuple(order)


def _grown_maps(x: MetricView, y: MetricView, points_x: IndexArray, points_y: IndexArray, identity: bool) -> IndexArray:
    """Maps (h, s) into ``points_y`` of the best choices of signs and orders, the least distorting first."""
    phi_x, phi_y = x.eigenfunctions[points_x], y.eigenfunctions[points_y]
    width = min(phi_x.shape[1], phi_y.shape[1], _GROWN)
    start = min(_ENUMERATED, width)
    near_x, near_y = between_samples(x.rows, points_x), between_samples(y.rows, points_y)
    # The first eigenfunction has one sign over the surface (D is positive), and canonical signs make it positive.
    signs = np.array(list(itertools.product((1, -1), repeat=start - 1)), dtype=np.float32)
    signs = np.column_stack([np.ones(len(signs), np.float32), signs])
    maps = np.concatenate(
        [
            nearest(phi_x[:, order] * signs[:, None, :], phi_y[:, :start])
            for order in orders(x.eigenvalues, y.eigenvalues, start)
        ]
    )
    if not identity:
        maps = maps[[displacement(near_y, images) > NEAR_IDENTITY for images in maps]]
    maps = _least_distorting(maps, near_x, near_y, _BEAM)
    for k in range(start + 1, width + 1):
        basis = phi_x[:, :k]
        inverse = np.linalg.solve(basis.T @ basis, basis.T)
        functional = orthogonal(inverse @ phi_y[maps, :k])
        maps = nearest(basis @ functional, phi_y[:, :k])
        if k in _CHECKED_AT:
            if not identity:
                maps = maps[[displacement(near_y, images) > NEAR_IDENTITY for images in maps]]
            maps = _least_distorting(maps, near_x, near_y, max(len(maps) // 3, _SURVIVORS))
    maps = _least_distorting(maps, near_x, near_y, len(maps))
    return maps[distinct(list(maps), near_y, _SURVIVORS)]


def between_samples(rows: SingleArray, samples: IndexArray) -> SingleArray:
    """Distances (s, s) among the first farthest points, from their rows."""
    return np.ascontiguousarray(rows[: len(samples), samples])


def _least_distorting(maps: IndexArray, near_x: SingleArray, near_y: SingleArray, count: int) -> IndexArray:
    values = point_distortions(near_x, near_y, maps)
    return maps[np.argsort(values, kind="stable")[:count]]


def displacement(distances: SingleArray, images: IndexArray) -> float:
    """Mean distance of a map of a shape to itself from the identity."""
    return float(distances[images, np.arange(len(images))].mean())
