"""The browser module by mouse and keys, on a page that it draws: what is under the mouse, the panel, narrow windows."""

from __future__ import annotations

import base64
import io
from xml.etree import ElementTree

import browser as tools
import matplotlib.image
import numpy as np
import pytest

import qgeo_widgets as qw
from qgeo_widgets import compared_colors as names

SVG = "{http://www.w3.org/2000/svg}"

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def path(pair, tmp_path_factory):
    x, y, where = pair
    path = tmp_path_factory.mktemp("page") / "compare.html"
    widget = qw.compare(x, y, p2p=where)
    widget.to_html(path, modes=["attribute: height", names.CHECKERBOARD])
    widget.close()
    return path


@pytest.fixture
def view(page, path):
    """The first shape on the page, drawn."""
    page.goto(path.as_uri())
    view = page.locator(".qgeo-view").first
    tools.until(lambda: tools.pixels(view).std() > 15)
    return view


def middle(view) -> tuple[float, float]:
    box = view.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_vertex_and_value_under_the_mouse_are_said_without_a_kernel(page, view, pair):
    tip = page.locator(".qgeo-tip")
    assert not tip.is_visible()
    page.mouse.move(*middle(view))
    tools.until(tip.is_visible)
    number, value = tip.inner_text().removeprefix("vertex ").split(": about ")
    height = pair[0].attributes["height"]
    assert float(value) == pytest.approx(height[int(number)], abs=np.ptp(height) / 200)
    box = view.bounding_box()
    page.mouse.move(box["x"] + 4, box["y"] + 4)
    tools.until(lambda: not tip.is_visible())


def test_keys_turn_move_come_nearer_and_go_home(page, view):
    view.focus()
    first = tools.settled(view)
    for key in ("ArrowRight", "ArrowUp", "+", "-", "Shift+ArrowLeft"):
        before = tools.settled(view)
        page.keyboard.press(key)
        tools.until(lambda before=before: np.abs(tools.pixels(view) - before).mean() > 0.3)
    page.keyboard.press("Home")
    tools.until(lambda: np.abs(tools.pixels(view) - first).mean() < 0.1)
    np.testing.assert_allclose(tools.settled(view), first, atol=2)


def test_the_panel_changes_what_is_drawn_and_back(page, view):
    page.get_by_text("view and picture").click()
    page.mouse.move(0, 0)
    first = tools.settled(view)
    for name in ("edges", "flat shading", "parallel projection"):
        page.get_by_label(name).check()
        tools.until(lambda: np.abs(tools.pixels(view) - first).mean() > 0.05)
        page.get_by_label(name).uncheck()
        tools.until(lambda: np.abs(tools.pixels(view) - first).mean() < 0.01)
    for name, value, back in (("opacity", "0.4", "1"), ("light", "0.5", "1")):
        page.get_by_label(name).fill(value)
        tools.until(lambda: np.abs(tools.pixels(view) - first).mean() > 1)
        page.get_by_label(name).fill(back)
        tools.until(lambda: np.abs(tools.pixels(view) - first).mean() < 0.01)
    np.testing.assert_allclose(tools.settled(view), first, atol=2)
    page.get_by_label("background", exact=True).select_option("black")
    tools.until(lambda: tools.pixels(view)[5, 5].max() < 3)
    ground = (np.abs(first - first[5, 5]) < 1).all(axis=2)[2:-2, 2:-2]
    assert tools.settled(view)[2:-2, 2:-2][ground].max() < 3  # and nothing else has changed its place


def test_standard_views_and_kept_ones(page, view):
    page.get_by_text("view and picture").click()
    page.get_by_label("parallel projection").check()  # the front and the back have one outline
    page.mouse.move(0, 0)
    front = tools.settled(view)

    def outline(picture):
        return (np.abs(picture - picture[2, 2]) > 6).any(axis=2)

    page.get_by_role("button", name="keep this view").click()
    page.get_by_label("look").select_option("from behind")
    tools.until(lambda: np.abs(tools.pixels(view) - front).mean() > 1)
    back = tools.settled(view)
    assert (outline(back)[:, ::-1] == outline(front)).mean() > 0.985
    page.get_by_label("look").select_option("saved 1")
    tools.until(lambda: np.abs(tools.pixels(view) - front).mean() < 0.05)


