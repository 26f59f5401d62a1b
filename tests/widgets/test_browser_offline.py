"""Pages written by the widgets, opened from a file in a browser that is offline."""

from __future__ import annotations

import base64
import gzip
import json
import re
from html import unescape
from types import SimpleNamespace

import browser as tools
import numpy as np
import pytest
import shapes

import qgeo_filters as qg
import qgeo_widgets as qw
from qgeo_filters import Animation, Surface
from qgeo_filters.animation.pose_transfer import Transfer
from qgeo_widgets import symmetry_widget
from qgeo_widgets.offscreen import pane_picture
from qgeo_widgets.rendering import display_mesh
from qgeo_widgets.rendering.pane import Line


@pytest.fixture
def offline(chromium, tmp_path):
    """Function that opens a page offline; afterwards nothing was asked for but the file, and nothing failed."""
    context = chromium.new_context(viewport={"width": 1100, "height": 900}, offline=True)
    page = context.new_page()
    asked, failed = [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: failed.append(str(error)))

    def opened(path):
        page.goto(path.as_uri())
        return page

    yield opened
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []
    assert failed == []
    context.close()


def page_data(path) -> dict:
    """The data inside a page, with bytes where it names a part of the block."""
    text = path.read_text()
    parts = {name: re.search(rf'<script id="{name}"[^>]*>(.*?)</script>', text, re.S)[1] for name in ("data", "arrays")}
    block = gzip.decompress(base64.b64decode(parts["arrays"]))

    def resolved(item):
        return block[item["bytes_at"] :][: item["length"]] if "bytes_at" in item else item

    return json.loads(parts["data"], object_hook=resolved)


def places(quantised: dict) -> np.ndarray:
    """Points (p, 3) that were sent in 16 bits each."""
    steps = np.frombuffer(quantised["bytes"], np.uint16).reshape(-1, 3)
    return steps * np.array(quantised["step"]) + quantised["low"]


def pair_clicked(page, view) -> tuple[int, int]:
    """What the page says after a click in the middle of X: its vertex, and the partner."""
    box = view.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    said = re.fullmatch(r"vertex (\d+) of X ↔ vertex (\d+) of Y", page.locator("#picked").inner_text())
    return int(said[1]), int(said[2])


def reddened(view, before: np.ndarray) -> np.ndarray:
    """Pixels of a view that have the colour of a mark now, and had not: whatever else is said or drawn anew."""
    seen, old = tools.settled(view).astype(int), before.astype(int)
    red = [np.abs(picture[..., :3] - (219, 28, 41)).max(axis=-1) < 60 for picture in (seen, old)]
    return red[0] & ~red[1]


def test_a_page_holds_shapes_colors_and_partners_as_they_are(pair, tmp_path):
    x, y, where = pair
    widget = qw.compare(x, y, p2p=where)
    widget.mode = "attribute: height"
    widget.picked = ("x", 4)
    widget.to_html(tmp_path / "page.html")
    data = page_data(tmp_path / "page.html")
    shape, pane = data["setup"]["panes"][0], widget._viewer.panes[0]
    np.testing.assert_array_equal(np.frombuffer(shape["index"], np.uint16).reshape(-1, 3), x.faces)
    np.testing.assert_allclose(places(shape["positions"]), pane.placement.to_scene(x.vertices), atol=1e-5)
    for name in ("vertices", "drawn"):
        np.testing.assert_array_equal(np.frombuffer(data["partners"][0][name], np.int32), where)
    assert data["modes"][data["start"]]["name"] == "attribute: height"
    painted = data["modes"][data["start"]]["steps"][0]["panes"][0]
    colors = np.frombuffer(painted["lut"], np.uint8).reshape(-1, 3)[np.frombuffer(painted["index"], np.uint8)]
    np.testing.assert_allclose(colors / 255, widget._viewer.panes[0].colors, atol=0.02)
    assert [mark["color"] for mark in data["setup"]["panes"][1]["marks"]] == ["#db1c29"]
    steps = {mode["name"]: len(mode["steps"]) for mode in data["modes"]}
    assert steps["eigenfunction"] == 20
    assert widget.mode == "attribute: height"
    assert widget.k == 1
    widget.close()


