"""From coarse to fine: what a shape has at each resolution, and maps that are found coarse, at full resolution."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from shapes import bent, crooked, limbed

import qgeo_filters as qg
from qgeo_filters.matching.maps.involution import optimal_involution
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.surface import Surface

#: A coarse level of 600 vertices and a fine one of 1500 for a body of 2562.
SMALL = MatchingParameters(search_vertices=600, registration_vertices=1500)
LIMBS = ((0.7, 0.6, -0.4), (-0.5, 0.8, -0.4), (0, -1, 0.3), (0, 0.6, 0.8))


@functools.cache
def body(bend: float) -> Surface:
    """A body with four unequal limbs and no symmetry."""
    vertices, faces = limbed(LIMBS, (1.2, 0.9, 0.7, 0.4), 4)
    return Surface(100 * bent(vertices, bend) + [5, 6, 7], faces)


@functools.cache
def prepared(bend: float) -> PreparedShape:
    return PreparedShape(body(bend), parameters=SMALL)


@functools.cache
def found(bend: float = 0.15) -> qg.MatchResult:
    return qg.match(prepared(0.0), prepared(bend))


def test_each_level_has_its_resolution() -> None:
    shape = prepared(0.0)
    assert (shape.full.n_vertices, shape.fine.n_vertices, shape.n_vertices) == (2562, 1500, 600)
    for level in (shape, shape.fine):
        assert level.unit.area == pytest.approx(1)
        np.testing.assert_allclose(level.unit.vertices * level.scale + level.centre, level.surface.vertices, atol=1e-10)
        functions = level.laplacian[:, :20].astype(np.float64)
        np.testing.assert_allclose(functions.T @ (level.areas[:, None] * functions), np.eye(20), atol=0.05)


def test_a_shape_that_is_small_has_one_level_and_is_not_copied() -> None:
    shape = PreparedShape(body(0.0), parameters=MatchingParameters(search_vertices=2500))
    assert shape.surface is shape.full
    assert shape.fine is shape
    np.testing.assert_array_equal(shape.full_vertices, np.arange(2562))
    np.testing.assert_array_equal(shape.vertex_of_full, np.arange(2562))


def test_places_on_the_coarse_level_are_near() -> None:
    """Coordinates, which are linear, come back to within the gap between the surfaces."""
    shape = prepared(0.0)
    np.testing.assert_allclose(np.asarray(shape.interpolation.sum(axis=1)).ravel(), 1, atol=1e-9)
    moved = shape.interpolation @ shape.surface.vertices - shape.full.vertices
    assert np.linalg.norm(moved, axis=1).max() < 0.03 * np.sqrt(shape.full.area)
    nearest = np.linalg.norm(shape.full.vertices[shape.full_vertices] - shape.surface.vertices, axis=1)
    assert nearest.max() < 0.03 * np.sqrt(shape.full.area)
    assert len(np.unique(shape.full_vertices)) == shape.n_vertices


@pytest.mark.parametrize("bend", [0.15, pytest.param(0.25, marks=[pytest.mark.slow, pytest.mark.thorough])])
def test_the_map_is_one_of_all_vertices(bend: float) -> None:
    """At .25 the quick search is in doubt."""
    y, scale = body(bend), np.sqrt(body(bend).area)
    map_ = found(bend)
    assert map_.p2p.shape == map_.inverse.shape == map_.distortion.shape == (2562,)
    for images in (map_.p2p, map_.inverse):
        assert np.linalg.norm(y.vertices[images] - y.vertices, axis=1).mean() < 0.02 * scale
    assert np.linalg.norm(map_.positions - y.vertices, axis=1).mean() < 0.02 * scale
    places = map_.barycentric.pulled_back(y.vertices)
    assert np.linalg.norm(places - y.vertices, axis=1).mean() < 0.02 * scale
    assert map_.confident
    assert map_.score < 0.05


def test_a_match_leaves_no_factorisation_behind() -> None:
    """They are larger than all else of a shape: an evening of matches must not collect them."""
    found()
    assert prepared(0.0).arap.n_factorised == prepared(0.0).fine.arap.n_factorised == 0


@pytest.mark.slow
def test_a_mirror_image_is_matched_as_one_at_full_resolution() -> None:
    vertices, faces = crooked(0)
    tiny = MatchingParameters(search_vertices=400, registration_vertices=500)
    image = Surface(vertices * [1, 1, -1], faces[:, ::-1])
    map_ = qg.match(Surface(vertices, faces), image, parameters=tiny)
    assert map_.orientation < -0.5
    assert map_.confident
    assert "mirror image" in map_.explanation
    moved = np.linalg.norm(map_.positions - image.vertices, axis=1)
    assert moved.mean() < 0.03 * np.sqrt(image.area)


@pytest.mark.slow
@pytest.mark.thorough
def test_distances_are_compared_at_full_resolution() -> None:
    """Against the definition, with distances on the surfaces as they were given."""
    x, map_ = prepared(0.0), found()
    probes = x.full_vertices[x.fps[: SMALL.probes]]
    sources = (body(0.0), probes), (body(0.15), map_.p2p[probes])
    of_x, of_y = (qg.distances(s, vertices) / np.sqrt(s.area) for s, vertices in sources)
    expected = np.abs(of_x - of_y[:, map_.p2p]).mean(axis=0)
    assert np.abs(map_.distortion - expected).mean() < 0.004
    assert map_.score == pytest.approx(float(map_.x.vertex_areas @ expected / map_.x.area), abs=0.003)


def test_the_involution_of_many_points_pairs_what_is_mirrored() -> None:
    """More than are matched at the least cost: exact mirror images are found, and what has none stays alone."""
    random = np.random.default_rng(0)
    right = random.uniform(0.1, 1, size=(7000, 3))
    points = np.concatenate([right, right * [-1, 1, 1], random.uniform(9, 10, size=(20, 3))])
    mirrored = points * [-1, 1, 1]
    side = np.sign(points[:, 0]).astype(np.int8)
    p2p = optimal_involution(np.column_stack([mirrored, points]), np.column_stack([points, mirrored]), side)
    np.testing.assert_array_equal(p2p[p2p], np.arange(len(points)))
    np.testing.assert_array_equal(p2p[:7000], np.arange(7000) + 7000)
