"""A texture from a file is carried through the map, seen in snapshots and on pages, and a bad one is named."""

from __future__ import annotations

import browser as tools
import numpy as np
import pytest
from PIL import Image

import qgeo_widgets as qw
from qgeo_filters import ParameterError, Surface
from qgeo_widgets.compared_colors import CARRIED, TEXTURE
from qgeo_widgets.offscreen import pane_picture
from qgeo_widgets.texture import Texture, texture_places

QUARTERS = np.array([[[230, 40, 40], [40, 200, 40]], [[40, 60, 230], [240, 220, 40]]], np.uint8)  # upper row first


@pytest.fixture(scope="module")
def photo(tmp_path_factory):
    """A file of four quarters: red, green, blue, yellow."""
    path = tmp_path_factory.mktemp("texture") / "photo.png"
    Image.fromarray(QUARTERS.repeat(64, axis=0).repeat(96, axis=1)).save(path)
    return path


def quarter(pixels: np.ndarray) -> np.ndarray:
    """Which of the four each pixel shows, whatever the light on it; -1 for none."""
    hue = pixels / np.maximum(pixels.sum(axis=-1, keepdims=True), 1)
    wanted = QUARTERS.reshape(4, 3) / QUARTERS.reshape(4, 3).sum(axis=1, keepdims=True)
    gap = np.abs(hue[..., None, :] - wanted).sum(axis=-1)
    return np.where(gap.min(axis=-1) < 0.12, gap.argmin(axis=-1), -1)


def test_the_first_row_is_above_and_the_picture_repeats():
    texture = Texture.of(QUARTERS.repeat(8, axis=0).repeat(8, axis=1))
    places = np.array([[0.25, 0.75], [0.75, 0.75], [0.25, 0.25], [0.75, 0.25], [1.25, -0.25], [np.nan, 0.5]])
    expected = np.vstack([QUARTERS.reshape(4, 3), QUARTERS[:1, 0], [[0.62 * 255] * 3]]) / 255
    np.testing.assert_allclose(texture.at(places), expected, atol=1e-12)
    between = texture.at(np.array([[0.5, 0.75]]))[0]  # half way between two pixels
    np.testing.assert_allclose(between, QUARTERS[0].mean(axis=0) / 255, atol=1e-12)


def test_files_and_arrays_are_one(photo):
    array = np.asarray(Image.open(photo))
    for given in (photo, str(photo), array, array / 255.0, np.dstack([array, np.full(array.shape[:2], 255, np.uint8)])):
        np.testing.assert_array_equal(Texture.of(given).pixels, array)
    clear = np.zeros((4, 4, 4), np.uint8)
    assert (Texture.of(clear).pixels == 255).all()  # white shows through
    assert (Texture.of(np.full((3, 5), 7, np.uint8)).pixels == 7).all()
    assert Texture.of(np.zeros((3000, 1500), np.uint8)).pixels.shape == (1024, 512, 3)


@pytest.mark.parametrize(
    ("texture", "message"),
    [
        ("nothing.png", r"nothing\.png: there is no such file"),
        (__file__, r"test_texture\.py cannot be read as a picture"),
        (np.zeros((3, 4, 2), np.uint8), r"shape \(3, 4, 2\), expected \(h, w\)"),
        (np.zeros((0, 4), np.uint8), r"shape \(0, 4\)"),
        (np.full((2, 2), 1.5), "numbers from 0 to 1"),
        (np.full((2, 2), np.nan), "numbers from 0 to 1"),
        (np.zeros((2, 2), np.int64), "not int64"),
        ([[1], [2, 3]], "no array"),
    ],
)
def test_a_bad_texture_is_a_sentence_and_all_else_is_shown(pair, texture, message):
    with pytest.raises(ParameterError, match=message):
        Texture.of(texture)
    widget = qw.compare(pair[0], pair[1], p2p=pair[2], texture=texture)
    assert "texture" in widget.message
    assert TEXTURE not in widget.modes
    assert widget.mode == CARRIED
    assert widget._viewer is not None
    widget.close()


def test_half_a_file_is_named(photo, tmp_path, pair):
    (tmp_path / "half.png").write_bytes(photo.read_bytes()[:150])
    with pytest.raises(ParameterError, match=r"half\.png cannot be read as a picture"):
        Texture.of(tmp_path / "half.png")


