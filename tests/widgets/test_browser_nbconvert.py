"""What nbconvert makes of a notebook that was run: pictures of the widgets, and pages that live, with no network."""

from __future__ import annotations

import browser as tools
import numpy as np
import pytest

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def path(pair, tmp_path_factory):
    """The page of a notebook with a widget, and the same embedded."""
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    nbconvert = pytest.importorskip("nbconvert", reason="needs nbconvert")
    folder = tmp_path_factory.mktemp("book")
    x, y, where = pair
    x.write(folder / "x.ply")
    y.write(folder / "y.ply")
    np.save(folder / "where.npy", where)
    load = (
        "import numpy as np, qgeo_filters as qg, qgeo_widgets as qw\n"
        "w = qw.compare(qg.Surface.read('x.ply'), qg.Surface.read('y.ply'), p2p=np.load('where.npy'))"
    )
    tools.write_notebook(folder / "book.ipynb", [load, "w", "w.embed(height=700)"])
    book = nbformat.read(folder / "book.ipynb", as_version=4)
    nbclient.NotebookClient(book, resources={"metadata": {"path": str(folder)}}).execute()
    text, _ = nbconvert.HTMLExporter().from_notebook_node(book)
    (folder / "book.html").write_text(text)
    return folder / "book.html"


@pytest.mark.slow
def test_the_picture_and_the_embedded_page_are_there_without_a_network(chromium, path):
    context = chromium.new_context(viewport={"width": 1100, "height": 900}, offline=True)
    page = context.new_page()
    page.goto(path.as_uri(), wait_until="domcontentloaded")
    picture = page.get_by_alt_text("as it was when the cell was run")
    picture.scroll_into_view_if_needed()
    assert picture.is_visible()
    assert tools.pixels(picture).std() > 15
    frame = page.frame_locator("iframe")
    views = frame.locator(".qgeo-view")
    views.first.scroll_into_view_if_needed()
    tools.until(lambda: views.count() == 2 and tools.pixels(views.first).std() > 15)
    before = [tools.settled(views.nth(k)) for k in range(2)]
    tools.drag(page, views.first, 60, 20)
    for k in range(2):
        tools.until(lambda k=k: np.abs(tools.pixels(views.nth(k)) - before[k]).mean() > 1)
    context.close()
