"""Correspondence of two shapes with no initial map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, overload

import numpy as np
import numpy.typing as npt
from tqdm.auto import tqdm

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import concerning
from qgeo_filters.matching.initialization.candidates import Candidate, candidates, mirrored_map
from qgeo_filters.matching.maps.barycentric import BarycentricMap, barycentric_map
from qgeo_filters.matching.maps.functional_map import functional_map
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import Shape, check_same_size
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.regions import eigenfunction_regions
from qgeo_filters.matching.selection.decision import Decision, choose_map
from qgeo_filters.matching.selection.signatures import hks_agreement
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.parallel import default_workers, single_threaded_blas
from qgeo_filters.repair.winding import Winding
from qgeo_filters.spectral.commutative import commutative_eigenspectra
from qgeo_filters.validation import frozen


@dataclass(frozen=True, eq=False)
class MatchResult:
    """Map from each vertex of X to a vertex of Y.

    Attributes
    ----------
    p2p : (n_x,) int64
        Vertex of Y for each vertex of X.
    inverse : (n_y,) int64
        Vertex of X for each vertex of Y.
    functional_map : (20, 20) float64
        C in the eigenfunctions of the distances: ``phi_x @ C`` approximates ``phi_y[p2p]``, for unit-area shapes.
    c_xy : float
        Distance of the first 20 eigenfunctions, paired along the map (paper, sec. 4.2), see `spectral_distance`; both
        in the last metric that the shapes were prepared in, which is the lifted one.
    distortion : (n_x,) float64
        Mean over points q of |d_X(p, q) - d_Y(Tp, Tq)|, in units of sqrt(area).
    score : float
        Mean of the distortion over the area: 0 for an isometry.
    runner_up : float
        Mean distortion of the best other map that keeps the orientation; inf if none was proposed.
    margin : float
        How many times the chosen map's cost (strain, tearing, folding, unlike parts) the runner-up's is.
    orientation : float
        See `orientation`: near 0.7 for a map between shapes of the same handedness; negative if Y is a mirror image.
    hks_agreement : float
        Of heat kernels along the map, see `hks_agreement`: above 0.9 between poses of one shape.
    confident : bool
        Whether the map stands clear of the others, keeps distances, relates like parts, has one orientation, and left
        and right can be told: of an open sheet nobody knows which side is out, see `Surface.winding`.
    explanation : str
        Why it is confident, or what is ambiguous, in a sentence; and which shape was inside out.
    regions_x, regions_y : (n_x,), (n_y,) int32
        Regions of equal number on both shapes, see `eigenfunction_regions`.
    positions : (n_x, 3) float64
        X deformed onto Y, in Y's frame and unit.
    barycentric : BarycentricMap
        Point within a triangle of Y for each vertex of X: that nearest to its position, near its vertex.
    log : MatchLog
        Every map that was proposed, and what became of it: why this one was chosen.
    """

    p2p: IndexArray
    inverse: IndexArray
    functional_map: FloatArray
    c_xy: float
    distortion: FloatArray
    score: float
    runner_up: float
    margin: float
    orientation: float
    hks_agreement: float
    confident: bool
    explanation: str
    regions_x: npt.NDArray[np.int32]
    regions_y: npt.NDArray[np.int32]
    positions: FloatArray
    barycentric: BarycentricMap
    log: MatchLog


@overload
def match(
    x: Shape,
    y: Shape,
    *,
    normalize: bool = ...,
    parameters: MatchingParameters | None = ...,
    log: Literal[False] = ...,
    workers: int | None = ...,
    progress: bool = ...,
) -> MatchResult: ...
@overload
def match(
    x: Shape,
    y: Shape,
    *,
    normalize: bool = ...,
    parameters: MatchingParameters | None = ...,
    log: Literal[True],
    workers: int | None = ...,
    progress: bool = ...,
) -> tuple[MatchResult, MatchLog]: ...
def match(
    x: Shape,
    y: Shape,
    *,
    normalize: bool = True,
    parameters: MatchingParameters | None = None,
    log: bool = False,
    workers: int | None = None,
    progress: bool = False,
) -> MatchResult | tuple[MatchResult, MatchLog]:
    """Correspondence between two shapes that bend into each other, with no initial map.

    Parameters
    ----------
    x, y : Surface, whatever `as_surface` takes, or PreparedShape
        In one piece, manifold, oriented, outwards or inwards; any triangulation, position and number of vertices. Pass
        prepared shapes where a shape takes part in several matches: all that belongs to one shape is computed once.
    normalize : bool
        Whether to compare shapes regardless of size. If not, and their areas differ by more than a tenth, they are
        refused.
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
        Shapes of different size with ``normalize=False``, or prepared with different parameters.

    Notes
    -----
    Coarse maps come from all choices of signs of the first eigenfunctions of the distances, in several metrics
    (`sign_search`), grown by spectral upsampling, and from likely matchings of the ends of limbs (`extrema_maps`). A
    shape with a left and a right has a mirrored map for every good one, which keeps distances as well: that of
    each map that turns the surface inside out is made by the self-symmetry, and only maps that keep the orientation
    compete. The best is the one along which X deforms with the least strain, tearing and folding onto parts that are
    alike (`choose_map`), registered on all vertices (`register`). The result does not depend on the signs
    and order that a solver returns, nor on position and size.
    """
    bar = tqdm(total=4, desc="prepare X", disable=not progress)
    with default_workers(workers), single_threaded_blas, bar:
        problem = MatchProblem.of(x, y, parameters, progress=progress)
        if not normalize:
            check_same_size(problem.x.surface, problem.y.surface, problem.parameters.same_area)
        with concerning("X"):
            problem.x.prepare()
        _next(bar, "prepare Y")
        with concerning("Y"):
            problem.y.prepare()
        _next(bar, "search")
        pool, mirrored = competing_candidates(problem)
        _next(bar, "register")
        decision = choose_map(problem.with_mirrored_y() if mirrored else problem, pool)
        _next(bar, "matched")
        result = _described(problem, decision, mirrored)
    return (result, result.log) if log else result


def _next(bar: tqdm, stage: str) -> None:
    bar.update()
    bar.set_description(stage)


def competing_candidates(problem: MatchProblem) -> tuple[list[Candidate], bool]:
    """Maps that keep the orientation; or those that reverse it, and True, if none of the former keeps distances."""
    x, y, given, log = problem.x, problem.y, problem.parameters, problem.log
    proposed = candidates(problem)
    kept = [c for c in proposed if c.orientation > 0]
    reversing = [c for c in proposed if c.orientation <= 0]
    if reversing:
        mirror = self_symmetry(y, parameters=given)
        other = mirror if mirror.found else self_symmetry(x, parameters=given)
        if other.found:
            kept += [mirrored_map(problem, c, other.nearest, of_y=mirror.found) for c in reversing]
    mirrored = not kept or (
        # Not one of the maps in the right hand is nearly as good: Y is the mirror image of something asymmetric.
        bool(reversing)
        and min(c.mean_distortion for c in reversing) < given.mirror_image_ratio * min(c.mean_distortion for c in kept)
    )
    for c in kept if mirrored else reversing:
        log.drop(c.number, "keeps the orientation, but not distances" if mirrored else "reverses the orientation")
    return (reversing if mirrored else kept), mirrored


def _described(problem: MatchProblem, decision: Decision, mirrored: bool) -> MatchResult:
    x, y = problem.x, problem.y
    dense, p2p = decision.dense, decision.dense.p2p
    probes = x.fps[: problem.parameters.probes]
    there = y.distances(p2p[probes])
    distortion = np.abs(x.fps_distances[: len(probes)] - there[:, p2p]).mean(axis=0, dtype=np.float64)
    score = float(x.areas @ distortion)
    turned, alike = orientation(x.unit, y.unit, p2p), hks_agreement(problem, p2p)
    confident, explanation = _verdict(problem.parameters, score, decision.margin, turned, alike, mirrored)
    confident, explanation = _with_sides({"X": x.winding, "Y": y.winding}, confident, explanation)
    phi_x, phi_y = x.spectrum.eigenfunctions, y.spectrum.eigenfunctions
    flip = np.array([-1.0, 1.0, 1.0]) if mirrored else 1.0
    centre = y.surface.vertex_areas @ y.surface.vertices / y.surface.area
    positions = dense.positions * flip * y.scale + centre
    regions_x, regions_y = eigenfunction_regions(phi_x, phi_y, p2p, x.areas)
    given = y.surface.turned_over() if y.winding == "inward" else y.surface  # corners in the caller's order
    return MatchResult(
        p2p=frozen(p2p),
        inverse=frozen(dense.inverse),
        functional_map=frozen(functional_map(phi_x, phi_y, p2p, x.areas)),
        c_xy=commutative_eigenspectra(x.spectrum, y.spectrum, p2p).c_xy,
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
        barycentric=barycentric_map(positions, p2p, given),
        log=problem.log,
    )


def _verdict(
    given: MatchingParameters, score: float, margin: float, turned: float, alike: float, mirrored: bool
) -> tuple[bool, str]:
    hand = "Y is matched as a mirror image of X: no map that keeps the orientation keeps distances" if mirrored else ""
    if score > given.near_isometric:
        return False, f"distances differ by {score:.3f} sqrt(area) in the mean: the shapes are not near-isometric" + (
            f"; {hand}" if hand else ""
        )
    if abs(turned) < given.settled_orientation:
        return False, f"the map turns much of the surface over (orientation {turned:.2f}): parts may be mirrored"
    if alike < given.match_alike:
        return False, (
            f"distances are kept to {score:.3f} sqrt(area) in the mean, but the map relates parts of different shape "
            f"(their heat kernels agree by {alike:.2f} only)"
        )
    if margin < given.margin:
        return False, (
            f"another map fits nearly as well (its cost is {margin:.2f} times as large): "
            "the shape looks alike in more than one way"
        )
    if mirrored:
        return False, hand
    rival = f"the next different map costs {margin:.1f} times as much" if margin < np.inf else "there is no other map"
    return True, f"distances are kept to {score:.3f} sqrt(area) in the mean; {rival}"


def _with_sides(winding: Mapping[str, Winding], confident: bool, explanation: str) -> tuple[bool, str]:
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
