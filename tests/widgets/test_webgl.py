"""The backend of our own browser module without a browser: what it sends, and what it makes of messages."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from qgeo_filters import Animation
from qgeo_widgets.page_block import PageBlock
from qgeo_widgets.rendering import browser_module
from qgeo_widgets.rendering.encoding import indices, quantised, with_bytes
from qgeo_widgets.rendering.motion import TICKS, Motion, placements_of
from qgeo_widgets.rendering.scene_placement import placement_of
from qgeo_widgets.rendering.webgl_viewer import WebglViewer

RENDERER = Path(__file__).parents[2] / "widgets" / "renderer"


@pytest.fixture
def viewer(pair):
    x, y, _ = pair
    viewer = WebglViewer([x, y], [placement_of(x), placement_of(y)], (300, 200), ["X", "Y"])
    yield viewer
    viewer.close()


def told(viewer, **content) -> None:
    """What the browser says."""
    viewer._scene._handle_custom_msg(content, [])


def test_shapes_are_sent_in_16_bits_and_no_worse_than_a_screen_shows(viewer, pair):
    for shape, surface, pane in zip(viewer._scene.setup["panes"], pair[:2], viewer.panes, strict=True):
        sent = shape["positions"]
        steps = np.frombuffer(sent["bytes"], np.uint16).reshape(-1, 3)
        places = np.array(sent["low"]) + np.array(sent["step"]) * steps
        np.testing.assert_allclose(places, pane.placement.to_scene(surface.vertices), atol=2e-5)
        np.testing.assert_array_equal(np.frombuffer(shape["index"], np.uint16).reshape(-1, 3), surface.faces)


@pytest.mark.parametrize("points", [np.zeros((1, 3)), [[0, 0, 0], [1, 0, 0]], np.eye(3).reshape(1, 3, 3) * 1e-30])
def test_flat_and_tiny_boxes_can_be_sent(points):
    sent = quantised(points)
    places = np.array(sent["low"]) + np.array(sent["step"]) * sent["bytes"]
    np.testing.assert_allclose(places, points, rtol=1e-4, atol=1e-34)


def test_triangles_take_as_many_bytes_as_their_vertices_need():
    faces = np.array([[0, 1, 65535]], dtype=np.int32)
    assert indices(faces, 65536).dtype == np.uint16
    assert indices(faces + 1, 65537).dtype == np.uint32
    assert indices(faces, 65536).tolist() == faces.tolist()


def test_what_changes_together_is_sent_once(viewer):
    sent = []
    viewer._scene.observe(lambda change: sent.append(change["name"]))
    with viewer.together():
        for pane in viewer.panes:
            pane.set_colors(np.zeros((pane.surface.n_vertices, 3)))
            pane.set_values(np.arange(float(pane.surface.n_vertices)))
            pane.set_regions(np.arange(pane.surface.n_vertices) % 2, np.eye(3))
            pane.set_mark("end", pane.surface.vertices[0])
    assert sorted(sent) == ["marks", "paints"]
    paint = viewer._scene.paints[1]
    np.testing.assert_array_equal(np.frombuffer(paint["values"], np.float32), np.arange(162))
    assert not np.frombuffer(paint["rgb"], np.uint8).any()
    pieces = len(paint["borders"]["rgb"]) // 3
    assert len(paint["borders"]["positions"]) == len(paint["borders"]["normals"]) == pieces * 9 * 4 > 0
    assert [mark["slot"] for mark in viewer._scene.marks[1]] == ["end"]


def test_clicks_are_picks_and_nonsense_is_none(viewer):
    seen = []
    viewer.on_pick(lambda pane, vertex: seen.append((pane, vertex)))
    pane = viewer.panes[1]
    face = pane.surface.faces[7]
    point = pane.placement.to_scene(pane.surface.vertices[face[2]]).tolist()
    told(viewer, kind="pick", pane=1, corners=face.tolist(), point=point)
    told(viewer, kind="pick", pane=2, corners=face.tolist(), point=point)
    told(viewer, kind="pick", pane=1, corners=[-1, 0, 1], point=point)
    told(viewer, kind="something else")
    assert seen == [(1, int(face[2]))]


def test_the_camera_of_the_browser_is_ours(viewer):
    seen = []
    viewer.on_camera(seen.append)
    viewer._scene.set_state({"camera": {"position": [1.0, 2.0, 3.0], "target": [0.1, 0.0, 0.0]}})
    assert viewer.camera == (1.0, 2.0, 3.0)
    assert viewer.target == (0.1, 0.0, 0.0)
    assert seen == [(1.0, 2.0, 3.0)]
    viewer.target = (0.0, 0.0, 0.5)
    assert seen == [(1.0, 2.0, 3.0)]  # it stands where it stood
    viewer.reset()
    assert viewer.camera == viewer.home
    assert viewer.target == (0.0, 0.0, 0.0)


def test_a_reader_of_still_pictures_may_ask_for_new_ones(viewer):
    asked = []
    viewer.on_redraw(lambda: asked.append(True))
    told(viewer, kind="redraw")
    viewer.show_stills(["data:a", "data:b"])
    assert asked == [True]
    assert viewer._scene.stills == ["data:a", "data:b"]


def test_frames_are_sent_once_and_a_time_is_a_tick(pair):
    x = pair[0]
    animation = Animation(x, np.stack([x.vertices, 2 * x.vertices, 3 * x.vertices]), [0.0, 1.0, 4.0])
    (placement,) = placements_of([animation])
    viewer = WebglViewer([x], [placement], (300, 200), ["X"], [Motion(animation, placement)])
    shape = viewer._scene.setup["panes"][0]
    sent = shape["frames"]
    steps = np.frombuffer(sent["bytes"], np.uint16).reshape(3, -1, 3)
    places = np.array(sent["low"]) + np.array(sent["step"]) * steps
    np.testing.assert_allclose(placement.to_surface(places), animation.positions, atol=1e-3)
    assert viewer._scene.setup["times"] == [0.0, 1.0, 4.0]
    viewer.show_time(1.0)
    assert viewer._scene.tick == TICKS / 4
    viewer.close()


def test_a_page_block_holds_equal_arrays_once_and_aligned():
    block = PageBlock()
    odd, even = np.arange(3, dtype=np.uint8), np.arange(5.0)
    placed = block.placed({"a": odd, "b": [even, odd.copy()], "c": "text"})
    assert placed["a"] == placed["b"][1] == {"bytes_at": 0, "length": 3}
    assert placed["b"][0] == {"bytes_at": 8, "length": 40}
    assert placed["c"] == "text"
    assert block.text() == block.text()
    assert with_bytes({"a": [odd]}) == {"a": [odd.tobytes()]}


def test_what_is_shipped_holds_its_licence_and_loads_nothing():
    assert "MIT licence" in browser_module.script()[:200]
    assert "Copyright" in browser_module.licence()
    assert "three.js authors" in browser_module.licence()
    for text in (browser_module.script(), browser_module.matrix_module(), browser_module.style()):
        assert "import(" not in text
        assert "cdn" not in text.lower()


@pytest.mark.slow
def test_what_is_shipped_is_what_the_sources_make(tmp_path):
    """Whoever changes the sources builds anew; skipped, saying so, where the bundler is not installed."""
    if not (RENDERER / "node_modules" / "esbuild").is_dir():
        pytest.skip("needs npm ci in widgets/renderer")
    before = browser_module.script(), browser_module.matrix_module(), browser_module.style()
    subprocess.run(["node", "build.mjs", str(tmp_path)], cwd=RENDERER, check=True)
    names = ("renderer.js", "matrix.js", "renderer.css")
    assert before == tuple((tmp_path / name).read_text(encoding="utf-8") for name in names)
