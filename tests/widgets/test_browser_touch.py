"""The browser module by fingers, on a page as wide as a telephone: one turns, two zoom and move, a tap is a click."""

from __future__ import annotations

import browser as tools
import numpy as np
import pytest

import qgeo_widgets as qw

pytestmark = pytest.mark.browser

WIDTH, HEIGHT = 390, 844


@pytest.fixture(scope="module")
def path(pair, tmp_path_factory):
    x, y, where = pair
    path = tmp_path_factory.mktemp("page") / "compare.html"
    widget = qw.compare(x, y, p2p=where)
    widget.to_html(path)
    widget.close()
    return path


@pytest.fixture
def view(chromium, path):
    """The first shape on the page of a telephone, drawn."""
    size = {"width": WIDTH, "height": HEIGHT}
    context = chromium.new_context(viewport=size, has_touch=True, is_mobile=True, device_scale_factor=2)
    page = context.new_page()
    page.goto(path.as_uri())
    view = page.locator(".qgeo-view").first
    tools.until(lambda: tools.pixels(view).std() > 15)
    yield view
    context.close()


def places(view, *shares: tuple[float, float]) -> list[tuple[float, float]]:
    """Points of the view, from its upper left corner, as shares of its size."""
    box = view.bounding_box()
    return [(box["x"] + a * box["width"], box["y"] + b * box["height"]) for a, b in shares]


def outline(picture: np.ndarray) -> np.ndarray:
    return (np.abs(picture - picture[4, 4]) > 6).any(axis=2)


def centre(shape: np.ndarray) -> np.ndarray:
    return np.argwhere(shape).mean(axis=0) / shape.shape[1]


def test_one_finger_turns_and_the_page_stays(view):
    page, first = view.page, tools.settled(view)
    start, end = places(view, (0.4, 0.6), (0.6, 0.4))  # upwards too, which would scroll the page
    tools.Fingers(page).move((start, end))
    tools.until(lambda: np.abs(tools.pixels(view) - first).mean() > 1)
    turned = tools.settled(view)
    assert page.evaluate("[scrollX, scrollY, visualViewport.scale]") == [0, 0, 1]
    # It was turned, not moved: all that is seen is about as large, and where it was.
    assert outline(turned).sum() == pytest.approx(outline(first).sum(), rel=0.25)
    assert np.abs(centre(outline(turned)) - centre(outline(first))).max() < 0.08
    back, there = places(view, (0.6, 0.4), (0.4, 0.6))
    tools.Fingers(page).move((back, there))
    tools.until(lambda: np.abs(tools.pixels(view) - first).mean() < 0.5)


def test_two_fingers_zoom_and_go_back(view):
    page, first = view.page, tools.settled(view)
    far, near = places(view, (0.3, 0.5), (0.7, 0.5)), places(view, (0.4, 0.5), (0.6, 0.5))
    tools.Fingers(page).move(*zip(far, near, strict=True))
    tools.until(lambda: outline(tools.pixels(view)).sum() < 0.5 * outline(first).sum())
    smaller = outline(tools.settled(view))
    # The fingers come together to half of their gap: twice as far away, a little less than half as wide.
    assert 0.18 < smaller.sum() / outline(first).sum() < 0.26
    assert np.abs(centre(smaller) - centre(outline(first))).max() < 0.03
    assert page.evaluate("visualViewport.scale") == 1  # the shape was zoomed, not the page
    tools.Fingers(page).move(*zip(near, far, strict=True))
    # The fingers' moves come one after the other, so that the shape may end a pixel or two aside.
    tools.until(lambda: (outline(tools.pixels(view)) != outline(first)).mean() < 0.03)


def test_two_fingers_move_the_shape(view):
    page, first = view.page, tools.settled(view)
    starts, ends = places(view, (0.4, 0.5), (0.6, 0.5)), places(view, (0.4, 0.7), (0.6, 0.7))
    tools.Fingers(page).move(*zip(starts, ends, strict=True))
    tools.until(lambda: np.abs(tools.pixels(view) - first).mean() > 1)
    down, right = centre(outline(tools.settled(view))) - centre(outline(first))
    height = view.bounding_box()["height"] / view.bounding_box()["width"]
    assert down == pytest.approx(0.2 * height, abs=0.05)
    assert abs(right) < 0.03


def test_a_tap_is_a_click_and_two_are_none(view):
    page, first = view.page, tools.settled(view)
    (middle,) = places(view, (0.5, 0.5))
    tools.Fingers(page).move(*[(place, place) for place in places(view, (0.45, 0.5), (0.55, 0.5))], steps=1)
    page.wait_for_timeout(500)
    np.testing.assert_allclose(tools.settled(view), first, atol=2)
    page.touchscreen.tap(*middle)
    tools.until(lambda: np.abs(tools.pixels(view) - first).mean() > 0.05)
