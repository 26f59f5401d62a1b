"""axe-core finds nothing wrong with pages, and with what a notebook shows; `npm ci` in the renderer has it."""

from __future__ import annotations

from pathlib import Path

import browser as tools
import numpy as np
import pytest
import shapes

import qgeo_widgets as qw
from qgeo_filters import Animation, Surface

pytestmark = pytest.mark.browser

AXE = Path(__file__).parents[2] / "widgets" / "renderer" / "node_modules" / "axe-core" / "axe.min.js"


@pytest.fixture(scope="module")
def axe():
    """Text of axe-core."""
    if not AXE.exists():
        pytest.skip("needs axe-core: cd widgets/renderer && npm ci")
    return AXE.read_text(encoding="utf-8")


def faults(page, axe: str, within: str = "document") -> list[str]:
    """What axe-core says of a part of the page: rule, help, and the first element."""
    page.evaluate(axe)
    found = page.evaluate(f"axe.run({within})")["violations"]
    return [f"{each['id']}: {each['help']}: {each['nodes'][0]['html'][:200]}" for each in found]


def made(kind: str, pair):
    x, y, where = pair
    if kind == "compare":
        return qw.compare(x, y, p2p=where, truth=where, texture=np.zeros((4, 4), np.uint8))
    if kind == "geodesics":
        return qw.geodesics(x, 3, 120)
    if kind == "matrix":
        return qw.matrix(x)
    if kind == "symmetry":
        return qw.symmetry(Surface(*shapes.icosphere(2)))
    if kind == "collection":
        return qw.collection({"a": x, "b": y}, {"b": where})
    return qw.animate(Animation(x, np.stack([x.vertices, 1.2 * x.vertices])))


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("kind", ["compare", "geodesics", "matrix", "symmetry", "collection", "animate"])
def test_a_page_has_names_roles_and_contrast(chromium, pair, tmp_path, axe, kind, scheme):
    widget = made(kind, pair)
    widget.to_html(tmp_path / "page.html")
    widget.close()
    context = chromium.new_context(color_scheme=scheme)
    page = context.new_page()
    page.goto((tmp_path / "page.html").as_uri())
    page.locator(".qgeo-look summary").click()
    tools.until(lambda: tools.pixels(page.locator(".qgeo-view").first).std() > 5)
    assert faults(page, axe) == []
    context.close()


@pytest.mark.slow
@pytest.mark.parametrize("theme", ["JupyterLab Light", "JupyterLab Dark"])
def test_a_widget_in_a_notebook_has_names_roles_and_contrast(chromium, lab, pair, axe, theme):
    x, y, where = pair
    x.write(lab.folder / "x.ply")
    y.write(lab.folder / "y.ply")
    np.save(lab.folder / "where.npy", where)
    page = chromium.new_context(viewport={"width": 1280, "height": 1000}).new_page()
    load = (
        "import numpy as np, qgeo_filters as qg, qgeo_widgets as qw\n"
        "x, y, where = qg.Surface.read('x.ply'), qg.Surface.read('y.ply'), np.load('where.npy')"
    )
    book = tools.Notebook(page, lab, "axe.ipynb", [load])
    page.evaluate("(theme) => window.jupyterapp.commands.execute('apputils:change-theme', {theme})", theme)
    dark = "false" if theme.endswith("Dark") else "true"
    page.wait_for_function(f"() => document.body.dataset.jpThemeLight === '{dark}'")
    for call in ("qw.compare(x, y, p2p=where)", "qw.geodesics(x, 3, 120)", "qw.matrix(x)"):
        book.show(f"w = {call}\nw")
        book.canvases(1)
        page.locator(".qgeo-look summary").first.click()
        page.wait_for_timeout(500)
        assert faults(page, axe, "'.jp-OutputArea-output .widget-vbox'") == [], call
        book.python("w.close()")
    page.context.close()
