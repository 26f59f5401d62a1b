"""A widget in a Voila dashboard, by mouse, in a headless Chromium."""

from __future__ import annotations

import browser as tools
import numpy as np
import pytest

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.mark.slow
def test_compare_in_voila(page, pair, tmp_path):
    pytest.importorskip("voila", reason="needs voila")
    x, y, where = pair
    x.write(tmp_path / "x.ply")
    y.write(tmp_path / "y.ply")
    np.save(tmp_path / "where.npy", where)
    cell = (
        "import numpy as np, qgeo_filters as qg, qgeo_widgets as qw\n"
        "qw.compare(qg.Surface.read('x.ply'), qg.Surface.read('y.ply'), p2p=np.load('where.npy'))"
    )
    tools.write_notebook(tmp_path / "board.ipynb", [cell])
    server = tools.voila(tmp_path, "board.ipynb")
    try:
        page.goto(server.url, timeout=tools.PATIENCE)
        left, right = tools.live_canvases(page, 2)
        before = tools.settled(left), tools.settled(right)
        tools.drag(page, left, 60, 20, release=False)
        for canvas, old in zip((left, right), before, strict=True):
            tools.until(lambda canvas=canvas, old=old: np.abs(tools.pixels(canvas) - old).mean() > 1)
        page.mouse.up()
        page.wait_for_timeout(800)
        box = left.bounding_box()
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        page.get_by_text("first point").wait_for()
        page.get_by_text("distance from vertex").wait_for()
        assert page.get_by_text("distance from vertex").is_visible()
    finally:
        server.stop()
