"""Snapshots show what the camera shows: the same places, the same sizes, and all that stands around."""

from __future__ import annotations

import base64
import io
from xml.etree import ElementTree

import matplotlib.image
import numpy as np
import pytest
import shapes

import qgeo_widgets as qw
from qgeo_filters import Surface
from qgeo_filters.errors import ParameterError
from qgeo_widgets.fields import ScalarField, region_field
from qgeo_widgets.legend import css
from qgeo_widgets.offscreen import pane_picture
from qgeo_widgets.rendering.camera_view import CameraView
from qgeo_widgets.rendering.viewer import FIELD_OF_VIEW

GREEN = (0.1, 1.0, 0.1)


def size_of(png: bytes) -> tuple[int, int]:
    height, width = matplotlib.image.imread(io.BytesIO(png), format="png").shape[:2]
    return width, height


@pytest.mark.parametrize(
    ("camera", "target"),
    [((0.0, 0.0, 5.0), (0.0, 0.0, 0.0)), ((0.0, 0.0, 2.5), (0.1, 0.2, 0.0)), ((2.0, 1.5, 2.5), (-0.2, 0.1, 0.3))],
)
def test_a_mark_is_where_the_camera_shows_it_and_as_large(pair, camera, target):
    widget = qw.compare(pair[0], pair[1], p2p=pair[2])
    widget._viewer.target = target
    widget.camera = camera
    toward = np.subtract(camera, target)
    distance = np.linalg.norm(toward)
    toward = toward / distance
    right = np.cross([0, 1, 0], toward) / np.linalg.norm(np.cross([0, 1, 0], toward))
    up = np.cross(toward, right)
    for pane in widget._viewer.panes:
        place = np.array(target) + 0.7 * toward + 0.12 * right - 0.2 * up  # in front of the shape, aside
        pane.set_colors(np.full((pane.surface.n_vertices, 3), 0.8))
        pane.set_mark("probe", pane.placement.to_surface(place), GREEN)
        picture = pane_picture(widget._viewer, pane, 440, 400).astype(float)
        rows, columns = np.nonzero((picture[..., 1] > 60) & (picture[..., 1] > 3 * picture[..., [0, 2]].max(axis=2)))
        pixels = 200 / np.tan(np.radians(FIELD_OF_VIEW / 2)) / (distance - 0.7)
        np.testing.assert_allclose(
            [columns.mean(), rows.mean()], [219.5 + 0.12 * pixels, 199.5 + 0.2 * pixels], atol=1.5
        )
        radius = widget._viewer.mark_radius * pixels
        assert np.sqrt(len(rows) / np.pi) == pytest.approx(radius, abs=0.7)
    widget.close()


def test_the_map_to_a_parallel_projection_keeps_lines_and_depth():
    view = CameraView(np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.0, -0.2]), 0.3, 1.5)
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (200, 3))
    flat, seen = view.flattened(points)
    assert seen.all()
    gaps = np.linalg.norm(view.position - view.target) - (points - view.target) @ view.axes[2]
    np.testing.assert_array_equal(np.argsort(flat[:, 2]), np.argsort(-gaps))
    middle, _ = view.flattened(0.5 * (points[:100] + points[100:]))
    along, to_middle = flat[100:] - flat[:100], middle - flat[:100]
    np.testing.assert_allclose(np.cross(along, to_middle), 0, atol=1e-12)
    behind, seen = view.flattened([view.position + 0.1 * view.axes[2]])
    assert not seen.any()
    np.testing.assert_array_equal(behind, 0)


def test_dpi_is_that_of_the_screen_times_and_checked(pair):
    widget = qw.compare(pair[0], pair[1], p2p=pair[2])
    small, large = (size_of(widget.snapshot(dpi=dpi)) for dpi in (96, 192))
    np.testing.assert_allclose(large, 2 * np.array(small), atol=2)
    assert small[0] >= 880
    for bad in (0, 5000, 96.5):
        with pytest.raises(ParameterError, match="dpi"):
            widget.snapshot(dpi=bad)
    widget.close()


def test_a_camera_within_the_shape_gives_a_picture(pair):
    widget = qw.compare(pair[0], pair[1], p2p=pair[2])
    widget._viewer.target = (0.0, 0.0, 9.0)  # it looks away
    widget.camera = (0.0, 0.0, 8.0)
    assert np.ptp(pane_picture(widget._viewer, widget._viewer.panes[0]), axis=(0, 1)).max() == 0
    widget.close()


