"""Rotations of neighbouring triangles, a part of the way from none: blended by what separates neighbours."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial.transform import Rotation

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.cholesky import BlockSolver
from qgeo_filters.deformation.rotation_lanes import disagreements, turn, walked_rotations
from qgeo_filters.surface import Surface

# Turns and ways that differ by less are equal up to rounding: then places decide, which do not depend on the order of
# vertices and triangles.
_EQUAL = 1e-9
# Length of a step that turns nothing, beside the squares of angles: ways are short where nothing turns, too.
_HOP = 0.01
# Steps of this angle, in radians, count a quarter of none: what is folded over is not asked which way.
_COUNTED = 0.1


class RotationWalk:
    """Rotations of triangles at any part of the way from none to the given ones.

    A rotation by more than half a turn has the same matrix as one the other way round, and by a whole turn as none at
    all. Those from a triangle to its neighbour are small and have one logarithm: they are blended, and put together
    along a tree, from the triangle of each piece that is turned least. Its ways are the shortest, the squares of angles
    summed, so that triangles that are folded over lead nowhere. Blended steps do not close around a vertex: along
    another tree they lead elsewhere. So the rotations are brought to where they agree best with the steps to all
    neighbours, by one step of Gauss and Newton, and it hardly matters which of many equal ways the tree took.

    Parameters
    ----------
    rotations : (m, 3, 3) float64
    start : Surface
    end : (n, 3) float64
        The poses between which they turn: where steps turn alike, their places order them.

    References
    ----------
    Baran, Vlasic, Grinspun, Popovic, "Semantic deformation transfer", SIGGRAPH 2009, for rotations relative to
    neighbours; Chatterjee and Govindu, "Efficient and robust large-scale rotation averaging", ICCV 2013, for the
    step.
    """

    def __init__(self, rotations: FloatArray, start: Surface, end: FloatArray) -> None:
        m = len(rotations)
        half = np.flatnonzero(start.twins.ravel() > np.arange(3 * m))
        one, other = half // 3, start.twins.ravel()[half].astype(np.int64) // 3
        between = _rotation_vectors(rotations[one], rotations[other])
        self._walk, self._before = _tree(rotations, np.linalg.norm(between, axis=1), one, other, start, end)
        reached_from = np.concatenate([rotations, np.eye(3)[None]])[self._before[:m]]
        self._steps = _rotation_vectors(reached_from, rotations)
        weights = (1 + np.einsum("ei,ei->e", between, between) / _COUNTED**2) ** -2.0
        beside = (self._before[one] != other) & (self._before[other] != one)  # along the tree all agree
        sides = np.stack([one[beside], other[beside]], axis=1)
        self._beside = sides, between[beside], weights[beside]
        counted = sparse.csc_array((np.tile(weights, 2), (np.r_[one, other], np.r_[other, one])), (m, m))
        diagonal = counted.sum(axis=1)
        diagonal[self._walk[self._before[self._walk] == m]] += 1.0  # the first of each piece stays
        centres = start.vertices[start.faces].mean(axis=1)
        self._agreed = BlockSolver((sparse.diags_array(diagonal) - counted).tocsc(), centres)

    def __call__(self, times: FloatArray) -> FloatArray:
        """Rotations as unit quaternions (m, 4, lanes), w first, at `LANES` times: at 0 none, at 1 the given ones."""
        rotations = walked_rotations(self._steps, self._walk, self._before, times)
        apart = disagreements(*self._beside, times, rotations)
        turn(rotations, self._agreed(apart.reshape(len(apart), -1)).reshape(apart.shape))
        return rotations


def _tree(
    rotations: FloatArray, angles: FloatArray, one: IndexArray, other: IndexArray, start: Surface, end: FloatArray
) -> tuple[IndexArray, IndexArray]:
    """Triangles from the first of each piece on, and from which each is reached, m for the first ones."""
    m = len(rotations)
    place = np.empty(start.n_vertices, dtype=np.int64)
    place[np.lexsort((*end.T, *start.vertices.T))] = np.arange(start.n_vertices)
    rank = np.empty(m, dtype=np.int64)
    rank[np.lexsort(np.sort(place[start.faces], axis=1).T)] = np.arange(m)
    ways = angles**2 + _HOP
    graph = sparse.csr_array((ways, (one.astype(np.int32), other.astype(np.int32))), (m, m))
    pieces, piece = connected_components(graph, directed=False)
    order = np.lexsort((rank, np.round((3.0 - np.trace(rotations, axis1=1, axis2=2)) / _EQUAL), piece))
    roots = order[np.searchsorted(piece[order], np.arange(pieces))]
    far = dijkstra(graph, directed=False, indices=roots, min_only=True)
    # Of neighbours that lie on ways of one length, up to rounding, the first by its place leads there.
    tails, heads = np.r_[one, other], np.r_[other, one]
    on_way = far[tails] + np.r_[ways, ways] <= far[heads] + _EQUAL
    tails, heads = tails[on_way], heads[on_way]
    order = np.lexsort((rank[tails], heads))
    before = np.full(m, m)
    before[heads[order][::-1]] = tails[order][::-1]
    before[roots] = m
    return np.lexsort((rank, far)).astype(np.int64), before.astype(np.int64)


def _rotation_vectors(one: FloatArray, other: FloatArray) -> FloatArray:
    """What turns one rotation into the other, in the frame of the one."""
    vectors: FloatArray = Rotation.from_matrix(np.einsum("tji,tjk->tik", one, other)).as_rotvec()
    return vectors