@pytest.fixture
def large(monkeypatch) -> tuple[Surface, Surface, np.ndarray]:
    """Two shapes with other numbers for the same vertices, drawn coarser, and the map from one to the other."""
    monkeypatch.setattr(display_mesh, "SHOWN_AS_IT_IS", 400)
    monkeypatch.setattr(display_mesh, "SHOWN_OF_LARGER", 390)
    vertices, faces = shapes.blob(3, seed=2)
    order = np.random.default_rng(0).permutation(len(vertices))  # vertex i of Y is vertex order[i] of X
    where = np.argsort(order)
    return Surface(vertices, faces), Surface(vertices[order] + [3, 0, 0], where[faces]), where


def test_partners_on_a_page_of_large_shapes_are_those_of_the_vertices_that_are_drawn(large, tmp_path):
    x, y, where = large
    where = np.where(np.arange(x.n_vertices) % 5 == 0, -1, where)
    widget = qw.compare(x, y, p2p=where)
    widget.to_html(tmp_path / "page.html")
    data = page_data(tmp_path / "page.html")
    left, right = (pane.display for pane in widget._viewer.panes)
    assert left.is_proxy
    assert right.is_proxy
    numbers = np.frombuffer(data["setup"]["panes"][0]["numbers"], np.int32)
    vertices, drawn = (np.frombuffer(data["partners"][0][name], np.int32) for name in ("vertices", "drawn"))
    assert len(vertices) == left.shown.n_vertices
    np.testing.assert_array_equal(vertices, where[numbers])
    np.testing.assert_array_equal(drawn < 0, vertices < 0)
    there = drawn >= 0
    off = np.linalg.norm(right.shown.vertices[drawn[there]] - y.vertices[vertices[there]], axis=1)
    assert off.max() < right.shown.edge_lengths.max()
    widget.close()


def test_rows_on_a_page_of_a_large_shape_are_those_of_the_vertices_that_are_drawn(large, tmp_path):
    x = large[0]
    widget = qw.matrix(x)
    widget.to_html(tmp_path / "page.html")
    matrix = page_data(tmp_path / "page.html")["matrix"]
    shown = widget._viewer.panes[0].display.shown
    index = np.frombuffer(matrix["rows"], np.uint8).reshape(matrix["count"], shown.n_vertices)
    vertices, drawn = (np.frombuffer(matrix[name], np.int32) for name in ("vertices", "drawn"))
    off = np.linalg.norm(shown.vertices[drawn] - x.vertices[vertices], axis=1)
    assert off.max() < shown.edge_lengths.max()
    # A row is nearest to nothing at its own vertex.
    nearest = shown.vertices[index.argmin(axis=1)]
    assert np.linalg.norm(nearest - x.vertices[vertices], axis=1).max() < 2 * shown.edge_lengths.max()
    widget.close()


@pytest.mark.slow
@pytest.mark.browser
def test_a_click_on_a_page_of_large_shapes_marks_the_partner(large, tmp_path, offline):
    x, y, where = large
    widget = qw.compare(x, y, p2p=where)
    widget.to_html(tmp_path / "page.html")
    widget.close()
    page = offline(tmp_path / "page.html")
    views = page.locator(".qgeo-view").first, page.locator(".qgeo-view").last
    tools.until(lambda: tools.pixels(views[0]).std() > 15)
    before = [tools.settled(view) for view in views]
    i, j = pair_clicked(page, views[0])
    assert where[i] == j
    tools.until(lambda: all(reddened(*pair).sum() > 20 for pair in zip(views, before, strict=True)))
    # The shapes are the same, and so are the places of both marks.
    one, other = (np.argwhere(reddened(view, old)).mean(axis=0) for view, old in zip(views, before, strict=True))
    assert np.linalg.norm(one - other) < 30  # the drawn vertices differ


def test_modes_of_a_page_can_be_chosen(pair, tmp_path):
    x, y, where = pair
    widget = qw.compare(x, y, p2p=where)
    widget.to_html(tmp_path / "page.html", modes=["attribute: height"])
    assert [mode["name"] for mode in page_data(tmp_path / "page.html")["modes"]] == ["attribute: height"]
    with pytest.raises(ValueError, match="unknown modes"):
        widget.to_html(tmp_path / "page.html", modes=["nonsense"])
    widget.close()


