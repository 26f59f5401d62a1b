"""Triangles in which regions meet, cut into pieces: each point is in the region of the nearest corners."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

from qgeo_filters import Surface
from qgeo_widgets.rendering.backends import new_viewer
from qgeo_widgets.rendering.region_borders import region_borders
from qgeo_widgets.rendering.scene_placement import placement_of


@pytest.fixture(scope="module")
def regions() -> tuple[Surface, np.ndarray]:
    surface = Surface(*shapes.blob(2, seed=3))
    return surface, np.random.default_rng(0).integers(0, 4, surface.n_vertices)


def test_each_point_of_a_piece_is_in_the_region_of_most_weight(regions):
    surface, labels = regions
    borders = region_borders(surface.faces, labels)
    inside = np.einsum("sq,pqc->psc", np.random.default_rng(1).dirichlet(np.ones(3), 20), borders.weights)
    own = labels[borders.corners]
    weight_of_region = np.einsum("psc,pcr->psr", inside, own[:, :, None] == np.arange(4))
    np.testing.assert_array_equal(weight_of_region.argmax(axis=2), np.repeat(borders.labels[:, None], 20, axis=1))


def test_pieces_fill_their_triangles_and_face_as_they_do(regions):
    surface, labels = regions
    borders = region_borders(surface.faces, labels)
    area = np.linalg.det(borders.weights)
    assert (area > 0).all()
    mixed = (labels[surface.faces] != labels[surface.faces][:, :1]).any(axis=1)
    keys = np.unique(np.sort(borders.corners, axis=1), axis=0, return_inverse=True)
    np.testing.assert_array_equal(keys[0], np.unique(np.sort(surface.faces[mixed], axis=1), axis=0))
    np.testing.assert_allclose(np.bincount(keys[1].ravel(), area), 1.0)
    points = borders.at_points(surface.vertices).reshape(-1, 3, 3)
    areas = 0.5 * np.linalg.norm(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), axis=1)
    assert areas.sum() == pytest.approx(surface.face_areas[mixed].sum())


def test_the_pane_draws_them_in_flat_colors_and_frees_what_it_drew(regions, counted, pythreejs):
    surface, labels = regions
    viewer = new_viewer([surface], [placement_of(surface)], (300, 200), ["X"])
    pane, palette = viewer.panes[0], np.eye(5, 3)
    for shift in range(4):
        pane.set_regions((labels + shift) % 4, palette)
        colors = pane._scene.children[-1].geometry.attributes["color"].array.reshape(-1, 3, 3)
        np.testing.assert_array_equal(colors, np.repeat(colors[:, :1], 3, axis=1))
    there = counted()
    pane.set_regions(labels, palette)
    assert counted() == there  # those from before are closed
    pane.set_regions(np.zeros_like(labels), palette)  # no borders
    pane.set_regions(None)
    assert pane.regions is None
    viewer.close()
    assert counted() == 0
