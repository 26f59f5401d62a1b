"""The intrinsic left/right symmetry of a shape as a point map, found with no initial guess."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from qgeo_filters._typing import IndexArray, RepairOption
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.finish import finished
from qgeo_filters.matching.given_vertices import symmetry_on_given
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape, Shape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.reflection_search import chosen_reflection, is_doubtful
from qgeo_filters.matching.selection.decision import Decision
from qgeo_filters.matching.selection.signatures import hks_agreement
from qgeo_filters.matching.symmetry_result import Symmetry, described_symmetry, no_symmetry
from qgeo_filters.parallel import default_workers, single_threaded_blas

#: Mean distortion of distances, in sqrt(area), up to which a map of the shape to its mirror image is a symmetry.
TOLERANCE = 0.08


def self_symmetry(
    shape: Shape,
    *,
    tolerance: float = TOLERANCE,
    repair: RepairOption = "auto",
    parameters: MatchingParameters | None = None,
    workers: int | None = None,
    progress: bool = False,
) -> Symmetry:
    """Intrinsic left/right symmetry of a shape: mirror vertex, side and asymmetry of each vertex.

    The search of `match` is run from the shape to its own image in a mirror: maps that keep the orientation
    there reverse it on the shape, which leaves out the identity. What bends, such as limbs in any pose, may bend: only
    distances on the surface count.

    Parameters
    ----------
    shape : Surface, whatever `as_surface` takes, or PreparedShape
        A prepared shape remembers its symmetry.
    tolerance : float
        Mean distortion of distances, in units of sqrt(area), up to which a map counts as a symmetry.
    repair : bool, "auto", "force" or "wrap"
        Whether the shape is made manifold, oriented and one piece first, as in `match`.
    parameters : MatchingParameters, optional
        What the search goes by; that of the prepared shape, or the measured default.
    workers : int, optional
        Threads; all cores that the process may use by default. The result does not depend on it.
    progress : bool
        Whether to show a progress bar over the distances.

    Returns
    -------
    Symmetry
        ``found`` is False, and ``reason`` says why, for a shape without such a symmetry, or with a whole family of
        them (sphere, torus), of which none can be singled out.

    Raises
    ------
    MeshError
        See `PreparedShape`.
    ParameterError
        A tolerance that is not positive, or a shape that was prepared with other parameters.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> ball = surface.vertices / [1.4, 1, 0.8]
    >>> ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    >>> radius = 1 + 0.3 * ball[:, [1]] + 0.25 * ball[:, [1]] * ball[:, [2]]
    >>> body = surface.with_vertices(ball * [1, 1.6, 0.7] * radius)  # its own mirror image in x = 0
    >>> symmetry = qg.self_symmetry(body)
    >>> symmetry.found, bool((symmetry.p2p[symmetry.p2p] == np.arange(162)).all())
    (True, True)
    >>> np.allclose(body.vertices[symmetry.nearest] * [-1, 1, 1], body.vertices)
    True
    """
    if not 0 < tolerance < np.inf:
        raise ParameterError(f"the tolerance must be a positive fraction of sqrt(area), got {tolerance!r}")
    with default_workers(workers):
        problem = MatchProblem.of_reflection(shape, parameters, repair=repair, progress=progress)
        return symmetry_on_given(_remembered(problem, tolerance), problem.x)


def reflection_of(shape: PreparedShape, parameters: MatchingParameters) -> IndexArray | None:
    """Vertex nearest to the mirror point of each vertex of the coarse shape, (n,); None without a symmetry."""
    found = _remembered(MatchProblem.of_reflection(shape, parameters), TOLERANCE)
    return shape.vertex_of_full[found.nearest[shape.full_vertices]] if found.found else None


def _remembered(problem: MatchProblem, tolerance: float) -> Symmetry:
    key = tolerance, problem.parameters
    kept = problem.x.symmetries
    if key not in kept:
        kept[key] = _found(problem, tolerance)
    found: Symmetry = kept[key]
    return found


def reflection_log(shape: Shape, *, parameters: MatchingParameters | None = None) -> MatchLog:
    """Every reflection that `self_symmetry` looks at, what it costs, and which rule drops it."""
    problem = MatchProblem.of_reflection(shape, parameters)
    _found(problem, TOLERANCE)
    return problem.log


@single_threaded_blas
def _found(problem: MatchProblem, tolerance: float) -> Symmetry:
    chosen = chosen_reflection(problem)
    finer = problem.x.finer() if is_doubtful(problem, chosen) else None
    if finer is not None:
        given = replace(problem.parameters, search_vertices=finer.parameters.search_vertices)
        closer = MatchProblem.of_reflection(finer, given)
        found = _judged(closer, chosen_reflection(closer), tolerance)
        if found.found:
            problem.log.maps[:] = closer.log.maps
            return found
    return _judged(problem, chosen, tolerance)


def _judged(problem: MatchProblem, decision: Decision | None, tolerance: float) -> Symmetry:
    """The reflection finished, or why it is none."""
    x, given = problem.x, problem.parameters
    if decision is None:
        return no_symmetry(x, "no map of the shape to its mirror image keeps distances even roughly")
    margin = decision.margin
    if margin < given.margin and decision.best.mean_distortion < tolerance:
        return no_symmetry(
            x,
            f"different reflections keep distances and shape about equally well (costs within {margin:.2f}): either "
            "a family of symmetries, of which none can be singled out, or a shape without any that is nearly round",
        )
    found = described_symmetry(problem, finished(problem, decision.best.dense))
    if found.score > tolerance:
        return no_symmetry(
            x,
            f"the best map of the shape to its mirror image distorts distances by {found.score:.3f} sqrt(area) "
            f"in the mean, more than the tolerance of {tolerance:g}",
        )
    alike = hks_agreement(problem, x.vertex_of_full[found.nearest[x.full_vertices]])
    gap = max(given.symmetry_gap * found.score, given.symmetry_least_gap)
    if alike < max(given.symmetry_alike, 1 - gap):
        return no_symmetry(
            x,
            f"the best map of the shape to its mirror image keeps distances to {found.score:.3f} sqrt(area), but "
            f"relates parts of different shape (their heat kernels agree by {alike:.2f} only)",
        )
    return found
