"""The way from one pose to another: exact at its ends, rigid where it can be, and unwinding what was wound up."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import arched, blob, creature, cylinder, icosphere

from qgeo_filters.deformation.interpolation import InterpolationPath
from qgeo_filters.deformation.similarity import Similarity
from qgeo_filters.surface import Surface


def moved(vertices: np.ndarray, by: list[float]) -> np.ndarray:
    return vertices + np.array(by)


def lengths(surface: Surface, positions: np.ndarray) -> np.ndarray:
    ends = positions[surface.edges]
    return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)


def volume(surface: Surface, positions: np.ndarray) -> float:
    a, b, c = (positions[surface.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def test_the_ends_are_exact() -> None:
    start = Surface(*creature())
    end = arched(start.vertices, 1.0) * 1.3 + 0.05 * np.random.default_rng(0).normal(size=start.vertices.shape)
    way = InterpolationPath(start, end)
    np.testing.assert_allclose(way(0.0), start.vertices, atol=1e-9)
    np.testing.assert_allclose(way(1.0), end, atol=1e-9)


@pytest.mark.parametrize("angle", [1.0, 2.0, 3.1])
def test_a_rigid_motion_is_rigid_on_the_way(angle: float) -> None:
    start = Surface(*blob(2))
    axis = np.array([1.0, 2.0, -1.0]) / np.sqrt(6)
    end = start.vertices @ Rotation.from_rotvec(angle * axis).as_matrix().T + [4, 0, 1]
    middle = InterpolationPath(start, end)(0.5)
    np.testing.assert_allclose(lengths(start, middle), lengths(start, start.vertices), rtol=1e-6)
    turned = start.vertices @ Rotation.from_rotvec(0.5 * angle * axis).as_matrix().T
    np.testing.assert_allclose(middle - middle.mean(axis=0), turned - turned.mean(axis=0), atol=1e-6)


def test_growth_is_even() -> None:
    start = Surface(*blob(2))
    found = InterpolationPath(start, 3 * start.vertices)(0.25)
    np.testing.assert_allclose(lengths(start, found), 1.5 * lengths(start, start.vertices), rtol=1e-6)


@pytest.mark.parametrize("turns", [0.4, 1.5, 3.0])
def test_a_rod_that_was_wound_up_unwinds(turns: float) -> None:
    """Twisted by three turns, its end is turned by one and a half in the middle, not by none or by half a one."""
    vertices, faces = cylinder(24, 120, radius=0.1, height=3.0)
    start = Surface(vertices, faces)

    def twisted(share: float) -> np.ndarray:
        angle = 2 * np.pi * turns * share * (vertices[:, 2] / 3.0 - 0.5)
        x, y, z = vertices.T
        return np.column_stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle), z])

    found = InterpolationPath(start, twisted(1.0))(0.5)
    back = Similarity.between(found, twisted(0.5), np.ones(len(found)), 1.0)  # the whole may be turned either way
    assert np.linalg.norm(back(found) - twisted(0.5), axis=1).max() < 0.07


def test_a_creature_that_bends_neither_shrinks_nor_stretches() -> None:
    start = Surface(*creature())
    end = arched(start.vertices, 1.2)
    for t in (0.25, 0.5, 0.75):
        found = InterpolationPath(start, end)(t)
        blend = (1 - t) * lengths(start, start.vertices) + t * lengths(start, end)
        assert np.abs(lengths(start, found) / blend - 1).mean() < 0.015
        expected = (1 - t) * volume(start, start.vertices) + t * volume(start, end)
        assert volume(start, found) == pytest.approx(expected, rel=0.03)


def test_the_way_back_is_the_way_there() -> None:
    start = Surface(*creature())
    end = arched(start.vertices, 1.0)
    there, back = InterpolationPath(start, end), InterpolationPath(start.with_vertices(end), start.vertices)
    assert np.linalg.norm(there(0.3) - back(0.7), axis=1).max() < 0.02 * np.sqrt(start.area)


def test_pieces_each_go_their_own_way() -> None:
    vertices, faces = icosphere(1)
    start = Surface(
        np.concatenate([vertices, moved(vertices, [4, 0, 0])]), np.concatenate([faces, faces + len(vertices)])
    )
    end = np.concatenate([moved(vertices, [0, 2, 0]), moved(vertices, [4, -2, 0])])
    found = InterpolationPath(start, end)(0.5)
    assert np.abs(lengths(start, found) / lengths(start, start.vertices) - 1).max() < 0.02


def test_flat_triangles_and_vertices_without_any_are_borne() -> None:
    vertices, faces = blob(2)
    start = Surface(np.vstack([vertices, [9.0, 9, 9], vertices[:1]]), np.vstack([faces, [[0, 1, len(vertices) + 1]]]))
    end = moved(start.vertices, [1.0, 0, 0])
    found = InterpolationPath(start, end)(0.5)
    np.testing.assert_allclose(found[: len(vertices)], moved(vertices, [0.5, 0, 0]), atol=1e-4)
    assert np.isfinite(found).all()
