"""Snapshots show what the camera shows: the same places, the same sizes, and all that stands around."""

from __future__ import annotations

import io

import matplotlib.image
import numpy as np
import pytest
import shapes

import qgeo_widgets as qw
from qgeo_filters import Surface
from qgeo_filters.errors import ParameterError
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
