"""A widget in Jupyter Notebook 7, by mouse, in a headless Chromium."""

from __future__ import annotations

import browser as tools
import numpy as np
import pytest

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.mark.slow
def test_compare_in_notebook_7(page, pair, tmp_path):
    notebook = pytest.importorskip("notebook", minversion="7", reason="needs notebook 7")
    assert notebook
    x, y, where = pair
    x.write(tmp_path / "x.ply")
    y.write(tmp_path / "y.ply")
    np.save(tmp_path / "where.npy", where)
    load = (
        "import numpy as np, qgeo_filters as qg, qgeo_widgets as qw\n"
        "x, y, where = qg.Surface.read('x.ply'), qg.Surface.read('y.ply'), np.load('where.npy')"
    )
    server = tools.notebook(tmp_path)
    try:
        book = tools.Notebook(page, server, "book.ipynb", [load], tree="notebooks")
        book.show("w = qw.compare(x, y, p2p=where)\nw")
        left, right = book.canvases(2)
        before = tools.settled(left), tools.settled(right)
        tools.drag(page, left, 60, 20)
        for canvas, old in zip((left, right), before, strict=True):
            tools.until(lambda canvas=canvas, old=old: np.abs(tools.pixels(canvas) - old).mean() > 1)
        tools.until(lambda: book.python("print(w.camera != w._viewer.home)") == "True")
        box = left.bounding_box()
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        tools.until(lambda: book.python("print(w.picked[0])") == "x")
    finally:
        server.stop()