def test_the_chart_is_in_the_picture():
    widget = qw.geodesics(Surface(*shapes.blob(2, seed=3)))
    width, height = size_of(widget.snapshot(dpi=96))
    widget.source, widget.target = 5, 100
    png = widget.snapshot(dpi=96)
    assert size_of(png) == (width, pytest.approx(height + 2.1 * 96, abs=2))
    picture = matplotlib.image.imread(io.BytesIO(png), format="png")[-200:, :, :3]
    violet = (np.abs(picture - np.array([0x7B, 0x3F, 0xB5]) / 255) < 0.03).all(axis=2)
    assert violet.any(axis=1).sum() > 100  # the cursor
    widget.close()


SVG = "{http://www.w3.org/2000/svg}"
HREF = "{http://www.w3.org/1999/xlink}href"


def test_an_svg_has_the_shapes_as_pixels_and_all_else_as_text_and_lines(pair, tmp_path):
    widget = qw.compare(pair[0], pair[1], p2p=pair[2])
    widget.mode = "attribute: height"
    path = tmp_path / "picture.svg"
    data = widget.snapshot(path, dpi=96)
    assert path.read_bytes() == data == widget.snapshot(form="svg", dpi=96)  # neither time nor chance are in it
    root = ElementTree.fromstring(data)
    pictures = [base64.b64decode(image.get(HREF).partition("base64,")[2]) for image in root.iter(f"{SVG}image")]
    shapes_only = [size_of(picture) for picture in pictures if min(size_of(picture)) > 50]
    assert len(shapes_only) == 2
    for picture, pane in zip(pictures, widget._viewer.panes, strict=False):
        drawn = matplotlib.image.imread(io.BytesIO(picture), format="png")[..., :3]
        expected = pane_picture(widget._viewer, pane, *widget._viewer.size) / 255
        assert drawn.shape == expected.shape
        assert min(np.abs(drawn - expected).mean(), np.abs(drawn[::-1] - expected).mean()) < 1 / 255
    texts = {"".join(text.itertext()).strip() for text in root.iter(f"{SVG}text")}
    assert {"X", "Y", "height"} <= texts
    low, high = (float(f(pair[0].attributes["height"])) for f in (np.min, np.max))
    ticks = [float(text.replace("−", "-")) for text in texts - {"X", "Y", "height"}]
    assert len(ticks) >= 3
    assert all(low <= tick <= high for tick in ticks)
    widget.close()


def test_a_form_that_is_none_is_named(pair, tmp_path):
    widget = qw.compare(pair[0], pair[1], p2p=pair[2])
    with pytest.raises(ParameterError, match="form must be one of png, svg, got 'gif'"):
        widget.snapshot(form="gif")
    assert widget.snapshot(tmp_path / "a.png").startswith(b"\x89PNG")
    widget.close()


def test_the_legend_that_browsers_save_says_what_the_one_on_screen_says(pair):
    values = np.linspace(-1.0, 3.0, 162)
    values[7] = np.nan
    fields = [
        ScalarField([values], "a < b & c", signed=False),
        region_field([np.arange(30) % 12], "regions of one colour belong together"),
    ]
    for field in fields:
        root = ElementTree.fromstring(field.drawing(None))
        words = " ".join(text.text for text in root.iter(f"{SVG}text"))
        html = ElementTree.fromstring(field.legend(None).replace("&ensp;", " ").replace("<br>", ""))
        assert sorted(words.split()) == sorted(" ".join(html.itertext()).split())
        width, height = float(root.get("width")), float(root.get("height"))
        for text in root.iter(f"{SVG}text"):
            assert 0 < float(text.get("x")) < width
            assert 0 < float(text.get("y")) < height
    stops = [stop.get("stop-color") for stop in ElementTree.fromstring(fields[0].drawing(None)).iter(f"{SVG}stop")]
    assert [stops[0], stops[-1]] == [css(color) for color in fields[0].scale(None)(np.array([-1.0, 3.0]))]
    swatches = [box.get("fill") for box in ElementTree.fromstring(fields[1].drawing(None)).iter(f"{SVG}rect")]
    assert swatches == [css(color) for color, _ in fields[1].key]