def test_coordinates_are_given_named_found_or_projected(pair):
    x = pair[0]
    uv = np.random.default_rng(0).random((x.n_vertices, 2))
    wrong = AssertionError("not asked for")

    def never() -> np.ndarray:
        raise wrong

    named = Surface(x.vertices, x.faces, {"map": uv, "s": uv[:, 0], "t": uv[:, 1]})
    for surface, given in ((x, uv), (named, "map"), (named, None), (Surface(x.vertices, x.faces, {"uv": uv}), None)):
        np.testing.assert_array_equal(texture_places(surface, given, never), uv)
    np.testing.assert_array_equal(texture_places(x, None, lambda: uv + 1), uv + 1)
    for given, message in (("nope", "no attribute 'nope'"), (uv[:5], "shape"), (["a"], "no numbers")):
        with pytest.raises(ParameterError, match=message):
            texture_places(x, given, never)
    widget = qw.compare(pair[0], pair[1], p2p=pair[2], texture_coordinates=uv)
    assert "need a texture" in widget.message
    widget.close()


def test_a_projected_picture_is_whole_and_keeps_its_shape():
    texture = Texture.of(np.zeros((50, 100), np.uint8))
    points = np.random.default_rng(0).uniform([-1, -2, 0], [3, 4, 1], (500, 3))
    places = texture.projected(points)
    assert (places >= 0).all()
    assert (places <= 1).all()
    assert places[:, 1].min() < 1e-9 < 1 - 1e-9 < places[:, 1].max()
    slope = [np.polyfit(points[:, k], places[:, k], 1)[0] for k in (0, 1)]
    assert slope[1] / slope[0] == pytest.approx(2.0)  # the picture is twice as wide as high


def test_it_is_carried_to_each_vertex_and_seen_in_the_snapshot(pair, photo):
    x, y, where = pair
    widget = qw.compare(x, y, p2p=where, texture=photo)
    assert (widget.mode, widget.message) == (TEXTURE, "")
    on_x, on_y = (pane.places for pane in widget._viewer.panes)
    np.testing.assert_array_equal(on_y[where], on_x)
    np.testing.assert_allclose(widget._viewer.panes[1].colors[where], widget._viewer.panes[0].colors, atol=1e-6)
    shown = [quarter(pane_picture(widget._viewer, pane)) for pane in widget._viewer.panes]
    for picture in shown:
        for number in range(4):
            assert 0.02 < (picture == number).mean() < 0.4
    assert (shown[0] == shown[1]).mean() > 0.98  # Y is turned onto X
    rows, columns = np.nonzero(shown[0] == 0)
    assert rows.mean() < 0.5 * 364
    assert columns.mean() < 0.5 * 400  # the first pixel of the file is above on the left
    widget.mode = CARRIED
    assert all(pane.places is None for pane in widget._viewer.panes)
    widget.close()


@pytest.mark.slow
@pytest.mark.browser
def test_the_page_shows_what_the_snapshot_shows(pair, photo, tmp_path, page):
    """The texture where there are partners, and grey, up to the border of its triangles, where there are none."""
    x, y, where = pair
    alone = x.vertices[:, 0] > 0.4
    widget = qw.compare(x, y, p2p=np.where(alone, -1, where), texture=photo)
    np.testing.assert_array_equal(np.isnan(widget._viewer.panes[0].places).all(axis=1), alone)
    widget.to_html(tmp_path / "page.html", modes=[CARRIED, TEXTURE])
    expected = [quarter(pane_picture(widget._viewer, pane, *widget._viewer.size)) for pane in widget._viewer.panes]
    shapes_drawn = [(pane_picture(widget._viewer, p, 440, 400) < 230).any(axis=2) for p in widget._viewer.panes]
    widget.close()
    page.goto((tmp_path / "page.html").as_uri())
    views = page.locator(".qgeo-view")
    tools.until(lambda: (quarter(tools.pixels(views.first)) == 0).mean() > 0.02)
    for number in range(2):
        shown = quarter(tools.settled(views.nth(number)))[: expected[number].shape[0], : expected[number].shape[1]]
        both = (shown >= 0) & (expected[number][: shown.shape[0], : shown.shape[1]] >= 0)
        assert both.mean() > 0.15
        assert (shown == expected[number][: shown.shape[0], : shown.shape[1]])[both].mean() > 0.97
        grey = shapes_drawn[number] & (expected[number] < 0)
        assert 0.05 < grey.mean() < 0.4
        assert (
            shown[grey[: shown.shape[0], : shown.shape[1]]] < 0
        ).mean() > 0.9  # colours fade to grey in its last triangles
    page.select_option("#mode", label=CARRIED)
    tools.until(lambda: (quarter(tools.pixels(views.first)) >= 0).mean() < 0.12)