def test_a_picture_is_as_large_as_was_asked_for_and_clear_around_the_shapes(page, view):
    page.get_by_text("view and picture").click()
    page.get_by_label("picture", exact=True).select_option("2 times as large")
    page.get_by_label("no background").check()
    with page.expect_download() as download:
        page.get_by_role("button", name="save picture").click()
    picture = matplotlib.image.imread(io.BytesIO(download.value.path().read_bytes()), format="png")
    whole = page.locator("#panes").bounding_box()
    assert picture.shape[2] == 4
    assert picture.shape[1] == pytest.approx(2 * whole["width"], abs=2)
    assert picture[2, 2, 3] == 0
    assert 0.05 < (picture[..., 3] == 1).mean() < 0.6


def test_a_picture_as_svg_has_titles_and_legend_as_text(page, view):
    page.get_by_text("view and picture").click()
    page.get_by_label("form").select_option("SVG, with legend")
    with page.expect_download() as download:
        page.get_by_role("button", name="save picture").click()
    assert download.value.suggested_filename == "qgeo-picture.svg"
    root = ElementTree.parse(download.value.path()).getroot()
    words = {text.text for text in root.iter(f"{SVG}text")}
    assert {"X, 162 vertices", "Y, 162 vertices", "height"} <= words
    on_page = set(page.locator("#legend").inner_text().split())
    assert on_page <= {word for text in words for word in text.split()}
    (image,) = root.iter(f"{SVG}image")
    pixels = matplotlib.image.imread(io.BytesIO(base64.b64decode(image.get("href").partition("base64,")[2])), "png")
    whole = page.locator("#panes").bounding_box()
    assert pixels.shape[1] == pytest.approx(whole["width"], abs=2)
    assert 0.02 < (pixels[..., 3] == 1).mean() < 1
    legend = next(each for each in root if each.tag == f"{SVG}svg" and each.find(f"{SVG}linearGradient") is not None)
    frame = next(each for each in root if each.find(f"{SVG}image") is not None)
    assert float(legend.get("y")) == float(frame.get("height"))  # nothing over anything else
    assert float(root.get("height")) == float(legend.get("y")) + float(legend.get("height"))


def test_a_canvas_that_the_browser_gives_up_says_so_and_is_drawn_anew(page, view):
    """Chromium draws in 16 canvases, and takes the oldest away for each further one."""
    notice = page.get_by_role("alert").filter(has_text="The browser has stopped drawing these shapes")
    assert not notice.is_visible()
    page.evaluate(
        """() => { window.others = Array.from({length: 24}, () => {
            const canvas = document.createElement('canvas');
            canvas.getContext('webgl2').clear(16384);
            return canvas;
        }); }"""
    )
    tools.until(notice.is_visible)
    notice.get_by_role("button", name="draw anew").click()
    tools.until(lambda: tools.pixels(page.locator(".qgeo-view").first).std() > 15)
    assert not notice.is_visible()


def test_the_checkerboard_is_sharp_within_triangles(page, view):
    page.mouse.move(0, 0)
    smooth = tools.settled(view)
    page.select_option("#mode", label=names.CHECKERBOARD)
    tools.until(lambda: np.abs(tools.pixels(view) - smooth).mean() > 1)

    def steps(picture):
        """Share of the pixels of the shape that are far from the one beside."""
        on_shape = (np.abs(picture - picture[5, 5]) > 12).any(axis=2)
        inside = on_shape[:, 1:] & on_shape[:, :-1]
        return (np.abs(np.diff(picture.sum(axis=2), axis=1)) > 60)[inside].mean()

    assert steps(smooth) < 0.01
    assert steps(tools.settled(view)) > 0.03


