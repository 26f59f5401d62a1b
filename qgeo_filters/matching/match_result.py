"""What `match` returns: the map from X to Y, how good it is, and why it was chosen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.matching.maps.barycentric import BarycentricMap
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.surface import Surface


@dataclass(frozen=True, eq=False)
class MatchResult:
    """Map from each vertex of X to a vertex of Y.

    Attributes
    ----------
    x, y : Surface
        The shapes as they were given.
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

    x: Surface
    y: Surface
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
