"""Widgets show the mesh that was given, where its repair or the closed surface around it is measured and matched."""

from __future__ import annotations

from types import SimpleNamespace

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
from qgeo_widgets import symmetry_widget
from qgeo_widgets.contours import sign_changes
from qgeo_widgets.offscreen import pane_picture

ALPHA = 0.07


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


def hollow(positions: np.ndarray, faces: np.ndarray) -> Surface:
    """A closed shape with a small sphere inside, every third face turned over."""
    ball, ball_faces = shapes.icosphere(1)
    both = np.concatenate([faces, ball_faces + len(positions)])
    both[::3] = both[::3, ::-1]
    return Surface(np.concatenate([positions, 0.25 * ball]), both, {"number": np.arange(len(positions) + len(ball))})


@pytest.fixture(scope="module")
def pair_of_wraps() -> SimpleNamespace:
    """Two hollow shapes, the closed surfaces around them, and a match of those, on the vertices that were given."""
    positions, faces = shapes.creature(level=2)
    x, y = hollow(positions, faces), hollow(shapes.bent(positions, 0.3), faces)
    inside = np.arange(x.n_vertices) >= len(positions)
    same = known(x, y, np.array(y.vertices), p2p=np.arange(x.n_vertices), wrap_x=ALPHA, wrap_y=ALPHA)
    found = without_partners(same, inside, inside)
    wraps = [qg.wrap_surface(mesh, alpha=ALPHA) for mesh in (x, y)]
    for wrap in wraps:
        np.testing.assert_array_equal(wrap.vertex_of_original < 0, inside)
    return SimpleNamespace(x=x, y=y, inside=inside, found=found, wraps=wraps)


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


# -- a mesh that is not welded ------------------------------------------------------------------------------------


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
    repair = qg.repair_surface(soup)
    (axis,) = sign_changes(repair.surface, found.side[repair.origin])
    assert len(curves) == 1  # and no piece of one in each triangle
    np.testing.assert_array_equal(curves[0], axis)
    widget.mode = symmetry_widget.SUM
    expected = qg.SelfSymmetry()(soup).attributes["qgeo_symmetry_sum"]
    np.testing.assert_array_equal(widget._field.values[0], expected)
    widget.mode = symmetry_widget.DIFFERENCE
    assert np.abs(widget._field.values[0]).max() < 1e-9
    widget.close()
    wrong = qw.symmetry(soup, symmetry=SimpleNamespace(found=True, p2p=np.arange(4)))
    assert "symmetry is one of 4 vertices, but the mesh has 960" in wrong.message
    wrong.close()


# -- a match of wraps ---------------------------------------------------------------------------------------------


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


# -- a match of a part --------------------------------------------------------------------------------------------


def test_a_match_of_a_part_is_shown_as_it_is(pair):
    x, y, where = pair
    part = x.vertices[:, 0] > 0
    found = known(x, y, y.vertices[where], p2p=where, inverse=np.argsort(where))
    found = without_partners(found, part, part[np.argsort(where)])
    widget = qw.compare(x, y, p2p=found, truth=where)
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