@pytest.mark.parametrize(("width", "rows"), [(1280, 1), (740, 1), (390, 2)])
def test_shapes_are_side_by_side_where_there_is_room_and_nothing_is_cut_off(page, path, width, rows):
    page.set_viewport_size({"width": width, "height": 900})
    page.goto(path.as_uri())
    views = page.locator(".qgeo-view")
    tools.until(lambda: tools.pixels(views.first).std() > 15)
    boxes = [views.nth(k).bounding_box() for k in range(2)]
    assert len({round(box["y"]) for box in boxes}) == rows
    assert all(box["x"] >= 0 and box["x"] + box["width"] <= width for box in boxes)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    for k in range(2):
        assert tools.pixels(views.nth(k)).std() > 15


def test_a_dark_page_is_dark_behind_the_shapes_too(chromium, path):
    context = chromium.new_context(viewport={"width": 1100, "height": 900}, color_scheme="dark")
    page = context.new_page()
    page.goto(path.as_uri())
    view = page.locator(".qgeo-view").first
    tools.until(lambda: tools.pixels(view).std() > 15)
    assert tools.pixels(view)[5, 5].max() < 60
    context.close()


@pytest.mark.parametrize("width", [390, 1280])
def test_the_chart_of_a_path_is_as_wide_as_there_is_room_and_its_text_is_not_small(page, pair, tmp_path, width):
    widget = qw.geodesics(pair[0], 3, 120)
    widget.to_html(tmp_path / "path.html")
    widget.close()
    page.set_viewport_size({"width": width, "height": 900})
    page.goto((tmp_path / "path.html").as_uri())
    chart = page.locator(".qgeo-chart")
    box = chart.bounding_box()
    assert box["x"] >= 0
    assert box["width"] == min(500, width - 32)
    for text in chart.locator("text").all():
        place = text.bounding_box()
        assert place["x"] >= 0
        assert place["x"] + place["width"] <= min(box["x"] + box["width"] + 8, width)
        scale = text.evaluate("(each) => Math.hypot(each.getScreenCTM().a, each.getScreenCTM().b)")
        assert scale * text.evaluate("(each) => parseFloat(getComputedStyle(each).fontSize)") == pytest.approx(11)
    plot = chart.locator("svg").nth(1).bounding_box()
    places = [each.bounding_box() for each in chart.locator("circle").all()]
    assert places
    assert all(plot["x"] - 3 <= each["x"] <= plot["x"] + plot["width"] + 3 for each in places)


@pytest.mark.parametrize(("width", "beside"), [(900, True), (390, False)])
def test_matrix_and_shape_are_side_by_side_where_there_is_room_and_the_strip_is_as_high(
    page, pair, tmp_path, width, beside
):
    widget = qw.matrix(pair[0])
    widget.to_html(tmp_path / "matrix.html")
    widget.close()
    page.set_viewport_size({"width": width, "height": 900})
    page.goto((tmp_path / "matrix.html").as_uri())
    page.locator("canvas.qgeo-matrix").wait_for()
    view, matrix = (page.locator(each).bounding_box() for each in (".qgeo-view", "canvas.qgeo-matrix"))
    assert (abs(view["y"] - matrix["y"]) < 30) == beside
    assert view["x"] + view["width"] <= width
    strip = page.locator(".qgeo-strip").bounding_box()
    assert (strip["y"], strip["height"]) == pytest.approx((matrix["y"], matrix["height"]), abs=2)
    assert matrix["width"] == pytest.approx(matrix["height"], abs=1)


def test_the_ground_follows_when_day_turns_to_night(page, view):
    ground = tools.settled(view)[5, 5]
    page.emulate_media(color_scheme="dark")
    tools.until(lambda: not np.array_equal(tools.pixels(view)[5, 5], ground))
    np.testing.assert_allclose(tools.settled(view)[5, 5], [0x1E, 0x21, 0x27], atol=4)
    page.emulate_media(color_scheme="light")
    tools.until(lambda: tools.pixels(view)[5, 5].mean() > 128)
    np.testing.assert_allclose(tools.settled(view)[5, 5], ground, atol=1)
