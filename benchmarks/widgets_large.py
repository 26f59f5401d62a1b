"""A page of a large mesh: megabytes, seconds until it shows, milliseconds of a change of colours; needs Chromium.

    python benchmarks/widgets_large.py MESH [--json results/widgets_large.json]

The mesh is compared with itself, turned, in two modes. A change of colours is from the choice in the list to the
picture after the next, in a headless Chromium that draws in software: a graphics card is quicker. The same once more
without what such a card does: WebGL's draw calls do nothing, all else is done, decoding and what is sent to the card
too. In JupyterLab, likewise without drawing, from the message that asks the kernel for a change of limits to the last
draw call that follows: kernel, what is sent, decoding, attributes; a frame of the browser is waited for in each. Of
that, what the browser's script takes, and the kernel's processor time, which other work on the machine lengthens less.
Beside it: seconds until the widget of two such meshes is made.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright
from record import Record, recorded

import qgeo_filters as qg
import qgeo_widgets as qw

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import browser as tools

_CHANGE = """async () => {
  const list = document.querySelector('#mode');
  const seconds = [];
  for (let turn = 0; turn < 10; turn++) {
    const start = performance.now();
    list.value = String(1 - Number(list.value));
    list.dispatchEvent(new Event('change'));
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    seconds.push((window.drawnAt ?? performance.now()) - start);
  }
  return seconds;
}"""

# In place of what a graphics card does; tells when the last call was.
_NO_DRAWING = """for (const name of ['drawElements', 'drawArrays', 'drawElementsInstanced', 'drawArraysInstanced']) {
  WebGL2RenderingContext.prototype[name] = () => { window.drawnAt = performance.now(); };
}"""
_LIVE = """async ([low, high]) => {
  const kernel = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
  const before = window.drawnAt;
  const start = performance.now();
  kernel.requestExecute({code: `w.limits = (${low}, ${high})`, store_history: false});
  while (window.drawnAt === before) await new Promise(requestAnimationFrame);
  await new Promise((done) => setTimeout(done, 300));
  return window.drawnAt - start;
}"""
_CELL = """import numpy as np, qgeo_filters as qg, qgeo_widgets as qw
mesh = qg.Surface.read("mesh.ply")
x = qg.Surface(mesh.vertices, mesh.faces, {"height": mesh.vertices[:, 2]})
w = qw.compare(x, x.with_vertices(mesh.vertices[:, [1, 2, 0]]), p2p=np.arange(x.n_vertices))
w.mode = "attribute: height"
w"""


class Script:
    """Milliseconds that the script of a page has run."""

    def __init__(self, page: Any) -> None:
        self._session = page.context.new_cdp_session(page)
        self._session.send("Performance.enable")

    def milliseconds(self) -> float:
        """Until now."""
        metrics = self._session.send("Performance.getMetrics")["metrics"]
        return 1000 * float(next(each["value"] for each in metrics if each["name"] == "ScriptDuration"))


def change_times(browser: Any, path: Path, *, draws: bool) -> tuple[list[float], float]:
    """Milliseconds of changes of colours on a page, and those of the script for each."""
    page = browser.new_page(viewport={"width": 1280, "height": 1000})
    if not draws:
        page.add_init_script(_NO_DRAWING)
    page.goto(path.as_uri())
    page.wait_for_function("() => document.querySelector('#mode').length && document.querySelector('.qgeo-view')")
    page.wait_for_timeout(1000)
    script = Script(page)
    before = script.milliseconds()
    times: list[float] = page.evaluate(_CHANGE)
    spent = (script.milliseconds() - before) / len(times)
    page.close()
    return times, spent


def live_times(browser: Any, mesh: qg.Surface, folder: Path) -> tuple[list[float], float]:
    """The same of changes of limits in JupyterLab, in which nothing is drawn."""
    mesh.write(folder / "mesh.ply")
    page = browser.new_page(viewport={"width": 1280, "height": 1000})
    page.add_init_script(_NO_DRAWING)
    server = tools.lab(folder)
    try:
        tools.Notebook(page, server, "large.ipynb", [_CELL])
        page.wait_for_function("() => window.drawnAt", timeout=tools.PATIENCE)
        page.wait_for_timeout(5000)
        limits = [np.quantile(mesh.vertices[:, 2], [0.01 * k, 0.9]).tolist() for k in range(1, 12)]
        page.evaluate(_LIVE, limits[0])
        script = Script(page)
        before = script.milliseconds()
        times = [page.evaluate(_LIVE, each) for each in limits[1:]]
        return times, (script.milliseconds() - before) / len(times)
    finally:
        server.stop()
        page.close()


def both(times: list[float]) -> str:
    """Median and longest."""
    return f"{np.median(times):.0f} / {max(times):.0f} ms"


def main(record: Record) -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=Path)
    mesh = qg.Surface.read(parser.parse_args(record.arguments).mesh)
    x = qg.Surface(mesh.vertices, mesh.faces, {"height": mesh.vertices[:, 2]})
    y = x.with_vertices(x.vertices @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]))
    table = record.table(f"{x.n_vertices} vertices on each side", "what", "how much")
    start = time.perf_counter()
    widget = qw.compare(x, y, p2p=np.arange(x.n_vertices))
    table.row("widget made", f"{time.perf_counter() - start:.2f} s")
    widget.mode = "attribute: height"
    start = time.process_time()
    for k in range(1, 11):
        widget.limits = tuple(np.quantile(x.attributes["height"], [0.01 * k, 0.9]).tolist())
    kernel = 100 * (time.process_time() - start)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = Path(folder) / "page.html"
        widget.to_html(path, modes=["colours carried from X to Y", "attribute: height"])
        table.row("page", f"{path.stat().st_size / 1e6:.2f} MB")
        browser = playwright.chromium.launch(executable_path=tools.chromium(), args=tools.CHROMIUM_FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 1000})
        start = time.perf_counter()
        page.goto(path.as_uri())
        tools.until(lambda: tools.pixels(page.locator(".qgeo-view").first).std() > 15)
        table.row("page opened and drawn", f"{time.perf_counter() - start:.1f} s")
        page.close()
        drawn, _ = change_times(browser, path, draws=True)
        table.row("page: colours changed, drawn in software: median / longest", both(drawn))
        times, script = change_times(browser, path, draws=False)
        table.row("the same without drawing", both(times))
        table.row("of that, the page's script", f"{script:.1f} ms")
        times, script = live_times(browser, x, Path(folder))
        table.row("JupyterLab: limits changed, without drawing", both(times))
        table.row("of that, kernel / script of the whole page", f"{kernel:.0f} / {script:.0f} ms")
        browser.close()


if __name__ == "__main__":
    with recorded() as record:
        main(record)
