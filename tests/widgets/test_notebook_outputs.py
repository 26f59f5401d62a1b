"""What a widget leaves in a notebook, and in its kernel when a cell is run again and again."""

from __future__ import annotations

import re
from types import SimpleNamespace

import browser as tools
import pytest

import qgeo_widgets as qw
from qgeo_widgets import cell_widgets, saved_image


@pytest.fixture
def cell(monkeypatch):
    """Function that says which cell is run, by which message."""
    parent = {}
    kernel = SimpleNamespace(get_parent=lambda channel: parent)
    monkeypatch.setattr(cell_widgets, "get_ipython", lambda: SimpleNamespace(kernel=kernel))

    def runs(name, message, kind="execute_request"):
        metadata = {"cellId": f"{id(parent)} {name}"} if name else {}
        parent.update(header={"msg_id": message, "msg_type": kind}, metadata=metadata)

    return runs


def test_a_cell_that_is_run_again_leaves_the_widgets_of_its_last_run(pair, cell, counted):
    cell("a", "0")
    kept = qw.geodesics(pair[0])
    one = counted()
    for run in range(1, 5):
        cell("b", str(run))
        first, second = qw.geodesics(pair[0]), qw.geodesics(pair[0])
        assert counted() == pytest.approx(3 * one, abs=2)
    for widget in (kept, first, second):  # one in another cell, and both of one run
        assert widget.comm is not None
        widget.source = 3
        widget.close()
    assert counted() == 0


@pytest.mark.parametrize(("name", "kind"), [("", "execute_request"), ("a", "comm_msg")])
def test_where_no_cell_is_run_nothing_is_closed(pair, cell, name, kind):
    cell(name, "1", kind)
    first = qw.geodesics(pair[0])
    cell(name, "2", kind)
    second = qw.geodesics(pair[0])
    for widget in (first, second):
        assert widget._viewer is not None
        widget.close()


def test_the_picture_is_an_output_of_its_own(pair, monkeypatch):
    shown = []
    monkeypatch.setattr(saved_image, "display", lambda data, raw: shown.append(data))
    widget = qw.compare(*pair[:2], p2p=pair[2])
    widget._ipython_display_()
    live, picture = shown
    assert set(live) == {"application/vnd.jupyter.widget-view+json", "text/plain"}
    assert live["text/plain"] == "CompareWidget: Two shapes and the map between them"
    assert re.search('<img alt="CompareWidget[^>]+ src="data:image/png;base64,iVBOR', picture["text/html"])
    assert picture["image/png"].startswith(b"\x89PNG")
    assert f"body:has(.qgeo-live-{widget.model_id})" in picture["text/html"]
    assert f"qgeo-live-{widget.model_id}" in widget._dom_classes
    widget.close()


@pytest.mark.browser
@pytest.mark.slow
def test_lab_shows_the_picture_where_there_is_no_kernel_and_hides_it_beside_the_widget(pair, lab, page):
    pair[0].write(lab.folder / "x.ply")
    cells = ["import qgeo_filters as qg, qgeo_widgets as qw", "w = qw.geodesics(qg.Surface.read('x.ply'))\nw"]
    book = tools.Notebook(page, lab, "no_kernel.ipynb", cells)
    book.canvases(1)
    picture = page.locator("img[alt^='GeodesicsWidget']")
    picture.wait_for(state="attached")
    assert not picture.is_visible()
    page.evaluate("() => window.jupyterapp.commands.execute('docmanager:save')")
    tools.until(lambda: "qgeo-saved" in (lab.folder / "no_kernel.ipynb").read_text())
    page.evaluate("() => window.jupyterapp.commands.execute('notebook:shutdown-kernel')")
    page.goto("about:blank")
    page.goto(f"{lab.url}/lab/tree/no_kernel.ipynb?reset", timeout=tools.PATIENCE)
    picture = page.locator("img[alt^='GeodesicsWidget']")
    picture.wait_for(state="visible", timeout=tools.PATIENCE)
    tools.until(lambda: tools.pixels(picture).std() > 15)
