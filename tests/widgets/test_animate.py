"""The widget of shapes in motion, driven through its traits, and what it would send to a browser."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

import qgeo_filters as qg
import qgeo_widgets as qw
from qgeo_filters import Animation, Surface
from qgeo_filters.animation.pose_transfer import Transfer
from qgeo_filters.errors import ParameterError
from qgeo_filters.report.colors import MISSING
from qgeo_filters.report.reel import reels
from qgeo_widgets.rendering import motion as motions
from qgeo_widgets.rendering.motion import TICKS

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


def test_a_title_says_once_what_is_shown(widget, transfer):
    titles = [shape["title"] for shape in widget._viewer._scene.setup["panes"]]
    counts = [transfer.source.surface.n_vertices, transfer.surface.n_vertices]
    assert [title.split("</b>, ")[1] for title in titles] == [f"{count} vertices, 4 frames" for count in counts]


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
    scene = widget._viewer._scene
    sent = []
    scene.observe(lambda change: sent.append(change["new"]), "tick")
    widget._player.clock.set_state({"value": TICKS // 2})
    assert widget.time == 3.0
    assert widget._player.clock.value == TICKS // 2
    assert sent == []
    widget.playing = False
    assert sent == [TICKS // 2]
    widget.time = 2.0
    assert widget._player.clock.value == scene.tick == TICKS // 4


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
        (17, {}, "animate takes an Animation, a Transfer, or meshes with equal triangles, got one int"),
        ({"a": x}, {}, "got one dict"),
        (walk.positions, {}, "positions alone have no triangles"),
        ([x.vertices], {}, "positions alone have no triangles"),
        ([], {}, "got an empty list"),
        ([x, y], {}, "other triangles"),
        ([x, lost], {}, "1 of 162 vertices are not finite"),
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


@pytest.mark.parametrize(
    "frames",
    [
        list,
        tuple,
        iter,
        lambda walk: [(pose.vertices, pose.faces) for pose in walk],
        lambda walk: [walk[0], *walk.positions[1:]],
    ],
    ids=["list", "tuple", "generator", "pairs", "positions after the first"],
)
def test_meshes_with_equal_triangles_are_frames(walk, frames):
    widget = qw.animate(frames(walk))
    assert widget.message == ""
    widget.frame = 2
    assert widget.time == 2.0
    np.testing.assert_allclose(widget._viewer.panes[0].motion.animation.positions, walk.positions)
    widget.close()


def test_a_tuple_of_two_meshes_is_two_frames_and_one_of_vertices_and_faces_is_one(walk):
    trimesh = pytest.importorskip("trimesh")
    meshes = tuple(trimesh.Trimesh(pose.vertices, pose.faces, process=False) for pose in (walk[0], walk[1]))
    for given, count in ((meshes, 2), ((walk[0].vertices, walk[0].faces), 1)):
        widget = qw.animate(given)
        assert widget.message == ""
        np.testing.assert_allclose(widget._viewer.panes[0].motion.animation.positions, walk.positions[:count])
        widget.close()


@pytest.mark.parametrize("given", [lambda mesh: mesh, lambda mesh: [mesh]], ids=["mesh", "list"])
def test_a_single_frame_has_nothing_to_play(pair, given):
    widget = qw.animate(given(pair[0]))
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


@pytest.mark.parametrize("backend", ["webgl", "pythreejs"])
def test_a_transfer_has_the_colors_of_its_film(pair, backend, tmp_path):
    """On Y those of the points of X, grey where there is none; also in the page, which begins with them."""
    x, _, _ = pair
    y = Surface(*shapes.icosphere(2))
    partners = np.arange(y.n_vertices) % x.n_vertices
    partners[:5] = -1
    moved = qg.transfer_deformation(x, swaying(x).positions, y.with_attributes({"old": y.vertices[:, 0]}), partners)
    before = qw.backend()
    qw.backend(backend)
    try:
        widget = qw.animate(moved)
    finally:
        qw.backend(before)
    assert widget.message == ""
    assert widget.mode == "colours carried from X to Y"
    assert list(widget.modes)[:2] == ["colours carried from X to Y", "plain"]
    left, right = widget._viewer.panes
    for pane, reel in zip((left, right), reels(moved), strict=True):
        np.testing.assert_allclose(pane.colors, reel.colors)
    np.testing.assert_allclose(right.colors[5:], left.colors[partners[5:]])
    np.testing.assert_allclose(right.colors[:5], np.broadcast_to(MISSING, (5, 3)))
    assert len(np.unique(left.colors, axis=0)) > 100
    if backend == "webgl":
        widget.to_html(tmp_path / "page.html")
        assert "the colour of its partner on X" in (tmp_path / "page.html").read_text()
    widget.mode = "plain"
    assert len(np.unique(right.colors, axis=0)) == 1
    widget.close()
    widget = qw.animate(moved, attribute="old")
    assert widget.mode == "attribute: old"
    widget.close()


def test_layers_of_a_meshset_are_frames(walk):
    pymeshlab = pytest.importorskip("pymeshlab")
    layers = pymeshlab.MeshSet()
    for positions in walk.positions:
        layers.add_mesh(pymeshlab.Mesh(positions, walk.surface.faces))
    layers.set_current_mesh(1)
    layers.current_mesh().add_vertex_custom_scalar_attribute(walk.surface.vertices[:, 2], "height")
    widget = qw.animate(layers, attribute="height")
    assert widget.message == ""
    np.testing.assert_allclose(widget._viewer.panes[0].motion.animation.positions, walk.positions)
    np.testing.assert_allclose(widget._viewer.panes[0].motion.animation.surface.vertices, walk.positions[1])
    widget.close()


@pytest.mark.parametrize("size", [(440, 400), (300, 500), (600, 200)])
def test_the_first_view_cuts_nothing_off_in_any_frame_however_it_is_turned(transfer, size):
    widget = qw.animate(transfer, size=size)
    distance = widget.camera[2]
    slope = np.tan(np.radians(13.0))
    largest = 0.0
    for pane, animation in zip(widget._viewer.panes, (transfer.source, transfer), strict=True):
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
    pane = widget._viewer.panes[0]
    assert pane.motion.positions.shape[0] == 2
    assert 5000 <= pane.motion.positions.shape[1] <= 6600 < x.n_vertices
    np.testing.assert_allclose(pane.motion.positions[1] - pane.motion.positions[0], pane.motion.positions[0], atol=2)
    widget.close()


def test_a_picture_is_that_of_the_time(widget):
    first = widget.snapshot()
    widget.time = 4.0
    assert widget.snapshot() != first
    np.testing.assert_array_equal(
        widget._viewer.panes[1].surface.vertices, widget._viewer.panes[1].motion.animation.at(4.0)
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
    assert counted() > 20
    widget.close()
    assert counted() == 0
    widget.playing = True
    widget.time = 2.0
    assert not widget.playing
