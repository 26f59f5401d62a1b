"""The viewer without a browser: what it would send, what it makes of clicks, and that closing frees it."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
import shapes

import qgeo_widgets as qw
from qgeo_filters import Surface
from qgeo_widgets.rendering.backends import new_viewer
from qgeo_widgets.rendering.scene_placement import ScenePlacement, aligned_placement, placement_of
from qgeo_widgets.rendering.viewer import FIELD_OF_VIEW


@pytest.fixture
def viewer(pair, each_backend):
    x, y, _ = pair
    viewer = new_viewer([x, y], [placement_of(x), placement_of(y)], (300, 200), ["X", "Y"])
    yield viewer
    viewer.close()


def test_placements_make_shapes_of_one_size(pair):
    for surface in pair[:2]:
        placed = surface.with_vertices(placement_of(surface).to_scene(surface.vertices))
        assert placed.area == pytest.approx(1.0)
        np.testing.assert_allclose(placed.vertices.min(axis=0), -placed.vertices.max(axis=0), atol=1e-12)


def test_aligned_placement_undoes_a_rotation_but_never_mirrors(pair):
    x, y, where = pair
    target = placement_of(x).to_scene(x.vertices)
    seen = aligned_placement(y, y.vertices[where], target)
    np.testing.assert_allclose(np.linalg.det(seen.axes), 1.0)
    np.testing.assert_allclose(seen.to_scene(y.vertices[where]), target, atol=1e-9)
    mirrored = aligned_placement(y, y.vertices[where] * [-1, 1, 1], target)
    np.testing.assert_allclose(np.linalg.det(mirrored.axes), 1.0)


@pytest.mark.parametrize("stretch", [(1, 1, 1), (1, 1, 6), (6, 1, 1), (1, 6, 1), (1, 4, 4), (5, 5, 1)])
@pytest.mark.parametrize("size", [(440, 400), (300, 600)])
def test_the_first_view_holds_shapes_whole_however_they_are_turned(stretch, size):
    surface = Surface(shapes.blob(2, seed=3)[0] * stretch, shapes.blob(2, seed=3)[1])
    placement = ScenePlacement(surface.vertices.mean(axis=0), np.eye(3), 1.0)
    viewer = new_viewer([surface], [placement], size, ["X"])
    distance = viewer.home[2]
    viewer.close()
    points = placement.to_scene(surface.vertices)
    height, reached = np.tan(np.radians(FIELD_OF_VIEW / 2)), []
    for angle in np.linspace(0, 2 * np.pi, 73):
        x = points[:, 0] * np.cos(angle) + points[:, 2] * np.sin(angle)
        depth = distance - (points[:, 2] * np.cos(angle) - points[:, 0] * np.sin(angle))
        assert (depth > 0).all()
        seen = np.abs([x / (depth * height * size[0] / size[1]), points[:, 1] / (depth * height)])
        reached.append(seen.max())
    assert max(reached) < 1.0
    assert max(reached) > 0.75  # and no smaller than it must be


def test_camera_is_checked_and_reset(viewer):
    home = viewer.camera
    viewer.camera = (1, 2, 3)
    assert viewer.camera == (1.0, 2.0, 3.0)
    axes = viewer.camera_view().axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(axes[2], np.array([1, 2, 3]) / np.sqrt(14))
    viewer.reset()
    assert viewer.camera == home
    for bad in ((0, 0, 0), (1, 2), (np.nan, 0, 1)):
        with pytest.raises(ValueError, match="camera must be three finite numbers"):
            viewer.camera = bad


def test_a_line_of_one_point_is_none(viewer):
    viewer.panes[0].set_line("path", np.zeros((1, 3)))
    assert viewer.panes[0].lines == {}


def test_closing_frees_every_widget_and_the_surface(counted, each_backend):
    surface = Surface(*shapes.blob(2))
    viewer = new_viewer([surface], [placement_of(surface)], (300, 200), ["X"])
    viewer.panes[0].set_line("path", surface.vertices[:5])
    viewer.panes[0].set_line("path", surface.vertices[:7])
    viewer.panes[0].set_mark("end", surface.vertices[0])
    viewer.on_pick(lambda pane, vertex: None)
    assert counted() > 3
    alive = weakref.ref(surface)
    viewer.close()
    assert counted() == 0
    del viewer, surface
    gc.collect()
    assert alive() is None


def test_a_click_means_the_nearest_corner_of_the_right_pane(viewer):
    seen = []
    viewer.on_pick(lambda pane, vertex: seen.append((pane, vertex)))
    for number, vertex in ((1, 17), (0, 40)):
        pane = viewer.panes[number]
        face = pane.surface.faces[(pane.surface.faces == vertex).any(axis=1)][0]
        points = pane.placement.to_scene(pane.surface.vertices)
        pane.clicked(face, 0.8 * points[vertex] + 0.2 * points[face].mean(axis=0))
    viewer.panes[0].clicked([0, 1, 100_000], [0.0, 0.0, 0.0])  # of a mesh that is shown no longer
    assert seen == [(1, 17), (0, 40)]


def test_marks_lines_and_colors_are_what_was_set_last(viewer):
    pane = viewer.panes[0]
    for points in (np.eye(3), np.eye(3)[:2], np.eye(3)):
        pane.set_line("path", points)
        pane.set_mark("end", points[-1])
    assert list(pane.lines) == ["path"]
    np.testing.assert_array_equal(pane.lines["path"].points, np.eye(3))
    np.testing.assert_array_equal(pane.marks["end"].point, [0, 0, 1])
    pane.set_line("path", None)
    pane.set_mark("end", None)
    assert pane.marks == pane.lines == {}
    red = np.tile([1.0, 0.0, 0.0], (pane.surface.n_vertices, 1))
    assert pane.set_colors(red)
    assert not pane.set_colors(red.copy())
    with pytest.raises(ValueError, match="colors have shape"):
        pane.set_colors(red[:-1])


def test_unknown_backends_are_refused_and_change_nothing():
    with pytest.raises(ValueError, match="there is no backend 'vtk'; choose one of: webgl, pythreejs"):
        qw.backend("vtk")
    assert qw.backend() == "webgl"
