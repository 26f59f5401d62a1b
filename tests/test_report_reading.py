"""What makes a report readable: meanings beside numbers, labels apart, mirror colours, the worst places, paper."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.transforms import Bbox
from shapes import icosphere

from qgeo_filters.report.curves import plot_pairwise
from qgeo_filters.report.figures import plot_attribute, plot_scalar
from qgeo_filters.report.glossary import meaning
from qgeo_filters.report.html import Meaning, Table, report_page
from qgeo_filters.report.maps import plot_sides, plot_symmetry
from qgeo_filters.report.view import best_view
from qgeo_filters.report.worst_places import plot_worst_places, worst_places
from qgeo_filters.surface import Surface


@pytest.fixture(scope="module")
def sphere() -> Surface:
    vertices, faces = icosphere(3)
    return Surface(vertices * [2.0, 1.0, 0.7], faces)


def overlaps(labels: list[Bbox]) -> int:
    return sum(Bbox.intersection(a, b) is not None for k, a in enumerate(labels) for b in labels[:k])


@pytest.mark.parametrize(
    ("low", "high"), [(0.0, 0.0123), (1.0, 9.0), (-120345.0, 98765.0), (0.00012, 0.00034), (1e7, 1.1e7), (0, 3e-9)]
)
def test_numbers_along_a_color_bar_stand_apart(sphere: Surface, low: float, high: float) -> None:
    figure = plot_scalar(sphere, np.linspace(low, high, sphere.n_vertices), "length (mesh units)")
    figure.draw_without_rendering()
    bar = figure.axes[-1]
    shown = [label.get_window_extent() for label in bar.get_xticklabels() if label.get_text()]
    inside = [box for box in shown if figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1]
    assert len(inside) >= 2
    assert overlaps([box.expanded(1.05, 1.0) for box in inside]) == 0


@pytest.mark.parametrize("count", [2, 12, 13, 40, 150])
def test_names_of_a_table_stand_apart(count: int) -> None:
    names = [f"a rather long name of a shape {k}" for k in range(count)]
    figure = plot_pairwise(np.zeros((count, count)), names, "C_XY (no unit)")
    figure.draw_without_rendering()
    axes = figure.axes[0]
    rows = [label.get_window_extent() for label in axes.get_yticklabels()]
    assert overlaps(rows) == 0
    for label in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        assert label.get_fontsize() >= 5
        assert len(label.get_text()) <= 24
    columns = axes.get_xticklabels()
    ticks = axes.transData.transform([(label.get_position()[0], 0) for label in columns])[:, 0]
    height = columns[0].get_fontsize() / 72 * figure.dpi
    slant = np.sin(np.radians(columns[0].get_rotation()))  # lines of text that lie across are nearer to each other
    assert len(ticks) == 1 or np.diff(ticks).min() * slant >= height


def test_what_a_number_means_stands_beside_it() -> None:
    table = Table.explained("Results", {"score": 0.5, "of_others": 3})
    assert table.rows[0] == ("score", 0.5, Meaning(meaning("score")))
    page = report_page("", tables=[table])
    assert f'<td class="number">0.5</td><td class="meaning">{meaning("score")}</td>' in page
    assert 'class="table wide explained"' in page
    assert Table.explained("Results", {"of_others": 3}).rows == [("of_others", 3)]  # no empty column
    assert meaning("confident") != meaning("confident", "evaluate") != ""
    assert meaning("percent_within_0.05") == "vertices within 0.05 sqrt(area) of their true image, per cent"
    assert meaning("of_others") == ""


@pytest.mark.slow
def test_mirror_images_are_drawn_in_mirror_colors(sphere: Surface) -> None:
    images = np.array([np.linalg.norm(sphere.vertices - v * [-1, 1, 1], axis=1).argmin() for v in sphere.vertices])
    view = best_view(sphere.vertices, sphere.faces)
    pictures = [
        figure.axes[0].images[0].get_array()
        for figure in (
            plot_attribute(sphere, "qgeo_symmetry", images, view=view, images=True),
            plot_symmetry(sphere, p2p=images, title="qgeo_symmetry", view=view),
            plot_attribute(sphere, "qgeo_symmetry", images, view=view),
        )
    ]
    np.testing.assert_array_equal(pictures[0], pictures[1])
    assert pictures[2].shape != pictures[0].shape or np.abs(pictures[2].astype(int) - pictures[0]).max() > 50


def test_the_two_sides_have_the_colors_of_sides(sphere: Surface) -> None:
    side = np.sign(np.round(sphere.vertices[:, 0], 1)).astype(np.int32)
    view = best_view(sphere.vertices, sphere.faces)
    found = plot_attribute(sphere, "qgeo_side", side, view=view).axes[0].images[0].get_array().reshape(-1, 3)
    wanted = plot_sides(sphere, side, view=view).axes[0].images[0].get_array().reshape(-1, 3)
    for weights in ([1, 0, -1], [-1, 0, 1], [2, -1, -1]):  # reddest, bluest ...
        np.testing.assert_allclose(found[(found @ weights).argmax()], wanted[(wanted @ weights).argmax()], atol=12)


def test_the_worst_places_are_far_from_each_other(sphere: Surface) -> None:
    poles = [int((sphere.vertices @ axis).argmax()) for axis in ([1, 0, 0], [0, 1, 0], [-1, 0, 0])]
    values = np.zeros(sphere.n_vertices)
    for pole, height in zip(poles, (3.0, 2.0, 1.0), strict=True):
        values += height * np.exp(-20 * np.linalg.norm(sphere.vertices - sphere.vertices[pole], axis=1) ** 2)
    assert worst_places(sphere, values).tolist() == poles
    values[poles[0]] = np.nan
    assert worst_places(sphere, values, 2)[0] != poles[0]
    assert worst_places(sphere, np.full(sphere.n_vertices, np.nan)).tolist() == []
    gaps = worst_places(sphere, np.random.default_rng(0).random(sphere.n_vertices), 1000)
    apart = np.linalg.norm(sphere.vertices[gaps][:, None] - sphere.vertices[gaps], axis=2)[
        np.triu_indices(len(gaps), 1)
    ]
    assert apart.min() >= 0.2 * np.sqrt(sphere.area)
    with pytest.raises(ValueError, match=r"values have shape \(3,\), but there are 642 vertices"):
        worst_places(sphere, [1.0, 2.0, 3.0])


@pytest.mark.slow
def test_a_place_that_the_surface_hides_is_marked_before_it(sphere: Surface) -> None:
    """The inner of two shells, as a mouth in a head: no view from outside sees it, and its mark is seen."""
    inner = len(sphere.vertices)
    both = Surface(
        np.concatenate([sphere.vertices, 0.5 * sphere.vertices]), np.concatenate([sphere.faces, sphere.faces + inner])
    )
    place = inner + int(sphere.vertices[:, 1].argmax())
    figure = plot_worst_places(both, both, np.arange(2 * inner), np.ones(2 * inner), [place, place - inner])
    panels = [axes for axes in figure.axes if axes.images]
    assert [axes.get_title() for axes in panels] == [
        f"X, vertex {place}: 1, hidden", f"X, vertex {place - inner}: 1",
        f"Y, vertex {place}, hidden", f"Y, vertex {place - inner}",
    ]  # fmt: skip
    for axes in panels:
        red = np.asarray(axes.images[0].get_array()).astype(int) @ [2, -1, -1] > 180
        assert red.any()
        assert abs(np.nonzero(red)[0].mean() / len(red) - 0.5) < 0.06


@pytest.mark.slow
def test_the_picture_shows_each_place_and_its_image_in_the_middle(sphere: Surface) -> None:
    places = np.array([int((sphere.vertices @ axis).argmax()) for axis in ([1, 0, 0], [0, 0, -1], [0, 1, 0])])
    same = np.arange(sphere.n_vertices)
    figure = plot_worst_places(sphere, sphere, same, np.ones(len(same)), places)
    panels = [axes for axes in figure.axes if axes.images]
    assert len(panels) == 6
    assert [axes.get_title() for axes in panels[:3]] == [f"X, vertex {place}: 1" for place in places]
    for axes in panels:
        red = np.asarray(axes.images[0].get_array()).astype(int) @ [2, -1, -1] > 180
        rows, columns = np.nonzero(red)
        height, width = red.shape
        assert rows.size
        assert abs(rows.mean() / height - 0.5) < 0.06
        assert abs(columns.mean() / width - 0.5) < 0.06
    lost = same.copy()
    lost[places[1]] = -1
    titles = [axes.get_title() for axes in plot_worst_places(sphere, sphere, lost, np.ones(642), places).axes]
    assert titles[4] == "no partner"


def test_pages_are_made_for_the_night_and_for_paper() -> None:
    page = report_page("")
    for rule in ("(prefers-color-scheme: dark)", "@media print", "break-inside: avoid"):
        assert rule in page
    assert "filter:" not in page  # pictures keep the colours of their legends: test_browser_report looks
