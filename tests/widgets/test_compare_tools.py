"""What people do with a map that they look at: worst places, a painted region, a checkerboard, files of landmarks."""

from __future__ import annotations

import base64

import numpy as np
import pytest
import shapes

import qgeo_filters as qg
import qgeo_widgets as qw
from qgeo_widgets import compared_colors as names
from qgeo_widgets.brush import RADIUS, Brush


@pytest.fixture
def widget(pair):
    x, y, where = pair
    wrong = np.array(where)
    wrong[[3, 60]] = where[[100, 150]]
    widget = qw.compare(x, y, p2p=wrong, truth=where)
    assert widget.message == ""
    yield widget
    widget.close()


def test_wrong_places_are_a_list_to_click(widget, pair):
    assert widget._worst.layout.display == "none"
    widget.mode = names.ERROR
    assert set(widget._worst.vertices) == {3, 60}
    assert widget._worst.layout.display == ""
    button = next(b for b in widget._worst._buttons.children if b.description.startswith("60:"))
    button.click()
    assert widget.picked == ("x", 60)
    assert widget.mode == names.ERROR  # and still shown
    view, pane = widget._viewer.camera_view(), widget._viewer.panes[0]
    facing = pane.placement.axes @ pair[0].vertex_normals[60]
    assert facing @ view.axes[2] > 0.85
    widget.mode = names.CARRIED
    assert list(widget._worst.vertices) == []
    assert widget._worst.layout.display == "none"


def test_a_dab_is_what_lies_around_and_faces_the_same_way():
    flat = qg.testing.sample_surface()
    flat = flat.with_vertices(flat.vertices * [1, 1, 0.01])  # its sides are nearer than the brush is wide
    vertex = int(flat.vertices[:, 2].argmax())
    dab = Brush(flat, flat.vertex_normals, np.sqrt(flat.area)).dab(vertex)
    radius = RADIUS * np.sqrt(flat.area)
    near = np.linalg.norm(flat.vertices - flat.vertices[vertex], axis=1) <= radius
    same = flat.vertex_normals @ flat.vertex_normals[vertex] > 0
    np.testing.assert_array_equal(dab, np.union1d(np.flatnonzero(near & same), [vertex]))


def test_what_is_painted_on_one_shape_is_seen_on_both(pair):
    x, y, where = pair
    widget = qw.compare(x, y, p2p=where)
    widget.brush = True
    assert widget._viewer._scene.brush
    face = x.faces[(x.faces == 17).any(axis=1)][0]
    point = widget._viewer.panes[0].placement.to_scene(x.vertices[17]).tolist()
    widget._viewer._scene._handle_custom_msg({"kind": "paint", "pane": 0, "corners": face.tolist(), "point": point}, [])
    assert 17 in widget.painted
    assert widget.picked is None
    assert widget.mode == names.PAINTED
    on_x, on_y = (field == 0 for field in widget._field.labels)
    np.testing.assert_array_equal(np.flatnonzero(on_x), widget.painted)
    np.testing.assert_array_equal(on_y[where], on_x)
    before = list(widget.painted)
    widget._clicked(1, int(where[100]))  # on Y
    assert set(widget.painted) >= {*before, 100}
    widget.painted = [5, 3, 5]
    assert widget.painted == [3, 5]
    with pytest.raises(ValueError, match="painted"):
        widget.painted = [1, 400]
    widget.painted = []
    assert not (widget._field.labels[0] == 0).any()
    widget.close()


@pytest.mark.slow
def test_the_checkerboard_is_carried_and_pictured(pair, tmp_path):
    x, y, where = pair
    widget = qw.compare(x, y, p2p=where)
    plain = widget.snapshot()
    widget.mode = names.CHECKERBOARD
    on_x, on_y = (pane.cells for pane in widget._viewer.panes)
    np.testing.assert_allclose(on_y[where], on_x)
    sent = widget._viewer._scene.paints[1]["cells"]
    np.testing.assert_allclose(np.frombuffer(sent, np.float32).reshape(-1, 3), on_y, atol=1e-4)
    assert widget.snapshot() != plain
    widget.to_html(tmp_path / "page.html", modes=[names.CHECKERBOARD])
    widget.mode = names.CARRIED
    assert widget._viewer.panes[0].cells is None
    assert widget._viewer._scene.paints[1]["cells"] is None
    assert widget.snapshot() == plain
    widget.close()


