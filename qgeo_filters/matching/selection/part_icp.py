"""Maps that differ from a given one in how a part, such as a head, is turned against the rest."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.matching.initialization.agd_extrema import extremities
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.smooth_shells import Finished
from qgeo_filters.parallel import concurrently

# A part is what lies this near to an extremity, in sqrt(area); the map is bent around it, up to this many times that.
_RADIUS, _REACH = 0.2, 1.5
# Fewest vertices of a part, and about as many as are aligned.
_FEWEST, _ALIGNED = 20, 150
# Turns of the alignment, and the weight of normals against positions.
_TURNS = 12
_NORMALS = 0.1
# Alignments that leave less than this of the misfit, and that move the part by more than this, in sqrt(area).
_BETTER, _MOVED = 0.8, 0.04
# The rotations of a cube: one of them is within 63 degrees of any rotation.
_ROTATIONS = Rotation.create_group("O").as_matrix()
_UNTURNED = int(np.trace(_ROTATIONS, axis1=1, axis2=2).argmax())


def turned_parts(x: PreparedShape, y: PreparedShape, result: Finished) -> list[IndexArray]:
    """Maps (n_x,) in which one part is turned so that it fits better, one for each such part, the best fit first.

    Distances hardly tell how a head on a round neck is turned about it, and a deformation that has it wrong stays
    where it is. But the part alone is nearly rigid: it is laid onto Y from 24 directions by iterated closest points.
    If one fits much better than what the map has, the part goes there, and its surroundings half of the way.
    """
    tree = cKDTree(np.column_stack([y.unit.vertices, _NORMALS * y.normals]))
    normals = x.unit.with_vertices(result.positions).vertex_normals
    tried = concurrently(partial(_turned_part, x, result, normals, tree), extremities(x).tolist())
    found = [entry for entry in tried if entry]
    found.sort(key=lambda entry: entry[0])
    kept: list[int] = []
    for i, (_, end, _) in enumerate(found):
        if all(x.rows[end, x.samples[found[j][1]]] > 2 * _RADIUS for j in kept):
            kept.append(i)
    return [found[i][2] for i in kept]


def _turned_part(
    x: PreparedShape, result: Finished, normals: FloatArray, tree: cKDTree, end: int
) -> tuple[float, int, IndexArray] | None:
    """What is left of the misfit, the extremity, and the map with the part around it turned; None if it fits as is."""
    distance = x.rows[end]
    part = np.flatnonzero(distance < _RADIUS)
    if len(part) < _FEWEST:
        return None
    placed, placed_normals = _rigid(x, part, result.positions)
    some = slice(None, None, max(1, len(part) // _ALIGNED))
    aligned, misfits = _aligned(placed[some], placed_normals[some], tree)
    best = int(misfits.argmin())
    turn, start, end_point = _motion(placed[some], aligned[best])
    moved = float(np.linalg.norm((placed - start) @ turn + end_point - result.positions[part], axis=1).mean())
    if misfits[best] >= _BETTER * misfits[_UNTURNED] or moved <= _MOVED:
        return None
    # The motion fades out around the part.
    around = np.flatnonzero(distance < _REACH * _RADIUS)
    share = np.clip((_REACH - distance[around] / _RADIUS) / (_REACH - 1), 0, 1)[:, None]
    bend = Rotation.from_rotvec(share * Rotation.from_matrix(turn.T).as_rotvec())
    positions, directions = result.positions.copy(), normals.copy()
    positions[part], directions[part] = placed, placed_normals
    there = bend.apply(positions[around] - start) + start + share * (end_point - start)
    images = tree.query(np.column_stack([there, _NORMALS * bend.apply(directions[around])]))[1]
    p2p = result.p2p.copy()
    p2p[around] = images
    return float(misfits[best] / misfits[_UNTURNED]), end, p2p


def _motion(points: FloatArray, others: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rotation R and centres a, b so that ``(points - a) @ R + b`` is nearest to others; also of stacks (..., n, 3)."""
    start, end = points.mean(axis=-2), others.mean(axis=-2)
    first = (points - start[..., None, :]).swapaxes(-1, -2)
    u, _, v = np.linalg.svd(first @ (others - end[..., None, :]))
    u[..., 2] *= np.sign(np.linalg.det(u @ v))[..., None]
    return u @ v, start, end


def _rigid(x: PreparedShape, part: IndexArray, positions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The part as it is on X, moved rigidly to where the deformation has it, and its normals."""
    turn, start, end = _motion(x.unit.vertices[part], positions[part])
    return (x.unit.vertices[part] - start) @ turn + end, x.normals[part] @ turn


def _aligned(points: FloatArray, normals: FloatArray, tree: cKDTree) -> tuple[FloatArray, FloatArray]:
    """Positions (24, n, 3) after iterated closest points from each rotation, and the root mean square misfits (24,)."""
    centre = points.mean(axis=0)
    points = (points - centre) @ _ROTATIONS + centre
    normals = normals @ _ROTATIONS
    for _ in range(_TURNS):
        nearest = tree.query(np.concatenate([points, _NORMALS * normals], axis=-1))[1]
        turn, start, end = _motion(points, tree.data[nearest, :3])
        points = (points - start[:, None]) @ turn + end[:, None]
        normals = normals @ turn
    misfits = np.asarray(tree.query(np.concatenate([points, _NORMALS * normals], axis=-1))[0])
    return points, np.sqrt((misfits**2).mean(axis=1))
