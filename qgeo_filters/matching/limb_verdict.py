"""Whether a map leaves a limb of Y bare and lays two of X on another one: a tail that has slipped onto a leg."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.initialization.limb_maps import LimbEnds
from qgeo_filters.matching.problem import MatchProblem


def with_limbs(
    problem: MatchProblem, p2p: IndexArray, alike: float, confident: bool, explanation: str
) -> tuple[bool, str]:
    """The verdict once it is known where limbs of X end.

    In poses of one shape a crossed arm may have an end of its own: of 384 right maps of TOSCA 19 would be doubted.

    Parameters
    ----------
    problem : MatchProblem
    p2p : (n_x,) int
        Between the shapes as they were searched.
    alike : float
        Agreement of heat kernels: nothing is asked where that is as in poses of one shape.
    confident, explanation
        The verdict before.
    """
    given = problem.parameters
    if not confident or alike >= given.poses_alike:
        return confident, explanation
    # Which end is the mirror image of which does not matter here.
    of_x, of_y = (LimbEnds.of(s, np.arange(s.n_vertices), given) for s in (problem.x, problem.y))
    apart = of_y.distances[:, p2p[of_x.vertices]]
    if not apart.size:
        return confident, explanation
    doubled = (apart < given.limb_end_mirrored).sum(axis=1) > 1
    bare = apart.min(axis=1) > given.limb_ends_apart
    if not (doubled.any() and bare.any()):
        return confident, explanation
    return False, f"{explanation}; but two limbs of X end on one of Y, and one of Y has none"
