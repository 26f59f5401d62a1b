"""The search between coarse shapes: quickly first, then with everything, in one handedness or in both."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from qgeo_filters._typing import IndexArray, MirrorOption
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.initialization.candidates import Candidate, candidates, mapped_points, mirrored_map
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.selection.decision import Decision, choose_map
from qgeo_filters.matching.symmetry import reflection_of


@dataclass(frozen=True, eq=False)
class Found:
    """The best map between the coarse shapes.

    Attributes
    ----------
    decision : Decision
    mirrored : bool
        Whether it is one onto the mirror image of Y: it reverses the orientation.
    other_hand : float
        How many times as bad the best map of the other handedness is, whatever is known of the map; inf where only one
        was asked for or comes into question.
    """

    decision: Decision
    mirrored: bool
    other_hand: float = np.inf


def checked_mirror(mirror: str) -> None:
    """Raise `ParameterError` for what is none of the options."""
    if mirror not in ("no", "yes", "auto"):
        raise ParameterError(f"mirror must be 'no', 'yes' or 'auto', got {mirror!r}")


def chosen_map(problem: MatchProblem, mirror: MirrorOption = "auto") -> Found:
    """The best map between the coarse shapes.

    Where one has grown together, hints may lead the search astray: what is found without them competes.
    """
    found = searched(problem, mirror)
    if problem.known is None or not problem.more_handles:
        return found
    return _cheaper_for_hints(problem, found, searched(problem.with_known(None), mirror))


def _cheaper_for_hints(problem: MatchProblem, found: Found, other: Found) -> Found:
    """What was found, or what was without the hints, if that costs less with what it does to them."""
    x, best, rival = problem.x, found.decision.best, other.decision.best
    penalty = float(problem.penalties(x.fps, rival.dense.p2p[x.fps])) ** 2
    rival = replace(rival, cost=penalty * rival.cost, end_cost=penalty * rival.end_cost, penalty=penalty)
    if rival.end_cost >= best.end_cost:
        problem.log.choose(best.number)
        return found
    problem.log.choose(rival.number)
    margin = min(other.decision.margin, best.end_cost / rival.end_cost)
    return replace(other, decision=replace(other.decision, best=rival, margin=margin))


def searched(problem: MatchProblem, mirror: MirrorOption) -> Found:
    """The best map that one search finds.

    A quick search first; where it leaves any doubt, or one shape has more handles, all that there is. Shapes of which
    neither has a left and a right are matched both ways, since one may be the mirror image of the other.
    """
    asked = problem.with_mirrored_y() if mirror == "yes" else problem
    # Hints may contradict what seems clear, and where something has grown together distances mislead.
    if problem.parameters.quick and problem.known is None and not problem.more_handles:
        attempt = _first_attempt(asked, either=mirror == "auto")
        if attempt is not None:
            return Found(attempt, mirror == "yes")
    if mirror != "auto":
        keeping, reversing = _by_orientation(candidates(asked))
        twins = _twins(asked, reversing)
        if keeping or twins:
            _dropped(asked.log, reversing, "keeps the orientation" if mirror == "yes" else "reverses the orientation")
        # Without any that has the right hand, what comes nearest to it: the result will not be sure.
        pool = keeping + (twins or []) or [max(reversing, key=lambda c: c.orientation)]
        return Found(choose_map(asked, pool), mirror == "yes")
    keeping, reversing, apart = competing_candidates(problem)
    if not reversing:
        return Found(choose_map(problem, keeping), False)
    turned = problem.with_mirrored_y()
    if not keeping:
        return Found(choose_map(turned, reversing), True, apart)
    straight = choose_map(problem, keeping)
    first = problem.log.chosen
    opposite = choose_map(turned, reversing)
    ratio = opposite.best.end_cost / straight.best.end_cost
    # What is left and what is right is a matter of how the mesh is written: to turn it over needs a reason.
    if ratio * problem.parameters.mirror_image_cost < 1:
        return Found(opposite, True, straight.best.unhinted_cost / opposite.best.unhinted_cost)
    if first is not None:
        problem.log.choose(first.number)
    return Found(straight, False, opposite.best.unhinted_cost / straight.best.unhinted_cost)


def competing_candidates(problem: MatchProblem) -> tuple[list[Candidate], list[Candidate], float]:
    """Maps that keep the orientation, and those that reverse it; one list is empty if those cannot compete.

    And how many times as much as the latter the former distort distances.
    """
    given, log = problem.parameters, problem.log
    keeping, reversing = _by_orientation(candidates(problem))
    twins = _twins(problem, reversing)
    keeping += twins or []
    if not reversing:
        return keeping, reversing, np.inf
    if not keeping:  # none was proposed: that does not say that none is as good
        keeping = _rough_twins(problem, reversing)
        # What nearly has a left and a right, such as a wolf without a leg, may have lost the other one.
        if keeping and min(c.mean_distortion for c in keeping) < given.nearly_symmetric:
            keeping = _dropped(log, keeping, "nearly keeps distances: the shape may be in its own hand")
    if not keeping:
        return keeping, reversing, 1.0
    least = [max(min(c.mean_distortion for c in some), given.least_distortion) for some in (keeping, reversing)]
    apart = least[0] / least[1]
    ratio = min(c.rank for c in reversing) / max(min(c.rank for c in keeping), given.least_distortion)
    if ratio < given.mirror_image_ratio and (twins is None or problem.known):
        # Y is the mirror image of something asymmetric, or of what the hints say. What has a left and a right is in the
        # pose that X has in a mirror.
        return _dropped(log, keeping, "keeps the orientation, but not distances"), reversing, apart
    if twins is not None or ratio * given.mirror_image_ratio > 1:
        return keeping, _dropped(log, reversing, "reverses the orientation"), apart
    return keeping, reversing, apart


def _first_attempt(problem: MatchProblem, *, either: bool) -> Decision | None:
    """The best map that a quick search finds, unless there is any doubt.

    Parameters
    ----------
    either : bool
        Whether a map of the other handedness would do.
    """
    given = problem.parameters
    quick = replace(problem, parameters=given.first_attempt(), log=MatchLog())
    keeping, reversing = _by_orientation(candidates(quick))
    _dropped(quick.log, reversing, "reverses the orientation")
    if not keeping:
        return None
    least = min(c.rank for c in keeping)
    if reversing and min(c.rank for c in reversing) < given.quick_twins * least:
        keeping += _rough_twins(quick, reversing)
        least = min(c.rank for c in keeping)
    if either and reversing and min(c.rank for c in reversing) < given.quick_other_hand * least:
        return None
    decision = choose_map(quick, keeping)
    clear = (
        decision.margin >= given.quick_margin
        and decision.best.mean_distortion <= given.quick_distortion
        and decision.best.hks_agreement >= given.quick_alike
        and decision.best.relief_agreement >= given.quick_relief
    )
    if not clear:
        return None
    problem.log.maps.extend(quick.log.maps)
    return decision


def _by_orientation(proposed: list[Candidate]) -> tuple[list[Candidate], list[Candidate]]:
    """Those that keep the orientation, and the others."""
    return [c for c in proposed if c.orientation > 0], [c for c in proposed if c.orientation <= 0]


def _twins(problem: MatchProblem, reversing: list[Candidate]) -> list[Candidate] | None:
    """The mirrored maps of those that reverse the orientation; None for shapes without a left and a right."""
    if not reversing:
        return None
    x, y, given = problem.x, problem.y, problem.parameters
    mirror = reflection_of(y, given)
    other = reflection_of(x, given) if mirror is None else mirror
    if other is None:
        return None
    return [mirrored_map(problem, c, other, of_y=mirror is not None) for c in reversing]


def _rough_twins(problem: MatchProblem, reversing: list[Candidate]) -> list[Candidate]:
    """The mirrored maps of the best that reverse the orientation, by what may be reflections of Y."""
    best = sorted(reversing, key=lambda c: c.rank)[: problem.parameters.quick_twinned]
    mirrors = rough_reflections(problem.y, problem.parameters)
    twins = [mirrored_map(problem, c, mirror, of_y=True) for mirror in mirrors for c in best]
    return sorted(twins, key=lambda c: c.rank)[: problem.parameters.quick_twinned]


def rough_reflections(shape: PreparedShape, parameters: MatchingParameters) -> list[IndexArray]:
    """The candidates for a reflection of a shape that keep distances best, not registered: vertex of each, (n,)."""
    kept = shape.rough_reflections
    if parameters not in kept:
        problem = MatchProblem.of_reflection(shape, parameters)
        points = mapped_points(problem)
        nearest = shape.fps_distances[: len(points)].argmin(axis=0)
        proposed = [c for c in candidates(problem) if c.orientation > 0][: parameters.quick_twinned]
        kept[parameters] = [c.p2p[nearest] for c in proposed]
    return kept[parameters]


def _dropped(log: MatchLog, maps: list[Candidate], why: str) -> list[Candidate]:
    """None of them, once the log says why."""
    for c in maps:
        log.drop(c.number, why)
    return []