def test_names_cannot_break_the_page(pair, tmp_path):
    x = Surface(pair[0].vertices, pair[0].faces, {"</script><b>": np.arange(162.0)})
    widget = qw.compare(x, pair[1], p2p=pair[2])
    widget.to_html(tmp_path / "page.html")
    assert page_data(tmp_path / "page.html")["modes"][-1]["name"] == "attribute: </script><b>"
    widget.close()


@pytest.mark.browser
def test_compare_page_turns_both_views_picks_partners_and_switches_modes(pair, tmp_path, offline):
    x, y, where = pair
    widget = qw.compare(x, y, p2p=where)
    widget.to_html(tmp_path / "page.html")
    widget.close()
    page = offline(tmp_path / "page.html")
    left, right = page.locator(".qgeo-view").first, page.locator(".qgeo-view").last
    tools.until(lambda: tools.pixels(left).std() > 15)
    assert not page.locator("#player").is_visible()
    before = tools.settled(left), tools.settled(right)
    tools.drag(page, left, 60, 20, release=False)
    for canvas, old in zip((left, right), before, strict=True):
        assert np.abs(tools.settled(canvas) - old).mean() > 1
    page.mouse.up()
    assert "vertex" not in page.locator("#picked").inner_text()
    page.get_by_role("button", name="reset view").click()
    np.testing.assert_allclose(tools.settled(left), before[0], atol=2)
    i, j = pair_clicked(page, left)
    assert where[i] == j
    page.select_option("#mode", label="eigenfunction")
    first = tools.settled(left)
    page.locator("#step").fill("3")
    assert np.abs(tools.settled(left) - first).mean() > 2
    assert "φ₃" in page.locator("#legend").inner_text()


def standing_path(pair):
    return qw.geodesics(pair[0], 5, 5)


def one_point_twice(pair):
    widget = qw.compare(pair[0], pair[1], p2p=pair[2])
    widget.picked = widget.second = ("x", 7)
    return widget


def axis_of_a_point(pair):
    """A symmetry whose only vertex on the axis lies amid one side, as on cat0."""
    side = np.full(pair[0].n_vertices, -1)
    side[9] = 0
    same = np.arange(len(side))
    return qw.symmetry(pair[0], symmetry=SimpleNamespace(found=True, p2p=same, side=side, asymmetry=0.0 * side))


@pytest.mark.parametrize("make", [standing_path, one_point_twice, axis_of_a_point])
def test_a_line_without_length_is_not_drawn(pair, make):
    widget = make(pair)
    assert widget.message == ""
    assert [pane.lines for pane in widget._viewer.panes] == [{}] * len(widget._viewer.panes)
    widget.close()


@pytest.mark.browser
def test_a_page_with_a_line_too_short_to_see_is_not_blank(pair, tmp_path, offline):
    widget = qw.geodesics(pair[0])
    place = pair[0].vertices[5]
    widget._viewer.panes[0].lines["path"] = Line(np.stack([place, place + 1e-8, place]), (1.0, 0.0, 0.0), 5.0)
    widget.to_html(tmp_path / "page.html")
    widget.close()
    page = offline(tmp_path / "page.html")
    tools.until(lambda: tools.pixels(page.locator(".qgeo-view")).std() > 15)
    assert not page.locator("#no-drawing").is_visible()


@pytest.mark.browser
def test_a_page_that_cannot_draw_says_so_and_shows_the_still_picture(pair, tmp_path, page):
    widget = qw.geodesics(pair[0])
    widget.to_html(tmp_path / "page.html")
    widget.close()
    text = (tmp_path / "page.html").read_text()
    (tmp_path / "broken.html").write_text(text.replace('"panes": [', '"panes": [{}, ', 1))
    page.goto((tmp_path / "broken.html").as_uri())
    why = page.locator("#why").inner_text()
    assert re.match("This page could not draw the shapes, so this is a still picture. The error was: .*Error", why)
    tools.until(lambda: tools.pixels(page.locator("#no-drawing img")).std() > 15)
    assert not page.locator("#controls").is_visible()


