"""Correspondence of two shapes with no initial map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from tqdm.auto import tqdm

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.hosts.dispatch import SurfaceLike
from qgeo_filters.matching.initialization.candidates import Candidate, candidates, distortion
from qgeo_filters.matching.maps.barycentric import BarycentricMap, barycentric_map
from qgeo_filters.matching.maps.functional_map import functional_map
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_filters.matching.prepared_shape import PreparedShape, check_same_size
from qgeo_filters.matching.regions import eigenfunction_regions
from qgeo_filters.matching.selection.decision import Decision, decided
from qgeo_filters.matching.selection.signatures import likeness
from qgeo_filters.matching.symmetry import Symmetry, self_symmetry
from qgeo_filters.spectral.commutative import commutative_eigenspectra
from qgeo_filters.validation import frozen

# Points to which distances are compared for the distortion.
_PROBES = 200
# The runner-up must cost this many times as much, and the map distort distances by no more than that, to be sure.
_MARGIN = 1.3
_SURE = 0.12
# Likeness of a right map: poses of TOSCA's cat, dog and centaur have .96 to 1, different creatures .57 to .67.
_ALIKE = 0.9
# A finished map whose orientation is below this did not settle on one side.
_ORIENTED = 0.3


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
        in the last metric of the descriptors, which is the lifted one.
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
    likeness : float
        Agreement of heat kernels along the map, see `likeness`: above 0.9 between poses of one shape.
    confident : bool
        Whether the map stands clear of the others, keeps distances, relates like parts, and has one orientation.
    explanation : str
        Why it is confident, or what is ambiguous, in a sentence.
    regions_x, regions_y : (n_x,), (n_y,) int32
        Regions of equal number on both shapes, see `eigenfunction_regions`.
    positions : (n_x, 3) float64
        X deformed onto Y, in Y's frame and unit.
    barycentric : BarycentricMap
        Point within a triangle of Y for each vertex of X: that nearest to its position, near its vertex.
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
    likeness: float
    confident: bool
    explanation: str
    regions_x: npt.NDArray[np.int32]
    regions_y: npt.NDArray[np.int32]
    positions: FloatArray
    barycentric: BarycentricMap


def match(
    x: SurfaceLike | PreparedShape, y: SurfaceLike | PreparedShape, *, normalize: bool = True, progress: bool = False
) -> MatchResult:
    """Correspondence between two shapes that bend into each other, with no initial map.

    Parameters
    ----------
    x, y : PreparedShape, Surface, or whatever `as_surface` takes
        In one piece, manifold, oriented; any triangulation, position and number of vertices. Pass descriptors
        where a shape takes part in several matches: all that belongs to one shape is computed once.
    normalize : bool
        Whether to compare shapes regardless of size. If not, and their areas differ by more than a tenth, they are
        refused.
    progress : bool
        Whether to show progress bars: one over the stages, and one over the distances of a shape.

    Returns
    -------
    MatchResult

    Raises
    ------
    MeshError
        See `PreparedShape`.
    ValueError
        Shapes of different size with ``normalize=False``.

    Notes
    -----
    Coarse maps come from all choices of signs of the first eigenfunctions of the distances, in several metrics
    (`search`), grown by spectral upsampling, and from likely matchings of the ends of limbs (`extremity_maps`). A
    shape with a left and a right has a mirrored twin of every good map, which keeps distances as well: the twin of
    each map that turns the surface inside out is made by the self-symmetry, and only maps that keep the orientation
    compete. The best is the one along which X deforms with the least strain, tearing and folding onto parts that are
    alike (`decided`), and is finished on all vertices (`finished`). The result does not depend on the signs
    and order that a solver returns, nor on position and size.
    """
    a, b = PreparedShape.of(x, progress), PreparedShape.of(y, progress)
    if not normalize:
        check_same_size(a.surface, b.surface)
    with tqdm(total=4, desc="describe X", disable=not progress) as bar:
        a.prepared()
        _next(bar, "describe Y")
        b.prepared()
        _next(bar, "search")
        pool, mirrored = _competing(a, b)
        _next(bar, "try")
        decision = decided(a, b.mirrored if mirrored else b, pool)
        _next(bar, "matched")
    return _described(a, b, decision, mirrored)


def _next(bar: tqdm, stage: str) -> None:
    bar.update()
    bar.set_description(stage)


def _competing(x: PreparedShape, y: PreparedShape) -> tuple[list[Candidate], bool]:
    """Maps that keep the orientation; or those that reverse it, and True, if none of the former keeps distances."""
    proposed = candidates(x, y)
    kept = [c for c in proposed if c.orientation > 0]
    reversing = [c for c in proposed if c.orientation <= 0]
    if reversing:
        mirror = self_symmetry(y)
        other = mirror if mirror.found else self_symmetry(x)
        if other.found:
            kept += [_twin(x, y, c, other, onto=mirror.found) for c in reversing]
    mirrored = not kept or (
        # Not one of the maps in the right hand is nearly as good: Y is the mirror image of something asymmetric.
        bool(reversing) and min(c.distortion for c in reversing) < 0.5 * min(c.distortion for c in kept)
    )
    return (reversing if mirrored else kept), mirrored


def _twin(x: PreparedShape, y: PreparedShape, c: Candidate, symmetry: Symmetry, onto: bool) -> Candidate:
    """The mirrored twin of a candidate, by the symmetry of Y, or of X if not ``onto``."""
    if onto:
        p2p = symmetry.nearest[c.p2p]
    else:
        rows = x.rows[: len(c.p2p)]
        p2p = c.p2p[rows[:, symmetry.nearest[x.samples[: len(rows)]]].argmin(axis=0)]
    return Candidate(p2p, distortion(x, y, p2p), -c.orientation)


def _described(x: PreparedShape, y: PreparedShape, decision: Decision, mirrored: bool) -> MatchResult:
    result, margin = decision.result, decision.margin
    p2p = result.p2p
    probes = x.samples[:_PROBES]
    there = y.distances(p2p[probes])
    distortion = np.abs(x.rows[: len(probes)] - there[:, p2p]).mean(axis=0, dtype=np.float64)
    score = float(x.areas @ distortion)
    turned, alike = orientation(x.unit, y.unit, p2p), likeness(x, y, p2p)
    confident, explanation = _verdict(score, margin, turned, alike, mirrored)
    spectrum_x, spectrum_y = x.views[-1].spectrum, y.views[-1].spectrum
    phi_x, phi_y = spectrum_x.eigenfunctions, spectrum_y.eigenfunctions
    flip = np.array([-1.0, 1.0, 1.0]) if mirrored else 1.0
    centre = y.surface.vertex_areas @ y.surface.vertices / y.surface.area
    positions = result.positions * flip * y.scale + centre
    regions_x, regions_y = eigenfunction_regions(phi_x, phi_y, p2p, x.areas)
    return MatchResult(
        p2p=frozen(p2p),
        inverse=frozen(result.inverse),
        functional_map=frozen(functional_map(phi_x, phi_y, p2p, x.areas)),
        c_xy=commutative_eigenspectra(spectrum_x, spectrum_y, p2p).c_xy,
        distortion=frozen(distortion),
        score=score,
        runner_up=decision.runner_up,
        margin=margin,
        orientation=turned,
        likeness=alike,
        confident=confident,
        explanation=explanation,
        regions_x=frozen(regions_x),
        regions_y=frozen(regions_y),
        positions=frozen(positions),
        barycentric=barycentric_map(positions, p2p, y.surface),
    )


def _verdict(score: float, margin: float, turned: float, alike: float, mirrored: bool) -> tuple[bool, str]:
    hand = "Y is matched as a mirror image of X: no map that keeps the orientation keeps distances" if mirrored else ""
    if score > _SURE:
        return False, f"distances differ by {score:.3f} sqrt(area) in the mean: the shapes are not near-isometric" + (
            f"; {hand}" if hand else ""
        )
    if abs(turned) < _ORIENTED:
        return False, f"the map turns much of the surface over (orientation {turned:.2f}): parts may be mirrored"
    if alike < _ALIKE:
        return False, (
            f"distances are kept to {score:.3f} sqrt(area) in the mean, but the map relates parts of different shape "
            f"(their heat kernels agree by {alike:.2f} only)"
        )
    if margin < _MARGIN:
        return False, (
            f"another map fits nearly as well (its cost is {margin:.2f} times as large): "
            "the shape looks alike in more than one way"
        )
    if mirrored:
        return False, hand
    rival = f"the next different map costs {margin:.1f} times as much" if margin < np.inf else "there is no other map"
    return True, f"distances are kept to {score:.3f} sqrt(area) in the mean; {rival}"
