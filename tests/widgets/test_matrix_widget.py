"""The widget of the distance matrix, driven through its traits."""

from __future__ import annotations

import io
from itertools import pairwise

import matplotlib.image
import numpy as np
import pytest
import shapes
import traitlets

import qgeo_widgets as qw
from qgeo_filters import Surface, distance_matrix, distances, lifted_metric
from qgeo_widgets import matrix_widget as names


@pytest.fixture
def surface() -> Surface:
    return Surface(*shapes.blob(3, seed=3), {"height": np.arange(642.0)})


@pytest.fixture
def widget(surface):
    widget = qw.matrix(surface)
    assert widget.message == ""
    yield widget
    widget.close()


def hover(widget, row: int, column: int) -> None:
    """What the browser sends when the mouse is over an entry."""
    widget._pane.widget._handle_custom_msg({"kind": "hover", "row": row, "column": column}, [])


def test_picture_is_the_matrix_of_neighbours(widget, surface):
    vertices = widget._vertex_of_row
    assert len(set(vertices.tolist())) == 600
    D = distance_matrix(surface, lifted_metric(surface)) / np.sqrt(surface.area)
    np.testing.assert_allclose(widget._table, D[vertices], rtol=1e-5, atol=1e-6)
    # Rows beside each other are near each other: far nearer than rows in the mesh's order.
    beside = np.mean([D[a, b] for a, b in pairwise(vertices)])
    assert beside < 0.25 * D.mean()
    image = widget._pane.image
    assert image.shape == (600, 600, 3)
    np.testing.assert_array_equal(image, image.transpose(1, 0, 2))


def test_hover_shows_the_row_on_the_shape(widget, surface):
    hover(widget, 70, 30)
    assert widget.row == 70
    assert widget.picked == widget._vertex_of_row[70]
    assert widget.mode == names.DISTANCE
    expected = distances(surface, [widget.picked], lifted_metric(surface))[0] / np.sqrt(surface.area)
    np.testing.assert_allclose(widget._field.values[0], expected, rtol=1e-5, atol=1e-6)
    np.testing.assert_array_equal(widget._viewer.panes[0].marks["picked"][0], surface.vertices[widget.picked])
    assert f">{widget.picked}</td>" in widget._info.value


def test_distances_without_a_row_ask_for_one(widget):
    widget.mode = names.DISTANCE
    assert widget.hint.startswith("Move over the matrix or click on the shape")
    assert widget.message == ""
    hover(widget, 70, 30)
    assert widget.hint == ""


def test_a_vertex_without_a_row_has_its_own_distances(widget, surface):
    loose = next(v for v in range(surface.n_vertices) if v not in widget._row_of_vertex)
    widget.picked = loose
    expected = distances(surface, [loose], lifted_metric(surface))[0] / np.sqrt(surface.area)
    np.testing.assert_allclose(widget._field.values[0], expected)
    # The line stands at the nearest row, and the pick stays.
    assert widget.picked == loose
    assert expected[widget._vertex_of_row[widget.row]] == pytest.approx(expected[widget._vertex_of_row].min(), rel=1e-4)


def test_a_click_on_an_entry_marks_both_of_its_vertices(widget):
    widget._pane.widget._handle_custom_msg({"kind": "click", "row": 12, "column": 41}, [])
    i, j = widget._vertex_of_row[[12, 41]]
    assert f"d({i}, {j}) = {widget._table[12, j]:.4f}" in widget._info.value
    assert set(widget._viewer.panes[0].marks) == {"picked", "other"}
    widget._viewer.panes[0]._on_pick[0]((widget.picked + 40) % 100)  # a new pick takes the second mark away
    assert set(widget._viewer.panes[0].marks) == {"picked"}
    assert "entry" not in widget._info.value


def test_a_given_matrix_is_used_and_checked(surface):
    D = distance_matrix(surface)
    widget = qw.matrix(surface, matrix=D)
    widget.row = 5
    np.testing.assert_allclose(widget._field.values[0], D[widget.picked] / np.sqrt(surface.area), rtol=1e-6)
    widget.close()
    refused = qw.matrix(surface, matrix=D[:, :-1])
    assert "the matrix has shape (642, 641), but the mesh has 642 vertices" in refused.message
    refused.close()


def test_rows_out_of_range_are_refused(widget):
    with pytest.raises(traitlets.TraitError, match="row must be -1 or one of the 600 rows"):
        widget.row = 600
    with pytest.raises(traitlets.TraitError, match="picked must be one of 642 vertices"):
        widget.picked = 642


def test_a_mesh_in_pieces_shows_the_other_piece_grey(surface):
    vertices = np.concatenate([surface.vertices, surface.vertices + 5.0])
    faces = np.concatenate([surface.faces, surface.faces + surface.n_vertices])
    widget = qw.matrix((vertices, faces), curvature_weight=0.0)
    assert widget.message == ""
    widget.row = 0
    assert "no value" in widget._legend.value
    widget.close()


def test_a_mesh_that_is_no_surface_is_a_sentence():
    widget = qw.matrix(shapes.fan(), repair=False)
    assert "needs a manifold mesh, but edge (0, 1) has 3 faces" in widget.message
    widget.close()


def test_closing_frees_everything(surface, counted):
    widget = qw.matrix(surface)
    widget.row = 3
    assert counted() > 50
    widget.close()
    assert counted() == 0


def test_matrix_and_shape_show_one_distance_in_one_color(widget):
    for row in (3, 40):
        widget.row = row
        for limits in (None, (0.1, 0.7)):
            widget.limits = limits
            on_shape = widget._viewer.panes[0].colors[widget._vertex_of_row]
            np.testing.assert_allclose(widget._pane.image[row] / 255, on_shape, atol=0.5 / 255 + 1e-6)
    widget.mode = names.ORDER
    assert widget.limits is None


def test_a_snapshot_has_the_matrix_beside_the_shape(widget):
    widget.row = 3
    picture = matplotlib.image.imread(io.BytesIO(widget.snapshot(dpi=96)), format="png")
    width = widget._pane.size
    assert picture.shape[1] > 2 * width
    red = (np.abs(picture[..., :3] - np.array([255, 45, 85]) / 255) < 0.15).all(axis=2)
    assert red.any(axis=0).sum() > 0.95 * width
