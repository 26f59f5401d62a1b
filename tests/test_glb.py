"""A map as a scene: what has no partner is grey, landmarks are balls on both shapes; and pictures that cope with it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from known_match import PLACE, TURN, ellipsoids, without_partners

from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.report.colors import MISSING
from qgeo_filters.report.curves import plot_histogram
from qgeo_filters.report.glb import map_colors, write_match_glb
from qgeo_filters.report.maps import plot_correspondence, view_alike
from qgeo_filters.report.view import best_view


def part() -> MatchResult:
    """Ellipsoids whose lower halves have no partner."""
    found = ellipsoids()
    lower_y = ((found.y.vertices - PLACE) @ TURN.T)[:, 2] < -0.1
    return without_partners(found, found.x.vertices[:, 2] < -0.05, lower_y)


def test_what_has_no_partner_is_grey_and_landmarks_are_balls(tmp_path: Path) -> None:
    found = part()
    view = best_view(found.y.vertices, found.y.faces)
    on_x, on_y = map_colors(found, view)
    for colors, images in ((on_x, found.p2p), (on_y, found.inverse)):
        grey = (colors == MISSING).all(axis=1)
        np.testing.assert_array_equal(grey, images < 0)
        assert ((colors >= 0) & (colors <= 1)).all()
    high, low = int(found.x.vertices[:, 2].argmax()), int(found.x.vertices[:, 2].argmin())
    write_match_glb(tmp_path / "a.glb", found, landmarks=Landmarks(["high", "low"], vertices=[high, low]))
    scene = trimesh.load(tmp_path / "a.glb", process=False)
    assert set(scene.geometry) == {"X mesh", "Y mesh", "X high", "X low", "Y high"}  # low has no image
    ball = scene.geometry["Y high"].vertices.mean(axis=0)
    np.testing.assert_allclose(ball, found.landmarks([high]).points[0], atol=1e-4)
    np.testing.assert_array_equal(scene.geometry["X mesh"].faces, found.x.faces)


def test_pictures_of_a_map_without_some_partners() -> None:
    found = part()
    view = best_view(found.x.vertices, found.x.faces)
    assert view_alike(found.x, view, found.y, found.p2p).axes.shape == (3, 3)
    assert plot_correspondence(found.x, found.y, found.p2p).axes
    values = np.where(found.p2p < 0, np.nan, found.distortion)
    axes = plot_histogram(values, found.x.vertex_areas, "distortion").axes[0]
    heights = sum(bar.get_height() for bar in axes.patches)
    np.testing.assert_allclose(heights, 100.0)  # per cent of what is known
