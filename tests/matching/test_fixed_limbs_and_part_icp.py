"""Reflections that leave limbs in place, and parts that are turned against the rest."""

from __future__ import annotations

import numpy as np
from shapes import icosphere

from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.problem import MatchProblem
from qgeo_filters.matching.selection.fixed_limbs import leaves_limbs
from qgeo_filters.matching.selection.part_icp import turned_parts
from qgeo_filters.matching.smooth_shells import DenseMap
from qgeo_filters.surface import Surface

#: Everything at full resolution.
FULL = MatchingParameters(search_vertices=10_000, registration_vertices=10_000)
MIRROR = np.array([-1, 1, 1])


def nearest(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[:, None] - others, axis=2).argmin(axis=1)


def test_limbs_mirrored_into_themselves_are_told_from_limbs_exchanged() -> None:
    directions, faces = icosphere(3)
    limbs = np.array([(0.6, 0.7, -0.6), (-0.6, 0.7, -0.6), (0.6, -0.7, -0.6), (-0.6, -0.7, -0.6), (0, 1, 0.4)])
    limbs /= np.linalg.norm(limbs, axis=1, keepdims=True)
    vertices = directions * (0.6 + np.exp(12 * (directions @ limbs.T - 1)) @ [1.2, 1.2, 0.9, 0.9, 0.8])[:, None]
    shape = PreparedShape(Surface(vertices, faces))
    true = nearest(vertices * MIRROR, vertices)
    # The front limbs in planes through their own axes instead.
    false = true.copy()
    for axis in limbs[:2]:
        across = np.cross(axis, [0, 0, 1])
        across /= np.linalg.norm(across)
        limb = np.flatnonzero(directions @ axis > 0.9)
        false[limb] = nearest(vertices[limb] - 2 * np.outer(vertices[limb] @ across, across), vertices)
    assert leaves_limbs(MatchProblem.of_reflection(shape), false, true)
    assert not leaves_limbs(MatchProblem.of_reflection(shape), true, false)
    assert not leaves_limbs(MatchProblem.of_reflection(shape), true, true)
    # A map of front to back leaves nothing in place, nor does one that takes the head, which is on the axis, elsewhere.
    back = nearest(vertices * [1, -1, 1], vertices)
    assert not leaves_limbs(MatchProblem.of_reflection(shape), true, back)
    assert not leaves_limbs(MatchProblem.of_reflection(shape), back, true)
    elsewhere = true.copy()
    elsewhere[directions @ limbs[4] > 0.9] = int((vertices @ limbs[2]).argmax())
    assert not leaves_limbs(MatchProblem.of_reflection(shape), true, elsewhere)


def test_a_turned_part_is_turned_back_and_a_right_one_left_alone() -> None:
    """A rod that ends in a paddle without symmetry, twisted by 120 degrees against the map."""
    vertices, faces = icosphere(4)
    x, y, z = vertices.T
    wide = np.where(z > 0.6, 1 + 6 * (z - 0.6), 1.0)
    v = np.column_stack([x * 0.35 * np.where(x > 0, wide, np.sqrt(wide)), y * 0.35 / wide, 1.5 * z])
    shape = PreparedShape(Surface(v, faces), parameters=FULL)
    unit, same = shape.unit.vertices, np.arange(len(v))
    nothing = np.zeros((0, 0), np.float32)
    assert turned_parts(MatchProblem(shape, shape, FULL), DenseMap(same, same, unit, nothing, nothing)) == []
    angle = np.deg2rad(120) * np.clip((v[:, 2] - 0.3) / 0.5, 0, 1)
    c, s = np.cos(angle), np.sin(angle)
    twisted = np.column_stack([c * unit[:, 0] - s * unit[:, 1], s * unit[:, 0] + c * unit[:, 1], unit[:, 2]])
    p2p = nearest(twisted, unit)
    proposed = turned_parts(MatchProblem(shape, shape, FULL), DenseMap(p2p, p2p, twisted, nothing, nothing))
    end = v[:, 2] > 1.2
    before, after = (np.linalg.norm(unit[q[end]] - unit[end], axis=1).mean() for q in (p2p, proposed[0]))
    assert before > 0.05
    assert after < 0.01
