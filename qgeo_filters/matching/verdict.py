"""Whether a map can be trusted, and why, in a sentence."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from qgeo_filters._typing import IndexArray, MirrorOption
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.search import Found
from qgeo_filters.repair.winding import Winding


def verdict(
    given: MatchingParameters,
    score: float,
    turned: float,
    alike: float,
    margin: float,
    contrary: float = np.inf,
    grown: bool = False,
) -> tuple[bool, str]:
    """Whether a map is sure, and why.

    Parameters
    ----------
    score : float
        Its distortion.
    turned : float
        Its orientation.
    alike : float
        Agreement of heat kernels.
    margin, contrary : float
        See `Decision`.
    grown : bool
        Whether one shape has handles that the other lacks.
    """
    if score > given.near_isometric:
        return False, f"distances differ by {score:.3f} sqrt(area) in the mean: the shapes are not near-isometric"
    if abs(turned) < given.settled_orientation:
        return False, f"the map turns much of the surface over (orientation {turned:.2f}): parts may be mirrored"
    if alike < _least_alike(given, margin, grown):
        return False, (
            f"distances are kept to {score:.3f} sqrt(area) in the mean, but the map relates parts of different shape "
            f"(their heat kernels agree by {alike:.2f} only)"
        )
    poses = given.poses_isometric if alike >= given.poses_alike else given.hardly_isometric
    if score > poses and margin < given.hardly_isometric_margin:
        return False, (
            f"distances differ by {score:.3f} sqrt(area) in the mean, and another map costs only {margin:.2f} times as "
            "much: of shapes that are hardly isometric it may be the right one"
        )
    if margin < given.margin:
        return False, (
            f"another map fits nearly as well (its cost is {margin:.2f} times as large): "
            "the shape looks alike in more than one way"
        )
    if contrary < given.contrary_margin:
        return False, (
            f"another map costs only {contrary:.2f} times as much, and what bulges and what is hollow agrees better "
            "along it: this one may have the front where the back should be"
        )
    rival = f"the next different map costs {margin:.1f} times as much" if margin < np.inf else "there is no other map"
    return True, f"distances are kept to {score:.3f} sqrt(area) in the mean; {rival}"


def _least_alike(given: MatchingParameters, margin: float, grown: bool) -> float:
    """How well heat kernels must agree along a map of this margin."""
    if grown:
        return given.grown_alike
    return given.clear_alike if given.clear_margin <= margin < np.inf else given.match_alike


def with_hand(
    problem: MatchProblem, choice: Found, mirror: MirrorOption, confident: bool, explanation: str
) -> tuple[bool, str]:
    """The verdict once it is known how clear it is whether Y is matched as a mirror image of X."""
    if mirror == "yes":
        return confident, f"{explanation}; Y is matched as a mirror image of X, as was asked for"
    clear = choice.other_hand >= problem.parameters.clear_hand
    if choice.mirrored and problem.known:  # they chose it, and may be mistaken
        return False, f"{explanation}; Y is matched as a mirror image of X, as the hints have it: mirror='yes' says so"
    if choice.mirrored:
        other = f"the best map that keeps the orientation is {choice.other_hand:.1f} times as bad"
        if not clear:
            other = "but it is not clear that none which keeps the orientation is as good"
        return confident and clear, f"{explanation}; Y is matched as a mirror image of X: {other}"
    if confident and not clear:
        return False, (
            f"{explanation}; but Y may be the mirror image of X: the best map onto that costs "
            f"{choice.other_hand:.2f} times as much"
        )
    return confident, explanation


def with_hints(
    problem: MatchProblem, p2p: IndexArray, unhinted: float, confident: bool, explanation: str
) -> tuple[bool, str]:
    """The verdict once it is known what the map (n_x,) does to the hints, and what they did to the choice.

    Parameters
    ----------
    unhinted : float
        See `Decision`.
    """
    known, hints = problem.known, problem.hints
    if known is None or hints is None:
        return confident, explanation
    contradicted, k = known.contradicted(p2p), len(known.landmarks)
    errors, surroundings = known.landmark_errors(p2p), known.errors(np.arange(len(p2p)), p2p)
    others = "the rest" if contradicted.sum() < len(contradicted) else "the shapes"
    said = []
    for i in np.flatnonzero(contradicted[:k]):
        a, b = hints.landmarks[i]
        said.append(
            f"landmark {i} (vertex {a} of X, vertex {b} of Y) contradicts {others}: it is "
            f"{max(errors[i], surroundings[i]):.2f} sqrt(area) from where the map takes it"
        )
    for i in np.flatnonzero(contradicted[k:]):
        said.append(
            f"label {known.labels[i]} contradicts {others}: its part is {surroundings[k + i]:.2f} sqrt(area) from "
            "where the map takes it"
        )
    if unhinted * problem.parameters.margin < 1:
        said.append(f"without the hints another map would have been chosen, which costs {unhinted:.2f} times as much")
    if not said:
        return confident, f"{explanation}; it agrees with the hints"
    return False, "; ".join([*said, explanation])


def with_sides(winding: Mapping[str, Winding], confident: bool, explanation: str) -> tuple[bool, str]:
    """The verdict once it is known which side of each shape is out: what tells left from right."""
    flat = " and ".join(name for name, side in winding.items() if side == "undetermined")
    if confident and flat:
        confident = False
        explanation += (
            f"; but which side of {flat} is out cannot be told, an open sheet: the map may be the mirrored one"
        )
    inside_out = " and ".join(name for name, side in winding.items() if side == "inward")
    if inside_out:
        explanation += f"; {inside_out} had the inside out, which was turned over for the match"
    return confident, explanation
