"""A match that starts from a map which is known roughly: from other matches, a template, another method."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.correspondence import described
from qgeo_filters.matching.finish import finished
from qgeo_filters.matching.given_vertices import match_on_given
from qgeo_filters.matching.maps.map_distance import mean_distortion
from qgeo_filters.matching.maps.orientation import normal_cosines
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import Shape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.search import Found
from qgeo_filters.matching.selection.cost import Contender, registered
from qgeo_filters.matching.selection.decision import Decision, settled
from qgeo_filters.parallel import default_workers, single_threaded_blas
from qgeo_filters.validation import checked_indices


def match_from(
    x: Shape,
    y: Shape,
    p2p: npt.ArrayLike,
    *,
    rival: npt.ArrayLike | None = None,
    parameters: MatchingParameters | None = None,
    workers: int | None = None,
) -> MatchResult:
    """The match that a rough map leads to, with no search.

    Parameters
    ----------
    x, y : Surface, whatever `as_surface` takes, or PreparedShape
    p2p : array-like of int, shape (n_x,)
        Vertex of Y for each vertex of X, right in the large; -1: not known.
    rival : array-like of int, shape (n_x,), optional
        Another map, which is registered in the same way: ``margin`` says how many times as much it costs there, below
        1 if it is the cheaper one.
    parameters : MatchingParameters, optional
    workers : int, optional
        Threads; all cores by default.

    Returns
    -------
    MatchResult
        As `match` returns it: previewed, settled and finished along the map. Confident as `match` would be if the rival
        were the only other map.

    Raises
    ------
    ParameterError, MeshError
        A map that does not fit the shapes, or of hardly any vertex; shapes that cannot be matched.
    """
    with default_workers(workers), single_threaded_blas:
        problem = MatchProblem.of(x, y, parameters)
        start = _on_full(problem, p2p, "p2p")
        turned = _in_hand(problem, start)
        try:
            best = _settled(turned, start, "the given map")
            margin, runner_up = np.inf, np.inf
            if rival is not None:
                other = _on_full(problem, rival, "rival")
                against = _settled(_in_hand(problem, other), other, "the rival")
                margin, runner_up = against.end_cost / best.end_cost, against.mean_distortion
            problem.log.choose(best.number)
        finally:
            problem.x.arap.release()
        mirrored = turned is not problem
        decision = Decision(best, margin, runner_up)
        dense = finished(turned, best.to_finish)
        found = described(problem, Found(decision, mirrored), dense, "yes" if mirrored else "no")
        return match_on_given(found, problem.x, problem.y)


def _on_full(problem: MatchProblem, p2p: npt.ArrayLike, name: str) -> IndexArray:
    """The map between the repaired shapes, (n_full_x,)."""
    x, y = problem.x, problem.y
    images = checked_indices(p2p, y.given.n_vertices, name, missing=True)
    if len(images) != x.given.n_vertices:
        raise ParameterError(f"{name} must hold a vertex for each of the {x.given.n_vertices} of X, got {len(images)}")
    if y.repair is not None:
        images = np.where(images >= 0, y.repair.vertex_of_original[np.maximum(images, 0)], -1)
    return images if x.repair is None else images[x.repair.origin]


def _in_hand(problem: MatchProblem, full: IndexArray) -> MatchProblem:
    """The problem itself, or that of the mirror image of Y, in which the map keeps the orientation."""
    x, y = problem.x.oriented, problem.y.oriented
    known = (full >= 0)[x.faces].all(axis=1)
    seen = float(x.face_areas[known] @ normal_cosines(y, full[x.faces[known]]))
    return problem.with_mirrored_y() if seen < 0 else problem


def _settled(problem: MatchProblem, full: IndexArray, name: str) -> Contender:
    """What the map costs where it ends between the coarse shapes."""
    x, y, given = problem.x, problem.y, problem.parameters
    images = full[x.full_vertices]
    start = np.flatnonzero(images >= 0)
    if len(start) < min(given.coarse_points, x.n_vertices) // 2:
        raise ParameterError(f"{name} says where {len(start)} of {x.n_vertices} vertices go: too few to start from")
    p2p = y.vertex_of_full[images[start]]
    number = problem.log.propose(name, _distortion(problem, start, p2p))
    preview = registered(problem, [(number, p2p)], given.preview, start)
    return settled(problem, preview)[0]


def _distortion(problem: MatchProblem, start: IndexArray, p2p: IndexArray) -> float:
    """Mean distortion at the farthest points; of a part, with the rest where it is nearest in the order."""
    place = np.searchsorted(start, problem.x.fps).clip(0, len(start) - 1)
    return mean_distortion(problem, p2p[place])