@pytest.mark.slow
@pytest.mark.browser
def test_a_click_on_a_page_takes_the_exported_pick_away(pair, tmp_path, offline):
    x, y, where = pair
    widget = qw.compare(x, y, p2p=where)
    widget.landmarks = [(3, 4)]
    widget.picked, widget.second = ("x", 7), ("x", 100)
    widget.mode = "attribute: height"
    widget.to_html(tmp_path / "page.html")
    widget.second = widget.picked = None
    widget.to_html(tmp_path / "bare.html")
    widget.close()

    def after_a_click(path):
        page = offline(path)
        canvas = page.locator(".qgeo-view").first
        tools.until(lambda: tools.pixels(canvas).std() > 15)
        before = tools.settled(canvas)
        box = canvas.bounding_box()
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        return before, tools.settled(canvas), page.locator("#info").is_visible()

    with_marks, picked, info = after_a_click(tmp_path / "page.html")
    without, expected, _ = after_a_click(tmp_path / "bare.html")
    assert np.abs(with_marks - without).max() > 50
    np.testing.assert_allclose(picked, expected, atol=3)  # the landmark is still there, and nothing else
    assert not info


@pytest.mark.slow
@pytest.mark.browser
def test_regions_of_a_page_do_not_mix_their_colors(pair, tmp_path, offline):
    """Light is white: all that it makes of a colour has the colour's ratios of red, green and blue."""
    side = np.where(pair[0].vertices[:, 0] > 0, 1, -1)
    known = SimpleNamespace(found=True, p2p=np.arange(len(side)), side=side, asymmetry=0.0 * side)
    widget = qw.symmetry(pair[0], symmetry=known)
    for slot in list(widget._viewer.panes[0].lines):
        widget._viewer.panes[0].set_line(slot, None)
    widget.mode = symmetry_widget.SIDES
    widget.to_html(tmp_path / "page.html")
    palette = widget._field.palette[:2]
    widget.close()
    page = offline(tmp_path / "page.html")
    canvas = page.locator(".qgeo-view").first
    tools.until(lambda: tools.pixels(canvas).std() > 15)
    picture = tools.settled(canvas).reshape(-1, 3)
    ratios = picture[(np.abs(picture - [247, 247, 248]) > 3).any(axis=1)]
    ratios = ratios / np.linalg.norm(ratios, axis=1, keepdims=True)
    colors = palette / np.linalg.norm(palette, axis=1, keepdims=True)
    cosines = ratios @ colors.T
    assert (cosines.argmax(axis=1) == 0).mean() > 0.1
    assert (cosines.argmax(axis=1) == 1).mean() > 0.1
    assert (cosines.max(axis=1) < 0.995).mean() < 0.03  # edges alone


@pytest.mark.browser
def test_a_snapshot_is_what_a_page_shows(pair, tmp_path, offline):
    widget = qw.compare(pair[0], pair[1], p2p=pair[2])
    widget._viewer.target = (0.2, -0.1, 0.15)
    widget.camera = (1.2, 0.9, 1.6)
    widget.to_html(tmp_path / "page.html")
    pictures = [pane_picture(widget._viewer, pane, 440, 400) for pane in widget._viewer.panes]
    widget.close()
    page = offline(tmp_path / "page.html")
    for number, picture in enumerate(pictures):
        canvas = page.locator(".qgeo-view").nth(number)
        tools.until(lambda canvas=canvas: tools.pixels(canvas).std() > 15)
        on_page = tools.settled(canvas)
        covered = [
            (np.abs(each[:400, :440] - np.array([247.0, 247, 248])) > 4).any(axis=2) for each in (on_page, picture)
        ]
        assert (covered[0] & covered[1]).sum() / (covered[0] | covered[1]).sum() > 0.98


@pytest.mark.browser
def test_matrix_page_shows_rows_under_the_mouse(tmp_path, offline):
    widget = qw.matrix(Surface(*shapes.blob(2, seed=3)))
    vertices = widget._vertex_of_row
    widget.to_html(tmp_path / "page.html")
    widget.close()
    page = offline(tmp_path / "page.html")
    shape, matrix = page.locator(".qgeo-view"), page.locator(".matrix canvas")
    tools.until(lambda: tools.pixels(shape).std() > 15)
    before = tools.settled(shape)
    box = matrix.bounding_box()
    page.mouse.move(box["x"] + 100, box["y"] + 0.25 * box["height"])
    row = int(0.25 * len(vertices))
    assert page.locator("#picked").inner_text() == f"row {row}: distances from vertex {vertices[row]}"
    assert np.abs(tools.settled(shape) - before).mean() > 2


