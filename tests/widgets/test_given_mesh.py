"""Widgets show the mesh that was given, where its repair or the closed surface around it is measured and matched."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import shapes

import qgeo_filters as qg
import qgeo_widgets as qw
from qgeo_filters import Surface
from qgeo_filters.report.colors import MISSING
from qgeo_widgets import compared_colors as names
from qgeo_widgets import symmetry_widget
from qgeo_widgets.contours import sign_changes


@pytest.fixture(scope="module")
def box() -> Surface:
    """A box in two pieces that are not welded along their seam, with an attribute."""
    ball, faces = shapes.icosphere(2)
    vertices = ball / np.abs(ball).max(axis=1, keepdims=True) * [1.4, 1.0, 0.8]
    left = vertices[faces][:, :, 0].mean(axis=1) < vertices[:, 0].mean()
    parts = [np.unique(faces[side], return_inverse=True) for side in (left, ~left)]
    used = np.concatenate([parts[0][0], parts[1][0]])
    joined = np.concatenate([parts[0][1].reshape(-1, 3), parts[1][1].reshape(-1, 3) + len(parts[0][0])])
    return Surface(vertices[used], joined, {"number": np.arange(len(used), dtype=np.float64)})


def grey(colors: np.ndarray) -> np.ndarray:
    return np.isclose(colors, MISSING, atol=1e-6).all(axis=1)


def test_fields_of_a_box_in_two_pieces_are_those_of_filters_on_it(box):
    """Bit for bit, on the given vertices; and its own attributes, faces and positions are shown."""
    repair = qg.repair_surface(box)
    assert repair.surface.n_vertices < box.n_vertices
    assert repair.surface.genus == 0
    unit = np.sqrt(repair.surface.area)
    source, far = 3, box.n_vertices - 5
    row = qg.QuasiGeodesicDistances(sources=source)(box).attributes["qgeo_distance"] / unit
    phi = qg.QuasiGeodesicSpectrum()(box).attributes["qgeo_phi"] * unit
    assert np.isfinite(row).all()  # on both sides of the seam
    for mesh in (box, repair):
        widget = qw.compare(mesh, mesh, p2p=np.arange(box.n_vertices), truth=np.arange(box.n_vertices))
        assert widget.message == ""
        for pane in widget._viewer.panes:
            np.testing.assert_array_equal(pane.surface.vertices, box.vertices)
            np.testing.assert_array_equal(pane.surface.faces, box.faces)
        widget.picked = ("x", source)
        widget.mode = names.DISTANCE
        np.testing.assert_array_equal(widget._field.values[0], row)
        widget.mode, widget.k = "eigenfunction", 4
        np.testing.assert_array_equal(widget._field.values[0], phi[:, 3])
        widget.mode = names.ERROR
        assert widget._field.values[0].max() == 0
        widget.mode = "attribute: number"
        np.testing.assert_array_equal(widget._field.values[0], np.arange(box.n_vertices))
        widget.second = ("x", far)
        ends = repair.vertex_of_original[[source, far]]
        path = qg.quasi_geodesic(repair.surface, *map(int, ends), qg.lifted_metric(repair.surface))
        np.testing.assert_array_equal(widget._viewer.panes[0].lines["path"].points, path.points)
        assert "boundary vertices joined" in widget._orientation.value
        widget.close()


def test_paths_and_matrices_of_a_box_in_two_pieces(box):
    repair = qg.repair_surface(box)
    row = qg.QuasiGeodesicDistances(sources=3)(box).attributes["qgeo_distance"] / np.sqrt(repair.surface.area)
    bump = box.vertices[:, 0] ** 2
    widget = qw.geodesics(box, 3, box.n_vertices - 5, scalar=bump)
    assert widget.message == ""
    assert widget.path.converged
    np.testing.assert_allclose(widget.path.points[[0, -1]], box.vertices[[3, -5]], atol=1e-12)
    expected = qg.SurfaceScalar(scalar=bump)(box).attributes["qgeo_scalar"]
    np.testing.assert_array_equal(widget._field.values[0], expected)
    widget.close()
    widget = qw.matrix(box)
    widget.picked = 3
    np.testing.assert_array_equal(widget._field.values[0].astype(np.float32), row.astype(np.float32))
    widget.close()
    refused = qw.compare(box, box, p2p=np.arange(box.n_vertices), repair=False)
    refused.mode = "eigenfunction"
    assert "there are 2 pieces" in refused.message
    refused.close()


def test_the_symmetry_of_what_is_not_welded_is_on_its_own_vertices():
    positions, faces = shapes.creature(level=2)
    soup = Surface(positions[faces.ravel()], np.arange(3 * len(faces)).reshape(-1, 3))
    widget = qw.symmetry(soup)
    assert widget.message == ""
    found = qg.self_symmetry(soup)
    np.testing.assert_array_equal(widget._symmetry.p2p, found.p2p)
    tip = int(soup.vertices[:, 0].argmax())
    widget.picked = tip
    assert widget.image == found.p2p[tip]
    np.testing.assert_allclose(soup.vertices[widget.image], soup.vertices[tip] * [-1, 1, 1], atol=1e-9)
    curves = [line.points for line in widget._viewer.panes[0].lines.values()]
    assert len(curves) == len(found.curve) == 1  # and no piece of one in each triangle
    np.testing.assert_array_equal(curves[0], found.curve[0])
    repair = qg.repair_surface(soup)
    (axis,) = sign_changes(repair.surface, found.side[repair.origin])
    own = qw.symmetry(soup, symmetry=replace(found, curve=()))
    np.testing.assert_array_equal(own._viewer.panes[0].lines["axis 0"].points, axis)
    own.close()
    widget.mode = symmetry_widget.SUM
    expected = qg.SelfSymmetry()(soup).attributes["qgeo_symmetry_sum"]
    np.testing.assert_array_equal(widget._field.values[0], expected)
    widget.mode = symmetry_widget.DIFFERENCE
    assert np.abs(widget._field.values[0]).max() < 1e-9
    widget.close()
    wrong = qw.symmetry(soup, symmetry=SimpleNamespace(found=True, p2p=np.arange(4)))
    assert "symmetry is one of 4 vertices, but the mesh has 960" in wrong.message
    wrong.close()


def test_filters_and_widgets_wrap_a_mesh_alike(pair_of_wraps):
    x = pair_of_wraps.x
    filtered = qg.QuasiGeodesicDistances(sources=7)(x, repair="wrap")
    widget = qw.geodesics(x, 7, 120, repair="wrap")
    widget.mode = "distance from the source"
    wrap = qg.wrap_surface(x)
    expected = filtered.attributes["qgeo_distance"] / np.sqrt(wrap.surface.area)
    np.testing.assert_array_equal(widget._field.values[0], expected)
    np.testing.assert_array_equal(widget._viewer.panes[0].surface.vertices, x.vertices)
    widget.target = x.n_vertices - 1
    assert f"vertex {x.n_vertices - 1} of X has no place" in widget.message
    assert widget.path is None
    widget.close()


def test_a_mesh_that_was_wrapped_before_is_shown_with_the_attributes_that_it_has_now(pair_of_wraps):
    x = pair_of_wraps.x
    bare, named = Surface(x.vertices, x.faces), Surface(x.vertices, x.faces, {"bump": x.vertices[:, 1] ** 2})
    for mesh, found in ((bare, set()), (named, {"attribute: bump"})):
        widget = qw.geodesics(mesh, 7, 120, scalar="bump" if found else "mean_curvature", repair="wrap")
        assert widget.message == ""
        assert {mode for mode in widget.modes if mode.startswith("attribute")} == found
        widget.close()
    again = qw.compare(bare, named, p2p=pair_of_wraps.found)
    assert "attribute: bump" in again.modes
    assert again._shapes[0].surface.attributes.keys() == set()
    again.close()


def test_a_matrix_of_a_wrap_has_rows_for_what_has_a_place(pair_of_wraps):
    case = pair_of_wraps
    widget = qw.matrix(case.wraps[0])
    assert set(widget._vertex_of_row) == set(np.flatnonzero(~case.inside))
    assert np.isnan(widget._table[:, case.inside]).all()
    assert np.isfinite(widget._table[:, ~case.inside]).all()
    np.testing.assert_array_equal(grey(widget._viewer.panes[0].colors), case.inside)
    widget.picked = int(np.flatnonzero(case.inside)[0])
    assert "has no place on what is measured" in widget.message
    widget.picked = 7
    assert (widget.message, widget.mode) == ("", "distances of the row")
    widget.close()
