"""Correspondence of two shapes with no initial map."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, overload

import numpy as np
from tqdm.auto import tqdm

from qgeo_filters._typing import MirrorOption, PartialOption, RepairOption
from qgeo_filters.errors import ParameterError, concerning
from qgeo_filters.matching.finish import at_full_resolution, finished
from qgeo_filters.matching.given_vertices import match_on_given
from qgeo_filters.matching.hints import LabelPair, LandmarkPairs
from qgeo_filters.matching.limb_matching import with_limbs_matched
from qgeo_filters.matching.limb_verdict import with_limbs
from qgeo_filters.matching.maps.barycentric import barycentric_map
from qgeo_filters.matching.maps.functional_map import functional_map
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_filters.matching.maps.point_distortion import point_distortions
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.matchable import check_same_size
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.partial.partial_match import better_as_part, matched_as_part, partial_match
from qgeo_filters.matching.prepared_shape import Shape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.regions import eigenfunction_regions
from qgeo_filters.matching.search import Found, checked_mirror, chosen_map
from qgeo_filters.matching.selection.signatures import hks_agreement
from qgeo_filters.matching.smooth_shells import DenseMap
from qgeo_filters.matching.topological_noise import robust_to_shortcuts
from qgeo_filters.matching.verdict import verdict, with_hand, with_hints, with_sides
from qgeo_filters.parallel import concurrently, default_workers, report_progress, single_threaded_blas
from qgeo_filters.spectral.commutative import commutative_eigenspectra
from qgeo_filters.validation import frozen

_STAGES = 3  # prepare, search, register


@overload
def match(
    x: Shape,
    y: Shape,
    *,
    normalize: bool = True,
    repair: RepairOption = "auto",
    partial: PartialOption = "auto",
    mirror: MirrorOption = "auto",
    landmarks: LandmarkPairs | None = None,
    labels: LabelPair | None = None,
    parameters: MatchingParameters | None = None,
    log: Literal[False] = False,
    workers: int | None = None,
    progress: bool = False,
) -> MatchResult: ...
@overload
def match(
    x: Shape,
    y: Shape,
    *,
    normalize: bool = True,
    repair: RepairOption = "auto",
    partial: PartialOption = "auto",
    mirror: MirrorOption = "auto",
    landmarks: LandmarkPairs | None = None,
    labels: LabelPair | None = None,
    parameters: MatchingParameters | None = None,
    log: Literal[True],
    workers: int | None = None,
    progress: bool = False,
) -> tuple[MatchResult, MatchLog]: ...
def match(
    x: Shape,
    y: Shape,
    *,
    normalize: bool = True,
    repair: RepairOption = "auto",
    partial: PartialOption = "auto",
    mirror: MirrorOption = "auto",
    landmarks: LandmarkPairs | None = None,
    labels: LabelPair | None = None,
    parameters: MatchingParameters | None = None,
    log: bool = False,
    workers: int | None = None,
    progress: bool = False,
) -> MatchResult | tuple[MatchResult, MatchLog]:
    """Correspondence between two shapes that bend into each other, with no initial map.

    Parameters
    ----------
    x, y : Surface, whatever `as_surface` takes, or PreparedShape
        Any triangulation, position and number of vertices, faces outwards or inwards. Pass
        prepared shapes where a shape takes part in several matches: all that belongs to one shape is computed once.
    normalize : bool
        Whether to compare shapes regardless of size. If not, and their areas differ by more than a tenth, they are
        refused, or one is matched as a part. A part may be up to about a quarter smaller or larger than it should be;
        where sizes are right, say so with False: that is quicker, and surer.
    repair : bool, "auto", "force" or "wrap"
        Whether shapes are made manifold, oriented and one piece first: by default, "auto", those that are not (see
        `surface_and_repair`); the result says in ``repairs`` what was changed. It is on the vertices that were given,
        -1 and NaN where one had to go, see `match_on_given`. With False such shapes are refused. With "wrap" closed
        surfaces around them are matched, for raw CT and models in many pieces that are refused otherwise, see
        `wrap_surface`.
    partial : bool, "auto"
        Whether one shape is matched as a part of the other: a scan from one side, a body without a limb or half of it.
        Then ``p2p`` and ``inverse`` are -1 where there is no partner, and ``overlap_x`` and ``overlap_y`` say how much
        has one; see `partial_match`. By default, "auto", so it is where one shape has a boundary and less area than the
        other and sizes count (``normalize=False``), or else if the match of the whole shapes is not sure, and that of
        the part is.
    mirror : {"auto", "no", "yes"}
        Whether the map may reverse the orientation, as that of a left bone onto a right one must. By default, "auto",
        it may where neither shape has a left and a right of its own and the best such map is clearly better; where one
        has, a map in the right hand is as good. "yes" finds a reversing map in any case, "no" never.
    landmarks : sequence of (int, int), pair of (k, 3) arrays, or pair of Landmarks, optional
        What is known: pairs (vertex of X, vertex of Y), or points on X and those on Y that they belong to, or
        landmarks of equal names; to within a few edges. Even a single one steers the search. One on a vertex that a
        repair removes counts for what is left near it, and is refused where nothing is. Which of them the map
        contradicts is said in ``explanation``.
    labels : pair of array-like of int, shapes (n_x,) and (n_y,), optional
        Vertices of X and of Y with equal numbers lie in the same part; negative where that is not known.
    parameters : MatchingParameters, optional
        What the match goes by; that of the prepared shapes, or the measured default.
    log : bool
        Whether to return, beside the result, every map that was proposed: by whom, its distortion and orientation,
        each term of its cost, and which rule dropped it.
    workers : int, optional
        Threads; all cores that the process may use by default. The result does not depend on it.
    progress : bool
        Whether to show progress bars: one over the stages, and one over the distances of a shape.

    Returns
    -------
    MatchResult, or (MatchResult, MatchLog) with ``log=True``

    Raises
    ------
    MeshError
        See `PreparedShape`.
    ParameterError
        Shapes of different size with ``normalize=False``; shapes neither of which can be a part of the other with
        ``partial=True``; shapes prepared with different parameters; hints that cannot be, see `Hints.of`.

    Notes
    -----
    Maps are sought between proxies of 2000 vertices, registered to the end at 4000 at most, and carried to all
    vertices. A quick search with one metric comes first; the following is what is done where it leaves any doubt
    (`MatchingParameters`).

    Coarse maps come from all choices of signs of the first eigenfunctions of the distances, in several metrics
    (`sign_search`), grown by spectral upsampling, ranked by how much they distort distances and how unlike the parts
    are that they relate. A shape with a left and a right has a mirrored map for every good one, which keeps distances
    as well: that of each map that turns the surface inside out is made by the self-symmetry, and only maps that keep
    the orientation compete. Shapes of which neither has one are searched in both hands (``mirror``). The best is the
    one along which X deforms with the least strain, tearing and folding onto parts that are alike (`choose_map`),
    registered to the end (`finished`). The result does not depend on the signs and order that a solver returns, nor on
    position and size.

    Where distances are hardly kept, the ends of limbs are matched in all ways that go with the symmetries of both
    shapes, unless the map is clear (`with_limbs_matched`).

    Where one shape has handles that the other lacks, it has grown together where it touches itself: unless the map is
    clear, the other one is placed on it by distances that may only be shorter there (`robust_to_shortcuts`).

    Hints propose maps of their own, make maps dearer that disagree with them at each choice, and are felt by the
    registration near them (`KnownParts`). They may say that Y is a mirror image. The map is not confident if it
    contradicts one of them, or if without them another map would clearly have been chosen.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> y = x.with_vertices(2 * x.vertices + [5, 0, 0])  # as large again, and elsewhere
    >>> found = qg.match(x, y)
    >>> found.confident, bool((found.p2p == np.arange(162)).all())
    (True, True)
    >>> print(found.explanation)
    distances are kept to 0.000 sqrt(area) in the mean; there is no other map
    """
    checked_mirror(mirror)
    bar = tqdm(total=_STAGES, desc="prepare", disable=not progress)
    with default_workers(workers), single_threaded_blas, bar:
        problem = MatchProblem.of(
            x, y, parameters, repair=repair, landmarks=landmarks, labels=labels, progress=progress
        )
        if matched_as_part(problem.x.full, problem.y.full, partial, normalize):
            if mirror == "yes":
                raise ParameterError("partial matches keep the orientation: reflect one shape, or leave out partial")
            found = partial_match(problem, normalize=normalize)
            result = _result(problem, found, normalize, partial, mirror)
            return (result, result.log) if log else result
        if not normalize:
            check_same_size(problem.x.full, problem.y.full, problem.parameters.same_area)
        _prepare(problem)
        _next(bar, 1, "search")
        choice = robust_to_shortcuts(problem, with_limbs_matched(problem, chosen_map(problem, mirror)))
        _next(bar, 2, "register")
        dense = finished(problem.with_mirrored_y() if choice.mirrored else problem, choice.decision.best.to_finish)
        _next(bar, 3, "matched")
        found = described(problem, choice, dense, mirror)
        if partial == "auto" and mirror != "yes":
            found = better_as_part(problem, found)
        result = _result(problem, found, normalize, partial, mirror)
    return (result, result.log) if log else result


def _result(
    problem: MatchProblem, found: MatchResult, normalize: bool, partial: PartialOption, mirror: MirrorOption
) -> MatchResult:
    """What was found, on the vertices that were given, with the options that it was found with."""
    asked = replace(found, normalize=normalize, partial=partial, mirror=mirror)
    return match_on_given(asked, problem.x, problem.y)


def _prepare(problem: MatchProblem) -> None:
    """Compute all that belongs to one shape, of both side by side."""
    shapes = {"X": problem.x, "Y": problem.y}
    if problem.x.intrinsic is problem.y.intrinsic:
        del shapes["Y"]

    def prepared(name: str) -> None:
        with concerning(name):
            if name == "Y":
                # Not distances first in both: these leave the interpreter's lock free, a solver of eigenpairs holds it.
                _ = shapes[name].laplacian
            shapes[name].prepare()

    concurrently(prepared, shapes)


def _next(bar: tqdm, done: int, stage: str) -> None:
    bar.update()
    bar.set_description(stage)
    report_progress(stage, done, _STAGES)


def described(problem: MatchProblem, choice: Found, dense: DenseMap, mirror: MirrorOption) -> MatchResult:
    """What is known of a map that was chosen and registered to the end, on the repaired shapes."""
    x, y, decision, mirrored = problem.x, problem.y, choice.decision, choice.mirrored
    full = at_full_resolution(problem.with_mirrored_y() if mirrored else problem, dense)
    p2p = full.p2p
    distortion = point_distortions(problem, p2p)
    score = float(x.full_spectrum.areas @ distortion)
    turned = orientation(x.oriented, y.oriented, p2p)
    coarse = y.vertex_of_full[p2p[x.full_vertices]]
    alike = hks_agreement(problem, coarse)
    # Where a limb is unlike the one that it corresponds to, the map with it elsewhere says how alike the rest is.
    rest = decision.best.hks_agreement if decision.best.in_place else alike
    confident, explanation = verdict(
        problem.parameters, score, turned, max(alike, rest), decision.margin, decision.contrary,
        problem.more_handles != 0,
    )  # fmt: skip
    confident, explanation = with_limbs(problem, coarse, alike, confident, explanation)
    confident, explanation = with_hand(problem, choice, mirror, confident, explanation)
    confident, explanation = with_hints(problem, coarse, decision.unhinted, confident, explanation)
    confident, explanation = with_sides({"X": x.winding, "Y": y.winding}, confident, explanation)
    of_x, of_y = x.full_spectrum, y.full_spectrum
    phi_x, phi_y = of_x.eigenfunctions, of_y.eigenfunctions
    positions = full.positions * (np.array([-1.0, 1.0, 1.0]) if mirrored else 1.0)
    regions_x, regions_y = eigenfunction_regions(phi_x, phi_y, p2p, of_x.areas)
    return MatchResult(
        x=x.full,
        y=y.full,
        p2p=frozen(p2p),
        inverse=frozen(full.inverse),
        functional_map=frozen(functional_map(phi_x, phi_y, p2p, of_x.areas)),
        c_xy=commutative_eigenspectra(of_x, of_y, p2p).c_xy,
        distortion=frozen(distortion),
        score=score,
        runner_up=decision.runner_up,
        margin=decision.margin,
        orientation=turned,
        hks_agreement=alike,
        confident=confident,
        explanation=explanation,
        regions_x=frozen(regions_x),
        regions_y=frozen(regions_y),
        positions=frozen(positions),
        barycentric=barycentric_map(positions, p2p, y.full),
        log=problem.log,
        landmark_errors=frozen(problem.known.landmark_errors(coarse) if problem.known else np.zeros(0)),
    )
