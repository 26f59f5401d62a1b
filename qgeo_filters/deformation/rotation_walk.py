"""Rotations of neighbouring triangles, a part of the way from none: blended by what separates neighbours."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial.transform import Rotation

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.deformation.frame_lanes import walked_rotations

# A step between triangles that are turned alike: a graph has no edges of weight 0.
_LEAST_STEP = 1e-12


class RotationWalk:
    """Rotations of triangles at any part of the way from none to the given ones.

    A rotation by more than half a turn has the same matrix as one the other way round, and by a whole turn as none at
    all. Those from a triangle to its neighbour are small and have one logarithm: they are blended, and put together
    along a tree, from the triangle of each piece that is turned least. Its steps turn as little as can be, so that
    triangles that are folded over lead nowhere.

    Parameters
    ----------
    rotations : (m, 3, 3) float64
    twins : (m, 3) int
        See `connectivity.halfedge_twins`.

    References
    ----------
    Baran, Vlasic, Grinspun, Popovic, "Semantic deformation transfer", SIGGRAPH 2009, for rotations relative to
    neighbours.
    """

    def __init__(self, rotations: FloatArray, twins: IntArray) -> None:
        m = len(rotations)
        half = np.flatnonzero(twins.ravel() >= 0)
        one, other = half // 3, twins.ravel()[half] // 3
        apart = 3.0 - np.einsum("tij,tij->t", rotations[one], rotations[other])  # of the trace: no less than 0
        steps = np.maximum(apart, 0.0) + _LEAST_STEP
        pieces, piece = connected_components(sparse.csr_array((steps, (one, other)), (m, m)), directed=False)
        order = np.lexsort((-np.trace(rotations, axis1=1, axis2=2), piece))
        roots = order[np.searchsorted(piece[order], np.arange(pieces))]
        # One more node, not turned, from which all pieces are reached.
        # SciPy before 1.16 takes no trees of graphs that are numbered in 64 bits.
        ends = tuple(side.astype(np.int32) for side in (np.r_[one, np.full(pieces, m)], np.r_[other, roots]))
        graph = sparse.csr_array((np.concatenate([steps, np.ones(pieces)]), ends), (m + 1, m + 1))
        walk, before = breadth_first_order(minimum_spanning_tree(graph), m, directed=False)
        self._walk = np.ascontiguousarray(walk[1:], dtype=np.int64)
        self._before = np.ascontiguousarray(before, dtype=np.int64)
        reached_from = np.concatenate([rotations, np.eye(3)[None]])[self._before[:m]]
        steps_of = np.einsum("tji,tjk->tik", reached_from, rotations)
        self._steps: FloatArray = Rotation.from_matrix(steps_of).as_rotvec()

    def __call__(self, times: FloatArray) -> FloatArray:
        """Rotations as unit quaternions (m, 4, lanes), w first, at `LANES` times: at 0 none, at 1 the given ones."""
        return walked_rotations(self._steps, self._walk, self._before, times)
