"""Correspondence of two shapes one of which is a part of the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, PartialOption
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.maps.functional_map import functional_map
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.partial.distance_bounds import violations
from qgeo_filters.matching.partial.overlap import Overlap, in_faces_of, overlap
from qgeo_filters.matching.partial.part_choice import PartDecision
from qgeo_filters.matching.partial.part_pair import PartPair
from qgeo_filters.matching.partial.part_registration import PartMap
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.matching.partial.part_sizes import decided
from qgeo_filters.matching.partial.part_verdict import part_verdict
from qgeo_filters.matching.partial.partial_parameters import PartialParameters
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.verdict import with_hints, with_sides
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen


def partial_match(
    problem: MatchProblem, *, normalize: bool = False, given: PartialParameters | None = None
) -> MatchResult:
    """Map from X to Y where one is a part of the other: with a rim where it was cut, and of smaller area.

    Parameters
    ----------
    problem : MatchProblem
        Shapes in one unit of length; its hints steer the search.
    normalize : bool
        Whether the part may be of another size, up to about a quarter smaller or larger: several are tried.
    given : PartialParameters, optional

    Returns
    -------
    MatchResult
        On the repaired shapes (``full``). ``p2p`` and ``inverse`` are -1 where there is no partner; `distortion` is
        how far distances lie outside the bounds that the cut leaves, see `distance_bounds`; the functional map is that
        of the first eigenfunctions of the Laplacian; ``c_xy`` is NaN, since the distances of a part and of the whole
        have no eigenfunctions in common.

    Raises
    ------
    ParameterError
        Neither shape can be a part of the other by its rim and area.
    """
    chosen = PartialParameters() if given is None else given
    x_is_part = part_is_x(problem.x.full, problem.y.full)
    part, whole = (problem.x, problem.y) if x_is_part else (problem.y, problem.x)
    pair = PartPair.of(part, whole, chosen, problem.hints, 0 if x_is_part else 1)
    pair, decision = decided(pair, problem.log, normalize)
    return _described(problem, pair, decision, x_is_part)


def matched_as_part(x: Surface, y: Surface, partial: PartialOption, normalize: bool) -> bool:
    """Whether one shape is matched as a part of the other from the start.

    As was said, or, by "auto", if sizes count and say so: the shape with a rim has clearly less area.
    """
    if partial != "auto":
        return partial
    share = x.area / y.area
    if normalize or max(share, 1 / share) <= MatchingParameters.same_area:
        return False
    return bool(len((x if share < 1 else y).boundary_vertices))


def better_as_part(problem: MatchProblem, found: MatchResult, given: PartialParameters | None = None) -> MatchResult:
    """The match of the whole shapes, or that of a part if only that one can be trusted.

    Tried where the former is not sure, and one shape has a rim and clearly less area in one unit of length.
    """
    chosen = PartialParameters() if given is None else given
    if found.confident or not may_be_part(problem.x.full, problem.y.full, chosen):
        return found
    partial = partial_match(replace(problem, log=MatchLog()), given=chosen)
    return partial if partial.confident else found


def may_be_part(x: Surface, y: Surface, given: PartialParameters | None = None) -> bool:
    """Whether the smaller shape has a rim and clearly less area, so that "auto" may take it for a part."""
    chosen = PartialParameters() if given is None else given
    share = x.area / y.area
    small = x if share <= 1 else y
    return min(share, 1 / share) <= chosen.most_area and len(small.boundary_vertices) > 0


def part_is_x(x: Surface, y: Surface) -> bool:
    """Whether X is the part and Y the whole; False if it is the other way round.

    Raises
    ------
    ParameterError
        Neither has a rim, or the one that has is the larger.
    """
    share = x.area / y.area
    rims = len(x.boundary_vertices) > 0, len(y.boundary_vertices) > 0
    if share <= 1 and rims[0]:
        return True
    if share >= 1 and rims[1]:
        return False
    if not any(rims):
        raise ParameterError(
            "neither X nor Y has a boundary where it could have been cut: match them with partial=False"
        )
    name, other, ratio = ("X", "Y", share) if rims[0] else ("Y", "X", 1 / share)
    raise ParameterError(
        f"{name} has the boundary, but {ratio:.3g} times the area of {other}: no part of it. Are they in one unit of "
        "length?"
    )


def _described(problem: MatchProblem, pair: PartPair, decision: PartDecision, x_is_part: bool) -> MatchResult:
    part, whole, best = pair.part, pair.whole, decision.best
    found = overlap(part, whole, best.map)
    distortion = part.proxy.pulled_back(_distortion(part, whole, best.map.p2p))
    score = float(part.full.vertex_areas @ distortion) / part.full.area
    located = pair.known is not None and len(pair.known.to_x) >= problem.parameters.hints_that_locate
    name = "X" if x_is_part else "Y"
    confident, explanation = part_verdict(part.given, name, part.area, found, decision, score, located)
    problem = problem.with_known(pair.known)
    confident, explanation = with_hints(problem, best.map.p2p, decision.unhinted, confident, explanation)
    sides = {"X": problem.x.winding, "Y": problem.y.winding}
    confident, explanation = with_sides(sides, confident, explanation)
    regions = _regions(whole, found)
    on_whole = in_faces_of(found.on_whole, (problem.y if x_is_part else problem.x).full)
    on_part = in_faces_of(found.on_part, (problem.x if x_is_part else problem.y).full)
    to_whole, to_part = on_whole.nearest_corner, on_part.nearest_corner
    k = min(20, part.laplacian.shape[1], whole.laplacian.shape[1])
    low_part, low_whole = part.laplacian[:, :k].astype(np.float64), whole.laplacian[:, :k].astype(np.float64)
    if x_is_part:
        functional = functional_map(low_part, low_whole, best.map.p2p, part.areas)
        distortion = np.where(to_whole >= 0, distortion, np.nan)
        positions = found.positions
    else:
        functional = functional_map(low_whole, low_part, best.map.back, whole.areas)
        distortion = on_part.pulled_back(distortion)
        positions = on_part.pulled_back(part.full.vertices)
    return MatchResult(
        x=problem.x.full,
        y=problem.y.full,
        p2p=frozen(to_whole if x_is_part else to_part),
        inverse=frozen(to_part if x_is_part else to_whole),
        functional_map=frozen(functional),
        c_xy=float("nan"),
        distortion=frozen(distortion),
        score=score,
        runner_up=decision.runner_up,
        margin=decision.margin,
        orientation=best.orientation,
        hks_agreement=best.agreement,
        confident=confident,
        explanation=explanation,
        regions_x=frozen(_on_part(regions, to_whole) if x_is_part else regions),
        regions_y=frozen(regions if x_is_part else _on_part(regions, to_whole)),
        positions=frozen(positions),
        barycentric=on_whole if x_is_part else on_part,
        log=problem.log,
        overlap_x=found.share_of_part if x_is_part else found.share_of_whole,
        overlap_y=found.share_of_whole if x_is_part else found.share_of_part,
        landmark_errors=frozen(_landmark_errors(pair, best.map, x_is_part)),
    )


def _landmark_errors(pair: PartPair, found: PartMap, x_is_part: bool) -> FloatArray:
    """Distance (k,) on Y between the image of each landmark and its partner, in sqrt(area of Y)."""
    if pair.known is None:
        return np.zeros(0)
    if x_is_part:
        return pair.known.landmark_errors(found.p2p)
    return pair.known.swapped().landmark_errors(found.back) / np.sqrt(pair.part.area)


def _distortion(part: PartShape, whole: PartShape, p2p: npt.NDArray[np.int64]) -> FloatArray:
    """How far the distances of each vertex of the part lie outside their bounds, in the mean, (n,)."""
    points = part.fps[: part.given.coarse_points]
    most = part.rows[: len(points)].T
    least = np.minimum(most, part.rim[:, None] + part.rim[points])
    place = whole.rows[:, p2p[points]].argmin(axis=0)
    return violations(least, most, whole.rows[place][:, p2p].T).mean(axis=1, dtype=np.float64)


def _regions(whole: PartShape, found: Overlap) -> npt.NDArray[np.int32]:
    """Region of each vertex of the whole, that of the nearest of its first farthest points; -1 without partner."""
    near = whole.rows[:12].argmin(axis=0)
    label = near[whole.proxy.nearest_corner]
    return np.where(found.on_part.faces >= 0, label, -1).astype(np.int32)


def _on_part(regions: npt.NDArray[np.int32], images: npt.NDArray[np.int64]) -> npt.NDArray[np.int32]:
    return np.where(images >= 0, regions[images], -1).astype(np.int32)
