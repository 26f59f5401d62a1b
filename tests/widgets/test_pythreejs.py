"""The backend of pythreejs without a browser: what it would send, and what it makes of clicks."""

from __future__ import annotations

import numpy as np
import pytest

import qgeo_widgets as qw
from qgeo_filters import Animation
from qgeo_widgets.rendering.motion import TICKS
from qgeo_widgets.rendering.pythreejs_matrix import PythreejsMatrix
from qgeo_widgets.rendering.pythreejs_viewer import PythreejsViewer
from qgeo_widgets.rendering.scene_placement import placement_of


@pytest.fixture
def viewer(pair):
    x, y, _ = pair
    viewer = PythreejsViewer([x, y], [placement_of(x), placement_of(y)], (300, 200), ["X", "Y"])
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


def test_both_panes_share_camera_and_controls(viewer):
    first, second = (pane.renderer for pane in viewer.panes)
    assert first.camera is second.camera
    assert first.controls[0] is second.controls[0]


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


def test_no_more_canvases_than_browsers_keep(pair):
    x = pair[0]
    with pytest.raises(ValueError, match="1 to 8 shapes"):
        PythreejsViewer([x] * 13, [placement_of(x)] * 13, (300, 200), ["a"] * 13)


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


def test_the_mouse_over_a_matrix_is_over_an_entry():
    pane = PythreejsMatrix(np.zeros((50, 50, 3), dtype=np.uint8), 300)
    seen = []
    pane.on_hover(lambda *entry: seen.append(("over", *entry)))
    pane.on_click(lambda *entry: seen.append(("click", *entry)))
    for picker in (pane.hover, pane.click):
        picker.set_state({"faceIndex": 0, "point": [2 * 41.5 / 50 - 1, 1 - 2 * 12.5 / 50, 0.0]})
    assert seen == [("over", 12, 41), ("click", 12, 41)]
    pane.set_image(np.full((50, 50, 3), 9, dtype=np.uint8))
    pane.show(3, 4)
    pane.close()


# -- motion -----------------------------------------------------------------------------------------


@pytest.fixture
def walk(pair) -> Animation:
    """A surface that leans over more and more, and walks off."""
    x, y, z = pair[0].vertices.T
    poses = [np.column_stack([x + 0.4 * t * z**2 + 0.8 * t, y, z * (1 + 0.1 * t)]) for t in range(4)]
    return Animation(pair[0], np.stack(poses), np.array([1.0, 2.0, 4.0, 5.0]))


@pytest.fixture
def widget(walk, pythreejs):
    widget = qw.animate(walk)
    assert widget.message == ""
    yield widget
    widget.close()


def blended(pane, weights) -> np.ndarray:
    """What the graphics card makes of the frames: three.js adds the shares of what each target is off the first."""
    geometry = pane._moving_mesh.geometry
    start = geometry.attributes["position"].array.astype(np.float64)
    targets = geometry.morphAttributes["position"]
    return start + sum(w * (target.array - start) for w, target in zip(weights, targets, strict=True))


def test_every_time_shows_what_the_animation_has_there(widget, walk):
    for time in (1.0, 1.3, 2.0, 3.1, 4.75, 5.0):
        widget.time = time
        (pane,) = widget._viewer.panes
        shown = pane.placement.to_surface(blended(pane, pane._moving_mesh.morphTargetInfluences))
        np.testing.assert_allclose(shown, walk.at(time), atol=1e-5)


def test_the_browser_blends_the_same_at_each_tick_there_and_back(widget):
    (pane,) = widget._viewer.panes
    track = pane._action.clip.tracks[0]
    for tick in (0, 12_345, 60_000, TICKS, 140_000, 2 * TICKS):
        shares = [np.interp(tick, track.times, column) for column in track.values.T]
        np.testing.assert_allclose(shares, pane.motion.weights(widget._player.time_of(tick)), atol=1e-5)


def test_normals_are_those_of_each_frame(widget, walk):
    pane = widget._viewer.panes[0]
    sent = [array.array for array in pane._moving_mesh.geometry.morphAttributes["normal"]]
    for frame, normals in enumerate(sent, start=1):
        np.testing.assert_allclose(normals @ pane.placement.axes, walk[frame].vertex_normals, atol=1e-6)
    assert pane._moving_mesh.material.morphNormals


def test_each_frame_but_the_first_is_two_buffers(widget):
    for pane in widget._viewer.panes:
        geometry = pane._moving_mesh.geometry
        assert sorted(geometry.attributes) == ["color", "index", "normal", "position"]
        assert {name: len(frames) for name, frames in geometry.morphAttributes.items()} == {"position": 3, "normal": 3}
        for frames in geometry.morphAttributes.values():
            assert {frame.array.dtype for frame in frames} == {np.dtype(np.float32)}


def test_while_it_plays_the_kernel_sends_no_blends(widget):
    widget.playing = True
    mesh = widget._viewer.panes[0]._moving_mesh
    sent = []
    mesh.observe(lambda change: sent.append(change["new"]), "morphTargetInfluences")
    widget._player.clock.set_state({"value": TICKS // 2})
    assert widget.time == 3.0
    assert sent == []
    widget.playing = False
    np.testing.assert_allclose(mesh.morphTargetInfluences, [0.5, 0.5, 0.0])
