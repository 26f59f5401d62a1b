"""The intrinsic left/right symmetry of a shape as a point map, found with no initial guess."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike
from qgeo_filters.matching.initialization.candidates import candidates
from qgeo_filters.matching.maps.functional_map import nearest
from qgeo_filters.matching.maps.involution import paired
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.selection.decision import decided
from qgeo_filters.matching.selection.signatures import likeness
from qgeo_filters.matching.smooth_shells import Finished
from qgeo_filters.matching.symmetry_measure import symmetry_epsilon, symmetry_regions
from qgeo_filters.validation import frozen

#: Mean distortion of distances, in sqrt(area), up to which a map of the shape to its mirror image is a symmetry.
TOLERANCE = 0.08
# The next best reflection must cost this many times as much: a sphere or a torus has many that cost the same.
_MARGIN = 1.3
# Mean distance between the images, in sqrt(area), from which two reflections are different ones.
_ELSEWHERE = 0.1
# Likeness of mirror points: posed animals (TOSCA's cat, dog and centaur) have .96 to 1, random smooth blobs .91 to .96
# under their best reflection, but for those that are nearly symmetric.
_ALIKE = 0.96
# A pose that changes the surroundings changes distances, too: how much less than 1 the likeness may be, as a multiple
# of the distortion (the posed animals have at most .5, the two blobs that are the most alike 1.4 and 1.6); or this.
_UNLIKE, _LEAST_UNLIKE = 1.0, 0.015
# Points to which distances are compared for the asymmetry.
_PROBES = 200


@dataclass(frozen=True, eq=False)
class Symmetry:
    """Intrinsic reflection of a shape.

    Attributes
    ----------
    found : bool
    reason : str
        One sentence: what was found, or why nothing was.
    p2p : (n,) int64
        Mirror vertex T(i) of each vertex. An involution, T(T(i)) = i: vertices of the two sides are paired, those on
        the axis, and those for which the other side has too few vertices, are their own mirror. The identity if
        none was found.
    nearest : (n,) int64
        Vertex nearest to the mirror point of each vertex: more accurate than ``p2p`` by about half an edge, but
        several vertices may share one, and it is an involution only up to an edge.
    side : (n,) int8
        1 and -1 on the two sides, 0 on the axis. Which side is 1 has no meaning.
    fixed : (n,) bool
        The vertices on the axis.
    asymmetry : (n,) float64
        Mean over points q of :math:`|d(p, q) - d(Tp, Tq)|`, in units of sqrt(area).
    distortion : float
        Mean of the asymmetry over the area.
    orientation : float
        Of ``nearest``, see `orientation`: near -0.7 for a reflection.
    epsilon : float
        The paper's measure, eq. (3), between the points and their mirror points, see `symmetry_epsilon`; over all pairs
        of points if no symmetry was found.
    regions : (n,) int32
        Regions of the paper's measure, see `symmetry_regions`.
    """

    found: bool
    reason: str
    p2p: IndexArray
    nearest: IndexArray
    side: npt.NDArray[np.int8]
    fixed: npt.NDArray[np.bool_]
    asymmetry: FloatArray
    distortion: float
    orientation: float
    epsilon: float
    regions: npt.NDArray[np.int32]


def self_symmetry(
    shape: SurfaceLike | PreparedShape, *, tolerance: float = TOLERANCE, progress: bool = False
) -> Symmetry:
    """Intrinsic left/right symmetry of a shape: mirror vertex, side and asymmetry of each vertex.

    The search of `match` is run from the shape to its own image in a mirror: maps that keep the orientation
    there reverse it on the shape, which leaves out the identity. What bends, such as limbs in any pose, may bend: only
    distances on the surface count.

    Parameters
    ----------
    shape : PreparedShape, Surface, or whatever `as_surface` takes
        In one piece, manifold, oriented. A descriptor remembers its symmetry.
    tolerance : float
        Mean distortion of distances, in units of sqrt(area), up to which a map counts as a symmetry.
    progress : bool
        Whether to show a progress bar over the distances.

    Returns
    -------
    Symmetry
        ``found`` is False, and ``reason`` says why, for a shape without such a symmetry, or with a whole family of
        them (sphere, torus), of which none can be singled out.

    Raises
    ------
    MeshError
        See `PreparedShape`.
    """
    if not 0 < tolerance < np.inf:
        raise ParameterError(f"the tolerance must be a positive fraction of sqrt(area), got {tolerance!r}")
    descriptor = PreparedShape.of(shape, progress)
    kept = descriptor.__dict__.setdefault("_symmetries", {})
    if tolerance not in kept:
        kept[tolerance] = _found(descriptor, tolerance)
    return kept[tolerance]


def _found(x: PreparedShape, tolerance: float) -> Symmetry:
    reflections = [c for c in candidates(x, x.mirrored, identity=False) if c.orientation > 0]
    if not reflections:
        return _none(x, "no map of the shape to its mirror image keeps distances even roughly")
    decision = decided(x, x.mirrored, reflections, _ELSEWHERE, mirror=True)
    margin = decision.margin
    if margin < _MARGIN and decision.distortion < tolerance:
        return _none(
            x,
            f"different reflections keep distances and shape about equally well (costs within {margin:.2f}): either "
            "a family of symmetries, of which none can be singled out, or a shape without any that is nearly round",
        )
    found = _described(x, decision.result)
    if found.distortion > tolerance:
        return _none(
            x,
            f"the best map of the shape to its mirror image distorts distances by {found.distortion:.3f} sqrt(area) "
            f"in the mean, more than the tolerance of {tolerance:g}",
        )
    alike = likeness(x, x, found.nearest)
    if alike < max(_ALIKE, 1 - max(_UNLIKE * found.distortion, _LEAST_UNLIKE)):
        return _none(
            x,
            f"the best map of the shape to its mirror image keeps distances to {found.distortion:.3f} sqrt(area), but "
            f"relates parts of different shape (their heat kernels agree by {alike:.2f} only)",
        )
    return found


def _described(x: PreparedShape, result: Finished) -> Symmetry:
    # The map and its inverse are the same: matching in both at once makes the costs symmetric.
    first = np.column_stack([result.embedding_x, result.embedding_y])
    second = np.column_stack([result.embedding_y, result.embedding_x])
    p2p = nearest(first, second)
    side = _sides(x, p2p)
    # Where the vertices go between the vertices of the other side: nearer to the truth than the nearest of them.
    v, mirrored = x.unit.vertices, result.positions * np.array([-1.0, 1.0, 1.0])
    probes = x.samples[:_PROBES]
    there = x.distances(p2p[probes])
    asymmetry = np.abs(x.rows[: len(probes)] - there[:, p2p]).mean(axis=0, dtype=np.float64)
    distortion = float(x.areas @ asymmetry)
    return Symmetry(
        True,
        f"a reflection that distorts distances by {distortion:.3f} sqrt(area) in the mean",
        frozen(paired(np.column_stack([mirrored, v]), np.column_stack([v, mirrored]), side)),
        frozen(p2p),
        frozen(side),
        frozen(side == 0),
        frozen(asymmetry),
        distortion,
        orientation(x.unit, x.unit, p2p),
        symmetry_epsilon(x.views[-1].spectrum, p2p),
        frozen(symmetry_regions(x.views[-1].spectrum)),
    )


def _sides(x: PreparedShape, p2p: IndexArray) -> npt.NDArray[np.int8]:
    """Side of each vertex, (n,): 1, -1, and 0 along the axis.

    A shortest path from one side to a point of the other crosses the axis, where the point and its mirror
    are equally far: so the nearer of p and Tp is the one on the same side.
    """
    # Distance to the mirror of a point is that of the mirrored vertex to the point.
    excess = x.rows[:, p2p] - x.rows
    own = excess[np.arange(len(x.rows)), x.samples[: len(x.rows)]]
    reference = int(own.argmax())
    of_points = np.sign(excess[reference, x.samples[: len(x.rows)]])
    lead = (of_points[:, None] * excess).mean(axis=0, dtype=np.float64)
    side = np.sign(lead).astype(np.int8)
    a, b = x.unit.edges.T
    crossing = side[a] * side[b] < 0
    a, b = a[crossing], b[crossing]
    side[np.where(np.abs(lead[a]) <= np.abs(lead[b]), a, b)] = 0
    return side


def _none(x: PreparedShape, reason: str) -> Symmetry:
    n = x.n_vertices
    identity = frozen(np.arange(n))
    return Symmetry(
        False,
        reason,
        identity,
        identity,
        frozen(np.zeros(n, np.int8)),
        frozen(np.zeros(n, bool)),
        frozen(np.zeros(n)),
        0.0,
        1.0,
        symmetry_epsilon(x.views[-1].spectrum),
        frozen(symmetry_regions(x.views[-1].spectrum)),
    )
