"""A page of a large mesh: megabytes, seconds until it shows, milliseconds of a change of colours; needs Chromium.

    python benchmarks/widgets_large.py MESH [--json results/widgets_large.json]

The mesh is compared with itself, turned, in two modes. A change of colours is from the choice in the list to the
picture after the next, in a headless Chromium that draws in software: a graphics card is quicker. Beside it, in
the kernel: seconds until the widget of two such meshes is made, and those of a change of limits until all is sent.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

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
    seconds.push(performance.now() - start);
  }
  return seconds;
}"""


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
    start = time.perf_counter()
    widget.limits = tuple(np.quantile(x.attributes["height"], [0.2, 0.8]).tolist())
    table.row("limits changed, all sent", f"{1000 * (time.perf_counter() - start):.0f} ms")
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
        times = page.evaluate(_CHANGE)
        table.row("colours changed, drawn: median / longest", f"{np.median(times):.0f} / {max(times):.0f} ms")
        browser.close()


if __name__ == "__main__":
    with recorded() as record:
        main(record)
