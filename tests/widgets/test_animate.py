"""The widget of shapes in motion, driven through its traits, and what it would send to a browser."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

import qgeo_filters as qg
import qgeo_widgets as qw
from qgeo_filters import Animation, Surface
from qgeo_filters.animation.transfer import Transfer
from qgeo_filters.errors import ParameterError
from qgeo_widgets import motion as motions
from qgeo_widgets.moving_pane import TICKS

TIMES = np.array([1.0, 2.0, 4.0, 5.0])


def swaying(surface: Surface, size: float = 1.0) -> Animation:
    """A surface that leans over more and more, and walks off."""
    x, y, z = size * surface.vertices.T
    poses = [np.column_stack([x + 0.4 * t * z**2 + 0.8 * t, y, z * (1 + 0.1 * t)]) for t in range(4)]
    return Animation(surface, np.stack(poses), TIMES)


@pytest.fixture(scope="module")
def walk(pair) -> Animation:
    return swaying(pair[0])


@pytest.fixture(scope="module")
def transfer(walk) -> Transfer:
    other = Surface(*shapes.icosphere(2))
    return Transfer(other, swaying(other, 1.2).positions, TIMES, source=walk)


@pytest.fixture
def widget(transfer):
    widget = qw.animate(transfer)
    assert widget.message == ""
    yield widget
    widget.close()


def blended(pane, weights) -> np.ndarray:
    """What the graphics card makes of the frames: three.js adds the shares of what each target is off the first."""
    geometry = pane._moving_mesh.geometry
    start = geometry.attributes["position"].array.astype(np.float64)
    targets = geometry.morphAttributes["position"]
    return start + sum(w * (target.array - start) for w, target in zip(weights, targets, strict=True))


def test_every_time_shows_what_the_animation_has_there(widget, transfer):
    for time in (1.0, 1.3, 2.0, 3.1, 4.75, 5.0):
        widget.time = time
        for pane, animation in zip(widget._viewer.moving, (transfer.source, transfer), strict=True):
            shown = pane.placement.to_surface(blended(pane, pane._moving_mesh.morphTargetInfluences))
            np.testing.assert_allclose(shown, animation.at(time), atol=1e-5)


def test_the_browser_blends_the_same_at_each_tick_there_and_back(widget):
    pane = widget._viewer.moving[1]
    track = pane._action.clip.tracks[0]
    for tick in (0, 12_345, 60_000, TICKS, 140_000, 2 * TICKS):
        shares = [np.interp(tick, track.times, column) for column in track.values.T]
        np.testing.assert_allclose(shares, pane.motion.weights(widget._player.time_of(tick)), atol=1e-5)


def test_normals_are_those_of_each_frame(widget, transfer):
    pane = widget._viewer.moving[0]
    sent = [array.array for array in pane._moving_mesh.geometry.morphAttributes["normal"]]
    for frame, normals in enumerate(sent, start=1):
        np.testing.assert_allclose(normals @ pane.placement.axes, transfer.source[frame].vertex_normals, atol=1e-6)
    assert pane._moving_mesh.material.morphNormals


def test_time_and_frame_follow_each_other(widget):
    seen = []
    widget.observe(lambda change: seen.append(change["new"]), "frame")
    widget.time = 3.5
    assert widget.frame == 2
    widget.frame = 1
    assert widget.time == 2.0
    widget.time = 2.4
    assert widget.frame == 1
    assert widget.time == 2.4
    assert widget._player.slider.value == 2.4
    widget._player.slider.value = 4.5
    assert widget.time == 4.5
    assert seen == [2, 1, 2]


def test_the_clock_moves_the_time_and_nothing_is_sent_back(widget):
    widget.playing = True
    assert widget._player.clock.playing
    mesh = widget._viewer.moving[0]._moving_mesh
    sent = []
    mesh.observe(lambda change: sent.append(change["new"]), "morphTargetInfluences")
    widget._player.clock.set_state({"value": TICKS // 2})
    assert widget.time == 3.0
    assert widget._player.clock.value == TICKS // 2
    assert sent == []
    widget.playing = False
    np.testing.assert_allclose(mesh.morphTargetInfluences, [0.5, 0.5, 0.0])
    widget.time = 2.0
    assert widget._player.clock.value == TICKS // 4


def test_back_and_forth_runs_over_the_way_back(widget):
    clock = widget._player.clock
    widget.loop = "back and forth"
    widget.playing = True
    clock.set_state({"value": TICKS + TICKS // 4})
    assert widget.time == 4.0
    widget.loop = "repeat"
    assert (clock.value, clock.max) == (TICKS - TICKS // 4, TICKS)
    assert widget.time == 4.0


def test_once_ends_at_the_end_and_begins_anew(widget):
    clock = widget._player.clock
    widget.loop = "once"
    assert not clock.repeat
    widget.time = 5.0
    widget.playing = True
    assert widget.time == 1.0
    clock.set_state({"playing": False})
    assert not widget.playing
    assert widget._player.button.description == "play"


def test_speed_is_how_fast_the_clock_steps(transfer):
    widget = qw.animate(transfer, seconds=4.0)
    clock = widget._player.clock
    assert clock.step * 4.0 / (clock.interval / 1000) == pytest.approx(TICKS, rel=1e-3)
    before = clock.step
    widget.speed = 2.0
    assert clock.step == 2 * before
    widget.close()


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("time", 5.1, "time must be from 1 to 5, got 5.1"),
        ("time", np.nan, "time must be from 1 to 5, got nan"),
        ("frame", 4, "frame"),
        ("frame", -1, "frame"),
        ("speed", 0.0, "speed must be from 0.05 to 20, got 0.0"),
        ("speed", np.nan, "speed must be"),
        ("loop", "always", "loop must be one of repeat, back and forth, once"),
    ],
)
def test_what_cannot_be_is_said_and_leaves_all_as_it_was(widget, name, value, sentence):
    before = widget.time, widget.frame, widget.speed, widget.loop
    with pytest.raises(ParameterError, match=sentence):
        setattr(widget, name, value)
    assert (widget.time, widget.frame, widget.speed, widget.loop) == before


def test_what_is_no_animation_is_a_sentence_in_the_widget(pair, walk):
    x, y, _ = pair
    lost = x.vertices.copy()
    lost[3] = np.nan
    for given, options, sentence in [
        (x, {}, "animate takes an Animation, a Transfer, or a sequence of meshes"),
        (17, {}, "got one int"),
        ((x.vertices, x.faces), {}, "got one tuple"),
        ([], {}, "got an empty list"),
        ([x, y], {}, "other triangles"),
        ([x, lost], {}, "1 vertices are not finite"),
        (walk, {"seconds": 0.0}, "seconds must be a number from 0.1 to 3600, got 0.0"),
        (walk, {"seconds": np.nan}, "seconds must be"),
        (walk, {"attribute": "weight"}, "there is no attribute 'weight' (there are: height)"),
        (Transfer(x, walk.positions, source=walk), {}, "at other times than the 4 of Y"),
    ]:
        widget = qw.animate(given, **options)
        assert sentence in widget.message
        with pytest.raises(ParameterError, match="there is nothing to write"):
            widget.to_html("page.html")
        widget.playing = True
        assert not widget.playing
        widget.close()


def test_meshes_with_equal_triangles_are_frames(pair, walk):
    widget = qw.animate([(pose.vertices, pose.faces) for pose in walk])
    assert widget.message == ""
    widget.frame = 2
    assert widget.time == 2.0
    np.testing.assert_allclose(widget._viewer.moving[0].motion.animation.positions, walk.positions)
    widget.close()


def test_a_single_frame_has_nothing_to_play(pair):
    widget = qw.animate([pair[0]])
    assert widget.message == ""
    widget.playing = True
    assert not widget.playing
    assert widget._player.row.layout.display == "none"
    assert widget.snapshot().startswith(b"\x89PNG")
    widget.close()


def test_attributes_color_both_shapes_and_are_missing_where_absent(transfer):
    widget = qw.animate(transfer, attribute="height")
    assert widget.mode == "attribute: height"
    left, right = widget._viewer.panes
    assert len(np.unique(left.colors, axis=0)) > 100
    assert len(np.unique(right.colors, axis=0)) == 1
    widget.mode = "plain"
    assert len(np.unique(left.colors, axis=0)) == 1
    widget.close()


@pytest.mark.parametrize("size", [(440, 400), (300, 500), (600, 200)])
def test_the_first_view_cuts_nothing_off_in_any_frame_however_it_is_turned(transfer, size):
    widget = qw.animate(transfer, size=size)
    distance = widget.camera[2]
    slope = np.tan(np.radians(13.0))
    largest = 0.0
    for pane, animation in zip(widget._viewer.moving, (transfer.source, transfer), strict=True):
        for angle in np.linspace(0, 2 * np.pi, 33):
            turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
            x, y, z = np.moveaxis(pane.placement.to_scene(animation.positions) @ turn.T, -1, 0)
            largest = max(largest, np.abs(y / (distance - z)).max() / slope)
            largest = max(largest, np.abs(x / (distance - z)).max() / (slope * size[0] / size[1]))
    assert 0.85 < largest <= 1.0
    widget.close()


def test_both_shapes_have_one_turn_one_size_and_one_camera(widget):
    left, right = widget._viewer.panes
    np.testing.assert_array_equal(left.placement.axes, right.placement.axes)
    assert left.placement.scale == right.placement.scale
    assert left.renderer.camera is right.renderer.camera


def test_what_is_sent_is_bounded(pair, monkeypatch):
    x = Surface(*shapes.blob(4))
    frames = np.stack([x.vertices * (1 + 0.01 * k) for k in range(40)])
    monkeypatch.setattr(motions, "MOST_BYTES", 24 * 40 * 1000)
    monkeypatch.setattr(motions, "MOST_FRAMES", 30)
    motion = motions.Motion(Animation(x, frames), motions.placements_of([Animation(x, frames)])[0])
    assert motion.positions.dtype == motion.normals().dtype == np.float32
    assert motion.positions.nbytes + motion.normals().nbytes <= 24 * 40 * 1000
    assert motion.kept[0] == 0
    assert motion.kept[-1] == 39
    assert "of them sent" in motion.caption


def test_a_large_mesh_is_drawn_with_fewer_vertices(monkeypatch):
    x = Surface(*shapes.blob(5, seed=3))
    monkeypatch.setattr(motions, "MOST_BYTES", 24 * 2 * 6000)
    animation = Animation(x, np.stack([x.vertices, 2 * x.vertices]))
    widget = qw.animate(animation)
    pane = widget._viewer.moving[0]
    assert pane.motion.positions.shape[0] == 2
    assert 5000 <= pane.motion.positions.shape[1] <= 6600 < x.n_vertices
    np.testing.assert_allclose(pane.motion.positions[1] - pane.motion.positions[0], pane.motion.positions[0], atol=2)
    widget.close()


def test_each_frame_but_the_first_is_two_buffers(widget):
    for pane in widget._viewer.moving:
        geometry = pane._moving_mesh.geometry
        assert sorted(geometry.attributes) == ["color", "index", "normal", "position"]
        assert {name: len(frames) for name, frames in geometry.morphAttributes.items()} == {"position": 3, "normal": 3}
        for frames in geometry.morphAttributes.values():
            assert {frame.array.dtype for frame in frames} == {np.dtype(np.float32)}


def test_a_picture_is_that_of_the_time(widget):
    first = widget.snapshot()
    widget.time = 4.0
    assert widget.snapshot() != first
    np.testing.assert_array_equal(
        widget._viewer.panes[1].surface.vertices, widget._viewer.moving[1].motion.animation.at(4.0)
    )
    bundle = widget._repr_mimebundle_()
    assert "image/png" in (bundle[0] if isinstance(bundle, tuple) else bundle)


def test_an_interpolation_can_be_shown(pair):
    x = pair[0]
    way = qg.interpolate(x, x.with_vertices(x.vertices * [1, 1, 1.5]), np.linspace(0, 1, 5))
    widget = qw.animate(way)
    assert widget.message == ""
    widget.time = 0.6
    assert widget.frame == 2
    widget.close()


def test_closing_frees_everything(transfer, counted):
    widget = qw.animate(transfer)
    widget.playing = True
    widget.time = 3.0
    assert counted() > 60
    widget.close()
    assert counted() == 0
    widget.playing = True
    widget.time = 2.0
    assert not widget.playing
