"""Reflections that are another one with limbs left in place."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.matching.maps.map_distance import landmark_lower_bound
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.selection.cost import Contender


def without_fixed_limbs(problem: MatchProblem, ranked: list[Contender]) -> list[Contender]:
    """Those contenders for a reflection of X that may be one, in the same order."""
    given, log = problem.parameters, problem.log
    alike = [c for c in ranked if c.hks_agreement > given.reflection_alike] or ranked
    for c in ranked:
        if not any(c is a for a in alike):
            log.drop(
                c.number, f"relates parts as unlike as front and back (heat kernels agree by {c.hks_agreement:.2f})"
            )

    def rival_of(c: Contender) -> Contender | None:
        """Contender that exchanges limbs which c leaves in place."""
        for other in alike:
            if other is c or other.cost >= given.fixed_limbs_cost * c.cost:
                continue
            if other.hks_agreement > given.fixed_limbs_alike and leaves_limbs(problem, c.dense.p2p, other.dense.p2p):
                return other
        return None

    rivals = [rival_of(c) for c in alike]
    kept = [c for c, rival in zip(alike, rivals, strict=True) if rival is None]
    for c, rival in zip(alike, rivals, strict=True):
        if rival is not None and kept:
            log.drop(c.number, f"is #{rival.number} but for limbs that it leaves in place")
    return kept or alike


def leaves_limbs(problem: MatchProblem, one: IndexArray, other: IndexArray) -> bool:
    """Whether map ``one`` (n,) of a shape to itself is ``other``, but for limbs that it mirrors into themselves.

    Such a map is continuous, reverses the orientation and is an involution, too: it is the other one followed by a half
    turn of the surface between the two limbs, which exchanges them. And since a limb keeps its pose where it is, but
    two limbs seldom have the same, it may well distort distances less than the true reflection does.
    """
    x, given = problem.x, problem.parameters
    here = np.arange(x.n_vertices)
    limbs = landmark_lower_bound(x, one, other) > given.limb_different
    weight = x.areas * limbs
    total = float(weight.sum())
    if total < given.limb_area:
        return False
    stays, goes = (float(weight @ landmark_lower_bound(x, here, p2p)) / total for p2p in (one, other))
    exchanged = float(weight @ limbs[other]) > given.limb_exchanged * total
    return stays < given.limb_stays and goes > given.limb_goes and exchanged
