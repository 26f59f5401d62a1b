"""Whether the place of a part can be trusted, and why, in a sentence."""

from __future__ import annotations

import numpy as np

from qgeo_filters.matching.partial.overlap import Overlap
from qgeo_filters.matching.partial.part_choice import PartDecision
from qgeo_filters.matching.partial.partial_parameters import PartialParameters


def part_verdict(
    given: PartialParameters,
    name: str,
    area: float,
    found: Overlap,
    decision: PartDecision,
    score: float,
    located: bool = False,
) -> tuple[bool, str]:
    """Whether a place is sure, and why.

    Parameters
    ----------
    name : str
        Of the shape that is the part.
    area : float
        Its share of the whole's.
    score : float
        How far distances lie outside the bounds that the cut leaves, in the mean.
    located : bool
        Whether so much is known of the place that a small part cannot lie anywhere else.
    """
    best = decision.best
    whole = "Y" if name == "X" else "X"
    what = f"{name} as a part of {whole} ({100 * area:.0f} % of its area)"
    if area < given.least_area and not located:
        return False, f"{what} is too small to tell where it belongs: parts of at least {given.least_area:.0%} can be"
    if score > given.near_isometric:
        return False, f"{what}: distances differ by {score:.3f} sqrt(area) more than a cut explains"
    if best.orientation < given.settled_orientation:
        return False, (
            f"{what}: the map turns much of the surface over (orientation {best.orientation:.2f}); parts may be "
            "mirrored"
        )
    if best.folded > given.settled_folded or best.strain > given.settled_strain:
        return False, (
            f"{what} must be stretched or folded to lie there (strain {best.strain:.2f}, folded "
            f"{100 * best.folded:.1f} %)"
        )
    if best.unlikeness > given.settled_unlikeness:
        return False, (
            f"{what} would lie among surroundings that are not like its own (they differ by {best.unlikeness:.3f}, "
            f"right ones by less than {given.settled_unlikeness:g})"
        )
    if decision.margin < given.margin:
        return False, (
            f"{what} fits nearly as well elsewhere (at {decision.margin:.2f} times the cost): the shape looks alike in "
            "more than one place"
        )
    if found.share_of_part < given.least_overlap:
        return False, f"only {100 * found.share_of_part:.0f} % of {name} came to lie on {whole}"
    rival = (
        f"the next different place costs {decision.margin:.1f} times as much"
        if np.isfinite(decision.margin)
        else "there is no other place"
    )
    return True, f"{what}: distances agree to {score:.3f} sqrt(area) with what a cut leaves of them; {rival}"
