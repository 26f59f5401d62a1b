"""The pictures of the widgets in the README: what a browser shows of a notebook in JupyterLab.

    python benchmarks/readme_widgets.py [FOLDER]

writes widget_compare.png, widget_symmetry.png, widget_geodesics.png and widget_matrix.png, by default into docs/images.
The cows are those of readme_pictures.py. Needs chromium and what the extra [test] installs.
"""

from __future__ import annotations

import io
import sys
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image, ImageChops
from playwright.sync_api import sync_playwright
from readme_pictures import LARGEST, posed_cow

import qgeo_filters as qg
from qgeo_filters.atomic import atomic_write
from qgeo_filters.cli.demo import cow

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

import browser as tools  # noqa: E402

LOAD = "import qgeo_filters as qg, qgeo_widgets as qw\nx, y = qg.Surface.read('x.ply'), qg.Surface.read('y.ply')"
FLANK, FOREFOOT, HIP = 1703, 855, 1738  # vertices of the cow
#: What is typed into each notebook, and how many canvases appear.
NOTEBOOKS = {
    "widget_compare": (f"w = qw.compare(x, y)\nw.picked, w.second = ('x', {FLANK}), ('x', {FOREFOOT})\nw", 2),
    "widget_symmetry": (f"w = qw.symmetry(x)\nw.picked = {FLANK}\nw", 2),
    "widget_geodesics": (f"w = qw.geodesics(x, source={HIP}, target={FOREFOOT}, curvature_weight=0.1)\nw", 1),
    "widget_matrix": ("w = qw.matrix(x)\nw.row = 530\nw", 2),
}


def photographed(page: Any, server: tools.Server, name: str) -> Image.Image:
    """What the page shows of the widget of one notebook, once it has stopped changing."""
    cell, canvases = NOTEBOOKS[name]
    book = tools.Notebook(page, server, f"{name}.ipynb", [LOAD, cell])
    shown = book.canvases(canvases)
    message = book.python("print(w.message)")
    if message:
        raise RuntimeError(f"{name}: {message}")
    page.mouse.move(2, 2)  # over nothing that would light up
    for canvas in shown:
        tools.settled(canvas)
    return Image.open(io.BytesIO(page.locator(".jp-OutputArea-output .widget-vbox").first.screenshot())).convert("RGB")


def write(picture: Image.Image, path: Path) -> None:
    """Save as PNG without the margin at the right and below, with fewer pixels until the file is small enough."""
    paper = Image.new("RGB", picture.size, picture.getpixel((picture.width - 1, picture.height - 1)))
    *_, right, bottom = ImageChops.difference(picture, paper).getbbox() or (0, 0, *picture.size)
    picture = picture.crop((0, 0, right, bottom))
    data, width = _png(picture), picture.width
    while len(data) > LARGEST:
        width = int(0.95 * width)
        data = _png(picture.resize((width, picture.height * width // picture.width), Image.Resampling.LANCZOS))
    with atomic_write(path) as file:
        file.write(data)
    sys.stdout.write(f"{path.name}  {len(data) // 1000} kB\n")


def _png(picture: Image.Image) -> bytes:
    buffer = io.BytesIO()
    picture.save(buffer, format="png", optimize=True)
    return buffer.getvalue()


def main(folder: Path) -> None:
    """Make all of them."""
    folder.mkdir(parents=True, exist_ok=True)
    surface = qg.Surface.read(cow())
    with tempfile.TemporaryDirectory() as temporary, sync_playwright() as playwright:
        surface.write(Path(temporary) / "x.ply")
        posed_cow(surface).write(Path(temporary) / "y.ply")
        browser = playwright.chromium.launch(executable_path=tools.chromium(), headless=True, args=tools.CHROMIUM_FLAGS)
        server = tools.lab(Path(temporary))
        try:
            for name in NOTEBOOKS:
                context = browser.new_context(viewport={"width": 1280, "height": 1200})
                write(photographed(context.new_page(), server, name), folder / f"{name}.png")
                context.close()
        finally:
            server.stop()
            browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "images")
