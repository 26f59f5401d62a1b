"""The viewer without a browser: what it would send, what it makes of clicks, and that closing frees it."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
import shapes

from qgeo_filters import Surface
from qgeo_widgets.scene_placement import ScenePlacement, aligned_placement, placement_of
from qgeo_widgets.viewer import FIELD_OF_VIEW, Viewer


@pytest.fixture
def viewer(pair):
    x, y, _ = pair
    viewer = Viewer([x, y], [placement_of(x), placement_of(y)], (300, 200), ["X", "Y"])
    yield viewer
    viewer.close()


def hit(pane, vertex: int, share: float = 0.2) -> dict:
    """What the browser sends for a point of the surface beside a vertex."""
    face = pane.surface.faces[(pane.surface.faces == vertex).any(axis=1)][0]
    points = pane.placement.to_scene(pane.surface.vertices)
    place = (1 - share) * points[vertex] + share * points[face].mean(axis=0)
    return {"faceIndex": 0, "face": face.astype(float).tolist(), "point": place.tolist()}


def click(pane, vertex: int) -> None:
    """What the browser sends for a click on the surface beside a vertex."""
    pane.press.set_state(hit(pane, vertex))
    pane.picker.set_state(hit(pane, vertex))


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


def test_colors_are_sent_once_and_only_if_they_changed(viewer):
    pane = viewer.panes[0]
    sent = []
    pane._color_attribute.observe(lambda change: sent.append(change["new"]), "array")
    red = np.tile([1.0, 0.0, 0.0], (pane.surface.n_vertices, 1))
    assert pane.set_colors(red)
    assert not pane.set_colors(red.copy())
    assert len(sent) == 1
    np.testing.assert_array_equal(sent[0], red.astype(np.float32))
    with pytest.raises(ValueError, match="colors have shape"):
        pane.set_colors(red[:-1])


def test_a_click_gives_the_nearest_vertex_of_the_right_pane(viewer):
    seen = []
    viewer.on_pick(lambda pane, vertex: seen.append((pane, vertex)))
    click(viewer.panes[1], 17)
    click(viewer.panes[0], 40)
    assert seen == [(1, 17), (0, 40)]


def test_a_click_beside_the_surface_is_none(viewer):
    seen = []
    viewer.on_pick(lambda pane, vertex: seen.append(vertex))
    viewer.panes[0].picker.set_state({"faceIndex": None, "face": [0, 0, 0], "point": [0, 0, 0]})
    viewer.panes[0].picker.set_state({"faceIndex": None, "face": [0, 0, 0], "point": [0, 0, 1]})
    assert seen == []


def test_a_click_that_ends_a_drag_is_none(viewer):
    pane = viewer.panes[0]
    home = np.array(viewer.camera)
    seen = []
    viewer.on_pick(lambda pane, vertex: seen.append(vertex))
    # Another point is under the mouse; the camera's position is still on its way.
    pane.press.set_state(hit(pane, 3))
    pane.picker.set_state(hit(pane, 40))
    # The surface followed the mouse: the same point from elsewhere.
    pane.press.set_state(hit(pane, 4))
    viewer._camera.set_state({"position": (home + np.array([0.2 * home[2], 0, 0])).tolist()})
    pane.picker.set_state(hit(pane, 4))
    # From the background onto the surface.
    pane.press.set_state({"faceIndex": None, "face": [0, 0, 0], "point": [0, 0, 0]})
    pane.picker.set_state(hit(pane, 5))
    assert seen == []
    click(pane, 6)
    assert seen == [6]


def test_a_hand_that_is_not_quite_still_clicks(viewer):
    pane = viewer.panes[0]
    home = np.array(viewer.camera)
    seen = []
    viewer.on_pick(lambda pane, vertex: seen.append(vertex))
    pane.press.set_state(hit(pane, 3))
    viewer._camera.set_state({"position": (home + np.array([0.02 * home[2], 0, 0])).tolist()})
    pane.picker.set_state(hit(pane, 3, share=0.25))
    assert seen == [3]


@pytest.mark.parametrize("stretch", [(1, 1, 1), (1, 1, 6), (6, 1, 1), (1, 6, 1), (1, 4, 4), (5, 5, 1)])
@pytest.mark.parametrize("size", [(440, 400), (300, 600)])
def test_the_first_view_holds_shapes_whole_however_they_are_turned(stretch, size):
    surface = Surface(shapes.blob(2, seed=3)[0] * stretch, shapes.blob(2, seed=3)[1])
    placement = ScenePlacement(surface.vertices.mean(axis=0), np.eye(3), 1.0)
    viewer = Viewer([surface], [placement], size, ["X"])
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


def test_both_panes_share_camera_and_controls(viewer):
    first, second = (pane.renderer for pane in viewer.panes)
    assert first.camera is second.camera
    assert first.controls[0] is second.controls[0]


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


def test_lines_and_marks_replace_each_other(viewer):
    pane = viewer.panes[0]
    before = len(pane._scene.children)
    for points in (np.eye(3), np.eye(3)[:2], np.eye(3)):
        pane.set_line("path", points)
        pane.set_mark("end", points[-1])
    assert len(pane._scene.children) == before + 2
    pane.set_line("path", None)
    pane.set_mark("end", None)
    assert len(pane._scene.children) == before + 1  # the ball waits, hidden
    assert pane.marks == {}
    assert pane.lines == {}


def test_a_line_of_one_point_is_none(viewer):
    viewer.panes[0].set_line("path", np.zeros((1, 3)))
    assert viewer.panes[0].lines == {}


def test_closing_frees_every_widget_and_the_surface(counted):
    surface = Surface(*shapes.blob(2))
    viewer = Viewer([surface], [placement_of(surface)], (300, 200), ["X"])
    viewer.panes[0].set_line("path", surface.vertices[:5])
    viewer.panes[0].set_line("path", surface.vertices[:7])
    viewer.panes[0].set_mark("end", surface.vertices[0])
    viewer.on_pick(lambda pane, vertex: None)
    assert counted() > 20
    alive = weakref.ref(surface)
    viewer.close()
    assert counted() == 0
    del viewer, surface
    gc.collect()
    assert alive() is None


def test_no_more_canvases_than_browsers_keep(pair):
    x = pair[0]
    with pytest.raises(ValueError, match="1 to 8 canvases"):
        Viewer([x] * 13, [placement_of(x)] * 13, (300, 200), ["a"] * 13)
