"""Whether a map leaves a limb of Y bare and lays two of X on another one: a tail that has slipped onto a leg."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.initialization.limb_maps import LimbEnds
from qgeo_filters.matching.problem import MatchProblem


def with_limbs(problem: MatchProblem, p2p: IndexArray, confident: bool, explanation: str) -> tuple[bool, str]:
    """The verdict once it is known where limbs of X end.

    Parameters
    ----------
    problem : MatchProblem
    p2p : (n_x,) int
        Between the shapes as they were searched.
    confident, explanation
        The verdict before.
    """
    given = problem.parameters
    # Which end is the mirror image of which does not matter here.
    of_x, of_y = (LimbEnds.of(s, np.arange(s.n_vertices), given) for s in (problem.x, problem.y))
    apart = of_y.distances[:, p2p[of_x.vertices]]
    if not confident or not apart.size:
        return confident, explanation
    doubled = (apart < given.limb_end_mirrored).sum(axis=1) > 1
    bare = apart.min(axis=1) > given.limb_ends_apart
    if not (doubled.any() and bare.any()):
        return confident, explanation
    return False, f"{explanation}; but two limbs of X end on one of Y, and one of Y has none"
