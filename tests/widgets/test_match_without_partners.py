"""A match of wraps or of parts, in which vertices have no partner, shown on the meshes that were given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapes
from in_pieces import in_pieces
from known_match import known, without_partners

import qgeo_filters as qg
import qgeo_widgets as qw
from qgeo_filters import Surface
from qgeo_filters.report.colors import MISSING
from qgeo_widgets import compared_colors as names
from qgeo_widgets.offscreen import pane_picture


@pytest.fixture
def widget(pair_of_wraps):
    widget = qw.compare(pair_of_wraps.x, pair_of_wraps.y, p2p=pair_of_wraps.found)
    assert widget.message == ""
    yield widget
    widget.close()


def placed(p2p: np.ndarray, wrap: qg.Repair) -> np.ndarray:
    """Whether the image of each vertex has a place on the wrap."""
    return (p2p >= 0) & (wrap.vertex_of_original[p2p] >= 0)


def grey(colors: np.ndarray) -> np.ndarray:
    return np.isclose(colors, MISSING, atol=1e-6).all(axis=1)


def test_a_match_of_wraps_is_shown_on_the_meshes_that_were_given(widget, pair_of_wraps):
    case = pair_of_wraps
    one, other = widget._viewer.panes
    np.testing.assert_array_equal(one.surface.faces, case.x.faces)
    np.testing.assert_array_equal(other.surface.vertices, case.y.vertices)
    np.testing.assert_array_equal(widget.p2p, case.found.p2p)
    for pane in (one, other):
        np.testing.assert_array_equal(grey(pane.colors), case.inside)
    carried = case.found.transfer(one.colors)[~case.inside]
    np.testing.assert_allclose(other.colors[~case.inside], carried, atol=1e-6)
    for text in (widget._legend.value, widget._orientation.value):
        assert "vertices without a partner, 42 of 204 of X and 42 of 204 of Y" in text
    assert "in place of X" in widget._orientation.value
    widget.mode = names.REGIONS
    widget.mode = names.CHECKERBOARD
    for pane in (one, other):
        np.testing.assert_array_equal(np.isnan(pane.cells).all(axis=1), case.inside)
    before = pane_picture(widget._viewer, other, 80)
    widget.mode = names.CARRIED
    assert (pane_picture(widget._viewer, other, 80) != before).any()
    assert widget._viewer.panes[0].placement.scale == pytest.approx(1 / np.sqrt(case.wraps[0].surface.area))


def test_distances_on_wraps_are_carried_to_the_given_vertices(widget, pair_of_wraps):
    case = pair_of_wraps
    widget._clicked(0, 7)
    assert widget.mode == names.DISTANCE
    for values, wrap in zip(widget._field.values, case.wraps, strict=True):
        rows = qg.distances(wrap.surface, [wrap.vertex_of_original[7]], qg.lifted_metric(wrap.surface))
        np.testing.assert_array_equal(values, wrap.map_back(rows[0]) / np.sqrt(wrap.surface.area))
        np.testing.assert_array_equal(np.isnan(values), case.inside)
    assert "no value" in widget._legend.value
    for pane, mesh in zip(widget._viewer.panes, (case.x, case.y), strict=True):
        np.testing.assert_array_equal(pane.marks["first"].point, mesh.vertices[7])
    widget._clicked(0, 120)
    assert widget.message == ""
    for pane, wrap in zip(widget._viewer.panes, case.wraps, strict=True):
        ends = wrap.surface.vertices[wrap.vertex_of_original[[7, 120]]]
        np.testing.assert_allclose(pane.lines["path"].points[[0, -1]], ends, atol=1e-12)


def test_a_vertex_deep_inside_can_be_picked_and_has_no_partner_and_no_distances(widget, pair_of_wraps):
    inner = int(np.flatnonzero(pair_of_wraps.inside)[0])
    widget._clicked(0, inner)
    assert widget.pairs == [(inner, -1)]
    assert list(widget._viewer.panes[0].marks) == ["first"]
    assert list(widget._viewer.panes[1].marks) == []
    assert "no partner" in widget._info.value
    assert f"vertex {inner} of X has no place on what is measured" in widget.message
    assert widget.mode == names.CARRIED
    widget.use_as_landmark()
    assert widget.message == f"Vertex {inner} of X has no partner: click where it belongs, too."
    assert widget.landmarks == []


def test_matched_again_the_wraps_are_matched(widget, pair_of_wraps, monkeypatch):
    """With landmarks of the given vertices, by `match` with the wraps."""
    case, marks, results = pair_of_wraps, [(3, 3), (90, 90), (140, 140)], []

    def noted(x, y, **options):
        for shape, wrap in zip((x, y), case.wraps, strict=True):
            np.testing.assert_array_equal(shape.given.vertices, wrap.given.vertices)
            np.testing.assert_array_equal(shape.full.vertices, wrap.surface.vertices)
        assert np.array(options["landmarks"]).tolist() == [list(pair) for pair in marks]
        results.append(qg.match(x, y, **options))
        return results[-1]

    monkeypatch.setattr("qgeo_filters.filters.stages.match", noted)
    widget.landmarks = marks
    widget.match_again()
    assert widget.message == ""
    (found,) = results
    np.testing.assert_array_equal(widget.p2p, found.p2p)
    np.testing.assert_array_equal(widget._map.backward, found.inverse)
    np.testing.assert_array_equal(widget.p2p < 0, case.inside)
    assert np.linalg.norm(case.y.vertices[widget.p2p] - case.y.vertices, axis=1)[~case.inside].mean() < 0.2
    widget.mode = names.DISTORTION
    np.testing.assert_array_equal(widget._field.values[0], found.distortion)
    widget.mode = names.REGIONS
    np.testing.assert_array_equal(widget._field.labels[1], found.regions_y)
    assert "no partner" in widget._legend.value


def test_a_collection_of_wraps_shows_the_meshes_that_were_given(pair_of_wraps):
    case = pair_of_wraps
    places = case.found.inverse_barycentric
    widget = qw.collection({"x": case.wraps[0], "y": case.y}, {"y": places})
    assert widget.message == ""
    for pane, mesh in zip(widget._viewer.panes, (case.x, case.y), strict=True):
        np.testing.assert_array_equal(pane.surface.vertices, mesh.vertices)
        np.testing.assert_array_equal(pane.surface.faces, mesh.faces)
    widget.picked = 7
    widget.mode = "distance from the picked point"
    wrap = case.wraps[0]
    row = qg.distances(wrap.surface, [wrap.vertex_of_original[7]], qg.lifted_metric(wrap.surface))[0]
    expected = wrap.map_back(row) / np.sqrt(wrap.surface.area)
    np.testing.assert_array_equal(widget._field.values[0], expected)
    np.testing.assert_array_equal(widget._field.values[1], places.pulled_back(expected))
    widget.picked = case.x.n_vertices - 1
    assert "of x has no place on what is measured" in widget.message
    widget.close()


def test_what_no_repair_mends_is_refused_with_the_advice_that_helps():
    meshes = [in_pieces(shapes.creature(level=2), seed) for seed in (0, 1)]
    refused = qw.compare(*meshes, progress=False)
    assert "repair='wrap' for a closed surface around all of it" in refused.message
    refused.close()
    alone = np.full(len(meshes[1][0]), 3)
    truth = np.where(np.arange(len(meshes[0][0])) < 9, 4, -1)
    shown = qw.compare(*meshes, p2p=np.zeros(len(meshes[0][0]), dtype=int) + alone[0], truth=truth, repair="wrap")
    assert shown.message == ""
    shown.mode = names.ERROR
    assert np.isfinite(shown._field.values[0]).sum() == 9
    assert f"of 9 of {len(truth)} vertices" in shown._legend.value
    shown.close()


def test_two_raw_skulls_of_ct_with_their_landmarks(data_dir):
    """In a hundred pieces each, and walls with two sides: some of the vertices lie deep inside."""
    folder = data_dir / "harder" / "mouse_skulls_raw"
    if not folder.is_dir():
        pytest.skip("the raw skulls are not there")
    meshes = [Surface.read(folder / f"{name}.off") for name in ("CBA_J", "I")]
    marks = [np.loadtxt(folder / "corres" / f"{name}.vts", dtype=int) - 1 for name in ("CBA_J", "I")]
    known_marks = (marks[0] >= 0) & (marks[1] >= 0)
    p2p = np.full(meshes[0].n_vertices, -1)
    p2p[marks[0][known_marks]] = marks[1][known_marks]
    wraps = [qg.wrap_surface(mesh, alpha=0.06) for mesh in meshes]
    widget = qw.compare(*wraps, p2p=p2p, truth=p2p)
    assert widget.message == ""
    for pane, mesh, wrap in zip(widget._viewer.panes, meshes, wraps, strict=True):
        np.testing.assert_array_equal(pane.surface.faces, mesh.faces)
        assert 0.02 < (wrap.vertex_of_original < 0).mean() < 0.3
    widget.mode = names.ERROR
    errors = widget._field.values[0]
    np.testing.assert_array_equal(np.isfinite(errors), placed(p2p, wraps[1]))
    assert np.nanmax(errors) == 0
    widget._clicked(0, int(marks[0][known_marks][0]))
    assert (widget.message, widget.mode) == ("", names.DISTANCE)
    for values, wrap in zip(widget._field.values, wraps, strict=True):
        np.testing.assert_array_equal(np.isnan(values), wrap.vertex_of_original < 0)
    widget.close()


def test_a_match_of_a_part_is_shown_as_it_is(pair):
    x, y, where = pair
    part = x.vertices[:, 0] > 0
    found = known(x, y, y.vertices[where], p2p=where, inverse=np.argsort(where))
    found = without_partners(found, part, part[np.argsort(where)])
    found = replace(found, overlap_x=0.5, overlap_y=0.125)
    widget = qw.compare(x, y, p2p=found, truth=where)
    one, other = (pane.placement.scale for pane in widget._viewer.panes)
    assert other * np.sqrt(y.area) == pytest.approx(2 * one * np.sqrt(x.area))  # what is matched is as large on both
    assert widget.message == ""
    on_x, on_y = (pane.colors for pane in widget._viewer.panes)
    np.testing.assert_array_equal(grey(on_x), part)
    np.testing.assert_array_equal(grey(on_y)[where], part)
    assert f"{part.sum()} of 162 of X and {part.sum()} of 162 of Y" in widget._orientation.value
    widget.mode = names.ERROR
    np.testing.assert_array_equal(np.isnan(widget._field.values[0]), part)
    assert np.nanmax(widget._field.values[0]) == 0
    lone = int(np.flatnonzero(part)[0])
    widget._clicked(0, lone)
    assert (widget.message, widget.pairs, widget.mode) == ("", [(lone, -1)], names.DISTANCE)
    assert np.isfinite(widget._field.values[0]).all()
    assert np.isnan(widget._field.values[1]).all()
    assert f"from vertex {lone} of X, which has no partner, /" in widget._legend.value
    assert "not known" in widget._info.value
    widget._clicked(0, int(np.flatnonzero(~part)[0]))
    assert widget.message == ""
    assert list(widget._viewer.panes[0].lines) == ["path"]
    assert list(widget._viewer.panes[1].lines) == []
    widget.painted = [lone, int(np.flatnonzero(~part)[3])]
    on_x, on_y = widget._field.labels
    assert (on_x == 0).sum() == 2
    assert (on_y == 0).sum() == 1
    widget.close()