def growing(surface: Surface) -> Animation:
    """A surface that becomes longer and longer, at uneven times."""
    poses = [surface.vertices * [1, 1, 1 + 0.4 * k] for k in range(4)]
    return Animation(surface, np.stack(poses), [0.0, 1.0, 3.0, 4.0])


def test_a_page_of_an_animation_holds_each_frame_once(pair, tmp_path):
    walk = growing(pair[0])
    widget = qw.animate(walk, attribute="height")
    widget.time, widget.speed, widget.loop = 2.5, 2.0, "back and forth"
    widget.to_html(tmp_path / "page.html")
    data = page_data(tmp_path / "page.html")
    state = data["motion"]
    assert (state["time"], state["speed"], state["loop"], state["times"]) == (2.5, 2.0, "back and forth", [0, 1, 3, 4])
    placement = widget._viewer.panes[0].placement
    frames = places(data["setup"]["panes"][0]["frames"]).reshape(4, -1, 3)
    np.testing.assert_allclose(placement.to_surface(frames), walk.positions, atol=1e-4)
    assert data["modes"][data["start"]]["name"] == "attribute: height"
    widget.close()


@pytest.mark.slow
@pytest.mark.browser
def test_animation_page_plays_both_shapes_at_one_time(pair, tmp_path, offline):
    walk = growing(pair[0])
    widget = qw.animate(Transfer(walk.surface, walk.positions[:, :, [1, 0, 2]], walk.times, source=walk), seconds=2.0)
    widget.to_html(tmp_path / "page.html")
    widget.close()
    page = offline(tmp_path / "page.html")
    canvases = page.locator(".qgeo-view").first, page.locator(".qgeo-view").last
    time, shown, play = page.locator("#time"), page.locator("#time-value"), page.locator("#play")
    tools.until(lambda: tools.pixels(canvases[0]).std() > 10)
    assert page.locator("#player").is_visible()
    first = [tools.settled(canvas) for canvas in canvases]
    time.fill("2.5")
    assert shown.inner_text() == "2.50"
    later = [tools.settled(canvas) for canvas in canvases]
    for before, after in zip(first, later, strict=True):
        assert np.abs(after - before).mean() > 1
    time.fill("0")
    for canvas, before in zip(canvases, first, strict=True):
        np.testing.assert_array_equal(tools.settled(canvas), before)

    # It plays until it is told to pause, and a click on the way marks a vertex that goes along.
    play.click()
    assert play.inner_text() == "pause"
    tools.until(lambda: 0.2 < float(shown.inner_text()) < 3.9)
    play.click()
    assert play.inner_text() == "play"
    paused = shown.inner_text()
    still = tools.settled(canvases[0])
    assert shown.inner_text() == paused
    assert np.abs(still - first[0]).mean() > 0.3
    box = canvases[0].bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert "vertex" in page.locator("#picked").inner_text()

    # Once, and fast, it comes to its end and stays there; back and forth it returns.
    page.select_option("#loop", "once")
    page.locator("#speed").fill("1")
    play.click()
    tools.until(lambda: shown.inner_text() == "4.00" and play.inner_text() == "play")
    page.select_option("#loop", "back and forth")
    page.locator("#speed").fill("0")
    play.click()
    tools.until(lambda: 0.5 < float(shown.inner_text()) < 3.5)
    tools.drag(page, canvases[1], 40, 10)  # turns while it plays
    play.click()


def test_an_embedded_page_is_that_of_the_file(pair, tmp_path):
    widget = qw.compare(*pair[:2], p2p=pair[2])
    widget.to_html(tmp_path / "page.html", modes=["attribute: height"])
    shown = widget.embed(modes=["attribute: height"], height=500)._repr_html_()
    before, text, after = re.fullmatch(r'(.*srcdoc=")([^"]*)("[^"]*"[^"]*".*)', shown, re.DOTALL).groups()
    assert unescape(text) == (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "height:500px" in after
    assert before.startswith("<div><iframe title=")
    with pytest.raises(qg.ParameterError, match="height must be"):
        widget.embed(height=3)
    with pytest.raises(qg.ParameterError, match="unknown modes"):
        widget.embed(modes=["none"])
    widget.close()
    with pytest.raises(qg.ParameterError, match="nothing"):
        widget.embed()
