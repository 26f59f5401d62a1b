"""Controls: what must not be found, or not be sure, and beside each the nearest case that must."""

from __future__ import annotations

import functools
from pathlib import Path

import igl
import numpy as np
import pymeshlab
import pytest
import shapes
from shapes import Mesh, blob, creature, crooked, icosphere, torus

from qgeo_filters.evaluation.errors import geodesic_error
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.surface import Surface

COW = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"
# The cow's plane of symmetry is x = 0.
MIRROR = np.array([-1, 1, 1])


def bent(mesh: Mesh, amount: float = 0.15) -> Mesh:
    """The shape bent about the x axis and then about a slanting one, so that no plane mirrors it."""
    vertices, faces = mesh
    for axes in ((0, 1, 2), (2, 0, 1)):
        vertices = shapes.bent(vertices[:, axes], amount)[:, np.argsort(axes)]
    return vertices, faces


def turned(mesh: Mesh, seed: int = 0) -> Mesh:
    """The same shape with its vertices in another order and in another place."""
    vertices, faces = mesh
    random = np.random.default_rng(seed)
    order = random.permutation(len(vertices))
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    return 3 * vertices[order] @ (turn * np.linalg.det(turn)).T, np.argsort(order)[faces]


def ellipsoid(*axes: float) -> Mesh:
    """An ellipsoid of 162 vertices."""
    vertices, faces = icosphere(2)
    return vertices * axes, faces


@functools.cache
def described(seed: int, level: int = 2) -> PreparedShape:
    return PreparedShape(Surface(*crooked(seed, level)))


#: What turns onto itself in many ways.
ROUND = {
    "sphere": icosphere(2),
    "torus": torus(18, 9),
    "spheroid": ellipsoid(1, 0.6, 0.6),
    "ellipsoid": ellipsoid(1, 0.7, 0.5),
}


@functools.cache
def round_shape(name: str) -> PreparedShape:
    return PreparedShape(Surface(*ROUND[name]))


@functools.cache
def cow() -> Surface:
    """PyMeshLab's cow with a third of its vertices."""
    vertices, faces = igl.read_triangle_mesh(str(COW))
    vertices, faces, _, _ = igl.qslim(np.asfortranarray(vertices), np.asfortranarray(faces.astype(np.int32)), 1900)
    return Surface(vertices, faces)


def assert_none(surface: Surface | PreparedShape, reason: str) -> None:
    found = self_symmetry(surface)
    assert not found.found
    assert reason in found.reason
    assert np.array_equal(found.p2p, np.arange(len(found.p2p)))
    assert not found.side.any()
    assert not found.fixed.any()
    # Not 0, which would be a perfect symmetry.
    assert np.isnan(found.asymmetry).all()
    assert np.isnan(found.score)


@pytest.mark.parametrize("seed", range(10))
def test_a_creature_without_left_and_right_has_no_symmetry(seed: int) -> None:
    assert_none(described(seed), "relates parts of different shape")


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "strength"), [(4, 0.35), (7, 0.35), (8, 0.35), (2, 0.8)])
def test_a_smooth_blob_without_left_and_right_has_no_symmetry(seed: int, strength: float) -> None:
    """Of the first ten of either strength two that are farthest from any mirror image, and two that are nearest."""
    assert_none(Surface(*blob(3, seed, strength)), "relates parts of different shape")


@pytest.mark.parametrize("name", list(ROUND))
def test_of_many_reflections_none_is_singled_out(name: str) -> None:
    assert_none(round_shape(name), "family of symmetries")


def test_a_limb_of_half_the_length_ends_the_symmetry() -> None:
    assert_none(Surface(*creature(left=0.5)), "relates parts of different shape")


def test_bending_does_not_end_the_symmetry() -> None:
    """No plane mirrors the bent creature, but distances on it hardly know."""
    vertices, faces = creature()
    surface = Surface(*bent((vertices, faces)))
    found = self_symmetry(surface)
    assert found.found, found.reason
    mirror = np.linalg.norm(vertices[:, None] - vertices * MIRROR, axis=2).argmin(axis=1)
    assert geodesic_error(found.nearest, mirror, surface).mean() < 0.03
    assert np.array_equal(found.p2p[found.p2p], np.arange(len(vertices)))


def test_the_cow_is_symmetric() -> None:
    surface = cow()
    found = self_symmetry(surface)
    assert found.found, found.reason
    v = surface.vertices
    gaps = np.linalg.norm(v[found.nearest] - v * MIRROR, axis=1) / np.sqrt(surface.area)
    # The two sides have other vertices: even the vertex nearest to a mirror point is .008 away.
    assert gaps.mean() < 0.015
    away = np.abs(v[:, 0]) > 0.05 * np.sqrt(surface.area)
    assert abs((np.sign(v[away, 0]) * found.side[away]).mean()) > 0.97


@pytest.mark.slow
def test_different_creatures_are_not_matched_with_confidence() -> None:
    """Of the first pairs the one whose best map stood clearest of the others."""
    found = match(described(1, level=3), described(2, level=3))
    assert not found.confident
    assert found.explanation


@pytest.mark.slow
@pytest.mark.thorough
def test_a_blob_and_another_and_a_torus_are_not_matched_with_confidence() -> None:
    shape = PreparedShape(Surface(*blob(3, 0)))
    assert not match(shape, Surface(*blob(3, 1))).confident
    assert not match(shape, Surface(*torus(32, 16))).confident


@pytest.mark.parametrize("seed", [0, 1])
def test_a_bent_copy_is_matched_with_confidence_and_right(seed: int) -> None:
    mesh = bent(crooked(seed, 2))
    found = match(described(seed), Surface(*mesh))
    assert found.confident, found.explanation
    assert found.orientation > 0.6
    assert geodesic_error(found.p2p, np.arange(len(mesh[0])), Surface(*mesh)).mean() < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sphere", "torus", "ellipsoid"])
def test_what_turns_onto_itself_is_not_matched_to_itself_with_confidence(name: str) -> None:
    """Every rotation of it is as good a map as the identity."""
    found = match(round_shape(name), round_shape(name))
    assert not found.confident
    assert "more than one way" in found.explanation


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sphere", "torus"])
def test_what_turns_onto_itself_is_not_matched_to_a_turned_copy_with_confidence(name: str) -> None:
    found = match(round_shape(name), Surface(*turned(ROUND[name])))
    assert not found.confident
    assert "more than one way" in found.explanation
