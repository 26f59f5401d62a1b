"""The search for a reflection of a coarse shape."""

from __future__ import annotations

from qgeo_filters.matching.initialization.candidates import Candidate, candidates
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.selection.decision import Decision, choose_reflection


def chosen_reflection(problem: MatchProblem) -> Decision | None:
    """The best of all maps of the shape to its mirror image that were proposed; None if none was."""
    proposed = candidates(problem)
    for c in proposed:
        if c.orientation <= 0:
            problem.log.drop(c.number, "keeps the orientation of the shape: no reflection")
    reflections: list[Candidate] = [c for c in proposed if c.orientation > 0]
    return choose_reflection(problem, reflections) if reflections else None


def is_doubtful(problem: MatchProblem, decision: Decision | None) -> bool:
    """Whether a finer look may find a symmetry, or another one: distances are nearly kept, but not the surroundings."""
    given = problem.parameters
    if decision is None:
        return False
    nearly = decision.best.mean_distortion <= given.doubtful_reflection_distortion
    return nearly and decision.best.hks_agreement < given.doubtful_reflection_alike
