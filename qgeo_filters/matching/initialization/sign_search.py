"""Coarse maps between two shapes with no initial map: every sign of the first eigenfunctions is tried."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.matching.initialization.hypothesis import Hypothesis
from qgeo_filters.matching.intrinsic_shape import MetricEmbedding
from qgeo_filters.matching.maps.functional_map import nearest_neighbors, procrustes
from qgeo_filters.matching.maps.map_distance import between_fps, coarse_distortions, displacement, distinct_maps
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.parallel import concurrently


def sign_search(problem: MatchProblem) -> list[Hypothesis]:
    """Distinct coarse maps from X to Y by increasing geodesic distortion, times their penalties if there are hints.

    An isometry takes each eigenfunction of the distances to one of the other shape with the same eigenvalue, up to
    its sign; nearly equal eigenvalues may come in either order. For each choice of signs (and orders) of the first
    functions the points are mapped to their nearest neighbours in the space of these functions; then one
    more function after another is added, with the functional map that the point map gives. Choices that distort
    distances most are dropped on the way. The signs that a solver happens to return do not matter.

    Each metric proposes its own maps, all are compared in the first one. For a reflection, maps near the identity are
    left out.
    """
    x, y, given = problem.x, problem.y, problem.parameters
    s = min(given.coarse_points, len(x.fps), len(y.fps))
    points_x, points_y = x.fps[:s], y.fps[:s]
    near_x, near_y = between_fps(x.fps_distances, points_x), between_fps(y.fps_distances, points_y)
    metrics = range(len(given.curvature_weights))[-(given.proposing or len(given.curvature_weights)) :]
    pairs = [(x.embedding(metric), y.embedding(metric)) for metric in metrics]
    grown = concurrently(lambda pair: _grown_maps(problem, *pair, points_x, points_y), pairs)
    found = [
        (float(distortion), images, metric, float(distortion * penalty))
        for metric, maps in zip(metrics, grown, strict=True)
        for images, distortion, penalty in zip(
            maps,
            coarse_distortions(near_x, near_y, maps),
            problem.dearness(points_x, points_y[maps]),
            strict=True,
        )
    ]
    found.sort(key=lambda entry: entry[3])
    if problem.reflection:
        found = [entry for entry in found if displacement(near_y, entry[1]) > given.near_identity]
    hypotheses = []
    for place in distinct_maps([images for _, images, *_ in found], near_y, given.sign_hypotheses, given):
        distortion, images, metric, _ = found[place]
        by = f"signs of eigenfunctions, curvature weight {given.curvature_weights[metric]:g}"
        number = problem.log.propose(by, distortion)
        hypotheses.append(Hypothesis(points_x, points_y[images], distortion, metric, number))
    return hypotheses


def eigenfunction_orders(
    values_x: FloatArray, values_y: FloatArray, count: int, swap_gap: float
) -> Iterator[tuple[int, ...]]:
    """Orders of the first ``count`` eigenfunctions: as they are, and with nearly equal neighbours swapped."""
    swaps = [
        i
        for i in range(1, count - 1)
        if min(abs(abs(values[i]) - abs(values[i + 1])) / abs(values[i]) for values in (values_x, values_y)) < swap_gap
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


def _grown_maps(
    problem: MatchProblem, x: MetricEmbedding, y: MetricEmbedding, points_x: IndexArray, points_y: IndexArray
) -> IndexArray:
    """Maps (h, s) into ``points_y`` of the best choices of signs and orders, the best first."""
    given = problem.parameters
    phi_x, phi_y = x.eigenfunctions[points_x], y.eigenfunctions[points_y]
    width = min(phi_x.shape[1], phi_y.shape[1], given.signs_grown)
    start = min(given.signs_enumerated, width)
    near_x, near_y = between_fps(x.fps_distances, points_x), between_fps(y.fps_distances, points_y)

    def best(maps: IndexArray, count: int) -> IndexArray:
        values = coarse_distortions(near_x, near_y, maps) * problem.dearness(points_x, points_y[maps])
        return maps[np.argsort(values, kind="stable")[:count]]

    def elsewhere(maps: IndexArray) -> IndexArray:
        if not problem.reflection:
            return maps
        return maps[[displacement(near_y, images) > given.near_identity for images in maps]]

    # The first eigenfunction has one sign over the surface (D is positive), and canonical signs make it positive.
    signs = np.array(list(itertools.product((1, -1), repeat=start - 1)), dtype=np.float32)
    signs = np.column_stack([np.ones(len(signs), np.float32), signs])
    maps = np.concatenate(
        [
            nearest_neighbors(phi_x[:, order] * signs[:, None, :], phi_y[:, :start])
            for order in eigenfunction_orders(x.eigenvalues, y.eigenvalues, start, given.swap_gap)
        ]
    )
    maps = best(elsewhere(maps), given.sign_beam)
    for k in range(start + 1, width + 1):
        basis = phi_x[:, :k]
        inverse = np.linalg.solve(basis.T @ basis, basis.T)
        functional = procrustes(inverse @ phi_y[maps, :k])
        maps = nearest_neighbors(basis @ functional, phi_y[:, :k])
        if k in given.sign_checks:
            maps = elsewhere(maps)
            maps = best(maps, max(len(maps) // 3, given.sign_survivors))
    maps = best(maps, len(maps))
    return maps[list(distinct_maps(list(maps), near_y, given.sign_survivors, given))]
