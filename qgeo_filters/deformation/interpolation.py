"""The way from one position of a surface to another, as rigid as possible at every moment."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from qgeo_filters._typing import FloatArray
from qgeo_filters.cholesky import BlockSolver
from qgeo_filters.deformation.fit_rotations import fit_rotations
from qgeo_filters.deformation.frame_lanes import LANES, fitted_sums, turned_sums
from qgeo_filters.deformation.gradients import TriangleFrames
from qgeo_filters.deformation.poisson import area_shares, half_cotangents, poisson_matrix
from qgeo_filters.deformation.rotation_walk import RotationWalk
from qgeo_filters.deformation.similarity import Similarity
from qgeo_filters.surface import Surface

# Passes in which rotations are fitted to what the gradients gave, so that lengths are the blended ones.
_PASSES = 4
# An angle so near to half a turn is one up to rounding, and goes either way.
_HALF_TURN = 1e-9
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
        self._turn = _turn(self._whole.rotation)
        frames = TriangleFrames(start.vertices, start.faces)
        gradients = frames.gradients(end @ self._whole.rotation)
        rotations = fit_rotations(gradients)
        stretches = np.einsum("tji,tjk->tik", rotations, gradients)
        self._rotations = RotationWalk(rotations, start, end)
        corners = start.vertices[frames.faces]
        sides = np.ascontiguousarray(corners[:, 1:] - corners[:, :1])
        cotangents = half_cotangents(start.vertices, start.faces)
        self._sides = frames.faces, cotangents, sides, np.einsum("tij,tsj->tsi", stretches, sides)
        self._fitting = frames.inverses, np.einsum("tij,tkj->tik", frames.inverses, stretches), frames.flat
        self._pull = _PLACING * self._shares
        self._solve = BlockSolver(poisson_matrix(frames.faces, cotangents, self._pull), start.vertices)

    def __call__(self, t: float) -> FloatArray:
        """Positions (n, 3) at time t: at 0 and 1 the two poses; beyond them the motion goes on."""
        return next(self.frames(np.array([t])))

    def frames(self, times: FloatArray) -> Iterator[FloatArray]:
        """Positions at each of the times, several computed side by side: a third of the time of one after the other."""
        for first in range(0, len(times), LANES):
            some = times[first : first + LANES]
            block = self._block(some)
            for lane, t in enumerate(some):
                yield self._placed(block[:, :, lane], t)

    def _block(self, times: FloatArray) -> FloatArray:
        """Positions (n, 3, lanes) at so many times or fewer, the turn of the whole taken out."""
        count = len(times)
        lanes = np.append(times, np.full(LANES - count, times[-1]))
        # Without that turn, so that what places the pieces is not a blend that shrinks.
        targets = self._start[..., None] * (1 - lanes) + (self._end @ self._whole.rotation)[..., None] * lanes
        targets *= self._pull[:, None, None]
        right = targets.copy()
        turned_sums(*self._sides, lanes, self._rotations(lanes), right)
        positions = found = self._solved(right, count)
        between = (lanes > 0) & (lanes < 1)
        for _ in range(_PASSES if between.any() else 0):
            right[:] = targets
            fitted_sums(*self._sides, *self._fitting, lanes, positions, right)
            positions = self._solved(right, count)
        return np.where(between, positions, found)

    def _solved(self, right: FloatArray, count: int) -> FloatArray:
        """Positions for the first right-hand sides; the other lanes hold what they held."""
        if count == LANES:
            return self._solve(right.reshape(len(right), -1)).reshape(right.shape)
        positions = right.copy()
        some = self._solve(np.ascontiguousarray(right[..., :count]).reshape(len(right), -1))
        positions[..., :count] = some.reshape(len(right), 3, count)
        return positions

    def _placed(self, positions: FloatArray, t: float) -> FloatArray:
        """Turned as the whole is at that time, the centre of area on the straight way."""
        share = self._shares / self._shares.sum()
        centre = (1 - t) * share @ self._start + t * share @ self._end
        placed: FloatArray = (positions - share @ positions) @ Rotation.from_rotvec(
            t * self._turn
        ).as_matrix().T + centre
        return placed


def _turn(rotation: FloatArray) -> FloatArray:
    """Rotation vector; of the two of half a turn always the same, which is not that of rounding."""
    vector: FloatArray = Rotation.from_matrix(rotation).as_rotvec()
    if np.linalg.norm(vector) > np.pi - _HALF_TURN and vector[np.abs(vector).argmax()] < 0:
        return -vector
    return vector
