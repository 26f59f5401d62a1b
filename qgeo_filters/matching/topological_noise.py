"""Maps between a shape and one that has grown together where it touches itself.

A hand that is one with the leg it lies on makes a handle, and distances on that surface shorter: never longer. So the
one without the handle is placed on the other one as a part is on the whole, of which a cut makes distances longer.

References
----------
Laehner, Rodola, Bronstein, Cremers and others, "SHREC'16: Matching of deformable shapes with topological noise", 3DOR
2016.
"""

from __future__ import annotations

from dataclasses import replace

from qgeo_filters._typing import SingleArray
from qgeo_filters.matching.finish import turned_round
from qgeo_filters.matching.initialization.limb_maps import LimbEnds
from qgeo_filters.matching.partial.half_turns import turned_places
from qgeo_filters.matching.partial.limb_moves import with_limbs_moved
from qgeo_filters.matching.partial.part_choice import PartChoice, PlacedPart
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.matching.placement import Placement
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.schedule import Schedule
from qgeo_filters.matching.search import Found
from qgeo_filters.matching.selection.cost import Contender, measured
from qgeo_filters.matching.selection.decision import Decision
from qgeo_filters.matching.smooth_shells import register


def robust_to_shortcuts(problem: MatchProblem, found: Found, given: PartialParameters | None = None) -> Found:
    """What was found, or a clearly better map by distances that may only be shorter on the shape with more handles.

    Nothing is sought where both shapes have as many handles, or where what was found is clear as it is. The best places
    are turned round, too, see `half_turns`, and limbs moved to what is left uncovered, see `with_limbs_moved`.

    Parameters
    ----------
    problem : MatchProblem
    found : Found
        The best map by distances that should be equal.
    given : PartialParameters, optional
    """
    if not problem.more_handles or _is_clear(problem, found.decision):
        return found
    chosen = PartialParameters.of_grown_surfaces() if given is None else given
    asked = problem.with_mirrored_y() if found.mirrored else problem
    turned = asked.more_handles > 0
    way = asked.swapped() if turned else asked  # from the shape that has not grown together
    placement = Placement(way, chosen)
    before = found.decision
    start = before.best.dense.inverse if turned else before.best.dense.p2p
    placed = placement.compared.placed([(before.best.number, placement.at_points(start)), *placement.proposed()])
    usual, *others = placed
    # Costs are rough, and the usual search has compared its map with many: another one needs a reason.
    clear = [p for p in others if p.cost * chosen.shortcut_reason < usual.cost]
    cheapest = min(clear, key=lambda p: p.cost, default=usual)
    to_ends = LimbEnds.of(way.x, placement.mirror, way.parameters).distances
    best, tried = _mended(placement.compared, to_ends, cheapest, placed)
    choice = placement.compared.decided(best, [*placed, *tried])
    margin, unhinted = choice.margin, choice.unhinted
    if choice.best is usual:
        kept = replace(before, margin=min(before.margin, margin), unhinted=min(before.unhinted, unhinted))
        return replace(found, decision=kept)
    contender = _contender(way, asked, choice.best)
    return replace(found, decision=Decision(contender, margin, choice.runner_up, unhinted))


def _mended(
    compared: PartChoice, to_ends: SingleArray, cheapest: PlacedPart, placed: list[PlacedPart]
) -> tuple[PlacedPart, list[PlacedPart]]:
    """The cheapest place or one the other way up, limbs moved, and all that were tried."""
    count = compared.given.turned
    turned = turned_places(compared, compared.different(placed, count))
    best, tried = with_limbs_moved(compared, to_ends, cheapest)
    tried += turned
    for start in compared.different(turned, count):
        place, moved = with_limbs_moved(compared, to_ends, start)
        tried += moved
        if place.cost * compared.given.shortcut_reason < best.cost:
            best = place
    return best, tried


def _is_clear(problem: MatchProblem, decision: Decision) -> bool:
    given = problem.parameters
    return decision.margin >= given.grown_margin and decision.best.hks_agreement >= given.grown_clear


def _contender(way: MatchProblem, problem: MatchProblem, place: PlacedPart) -> Contender:
    """A place between the vertices of both shapes, from X to Y, with what it costs there."""
    try:
        dense = register(way, place.map.p2p, Schedule.of(way, way.parameters.coarse_to_fine))
    finally:
        way.x.arap.release()
    return measured(problem, dense if way is problem else turned_round(problem, dense), place.number)
