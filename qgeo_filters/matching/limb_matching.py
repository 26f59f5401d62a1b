"""Maps between shapes whose limbs are of other lengths: a woman and a gorilla."""

from __future__ import annotations

from dataclasses import replace

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.initialization.candidates import mapped_points
from qgeo_filters.matching.initialization.limb_maps import limb_maps
from qgeo_filters.matching.initialization.upsampling import laplacian_lift
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.search import Found
from qgeo_filters.matching.selection.cost import Contender, registered
from qgeo_filters.matching.selection.decision import Decision, decided_among, note_costs, settled
from qgeo_filters.matching.symmetry import reflection_of


def with_limbs_matched(problem: MatchProblem, found: Found) -> Found:
    """What was found, or a cheaper map that takes ends of limbs to ends of limbs as the symmetries allow.

    Where limbs are of other lengths, a map that takes hands to feet may keep distances best, and the right one is not
    among those that are proposed by distances. Of five ends, with a left and a right, few matchings go with the
    symmetries of both shapes, and what the deformation along each of them costs tells: that of X onto Y, and if that
    is not clear that of Y onto X, too. Nothing is sought where distances are kept, where what was found is clear as it
    is, or where a shape has no symmetry.
    """
    decision = found.decision
    if problem.more_handles or not _is_doubtful(problem, decision):
        return found
    asked = problem.with_mirrored_y() if found.mirrored else problem
    mirrors = [reflection_of(shape, problem.parameters) for shape in (asked.x, asked.y)]
    if mirrors[0] is None or mirrors[1] is None:
        return found
    ends = _settled_limb_maps(asked, mirrors[0], mirrors[1])
    if ends:
        decision = decided_among(asked, decision, ends)
    if _is_doubtful(problem, decision):  # a slender arm goes onto a stout one more easily than the other way
        back = _settled_limb_maps(asked.swapped(), mirrors[1], mirrors[0])
        if back:
            decision = decided_among(asked, decision, _turned_round(asked, back))
    return replace(found, decision=decision)


def _settled_limb_maps(problem: MatchProblem, mirror_x: IndexArray, mirror_y: IndexArray) -> list[Contender]:
    """The maps by ends of limbs that are cheapest in the preview, where they end."""
    given, points = problem.parameters, mapped_points(problem)
    maps = [(h.number, laplacian_lift(problem, h, points)) for h in limb_maps(problem, mirror_x, mirror_y)]
    if not maps:
        return []
    try:
        previews = sorted(registered(problem, maps, given.preview, points), key=lambda c: c.cost)
        close = [c for c in previews if c.cost <= given.limb_close_ratio * previews[0].cost][: given.limb_close_count]
        for c in previews:
            note_costs(problem, c, preview_cost=c.cost)
            if c not in close:
                problem.log.drop(c.number, "among the matchings of limbs others cost less in the preview")
        return settled(problem, close)
    finally:
        problem.x.arap.release()


def _turned_round(problem: MatchProblem, back: list[Contender]) -> list[Contender]:
    """The cheapest maps from Y to X as ones from X to Y, where those end."""
    given = problem.parameters
    cheapest = sorted(back, key=lambda c: c.end_cost)[: given.limb_turned_count]
    for c in back:
        if c not in cheapest:
            problem.log.drop(c.number, "from Y to X others cost less")
    maps = [(c.number, c.dense.inverse) for c in cheapest]
    try:
        ends = registered(problem, maps, given.coarse_to_fine)
    finally:
        problem.x.arap.release()
    for c in ends:
        note_costs(problem, c, end_cost=c.end_cost)
    return ends


def _is_doubtful(problem: MatchProblem, decision: Decision) -> bool:
    """Whether shapes are hardly isometric, and the map is not clear, or could not be called sure if it were."""
    given, distortion = problem.parameters, decision.best.mean_distortion
    clear = decision.margin >= given.limb_margin and distortion <= given.near_isometric
    return distortion > given.hardly_isometric and not clear
