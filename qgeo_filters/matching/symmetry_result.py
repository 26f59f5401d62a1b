"""The reflection of a shape, with all that is said of it: mirror points, sides, axis, asymmetry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.closest_points import with_normals
from qgeo_filters.html_repr import card, histogram, shown
from qgeo_filters.matching.finish import at_full_resolution
from qgeo_filters.matching.maps.barycentric import barycentric_map
from qgeo_filters.matching.maps.functional_map import nearest_neighbors, nearest_neighbors_both_ways
from qgeo_filters.matching.maps.involution import optimal_involution
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_filters.matching.maps.point_distortion import point_distortions
from qgeo_filters.matching.mirror_curve import MirrorPlane, mirror_plane, zero_curves
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.smooth_shells import DenseMap
from qgeo_filters.matching.symmetry_measure import symmetry_epsilon, symmetry_regions
from qgeo_filters.validation import frozen

# Deviation, in sqrt(area), up to which a symmetry is that of a plane.
_IN_A_PLANE = 0.02


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
        Mean over points q of :math:`|d(p, q) - d(Tp, Tq)|`, in units of sqrt(area); NaN if none was found.
    score : float
        Mean of the asymmetry over the area: 0 for an exact symmetry, NaN if none was found.
    orientation : float
        Of ``nearest``, see `orientation`: near -0.7 for a reflection; NaN if none was found.
    epsilon : float
        The paper's measure, eq. (3), between the points and their mirror points, see `symmetry_epsilon`; over all pairs
        of points if no symmetry was found.
    regions : (n,) int32
        Regions of the paper's measure, see `symmetry_regions`.
    barycentric : BarycentricMap
        The mirror point of each vertex within a triangle: what ``nearest`` rounds to a vertex. Carries values over:
        ``barycentric.pulled_back(values)``. Each vertex itself if no symmetry was found.
    curve : tuple of (k, 3) float64
        The axis: polylines on the surface along which mirror points meet, the longest first; a closed one ends where it
        begins. Empty if no symmetry was found.
    plane : MirrorPlane, optional
        The plane of a shape that is its own mirror image in space, to within .02 sqrt(area); None for one that is bent.
    repairs : tuple of str
        What was repaired before, a sentence each; empty if nothing was. A vertex that had to go has no mirror vertex:
        -1, see `symmetry_on_given`.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> ball = surface.vertices / [1.4, 1, 0.8]
    >>> ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    >>> radius = 1 + 0.3 * ball[:, [1]] + 0.25 * ball[:, [1]] * ball[:, [2]]
    >>> body = surface.with_vertices(ball * [1, 1.6, 0.7] * radius)  # its own mirror image in x = 0
    >>> symmetry = qg.self_symmetry(body)
    >>> print(symmetry.reason)
    a reflection that distorts distances by 0.000 sqrt(area) in the mean
    >>> sides = symmetry.side[[body.vertices[:, 0].argmin(), body.vertices[:, 0].argmax()]]
    >>> int(sides.sum()), len(symmetry.curve) > 0
    (0, True)
    """

    found: bool
    reason: str
    p2p: IndexArray
    nearest: IndexArray
    side: npt.NDArray[np.int8]
    fixed: npt.NDArray[np.bool_]
    asymmetry: FloatArray
    score: float
    orientation: float
    epsilon: float
    regions: npt.NDArray[np.int32]
    barycentric: BarycentricMap
    curve: tuple[FloatArray, ...] = ()
    plane: MirrorPlane | None = None
    repairs: tuple[str, ...] = ()

    def __repr__(self) -> str:
        if not self.found:
            return f"Symmetry: none found on {len(self.p2p)} vertices\n  {self.reason}"
        one, other, axis = (int((self.side == side).sum()) for side in (1, -1, 0))
        plane = "" if self.plane is None else f", in a plane to {self.plane.deviation:.4f} sqrt(area)"
        lines = [
            f"Symmetry: {len(self.p2p)} vertices, {one} and {other} on the sides, {axis} on the axis{plane}",
            f"  {self.reason}, {_largest(self.asymmetry):.4f} at most",
            *(f"  repaired: {sentence}" for sentence in self.repairs),
        ]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        known = self.found
        facts = {
            "vertices on the sides": " and ".join(str(int((self.side == k).sum())) for k in (1, -1)) if known else None,
            "on the axis": int(self.fixed.sum()) if known else None,
            "mean asymmetry": f"{shown(self.score)} sqrt(area)" if known else None,
            "largest": f"{shown(_largest(self.asymmetry))} sqrt(area)" if known else None,
            "orientation": self.orientation if known else None,
            "plane": f"to {shown(self.plane.deviation)} sqrt(area)"
            if self.plane is not None
            else "none: it is bent"
            if known
            else None,
            "epsilon, eq. (3)": self.epsilon,
            "repaired": list(self.repairs) or None,
        }
        return card(
            f"Symmetry of {len(self.p2p)} vertices",
            facts,
            subtitle=self.reason if known else f"NONE FOUND: {self.reason}",
            bars=histogram(self.asymmetry) if known else None,
            bars_label=f"vertices by asymmetry, from 0 to {shown(_largest(self.asymmetry))} sqrt(area)",
        )


