"""Maps that differ from a given one in how a part, such as a head, is turned against the rest."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.matching.initialization.agd_extrema import agd_extrema
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.smooth_shells import DenseMap
from qgeo_filters.parallel import concurrently

# The rotations of a cube: one of them is within 63 degrees of any rotation.
_ROTATIONS = Rotation.create_group("O").as_matrix()
_UNTURNED = int(np.trace(_ROTATIONS, axis1=1, axis2=2).argmax())


def turned_parts(problem: MatchProblem, dense: DenseMap) -> list[IndexArray]:
    """Maps (n_x,) in which one part is turned so that it fits better, one for each such part, the best fit first.

    Distances hardly tell how a head on a round neck is turned about it, and a deformation that has it wrong stays
    where it is. But the part alone is nearly rigid: it is laid onto Y from 24 directions by iterated closest points.
    If one fits much better than what the map has, the part goes there, and its surroundings half of the way.
    """
    x, y, given = problem.x, problem.y, problem.parameters
    tree = cKDTree(np.column_stack([y.unit.vertices, given.part_normals * y.normals]))
    normals = x.unit.with_vertices(dense.positions).vertex_normals
    tried = concurrently(partial(_turned_part, problem, dense, normals, tree), agd_extrema(x, given).tolist())
    found = [entry for entry in tried if entry]
    found.sort(key=lambda entry: entry[0])
    kept: list[int] = []
    for i, (_, end, _) in enumerate(found):
        if all(x.fps_distances[end, x.fps[found[j][1]]] > 2 * given.part_radius for j in kept):
            kept.append(i)
    return [found[i][2] for i in kept]


def _turned_part(
    problem: MatchProblem, dense: DenseMap, normals: FloatArray, tree: cKDTree, end: int
) -> tuple[float, int, IndexArray] | None:
    """What is left of the misfit, the extremum, and the map with the part around it turned; None if it fits as is."""
    x, given = problem.x, problem.parameters
    distance = x.fps_distances[end]
    part = np.flatnonzero(distance < given.part_radius)
    if len(part) < given.part_fewest:
        return None
    placed, placed_normals = _moved_rigidly(x, part, dense.positions)
    some = slice(None, None, max(1, len(part) // given.part_aligned))
    aligned, misfits = _aligned(placed[some], placed_normals[some], tree, given)
    best = int(misfits.argmin())
    turn, start, end_point = rigid_motion(placed[some], aligned[best])
    moved = float(np.linalg.norm((placed - start) @ turn + end_point - dense.positions[part], axis=1).mean())
    if misfits[best] >= given.part_better * misfits[_UNTURNED] or moved <= given.part_moved:
        return None
    # The motion fades out around the part.
    around = np.flatnonzero(distance < given.part_reach * given.part_radius)
    share = np.clip((given.part_reach - distance[around] / given.part_radius) / (given.part_reach - 1), 0, 1)[:, None]
    bend = Rotation.from_rotvec(share * Rotation.from_matrix(turn.T).as_rotvec())
    positions, directions = dense.positions.copy(), normals.copy()
    positions[part], directions[part] = placed, placed_normals
    there = bend.apply(positions[around] - start) + start + share * (end_point - start)
    images = tree.query(np.column_stack([there, given.part_normals * bend.apply(directions[around])]))[1]
    p2p = dense.p2p.copy()
    p2p[around] = images
    return float(misfits[best] / misfits[_UNTURNED]), end, p2p


def rigid_motion(points: FloatArray, others: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rotation R and centres a, b so that ``(points - a) @ R + b`` is nearest to others; also of stacks (..., n, 3)."""
    start, end = points.mean(axis=-2), others.mean(axis=-2)
    first = (points - start[..., None, :]).swapaxes(-1, -2)
    u, _, v = np.linalg.svd(first @ (others - end[..., None, :]))
    u[..., 2] *= np.sign(np.linalg.det(u @ v))[..., None]
    return u @ v, start, end


def _moved_rigidly(x: PreparedShape, part: IndexArray, positions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The part as it is on X, moved rigidly to where the deformation has it, and its normals."""
    turn, start, end = rigid_motion(x.unit.vertices[part], positions[part])
    return (x.unit.vertices[part] - start) @ turn + end, x.normals[part] @ turn


def _aligned(
    points: FloatArray, normals: FloatArray, tree: cKDTree, given: MatchingParameters
) -> tuple[FloatArray, FloatArray]:
    """Positions (24, n, 3) after iterated closest points from each rotation, and the root mean square misfits (24,)."""
    centre = points.mean(axis=0)
    points = (points - centre) @ _ROTATIONS + centre
    normals = normals @ _ROTATIONS
    for _ in range(given.part_iterations):
        nearest = tree.query(np.concatenate([points, given.part_normals * normals], axis=-1))[1]
        turn, start, end = rigid_motion(points, tree.data[nearest, :3])
        points = (points - start[:, None]) @ turn + end[:, None]
        normals = normals @ turn
    misfits = np.asarray(tree.query(np.concatenate([points, given.part_normals * normals], axis=-1))[0])
    return points, np.sqrt((misfits**2).mean(axis=1))
