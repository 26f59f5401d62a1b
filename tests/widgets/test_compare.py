"""The widget that compares two shapes, driven through its traits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapes
import traitlets
from known_match import known

import qgeo_widgets as qw
from qgeo_filters import Surface, distances, lifted_metric, quasi_geodesic
from qgeo_filters.errors import ParameterError
from qgeo_filters.filters import stages
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_widgets import compared_colors as names
from qgeo_widgets.rendering.disposal import widgets_within


@pytest.fixture
def widget(pair):
    x, y, where = pair
    widget = qw.compare(x, y, p2p=where, truth=where)
    assert widget.message == ""
    yield widget
    widget.close()


def colors(widget) -> list[np.ndarray]:
    return [pane.colors for pane in widget._viewer.panes]


def test_carried_colors_agree_at_partners(widget, pair):
    on_x, on_y = colors(widget)
    np.testing.assert_array_equal(on_x, on_y[pair[2]])
    assert len(np.unique(on_x, axis=0)) > 100


def test_a_pick_on_either_side_marks_both_and_shows_both_distances(widget, pair):
    x, _, where = pair
    widget._clicked(1, 33)
    assert widget.picked == ("y", 33)
    (i, j) = widget.pairs[0]
    assert (where[i], j) == (33, 33)
    assert widget.mode == names.DISTANCE
    for pane, vertex in zip(widget._viewer.panes, (i, j), strict=True):
        np.testing.assert_array_equal(pane.marks["first"][0], pane.surface.vertices[vertex])
    field = widget._field
    expected = distances(x, [i], lifted_metric(x))[0] / np.sqrt(x.area)
    np.testing.assert_allclose(field.values[0], expected)
    np.testing.assert_allclose(field.values[1][where], field.values[0], rtol=5e-3, atol=1e-6)
    assert f"vertex {i}" in widget._info.value
    assert "height" in widget._info.value


def test_two_picks_draw_the_paths_with_their_lengths(widget, pair):
    x, _, where = pair
    widget.picked = ("x", 3)
    widget.second = ("x", 150)
    path = quasi_geodesic(x, 3, 150, lifted_metric(x))
    assert f"{path.length / np.sqrt(x.area):.4f}" in widget._info.value
    on_x, on_y = (pane.lines["path"][0] for pane in widget._viewer.panes)
    np.testing.assert_allclose(on_x, path.points)
    np.testing.assert_allclose(on_y[[0, -1]], pair[1].vertices[where[[3, 150]]])
    widget._clicked(0, 7)  # a third click starts anew
    assert widget.second is None
    assert widget._viewer.panes[0].lines == {}


def test_follow_off_keeps_the_mode(widget):
    widget.follow = False
    widget._clicked(0, 5)
    assert widget.mode == names.CARRIED
    assert widget.picked == ("x", 5)


def test_eigenfunctions_follow_k_and_agree_in_sign(widget, pair):
    widget.mode = "eigenfunction"
    for k in (1, 2, 3):
        widget.k = k
        on_x, on_y = widget._field.values
        np.testing.assert_allclose(on_y[pair[2]], on_x, atol=0.06 * np.abs(on_x).max())
    assert widget._k_slider.value == 3
    assert widget._k_slider.max == 20


def test_error_of_the_truth_is_zero_and_of_another_map_is_not(widget, pair):
    x, y, where = pair
    widget.mode = names.ERROR
    assert widget._field.values[0].max() == 0
    other = qw.compare(x, y, p2p=np.roll(where, 1), truth=where)
    other.mode = names.ERROR
    row = distances(y, [where[0]])[0] / np.sqrt(y.area)
    np.testing.assert_allclose(other._field.values[0][0], row[other.p2p[0]], rtol=1e-3)
    other.close()


def test_limits_change_colors_and_legend_and_a_mode_resets_them(widget):
    widget.picked = ("x", 0)
    widget.mode = names.DISTANCE
    before = colors(widget)[0].copy()
    widget.limits = (0.0, 0.3)
    assert np.abs(colors(widget)[0] - before).max() > 0.1
    assert ">0.3<" in widget._legend.value
    widget.mode = names.CARRIED
    assert widget.limits is None
    assert widget._span_slider.layout.display == "none"


def test_range_slider_of_a_signed_scale_stays_centred(widget):
    widget.mode = "eigenfunction"
    top = widget._field.bounds[1]
    widget._span_slider.value = (30.0, 100.0)
    np.testing.assert_allclose(widget.limits, (-0.4 * top, 0.4 * top))
    assert widget._span_slider.value == pytest.approx((30.0, 70.0))


def test_attribute_of_one_shape_only_is_grey_on_the_other(widget):
    widget.mode = "attribute: height"
    on_x, on_y = colors(widget)
    assert len(np.unique(on_x, axis=0)) > 50
    assert len(np.unique(on_y, axis=0)) == 1
    assert "no value" in widget._legend.value


def test_an_unknown_mode_or_attribute_is_a_sentence_and_changes_nothing(widget):
    before = widget.mode
    widget.mode = "attribute: weight"
    assert widget.mode == before
    assert "no attribute 'weight'" in widget.message
    assert "no attribute" in widget._message_line.value
    widget.mode = "nonsense"
    assert "no mode 'nonsense'" in widget.message
    widget.mode = "eigenfunction"
    assert widget.message == ""


def test_what_cannot_be_shown_leaves_state_and_picture_as_they_were(pair):
    x = Surface(pair[0].vertices, pair[0].faces, {"name": np.full(162, "tooth"), "height": pair[0].vertices[:, 2]})
    widget = qw.compare(x, pair[1], p2p=pair[2])
    widget.mode = "eigenfunction"
    widget.k = 4
    state = [
        widget.mode,
        widget.k,
        widget.limits,
        widget._mode_list.value,
        widget._k_slider.value,
        widget._legend.value,
    ]
    before = colors(widget)

    def check():
        shown = [widget._mode_list.value, widget._k_slider.value, widget._legend.value]
        assert [widget.mode, widget.k, widget.limits, *shown] == state
        for one, other in zip(colors(widget), before, strict=True):
            np.testing.assert_array_equal(one, other)

    widget.mode = "attribute: name"  # text
    assert "attribute 'name' holds" in widget.message
    check()
    widget._mode_list.set_state({"index": widget.modes.index("attribute: name")})  # as it comes from the browser
    assert "attribute 'name' holds" in widget.message
    check()
    with pytest.raises(ParameterError, match="k must be from 1 to 20 for 'eigenfunction', got 21"):
        widget.k = 21
    check()
    widget.k = 5
    assert (widget.message, widget._k_slider.value) == ("", 5)
    widget.mode = "attribute: height"  # with one column
    assert (widget.k, widget._k_slider.max) == (1, 1)
    widget.close()


@pytest.mark.parametrize("limits", [(3, 1), (1, 1), (0, np.nan), (-np.inf, 1), ("a", "b"), "text", (1,)])
def test_refused_limits_leave_state_and_picture_as_they_were(widget, limits):
    widget.mode = "attribute: height"
    widget.limits = (0.0, 0.5)
    before, legend = colors(widget), widget._legend.value
    with pytest.raises((ParameterError, traitlets.TraitError), match="limits"):
        widget.limits = limits
    assert (widget.limits, widget._legend.value) == ((0.0, 0.5), legend)
    for one, other in zip(colors(widget), before, strict=True):
        np.testing.assert_array_equal(one, other)
    widget.mode = names.CARRIED
    with pytest.raises(ParameterError, match="stand for no numbers"):
        widget.limits = (0.0, 1.0)


def test_a_refused_camera_stays_where_it_was(widget):
    with pytest.raises(ParameterError, match="camera must be three finite"):
        widget.camera = (0.0, 0.0, 0.0)
    assert widget.camera == widget._viewer.camera == widget._viewer.home


def test_distance_without_a_pick_asks_for_one(widget, tmp_path):
    before = colors(widget)[0]
    widget.mode = names.DISTANCE
    assert widget.hint == "Click a point on one of the shapes: the distances from it are then shown."
    assert widget.hint in widget._message_line.value
    assert widget.message == ""  # nothing went wrong
    np.testing.assert_array_equal(colors(widget)[0], before)
    with pytest.raises(ParameterError, match=r"cannot be written yet\. Click a point"):
        widget.to_html(tmp_path / "page.html", modes=[names.DISTANCE])
    widget.picked = ("x", 5)
    assert widget.hint == ""
    assert (colors(widget)[0] != before).any()


def test_what_went_wrong_stays_when_the_colors_are_drawn_anew(pair):
    x = pair[0]
    vertices = np.concatenate([x.vertices, x.vertices + 5.0])
    two = Surface(vertices, np.concatenate([x.faces, x.faces + x.n_vertices]))
    widget = qw.compare(two, two, p2p=np.arange(two.n_vertices), curvature_weight=0.0)
    widget.mode = names.DISTANCE
    widget.picked = ("x", 3)
    assert widget.message == ""
    widget.second = ("x", x.n_vertices + 3)
    assert "piece" in widget.message
    assert "second point" in widget._info.value
    widget.close()


def test_no_symmetry_no_mirrored_twin(pair, widget):
    widget.__dict__["_mirror"] = None  # what a shape without symmetry gives, at a cost
    widget.mode = names.ERROR
    widget.flip = True
    assert widget.message == "No symmetry was found on Y, so that the map has no mirrored twin."
    assert widget.flip is False
    np.testing.assert_array_equal(widget.p2p, pair[2])
    assert widget._field.values[0].max() == 0


def test_a_bug_is_raised_and_no_sentence(widget, pair, monkeypatch):
    def planted(*args, **options):
        raise ValueError("a bug of ours")

    monkeypatch.setattr("qgeo_widgets.shape.Shape.eigenfunction", planted)
    with pytest.raises(ValueError, match="a bug of ours"):  # as it comes from the browser
        widget._mode_list.set_state({"index": widget.modes.index("eigenfunction")})
    assert widget.message == ""
    widget.mode = names.CARRIED
    with pytest.raises(ValueError, match="a bug of ours"):
        widget.mode = "eigenfunction"
    assert widget.message == ""
    monkeypatch.setattr("qgeo_filters.filters.stages.correspondence_of", planted)
    with pytest.raises(ValueError, match="a bug of ours"):
        qw.compare(*pair[:2], progress=False)


def test_orientation_is_that_of_the_match(widget, pair):
    x, y, where = pair
    assert widget._map.orientation == orientation(x, y, where)
    corners = y.vertices[where[x.faces]]  # the definition, once more
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    own = y.vertex_normals[where[x.faces]].sum(axis=1)
    cosine = (normal * own).sum(axis=1) / np.linalg.norm(normal, axis=1) / np.linalg.norm(own, axis=1)
    assert widget._map.orientation == pytest.approx(np.average(cosine, weights=x.face_areas), rel=1e-12)


def test_picks_are_checked(widget):
    with pytest.raises(ValueError, match="picked is vertex 5000"):
        widget.picked = ("x", 5000)
    with pytest.raises(traitlets.TraitError):
        widget.picked = ("z", 1)
    assert widget.picked is None


def test_traits_can_be_observed_and_the_camera_set(widget):
    seen = []
    widget.observe(lambda change: seen.append(change["new"]), ["picked", "mode", "camera"])
    widget.camera = (1.0, 2.0, 3.0)
    widget._viewer.camera = [3.0, 2.0, 1.0]
    widget._clicked(0, 9)
    assert seen == [(1.0, 2.0, 3.0), (3.0, 2.0, 1.0), ("x", 9), names.DISTANCE]
    widget.reset_view()
    assert widget.camera == widget._viewer.home


@pytest.mark.parametrize("kind", ["faces", "map", "path", "object"])
def test_bad_input_is_a_sentence_in_the_widget(pair, kind):
    x, y, where = pair
    widget = {
        "faces": lambda: qw.compare((x.vertices, np.empty((0, 3), int)), y, p2p=where),
        "map": lambda: qw.compare(x, y, p2p=where[:-1]),
        "path": lambda: qw.compare("no-such-file.off", y, p2p=where),
        "object": lambda: qw.compare(x, 17, p2p=where),
    }[kind]()
    sentence = {"faces": "no faces", "map": "p2p must be", "path": "no-such-file", "object": "cannot take a mesh"}
    assert sentence[kind] in widget.message
    assert "Traceback" not in widget._message_line.value
    with pytest.raises(ValueError, match="nothing to draw"):
        widget.snapshot()
    widget.close()


def test_without_a_map_one_is_found_with_its_regions(pair):
    x, y, where = pair
    widget = qw.compare(x, y, truth=where, progress=False)
    assert widget.message == ""
    assert (widget.p2p == where).mean() > 0.95
    assert "confident" in widget._orientation.value
    widget.mode = names.REGIONS
    on_x, on_y = colors(widget)
    assert len(np.unique(on_x, axis=0)) > 3
    assert (on_x == on_y[where]).all(axis=1).mean() > 0.8
    widget.mode = names.DISTORTION
    assert widget._field.values[0].max() < 0.1
    widget.close()


def test_a_match_is_taken_with_its_regions_score_and_doubt(pair):
    x, y, _ = pair
    found = replace(stages.correspondence_of(x, y, True, partial=False), confident=False, explanation="who knows")
    widget = qw.compare(x, y, p2p=found)
    assert widget.message == ""
    np.testing.assert_array_equal(widget.p2p, found.p2p)
    assert f"{found.score:.4f}" in widget._orientation.value
    assert "not confident: who knows" in widget._orientation.value
    assert {names.REGIONS, names.DISTORTION} <= set(widget.modes)
    widget.close()
    small = Surface(*shapes.icosphere(1))
    wrong = qw.compare(small, y, p2p=found)
    assert "a match of shapes of 162 and 162 vertices, but these have 42 and 162" in wrong.message
    wrong.close()


@pytest.mark.parametrize("truth", [[0], [[0, 1], [2]], ["a"] * 162, np.full(162, 200)])
def test_a_bad_truth_is_called_truth(pair, truth):
    widget = qw.compare(*pair[:2], p2p=pair[2], truth=truth)
    assert widget.message.startswith(("truth must be 162 vertex indices", "truth[0] is vertex 200, but Y has 162"))
    widget.close()


def test_advice_names_what_there_is_in_a_notebook(pair):
    x = pair[0]
    fan = np.concatenate([x.faces, [[x.faces[0, 0], x.faces[0, 1], 100]]])  # a third face on an edge
    widget = qw.geodesics((x.vertices, fan), 0, 60, repair=False)
    assert "repair=True splits" in widget.message  # an argument of this widget, and of a collection's none
    grid = qw.collection({"one-sided": shapes.moebius()}, {})
    grid.picked = 3
    grid.mode = "distance from the picked point"
    assert "orient them with qg.repair_surface(mesh)" in grid.message
    assert "repair=True" not in grid.message
    widget.close()
    grid.close()


def test_mirrored_shows_the_twin_of_the_map():
    vertices, faces = shapes.icosphere(3)
    lumpy = vertices * (1 + 0.3 * vertices[:, 1:2] + 0.2 * vertices[:, 2:] ** 2)
    mirror = np.linalg.norm(lumpy[:, None] * [-1, 1, 1] - lumpy, axis=2).argmin(axis=1)
    same = np.arange(len(lumpy))
    widget = qw.compare((lumpy, faces), (lumpy, faces), p2p=same, truth=same)
    assert "keeps the orientation" in widget._orientation.value
    widget.__dict__["_mirror"] = mirror  # what self_symmetry finds, at a cost
    widget.mode = names.ERROR
    widget.flip = True
    np.testing.assert_array_equal(widget.p2p, mirror)
    assert "is mirrored" in widget._orientation.value
    assert widget._field.values[0].max() > 0.3
    widget.flip = False
    np.testing.assert_array_equal(widget.p2p, same)
    assert widget._field.values[0].max() == 0
    widget.close()


def test_shapes_that_cannot_match_are_a_sentence(pair):
    x, y, _ = pair
    vertices = np.concatenate([x.vertices, x.vertices + 5.0])
    widget = qw.compare((vertices, np.concatenate([x.faces, x.faces + x.n_vertices])), y, progress=False)
    assert "one piece" in widget.message
    widget.close()


def test_hosts_of_all_kinds_come_in(pair):
    open3d = pytest.importorskip("open3d")
    pymeshlab = pytest.importorskip("pymeshlab")
    pyvista = pytest.importorskip("pyvista")
    x, y, where = pair
    legacy = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(x.vertices.copy()), open3d.utility.Vector3iVector(x.faces.copy())
    )
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(y.vertices.copy(), y.faces.copy()))
    surface = pyvista.PolyData.from_regular_faces(y.vertices, y.faces)
    for host in (meshes, surface):
        widget = qw.compare(legacy, host, p2p=where)
        assert widget.message == ""
        np.testing.assert_allclose(widget._viewer.panes[1].surface.vertices, y.vertices)
        widget.close()


def test_nothing_is_computed_twice(widget, monkeypatch):
    calls = []
    original = distances
    monkeypatch.setattr("qgeo_widgets.shape.distances", lambda *a, **k: calls.append(a[1]) or original(*a, **k))
    widget.picked = ("x", 5)
    widget.mode = names.DISTANCE
    widget.limits = (0.0, 0.2)
    widget.mode = names.CARRIED
    widget.mode = names.DISTANCE
    widget.second = ("x", 8)
    widget.picked = ("x", 6)
    widget.picked = ("x", 5)
    assert len(calls) == 4  # two vertices on two shapes


def size_of(value) -> int:
    """Bytes of the arrays in what is sent."""
    if isinstance(value, bytes):
        return len(value)
    if isinstance(value, dict):
        return sum(map(size_of, value.values()))
    return sum(map(size_of, value)) if isinstance(value, list) else 0


def test_a_change_of_mode_sends_the_colors_and_no_mesh(widget):
    sent: list[tuple[str, str, int]] = []

    def noted(change):
        if change["name"] in change["owner"].keys:  # what goes to the browser
            sent.append((type(change["owner"]).__name__, change["name"], size_of(change["new"])))

    for part in widgets_within(widget):
        part.observe(noted)
    widget.mode = "attribute: height"
    # A colour in three bytes, and the value that it stands for in four.
    colors_of = sum(pane.surface.n_vertices * (3 + 4) for pane in widget._viewer.panes)
    assert [size for _, name, size in sent if name == "paints"] == [colors_of]
    # All else is a few lines of HTML and places of sliders.
    assert {name for _, name, size in sent if size} == {"paints"}
    assert "SceneWidget" not in {kind for kind, name, _ in sent if name not in ("paints", "legend")}
    sent.clear()
    widget.limits = (0.0, 0.5)
    assert sum(size for _, _, size in sent) == colors_of


def test_closing_frees_everything(pair, counted):
    x, y, where = pair
    widget = qw.compare(x, y, p2p=where)
    widget._clicked(0, 3)
    widget._clicked(0, 30)
    widget.mode = "eigenfunction"
    assert counted() > 30
    widget.close()
    assert counted() == 0


def test_picture_for_hosts_without_widgets(widget):
    bundle = widget._repr_mimebundle_()
    data = bundle[0] if isinstance(bundle, tuple) else bundle
    assert "application/vnd.jupyter.widget-view+json" in data
    assert data["image/png"][:4] == b"\x89PNG"
    assert len(widget._viewer._scene.stills) == 2
    assert all(url.startswith("data:image/png") for url in widget._viewer._scene.stills)


def test_snapshot_is_written_whole(widget, tmp_path):
    png = widget.snapshot(tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == png
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


# -- landmarks -----------------------------------------------------------------------------------------------


def test_a_pick_on_each_shape_becomes_a_landmark_with_a_mark_on_both(widget, pair):
    widget._list.use.click()
    assert widget.message.startswith("Click a point on X, and then on Y where it belongs")
    widget._clicked(0, 5)
    widget._clicked(1, 40)
    widget._list.use.click()
    assert (widget.landmarks, widget.message) == ([(5, 40)], "")
    for pane, vertex in zip(widget._viewer.panes, (5, 40), strict=True):
        np.testing.assert_array_equal(pane.marks["landmark 0"][0], pane.surface.vertices[vertex])
    on_x, on_y = (pane.marks["landmark 0"][1] for pane in widget._viewer.panes)
    assert on_x == on_y
    widget._clicked(1, 33)  # one pick alone: the map is right there
    widget._list.use.click()
    assert widget.landmarks == [(5, 40), (int(np.flatnonzero(pair[2] == 33)[0]), 33)]
    widget.second = None
    widget._clicked(1, 9)
    widget._list.use.click()
    assert "Both points were picked on one shape" in widget.message
    widget._clicked(0, 5)  # the same vertex again: the new partner stands
    widget._clicked(1, 60)
    widget._list.use.click()
    assert widget.landmarks[-1] == (5, 60)
    assert len(widget.landmarks) == 2


def test_landmarks_are_listed_and_removed(widget):
    widget.landmarks = [(5, 40), (6, 41)]
    rows = widget._list._rows.children
    assert ["vertex 5 of X, vertex 40 of Y" in rows[0].children[0].value, len(rows)] == [True, 2]
    rows[0].children[1].click()
    assert widget.landmarks == [(6, 41)]
    for pane, vertex in zip(widget._viewer.panes, (6, 41), strict=True):
        np.testing.assert_array_equal(pane.marks["landmark 0"][0], pane.surface.vertices[vertex])
        assert "landmark 1" not in pane.marks
    with pytest.raises(ValueError, match="landmark 0 on Y is vertex 5000"):
        widget.landmarks = [(1, 5000)]


def test_matched_again_the_map_agrees_with_the_landmarks(pair, counted):
    """From a wrong map, in the background, as the button does it; with the colours of a found map."""
    x, y, where = pair
    widget = qw.compare(x, y, p2p=np.roll(where, 1), truth=where)
    widget.mode = names.ERROR
    assert widget._field.values[0].mean() > 0.1
    widget.landmarks = [(i, int(where[i])) for i in (3, 50, 110)]
    widget._list.again.click()
    widget._long.join(120)
    assert (widget.message, widget._list.busy, widget._list.again.disabled) == ("", False, False)
    assert (widget.p2p == where).mean() > 0.95
    assert widget.mode == names.ERROR  # and it is drawn anew
    assert widget._field.values[0].mean() < 0.02
    assert {names.REGIONS, names.DISTORTION} <= set(widget._mode_list.options) == set(widget.modes)
    assert "it agrees with the hints" in widget._orientation.value
    assert "the map comes within 0.0" in widget._list._rows.children[0].children[0].value
    widget.close()
    assert counted() == 0


def test_matched_again_with_the_options_of_the_match(pair, monkeypatch):
    x, y, where = pair
    found = known(x, y, y.vertices[where], p2p=where, normalize=False, partial=False, mirror="yes")
    asked = []

    def noted(x, y, normalize, progress, *, partial, mirror, **others):
        asked.append((normalize, partial, mirror))
        return found

    monkeypatch.setattr(stages, "correspondence_of", noted)
    for p2p in (found, where):
        widget = qw.compare(x, y, p2p=p2p)
        widget.landmarks = [(3, int(where[3]))]
        widget.match_again()
        assert widget.message == ""
        widget.close()
    assert asked == [(False, False, "yes"), (True, "auto", "auto")]  # a map alone does not say


def test_landmarks_that_cannot_be_are_a_sentence(widget, pair):
    before = widget.p2p
    widget.landmarks = [(5, 40), (5, 41)]
    widget.match_again()
    assert "landmarks contradict each other: vertex 5 of X belongs to vertices 40, 41 of Y" in widget.message
    np.testing.assert_array_equal(widget.p2p, before)