def test_landmarks_are_saved_and_loaded(widget, pair, tmp_path):
    x, y, where = pair
    widget.landmarks = [(5, int(where[5])), (90, int(where[90]))]
    widget.save_landmarks(tmp_path / "pairs.csv")
    assert (tmp_path / "pairs.csv").read_text() == f"x_vertex,y_vertex\n5,{where[5]}\n90,{where[90]}\n"
    assert "landmarks.csv" in widget._list._save.value
    widget.landmarks = []
    widget.load_landmarks(tmp_path / "pairs.csv")
    assert widget.landmarks == [(5, int(where[5])), (90, int(where[90]))]
    # Landmarks of two files belong together by name.
    for mesh, vertices, file in ((x, [7, 33], "x.mrk.json"), (y, where[[33, 7]], "y.mrk.json")):
        order = ["a", "b"] if file[0] == "x" else ["b", "a"]
        qg.write_landmarks(tmp_path / file, qg.Landmarks(order, mesh.vertices[vertices]))
    widget.load_landmarks(tmp_path / "x.mrk.json", tmp_path / "y.mrk.json")
    assert widget.landmarks == [(7, int(where[7])), (33, int(where[33]))]
    with pytest.raises(ValueError, match="one file of pairs, or one of landmarks for X and one for Y"):
        widget.load_landmarks(*["a"] * 3)
    assert len(widget.landmarks) == 2


def test_landmarks_in_files_are_vertices_of_the_meshes_that_were_given(tmp_path):
    """As commands and functions mean them, whatever is matched; a lost one is taken or refused as there."""
    vertices, faces = shapes.creature(level=2)
    n, loose = len(vertices), np.array([[0.0, 0, 0], vertices[7] * 1.001])
    mess = np.concatenate([loose, vertices[::-1]]), n + 1 - faces  # two vertices without a face come first
    repair, whole = qg.repair_surface(mess), qg.Surface(vertices, faces)
    assert repair.surface.n_vertices == n
    widget = qw.compare(repair, whole, p2p=np.concatenate([[-1, -1], np.arange(n)[::-1]]))
    widget.picked = ("x", n + 1 - 7)
    widget.use_as_landmark()
    assert widget.landmarks == [(n + 1 - 7, 7)]
    widget.save_landmarks(tmp_path / "pairs.csv")
    assert (tmp_path / "pairs.csv").read_text() == f"x_vertex,y_vertex\n{n + 1 - 7},7\n"
    assert base64.b64encode((tmp_path / "pairs.csv").read_bytes()).decode() in widget._list._save.value
    for vertex, taken in ((n + 1 - 7, True), (1, True), (0, False)):
        widget.landmarks = []
        (tmp_path / "pairs.csv").write_text(f"{vertex},7\n")
        if taken:
            widget.load_landmarks(tmp_path / "pairs.csv")
            assert widget.landmarks == [(vertex, 7)]
        else:
            said = f"landmark 0 is vertex {vertex} of X, which had to go when that was repaired"
            with pytest.raises(qg.ParameterError, match=said):
                widget.load_landmarks(tmp_path / "pairs.csv")
            assert widget.landmarks == []
            with pytest.raises(qg.ParameterError, match=said):
                qg.match(mess, whole, landmarks=[(vertex, 7)])
    widget.close()


def upload(name: str, content: bytes) -> dict:
    """What the browser sends of a file."""
    return {"name": name, "type": "", "size": len(content), "content": memoryview(content), "last_modified": 0}


def test_files_that_are_chosen_in_the_browser_are_loaded_or_said_to_be_wrong(widget):
    widget._list._uploaded({"new": (upload("pairs.csv", b"4,5\n6,7\n"),)})
    assert widget.landmarks == [(4, 5), (6, 7)]
    widget._list._uploaded({"new": (upload("pairs.csv", b"4,5\n6,seven\n"),)})
    assert "line 2 is no pair of vertices" in widget.message
    assert widget.landmarks == [(4, 5), (6, 7)]
    widget._list._uploaded({"new": (upload("../pairs.csv", b"4,500\n"),)})
    assert "500" in widget.message
    assert widget.landmarks == [(4, 5), (6, 7)]
