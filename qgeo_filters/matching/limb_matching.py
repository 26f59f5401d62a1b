"""Maps between shapes whose limbs are of other lengths: a woman and a gorilla."""

from __future__ import annotations

from dataclasses import replace

from qgeo_filters.matching.initialization.candidates import mapped_points
from qgeo_filters.matching.initialization.limb_maps import limb_maps
from qgeo_filters.matching.initialization.upsampling import laplacian_lift
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.search import Found
from qgeo_filters.matching.selection.cost import registered
from qgeo_filters.matching.selection.decision import Decision, decided_among, settled
from qgeo_filters.matching.symmetry import reflection_of


def with_limbs_matched(problem: MatchProblem, found: Found) -> Found:
    """What was found, or a cheaper map that takes ends of limbs to ends of limbs as the symmetries allow.

    Where limbs are of other lengths, a map that takes hands to feet may keep distances best, and the right one is not
    among those that are proposed by distances. Of five ends, with a left and a right, few matchings go with the
    symmetries of both shapes, and what the deformation along each of them costs tells. Nothing is sought where
    distances are kept, where what was found is clear as it is, or where a shape has no symmetry.
    """
    decision = found.decision
    if problem.more_handles or not _is_doubtful(problem, decision):
        return found
    asked = problem.with_mirrored_y() if found.mirrored else problem
    mirrors = [reflection_of(shape, problem.parameters) for shape in (asked.x, asked.y)]
    if mirrors[0] is None or mirrors[1] is None:
        return found
    given, points = problem.parameters, mapped_points(asked)
    maps = [(h.number, laplacian_lift(asked, h, points)) for h in limb_maps(asked, mirrors[0], mirrors[1])]
    if not maps:
        return found
    try:
        previews = sorted(registered(asked, maps, given.preview, points), key=lambda c: c.cost)
        close = [c for c in previews if c.cost <= given.limb_close_ratio * previews[0].cost][: given.limb_close_count]
        for c in previews:
            if c not in close:
                asked.log.drop(c.number, "among the matchings of limbs others cost less in the preview")
        return replace(found, decision=decided_among(asked, decision, settled(asked, close)))
    finally:
        asked.x.arap.release()


def _is_doubtful(problem: MatchProblem, decision: Decision) -> bool:
    given = problem.parameters
    return decision.best.mean_distortion > given.hardly_isometric and decision.margin < given.limb_margin
