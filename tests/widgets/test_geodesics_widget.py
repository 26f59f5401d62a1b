"""The widget of quasi-geodesics, driven through its traits."""

from __future__ import annotations

import re

import numpy as np
import pytest
import shapes

import qgeo_widgets as qw
from qgeo_filters import Surface, distances, lifted_metric
from qgeo_widgets import geodesics_widget as names
from qgeo_widgets.chart import HEIGHT, curvature_chart


@pytest.fixture(scope="module")
def surface() -> Surface:
    return Surface(*shapes.blob(3, seed=3))


@pytest.fixture
def widget(surface):
    widget = qw.geodesics(surface)
    assert widget.message == ""
    yield widget
    widget.close()


def test_two_clicks_give_a_path_between_their_vertices(widget, surface):
    assert "Click the source" in widget._info.value
    widget._clicked(0, 10)
    assert "Click the target" in widget._info.value
    widget._clicked(0, 600)
    pane = widget._viewer.panes[0]
    np.testing.assert_allclose(pane.lines["path"][0][[0, -1]], surface.vertices[[10, 600]], atol=1e-12)
    np.testing.assert_allclose(pane.lines["before"][0], widget.path_before.points)
    shortest = distances(surface, [10], lifted_metric(surface), method="exact")[0, 600]
    assert widget.path.length == pytest.approx(shortest, rel=1e-9)
    for path in (widget.path, widget.path_before):
        assert f"{path.length / np.sqrt(surface.area):.4f}" in widget._info.value
    widget._clicked(0, 20)
    assert (widget.source, widget.target) == (20, None)
    assert widget.path is None
    assert pane.lines == {}


def test_the_path_is_the_shortest_where_straightening_stays_on_the_wrong_side(surface):
    """Over bumps the way is locally shortest, and twice as long as around them."""
    bumps = np.sin(7 * surface.vertices[:, 0]) * np.sin(7 * surface.vertices[:, 1])
    widget = qw.geodesics(surface, 10, 419, scalar=bumps, curvature_weight=0.3)
    shortest = distances(surface, [10], lifted_metric(surface, bumps, 0.3), method="exact")[0, 419]
    assert widget.path.length == pytest.approx(shortest, rel=1e-9)
    assert widget.path_before.length > 1.5 * shortest
    assert widget.path.converged
    assert f"{100 * (widget.path_before.length / shortest - 1):.1f} %" in widget._info.value
    widget.close()


def test_before_straightening_can_be_hidden(widget):
    widget.source, widget.target = 10, 600
    widget.before = False
    assert set(widget._viewer.panes[0].lines) == {"path"}


def test_more_weight_leads_the_path_around_a_bump_of_the_scalar():
    vertices, faces = shapes.grid(24)
    bump = np.exp(-np.sum((vertices[:, :2] - [0.5, 0.52]) ** 2, axis=1) / 0.02)
    ends = [np.linalg.norm(vertices[:, :2] - place, axis=1).argmin() for place in ([0.0, 0.5], [1.0, 0.5])]
    widget = qw.geodesics((vertices, faces), *map(int, ends), scalar=bump, curvature_weight=0.0)
    lengths, climbs, nearest = [], [], []
    for weight in (0.0, 0.05, 0.3):
        widget.curvature_weight = weight
        path = widget.path
        assert path.converged
        values = np.einsum("pi,pi->p", bump[np.asarray(faces)[path.faces]], path.barycentric)
        lengths.append(np.linalg.norm(np.diff(path.points, axis=0), axis=1).sum())
        climbs.append(np.abs(np.diff(values)).sum())
        nearest.append(np.linalg.norm(path.points[:, :2] - [0.5, 0.52], axis=1).min())
    assert lengths[0] == pytest.approx(1.0)
    assert lengths[0] < lengths[1] < lengths[2]
    assert climbs[0] > climbs[1] > climbs[2]
    assert nearest[2] > 0.1
    widget.close()


def test_place_moves_the_point_along_the_path_and_the_line_on_the_chart(widget, surface):
    widget.source, widget.target = 10, 600
    for place, index in ((0.0, 0), (1.0, -1)):
        widget.place = place
        point = widget._viewer.panes[0].marks["place"][0]
        np.testing.assert_allclose(point, widget.path.points[index], atol=1e-12)
        x = f"{100 * place:.2f}%"
        assert f'<line x1="{x}" y1="10" x2="{x}"' in widget._chart.value


def test_chart_draws_every_curvature_in_its_place():
    svg = curvature_chart(np.array([0.5, 1.0]), np.array([0.2, -0.4]), 2.0, 1.5)
    circles = [tuple(map(float, c)) for c in re.findall(r'<circle cx="([\d.]+)%" cy="([\d.]+)"', svg)]
    middle = 10 + (HEIGHT - 50) / 2
    assert [c[0] for c in circles] == [25.0, 50.0]
    assert circles[1][1] - middle == pytest.approx(2 * (middle - circles[0][1]), abs=0.2)
    assert "nan" not in curvature_chart(np.array([0.5]), np.array([np.nan]), 1.0, 0.0)


def test_distance_follows_the_weight(widget, surface):
    widget.source = 10
    widget.mode = names.DISTANCE
    first = widget._field.values[0]
    widget.curvature_weight = 0.3
    assert (widget._field.values[0] >= first - 1e-9).all()
    assert widget._field.values[0].max() > 1.2 * first.max()


def test_the_old_name_of_the_weight_is_taken_with_a_warning(widget):
    with pytest.warns(DeprecationWarning, match="weight is now called curvature_weight"):
        widget.weight = 0.2
    assert widget.curvature_weight == 0.2
    with pytest.warns(DeprecationWarning, match="curvature_weight"):
        assert widget.weight == 0.2


def test_source_equal_to_target_and_bad_vertices(widget):
    widget.source, widget.target = 10, 10
    assert widget.message == ""
    assert widget.path.length == 0.0
    with pytest.raises(ValueError, match="target is vertex 9999"):
        widget.target = 9999


def test_two_pieces_have_no_path(surface):
    vertices = np.concatenate([surface.vertices, surface.vertices + 5.0])
    faces = np.concatenate([surface.faces, surface.faces + surface.n_vertices])
    widget = qw.geodesics((vertices, faces), 0, 700, scalar="gaussian_curvature")
    assert "piece" in widget.message
    assert widget._viewer.panes[0].lines == {}
    widget.target = 600
    assert widget.message == ""
    assert widget.path is not None
    widget.mode = names.DISTANCE
    widget.target = 700
    assert "piece" in widget.message  # the new colours do not take it away
    assert widget.path is None  # nor is the old path left
    assert widget._viewer.panes[0].lines == {}
    widget.close()


def test_distance_without_a_source_asks_for_one(widget):
    widget.mode = names.DISTANCE
    assert widget.hint.startswith("Click the source of a path")
    assert widget.message == ""
    widget.source = 10
    assert widget.hint == ""


def test_closing_frees_everything(surface, counted):
    widget = qw.geodesics(surface, 10, 600)
    widget.curvature_weight = 0.1
    assert counted() > 50
    widget.close()
    assert counted() == 0
