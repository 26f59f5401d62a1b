"""The widget of a collection, by its parts and by mouse."""

from __future__ import annotations

import browser as tools
import numpy as np
import pytest
from shapes import bent, blob
from small_collection import QUICK, poses

import qgeo_widgets as qw
from qgeo_filters import Collection, Surface
from qgeo_widgets.collection_widget import CARRIED, DISTANCE

VERTICES, FACES = blob(2)
N = len(VERTICES)
ORDER = np.random.default_rng(0).permutation(N)
HEIGHT = VERTICES[:, 2].copy()


def shapes(count: int = 4) -> tuple[dict[str, Surface], dict[str, np.ndarray]]:
    """A template and bent copies of it, their vertices shuffled, and the true maps to it."""
    where = np.argsort(ORDER)
    found = {"t": Surface(VERTICES, FACES, {"height": HEIGHT})}
    for i in range(1, count):
        found[f"s{i}"] = Surface(bent(VERTICES, 0.1 * i)[ORDER], where[FACES])
    return found, {name: ORDER for name in found if name != "t"}


def test_one_colouring_and_one_pick_on_all(counted):
    some, maps = shapes()
    widget = qw.collection(some, maps)
    assert widget.message == ""
    assert widget.names == ("t", "s1", "s2", "s3")
    panes = widget._viewer.panes
    for pane in panes[1:]:
        assert np.allclose(pane.colors, panes[0].colors[ORDER], atol=1e-6)
    widget._clicked(2, 17)  # as a click on the third shape does
    assert widget.picked == ORDER[17]
    assert widget.partners == (ORDER[17], 17, 17, 17)
    widget.mode = DISTANCE
    assert np.array_equal(widget._field.values[1], widget._field.values[0][ORDER])
    assert widget._field.values[0][ORDER[17]] == 0
    widget.mode = "attribute: height"
    assert np.array_equal(widget._field.values[3], HEIGHT[ORDER])
    widget.mode = CARRIED
    assert widget.snapshot().startswith(b"\x89PNG")
    widget.close()
    assert counted() == 0


def test_a_collection_brings_its_own_maps():
    pytest.importorskip("pandas")
    poses_ = poses(3)
    collection = Collection(poses_, parameters=QUICK)
    widget = qw.collection(collection, template="p1")
    assert widget.message == ""
    assert widget.names == ("p1", "p0", "p2")
    assert collection.status().matched == 2  # with the template, and no other pair
    places = collection.maps_to("p1")
    at = poses_["p1"].vertices
    widget.picked = 40
    for name, partner in zip(widget.names[1:], widget.partners[1:], strict=True):
        gaps = np.linalg.norm(places[name].pulled_back(at) - at[40], axis=1)
        assert gaps[partner] == gaps.min()
    widget.close()
    widget = qw.collection(poses_)
    assert "maps='matched' are maps of a Collection" in widget.message
    widget.close()


def test_vertices_without_a_partner_are_grey_and_say_so():
    some, maps = shapes(2)
    widget = qw.collection(some, {"s1": np.where(np.arange(N) < 5, -1, maps["s1"])})
    assert np.allclose(widget._viewer.panes[1].colors[:5], 0.62, atol=0.01)
    widget._clicked(1, 3)
    assert widget.picked is None
    assert "Vertex 3 of s1 has no partner" in widget.message
    widget.picked = N
    assert "no 162" in widget.message
    widget.close()


def test_many_shapes_come_in_pages(pythreejs):
    some, maps = shapes(10)
    first, second = (qw.collection(some, maps, page=page) for page in (1, 2))
    assert len(first.names) == 8
    assert second.names == ("t", "s8", "s9")
    assert "Page 1 of 2" in first._info.value
    for widget in (first, second):
        widget.close()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"template": "x"}, "no shape called 'x'"),
        ({"page": 2}, "page must be between 1 and 1"),
        ({"maps": {"s1": ORDER}}, "no map from s2 to t (2 such"),
        ({"maps": {"s1": ORDER[:5], "s2": ORDER, "s3": ORDER}}, "map s1 - t has 5 entries"),
        ({"shapes": {}}, "there is no shape"),
    ],
)
def test_what_does_not_fit_is_a_sentence(change, message):
    some, maps = shapes()
    widget = qw.collection(**{"shapes": some, "maps": maps, **change})
    assert message in widget.message
    widget.close()


@pytest.mark.browser
@pytest.mark.slow
def test_a_click_on_one_shape_marks_all(page, lab, request):
    some, _ = shapes(8)
    for name, surface in some.items():
        surface.write(lab.folder / f"{name}.ply")
    np.save(lab.folder / "order.npy", ORDER)
    load = (
        "import numpy as np, qgeo_filters as qg, qgeo_widgets as qw\n"
        f"shapes = {{n: qg.Surface.read(n + '.ply') for n in {list(some)}}}\n"
        "order = np.load('order.npy')"
    )
    cell = "w = qw.collection(shapes, {n: order for n in shapes if n != 't'}, size=(150, 140))\nw"
    book = tools.Notebook(page, lab, f"{request.node.name}.ipynb", [load, cell])
    canvases = book.canvases(8)
    before = [tools.settled(canvas) for canvas in canvases]
    box = canvases[1].bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    for canvas, old in zip(canvases, before, strict=True):
        tools.until(lambda canvas=canvas, old=old: np.abs(tools.pixels(canvas) - old).max() > 40)
    assert book.python("print(w.picked is not None, len(w.partners), repr(w.message))") == "True 8 ''"
