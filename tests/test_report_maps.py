"""Figures of maps (sides, regions, poses, views from the same side) and charts of errors."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from shapes import icosphere

from qgeo_filters.errors import ParameterError
from qgeo_filters.evaluation import BENCHMARKS
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.report.curves import plot_error_curve, plot_histogram, plot_pairwise
from qgeo_filters.report.maps import plot_poses, plot_region_pair, plot_sides, view_alike
from qgeo_filters.report.match_log import plot_match_log
from qgeo_filters.report.view import best_view, view_from
from qgeo_filters.surface import Surface


@pytest.fixture(scope="module")
def sphere() -> Surface:
    """162 vertices, stretched so that there is a broadside."""
    vertices, faces = icosphere(2)
    return Surface(vertices * [2.0, 1.0, 0.7], faces)


def test_the_same_side_is_shown_of_a_turned_copy(sphere: Surface) -> None:
    view = best_view(sphere.vertices, sphere.faces)
    turn = np.diag([-1.0, 1.0, -1.0])  # half a turn about the upright axis
    turned = Surface(sphere.vertices @ turn, sphere.faces)
    other = view_alike(sphere, view, turned, np.arange(162))
    seen, seen_of_copy = sphere.vertex_normals @ view.axes[2] > 0, turned.vertex_normals @ other.axes[2] > 0
    assert (seen == seen_of_copy).mean() > 0.95


@pytest.mark.slow
def test_sides_show_two_colours_and_the_axis(sphere: Surface) -> None:
    side = np.sign(np.round(sphere.vertices[:, 0], 1)).astype(np.int8)
    assert (side == 0).any()
    picture = plot_sides(sphere, side).axes[0].images[0].get_array().reshape(-1, 3).astype(int)
    red, green, blue = picture.T
    assert (blue > red + 20).sum() > 500
    assert (red > blue + 40).sum() > 500
    assert ((red > green + 80) & (red > blue + 60)).sum() > 50
    with pytest.raises(ValueError, match="-1, 0 or 1 for each of the 162"):
        plot_sides(sphere, side * 2)


def test_regions_of_equal_number_have_equal_colours(sphere: Surface) -> None:
    regions = (sphere.vertices[:, 0] > 0).astype(np.int32)
    view = best_view(sphere.vertices, sphere.faces)
    figure = plot_region_pair(sphere, sphere, regions, regions, views=(view, view))
    first, second = (axes.images[0].get_array() for axes in figure.axes)
    np.testing.assert_array_equal(first, second)


def test_one_camera_and_one_scale_for_all_poses(sphere: Surface) -> None:
    """In the picture a length is as long in each pose, whatever their places; only the area sets the scale."""
    same, view = [np.arange(162)] * 3, view_from(0)
    bent = sphere.with_vertices(sphere.vertices * [0.5, 1.5, 1.0])
    poses = [sphere, sphere.with_vertices(10 * sphere.vertices + 50), bent]
    for given in (view, None):
        first, larger, other = (
            np.asarray(axes.images[0].get_array()) for axes in plot_poses(poses, same, view=given).axes
        )
        np.testing.assert_allclose(first.astype(int), larger, atol=2)
        camera = given or best_view(sphere.vertices, sphere.faces)
        drawn = [(picture < 250).any(axis=2) for picture in (first, other)]
        for axis in (0, 1):  # pixels across and up
            pixels = [np.ptp(np.flatnonzero(mask.any(axis=axis))) for mask in drawn]
            lengths = [np.ptp(pose.vertices @ camera.axes[axis]) / np.sqrt(pose.area) for pose in (sphere, bent)]
            assert pixels[1] / pixels[0] == pytest.approx(lengths[1] / lengths[0], rel=0.03)
    with pytest.raises(ValueError, match="there are no poses"):
        plot_poses([], [])


@pytest.mark.slow
def test_poses_in_one_colouring(sphere: Surface) -> None:
    order = np.random.default_rng(0).permutation(162)
    image = np.argsort(order)
    shuffled = Surface(sphere.vertices[order], image[sphere.faces])
    first, second = (
        axes.images[0].get_array() for axes in plot_poses([sphere, shuffled], [np.arange(162), image]).axes
    )
    assert np.abs(first.astype(int) - second).mean() < 1.0
    # From one place a turned shape looks turned.
    turned, same, view = sphere.with_vertices(sphere.vertices[:, [2, 1, 0]] * [1.5, 1, 1]), np.arange(162), view_from(0)
    wide = sphere.with_vertices(turned.vertices[:, [2, 1, 0]])
    one, other = (axes.images[0].get_array() for axes in plot_poses([wide, turned], [same, same], view=view).axes)
    assert np.abs(one.astype(int) - other).mean() > 5
    with pytest.raises(ValueError, match="one map for each of the 2 poses"):
        plot_poses([sphere, sphere], [np.arange(162)])


def test_histogram_is_of_the_area() -> None:
    axes = plot_histogram([0.0, 1.0], [3.0, 1.0], "distortion").axes[0]
    heights = [patch.get_height() for patch in axes.patches]
    assert (heights[0], heights[-1]) == (75.0, 25.0)
    assert axes.lines[0].get_xdata()[0] == 0.25  # the mean


def test_histogram_of_an_isometry() -> None:
    assert plot_histogram(np.zeros(5), np.ones(5), "distortion").axes[0].get_xlim()[1] > 0


def test_error_curve() -> None:
    line = plot_error_curve([0.0, 0.0, 0.1, 0.5]).axes[0].lines[0]
    shares = dict(zip(np.round(line.get_xdata(), 3).tolist(), line.get_ydata().tolist(), strict=True))
    assert (shares[0.0], shares[0.2]) == (50.0, 75.0)


def test_error_curve_beside_published_means() -> None:
    """A line at each mean, of one colour for what was trained on the set, and all of them named with their figures."""
    others = BENCHMARKS["smal_r"].published
    figure = plot_error_curve([0.0, 0.02], mean=0.01, published=others, largest=0.25)
    upright = [line for line in figure.axes[0].lines if len(set(line.get_xdata())) == 1]
    colors = {one.error: {str(line.get_color()) for line in upright if line.get_xdata()[0] == one.error / 100}
              for one in others}  # fmt: skip
    assert any(line.get_xdata()[0] == 0.01 for line in upright)
    assert all(len(found) == 1 for found in colors.values())
    trained = {one.error for one in others if one.learned}
    assert not set().union(*(colors[error] for error in trained)) & set().union(
        *(found for error, found in colors.items() if error not in trained)
    )
    named = " ".join(text.get_text().replace("\n", " ") for text in figure.legends[0].get_texts())
    assert [named.count(f"{one.error / 100:.3f}") for one in others] == [1] * len(others)
    assert "Smooth Shells 0.361 (beyond)" in named


def test_pairwise() -> None:
    axes = plot_pairwise([[0.0, 2.0], [2.0, 0.0]], ["a", "b"], "C_XY").axes[0]
    assert [text.get_text() for text in axes.texts] == ["0", "2", "2", "0"]
    with pytest.raises(ValueError, match="3 names"):
        plot_pairwise(np.eye(2), ["a", "b", "c"], "C_XY")


def test_the_log_of_a_match_has_a_row_for_each_map_with_its_fate() -> None:
    log = MatchLog()
    for k in range(30):
        log.propose(f"somebody {k}", 0.01 * (k + 1), orientation=0.9 if k % 3 else -0.9)
    for k in range(4):
        log.note(k, preview_cost=10.0**k)
    log.note(0, end_cost=2.0)
    log.note(1, end_cost=1.0)
    long = "a rule whose name is so long that it does not fit beside the picture in one line, as may happen"
    log.drop(7, long)
    log.drop(8, f"{long}, and {long}")
    log.choose(1)
    figure = plot_match_log(log, most=12)
    left, costs, right = figure.axes
    assert [label.get_text() for label in left.get_yticklabels()][:2] == ["#1", "#0"]
    fates = [text.get_text() for text in right.texts]
    assert len(fates) == 12
    assert fates[0] == "chosen"
    assert fates[1] == "costs more at the end than #1"
    words = plot_match_log(log, most=30).axes[2].texts
    assert sum(text.get_text().replace("\n", " ") == long for text in words) == 1
    assert sum(text.get_text().endswith("…") and text.get_text().count("\n") == 1 for text in words) == 1
    # Multiples of the least cost: of the preview, #0's, and of the end, the chosen one's.
    ratios = np.concatenate([points.get_offsets()[:, 0] for points in costs.collections])
    assert sorted(ratios) == pytest.approx([1, 1, 2, 10, 100, 1000])
    with pytest.raises(ParameterError, match="no maps"):
        plot_match_log(MatchLog())


def test_words_of_the_log_can_be_read_on_paper() -> None:
    """Each at 4.5 : 1 against white (WCAG 2, AA), whole, and apart from the next."""
    log = MatchLog()
    rule = "distorts distances by more than 0.094, times how unlike the surroundings of what it relates are"
    for k in range(12):
        log.propose(f"somebody {k}", 0.01 * (k + 1), orientation=0.9)
        log.note(k, **({"preview_cost": 1.0 + k} if k < 6 else {}), **({"end_cost": 2.0 + k} if k < 3 else {}))
        if k:
            log.drop(k, rule)
    log.choose(0)
    figure = plot_match_log(log)
    figure.draw_without_rendering()
    words = figure.axes[2].texts
    for text in words:
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(text.get_color())]
        assert 1.05 / (np.dot([0.2126, 0.7152, 0.0722], linear) + 0.05) >= 4.5
    boxes = [text.get_window_extent() for text in words]
    assert len({text.get_color() for text in words}) == 4
    assert all(box.x1 <= figure.bbox.x1 for box in boxes)
    assert not any(upper.overlaps(lower) for upper, lower in itertools.pairwise(boxes))
