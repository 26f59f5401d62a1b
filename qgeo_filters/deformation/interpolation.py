"""The way from one position of a surface to another, as rigid as possible at every moment."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial.transform import Rotation

from qgeo_filters._typing import FloatArray
from qgeo_filters.deformation.fit_rotations import fit_rotations
from qgeo_filters.deformation.gradients import TriangleFrames
from qgeo_filters.deformation.poisson import PoissonSolver
from qgeo_filters.deformation.similarity import Similarity
from qgeo_filters.jit import njit
from qgeo_filters.surface import Surface

# Passes in which rotations are fitted to what the gradients gave, so that lengths are the blended ones.
_PASSES = 8
# Pull towards the linear blend, over the area: it places each piece, and does no more.
_PLACING = 1e-6
# A step of the walk between triangles that are turned alike: a graph has no edges of weight 0.
_LEAST_STEP = 1e-12


class InterpolationPath:
    r"""Positions of a surface between two poses.

    Each triangle's deformation gradient is a rotation times a stretch, F = R S. The rotation's logarithm, and the
    stretch, are blended linearly; one solve makes positions of the gradients, and a few passes of fitting rotations
    bring the lengths to the blended ones. The turn of the whole is taken out before and blended on its own.

    Parameters
    ----------
    start : Surface
    end : (n, 3) float64
        The other pose of its vertices.

    Notes
    -----
    A rotation by more than half a turn has the same matrix as one the other way round: of a triangle's logarithms that
    one counts which is nearest to its neighbour's, from triangle to triangle, so that a limb that is wound up unwinds.

    References
    ----------
    Alexa, Cohen-Or, Levin, "As-rigid-as-possible shape interpolation", SIGGRAPH 2000; Sumner, Zwicker, Gotsman,
    Popovic, "Mesh-based inverse kinematics", SIGGRAPH 2005, for gradients of triangles in space; Sorkine and Alexa,
    "As-rigid-as-possible surface modeling", SGP 2007, for the passes.
    """

    def __init__(self, start: Surface, end: FloatArray) -> None:
        self._start, self._end = start.vertices, end
        self._areas = start.vertex_areas if start.area > 0 else np.ones(start.n_vertices)
        self._whole = Similarity.between(start.vertices, end, self._areas, 1.0)
        self._turn = Rotation.from_matrix(self._whole.rotation).as_rotvec()
        self._frames = TriangleFrames(start.vertices, start.faces)
        aligned = end @ self._whole.rotation
        gradients = self._frames.gradients(aligned)
        rotations = fit_rotations(gradients)
        self._stretches = np.einsum("tji,tjk->tik", rotations, gradients)
        self._logarithms = continuous_logarithms(rotations, start)
        self._solver = PoissonSolver(start.vertices, start.faces, _PLACING * self._areas / self._areas.sum())

    def __call__(self, t: float) -> FloatArray:
        """Positions (n, 3) at time t: at 0 and 1 the two poses; beyond them the motion goes on."""
        stretch = (1 - t) * np.eye(3) + t * self._stretches
        turned = Rotation.from_rotvec(t * self._logarithms).as_matrix()
        # Without the turn of the whole, so that what places the pieces is not a blend that shrinks.
        targets = (1 - t) * self._start + t * self._end @ self._whole.rotation
        positions = self._solver(turned @ stretch, targets)
        for _ in range(_PASSES if 0 < t < 1 else 0):
            rotations = _fitted(self._frames.gradients(positions), stretch)
            positions = self._solver(rotations @ stretch, targets)
        return self._placed(positions, t)

    def _placed(self, positions: FloatArray, t: float) -> FloatArray:
        """Turned as the whole is at that time, the centre of area on the straight way."""
        share = self._areas / self._areas.sum()
        centre = (1 - t) * share @ self._start + t * share @ self._end
        placed: FloatArray = (positions - share @ positions) @ Rotation.from_rotvec(
            t * self._turn
        ).as_matrix().T + centre
        return placed


def _fitted(gradients: FloatArray, stretches: FloatArray) -> FloatArray:
    """Rotation R of each triangle for which R S is nearest to its gradient."""
    return fit_rotations(np.einsum("tij,tkj->tik", gradients, stretches))


def continuous_logarithms(rotations: FloatArray, surface: Surface) -> FloatArray:
    """Rotation vectors (m, 3) of the rotations of a surface's triangles (m, 3, 3), without jumps of a whole turn.

    From the triangle of each piece that is turned least, along the tree whose steps turn least, so that triangles that
    are folded over lead nowhere.
    """
    vectors: FloatArray = np.ascontiguousarray(Rotation.from_matrix(rotations).as_rotvec())
    m = len(vectors)
    half = np.flatnonzero(surface.twins.ravel() >= 0)
    one, other = half // 3, surface.twins.ravel()[half] // 3
    apart = 3.0 - np.einsum("tij,tij->t", rotations[one], rotations[other])  # of the trace: no less than 0
    steps = np.maximum(apart, 0.0) + _LEAST_STEP
    pieces, piece = connected_components(sparse.csr_array((steps, (one, other)), (m, m)), directed=False)
    order = np.lexsort((np.linalg.norm(vectors, axis=1), piece))
    roots = order[np.searchsorted(piece[order], np.arange(pieces))]
    # One more node, from which all pieces are reached.
    row, column = np.concatenate([one, np.full(pieces, m)]), np.concatenate([other, roots])
    graph = sparse.csr_array((np.concatenate([steps, np.ones(pieces)]), (row, column)), (m + 1, m + 1))
    tree = minimum_spanning_tree(graph)
    walk, before = breadth_first_order(tree, m, directed=False)
    _without_jumps(vectors, walk[1:].astype(np.int64), before.astype(np.int64))
    return vectors


@njit()
def _without_jumps(vectors: FloatArray, walk: npt.NDArray[np.int64], before: npt.NDArray[np.int64]) -> None:
    """Add whole turns about its axis to each vector, so that it is nearest to the one that the walk came from."""
    root = len(vectors)
    for t in walk:
        angle = np.sqrt(vectors[t, 0] ** 2 + vectors[t, 1] ** 2 + vectors[t, 2] ** 2)
        if before[t] == root or angle == 0.0:
            continue
        along = 0.0
        for c in range(3):
            along += vectors[before[t], c] * vectors[t, c] / angle
        turns = np.round((along - angle) / (2 * np.pi))
        for c in range(3):
            vectors[t, c] *= (angle + 2 * np.pi * turns) / angle
