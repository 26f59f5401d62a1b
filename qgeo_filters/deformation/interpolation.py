"""The way from one position of a surface to another, as rigid as possible at every moment."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from qgeo_filters._typing import FloatArray
from qgeo_filters.deformation.fit_rotations import fit_rotations
from qgeo_filters.deformation.gradients import TriangleFrames
from qgeo_filters.deformation.poisson import PoissonSolver, area_shares
from qgeo_filters.deformation.rotation_walk import RotationWalk
from qgeo_filters.deformation.similarity import Similarity
from qgeo_filters.jit import njit
from qgeo_filters.surface import Surface

# Passes in which rotations are fitted to what the gradients gave, so that lengths are the blended ones.
_PASSES = 4
# Pull towards the linear blend, over the area: it places each piece, and does no more.
_PLACING = 1e-6


class InterpolationPath:
    r"""Positions of a surface between two poses.

    Each triangle's deformation gradient is a rotation times a stretch, F = R S. Stretches are blended linearly, and
    rotations from triangle to triangle (`RotationWalk`), so that a limb that is wound up unwinds; one solve makes
    positions of the gradients, and a few passes of fitting rotations bring the lengths to the blended ones. The turn
    of the whole is taken out before and blended on its own.

    Parameters
    ----------
    start : Surface
    end : (n, 3) float64
        The other pose of its vertices.

    References
    ----------
    Alexa, Cohen-Or, Levin, "As-rigid-as-possible shape interpolation", SIGGRAPH 2000; Sumner, Zwicker, Gotsman,
    Popovic, "Mesh-based inverse kinematics", SIGGRAPH 2005, for gradients of triangles in space; Sorkine and Alexa,
    "As-rigid-as-possible surface modeling", SGP 2007, for the passes.
    """

    def __init__(self, start: Surface, end: FloatArray) -> None:
        self._start, self._end = start.vertices, end
        self._shares = area_shares(start)
        self._whole = Similarity.between(start.vertices, end, self._shares, 1.0)
        self._turn = Rotation.from_matrix(self._whole.rotation).as_rotvec()
        self._frames = TriangleFrames(start.vertices, start.faces)
        aligned = end @ self._whole.rotation
        gradients = self._frames.gradients(aligned)
        rotations = fit_rotations(gradients)
        self._stretches = np.einsum("tji,tjk->tik", rotations, gradients)
        self._rotations = RotationWalk(rotations, start.twins)
        self._solver = PoissonSolver(start.vertices, start.faces, _PLACING * self._shares)

    def __call__(self, t: float) -> FloatArray:
        """Positions (n, 3) at time t: at 0 and 1 the two poses; beyond them the motion goes on."""
        stretch = (1 - t) * np.eye(3) + t * self._stretches
        turned = self._rotations(t)
        # Without the turn of the whole, so that what places the pieces is not a blend that shrinks.
        targets = (1 - t) * self._start + t * self._end @ self._whole.rotation
        positions = self._solver(turned @ stretch, targets)
        for _ in range(_PASSES if 0 < t < 1 else 0):
            positions = self._solver(_fitted(self._frames.gradients(positions), stretch), targets)
        return self._placed(positions, t)

    def _placed(self, positions: FloatArray, t: float) -> FloatArray:
        """Turned as the whole is at that time, the centre of area on the straight way."""
        share = self._shares / self._shares.sum()
        centre = (1 - t) * share @ self._start + t * share @ self._end
        placed: FloatArray = (positions - share @ positions) @ Rotation.from_rotvec(
            t * self._turn
        ).as_matrix().T + centre
        return placed


@njit()
def _fitted(gradients: FloatArray, stretches: FloatArray) -> FloatArray:
    """R S of each triangle, (m, 3, 3), for the rotation R with which it is nearest to the gradient."""
    products = np.zeros(gradients.shape)
    for t in range(len(gradients)):
        for a in range(3):
            for b in range(3):
                for c in range(3):
                    products[t, a, b] += gradients[t, a, c] * stretches[t, b, c]
    rotations = fit_rotations(products)
    products[:] = 0.0
    for t in range(len(gradients)):
        for a in range(3):
            for b in range(3):
                for c in range(3):
                    products[t, a, b] += rotations[t, a, c] * stretches[t, c, b]
    return products