def _largest(asymmetry: FloatArray) -> float:
    known = asymmetry[np.isfinite(asymmetry)]
    return float(known.max()) if known.size else np.nan


def described_symmetry(problem: MatchProblem, dense: DenseMap) -> Symmetry:
    """The reflection of a shape along a finished map to its mirror image."""
    x, spectrum = problem.x, problem.x.full_spectrum
    positions, nearest = _mirror_points(problem, dense)
    places = barycentric_map(positions, nearest, x.full)
    towards, lead = _leads(x, nearest, places)
    side = _sides(x, towards[nearest] - towards)
    plane = mirror_plane(x.full, places.pulled_back(x.full.vertices))
    asymmetry = point_distortions(problem, nearest)
    score = float(spectrum.areas @ asymmetry)
    # Where the vertices go between the vertices of the other side: nearer to the truth than the nearest of them.
    v = x.oriented.vertices
    return Symmetry(
        True,
        f"a reflection that distorts distances by {score:.3f} sqrt(area) in the mean",
        frozen(optimal_involution(np.column_stack([positions, v]), np.column_stack([v, positions]), side)),
        frozen(nearest),
        frozen(side),
        frozen(side == 0),
        frozen(asymmetry),
        score,
        orientation(x.oriented, x.oriented, nearest),
        symmetry_epsilon(spectrum, nearest),
        frozen(symmetry_regions(spectrum)),
        places,
        zero_curves(x.full, lead),
        plane if plane.deviation < _IN_A_PLANE else None,
    )


def _mirror_points(problem: MatchProblem, dense: DenseMap) -> tuple[FloatArray, IndexArray]:
    """Mirror point of each vertex at full resolution, (n, 3), in the frame of the shape, and the vertex nearest to it.

    The map and its inverse are the same: matching in both at once makes the costs symmetric.
    """
    x, flip = problem.x, np.array([-1.0, 1.0, 1.0])
    full = at_full_resolution(problem, dense)
    positions = full.positions * flip
    if x.fine_proxy.surface is x.oriented:
        first, second = dense.embedding_x, dense.embedding_y
        both = np.column_stack([first, second]), np.column_stack([second, first])
        return positions, nearest_neighbors(*both)
    here = with_normals(positions, x.oriented.with_vertices(full.positions).vertex_normals * flip, x.oriented)
    there = with_normals(x.oriented.vertices, x.oriented.vertex_normals, x.oriented)
    return positions, nearest_neighbors_both_ways(np.column_stack([here, there]), np.column_stack([there, here]))[0]


def _leads(x: PreparedShape, nearest: IndexArray, places: BarycentricMap) -> tuple[FloatArray, FloatArray]:
    """How far it is from one side to each vertex at full resolution, (n,), and how much farther to its mirror point.

    A shortest path from one side to a point of the other crosses the axis, where the point and its mirror
    are equally far: so the nearer of p and Tp is the one on the same side.
    """
    coarse = x.vertex_of_full[nearest[x.full_vertices]]
    points = x.fps[: len(x.fps_distances)]
    # Distance to the mirror of a point is that of the mirrored vertex to the point.
    excess = x.fps_distances[:, coarse] - x.fps_distances
    reference = int(excess[np.arange(len(points)), points].argmax())
    of_points = np.sign(excess[reference, points])
    towards = x.interpolation @ (of_points @ x.fps_distances.astype(np.float64) / len(points))
    return towards, places.pulled_back(towards) - towards


def _sides(x: PreparedShape, lead: FloatArray) -> npt.NDArray[np.int8]:
    """Side of each vertex at full resolution, (n,): 1, -1, and 0 along the axis, by how much farther its mirror is."""
    side = np.sign(lead).astype(np.int8)
    a, b = x.oriented.edges.T
    crossing = side[a] * side[b] < 0
    a, b = a[crossing], b[crossing]
    side[np.where(np.abs(lead[a]) <= np.abs(lead[b]), a, b)] = 0
    return side


def no_symmetry(x: PreparedShape, reason: str) -> Symmetry:
    """What is said of a shape without a symmetry: the identity, and why."""
    n, spectrum = x.full.n_vertices, x.full_spectrum
    identity = frozen(np.arange(n))
    return Symmetry(
        False,
        reason,
        identity,
        identity,
        frozen(np.zeros(n, np.int8)),
        frozen(np.zeros(n, bool)),
        frozen(np.full(n, np.nan)),
        np.nan,
        np.nan,
        symmetry_epsilon(spectrum),
        frozen(symmetry_regions(spectrum)),
        barycentric_map(x.full.vertices, identity, x.full),
    )
