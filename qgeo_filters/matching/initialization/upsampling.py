"""Coarse maps carried to more vertices by eigenfunctions."""

from __future__ import annotations

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.initialization.hypothesis import Hypothesis
from qgeo_filters.matching.maps.functional_map import functional_map, nearest_neighbors, zoomout
from qgeo_filters.matching.problem import MatchProblem


def zoomout_lift(problem: MatchProblem, hypothesis: Hypothesis, vertices: IndexArray) -> IndexArray:
    """Images (s,) of some vertices of X, by spectral upsampling over the eigenfunctions of the distances."""
    given = problem.parameters
    phi_x, phi_y = (shape.embedding(hypothesis.metric).eigenfunctions for shape in (problem.x, problem.y))
    width = min(phi_x.shape[1], phi_y.shape[1])
    start = min(given.zoomout_start, width)
    coarse = zoomout(phi_x, phi_y, hypothesis.p2p, hypothesis.points, [start])
    points, others = problem.x.fps[: given.zoomout_points], phi_y[problem.y.fps]
    images = nearest_neighbors(phi_x[points, :start] @ coarse, others[:, :start])
    functional = zoomout(phi_x, others, images, points, range(start, width + 1, given.zoomout_step))
    k = len(functional)
    return nearest_neighbors(phi_x[vertices, :k] @ functional, phi_y[:, :k])


def coarse_lift(problem: MatchProblem, hypothesis: Hypothesis, vertices: IndexArray) -> IndexArray:
    """Images (s,) of some vertices of X, by the first eigenfunctions of the distances."""
    phi_x, phi_y = (shape.embedding(hypothesis.metric).eigenfunctions for shape in (problem.x, problem.y))
    k = min(phi_x.shape[1], phi_y.shape[1], problem.parameters.zoomout_start)
    functional = zoomout(phi_x, phi_y, hypothesis.p2p, hypothesis.points, [k])
    return nearest_neighbors(phi_x[vertices, :k] @ functional, phi_y[:, :k])


def laplacian_lift(problem: MatchProblem, hypothesis: Hypothesis, vertices: IndexArray) -> IndexArray:
    """Images (s,) of some vertices of X, by the first eigenfunctions of the Laplacian."""
    k = problem.parameters.laplacian_lift
    left, right = problem.x.laplacian[:, :k], problem.y.laplacian[:, :k]
    functional = functional_map(left[hypothesis.points], right, hypothesis.p2p)
    return nearest_neighbors(left[vertices] @ functional, right)
