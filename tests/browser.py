"""JupyterLab, Voila and a headless Chromium for the tests of the widgets: start, run cells, look, click."""

from __future__ import annotations

import io
import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.image
import nbformat
import numpy as np

CHROMIUM_FLAGS = [
    "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-background-networking", "--no-first-run",
]  # fmt: skip
CANVAS = ".qgeo-view, canvas.qgeo-matrix, .jupyter-threejs canvas"  # of either backend
PATIENCE = 120_000


def chromium() -> str | None:
    """Path of the system's Chromium, None without one."""
    return shutil.which("chromium") or shutil.which("chromium-browser")


def write_notebook(path: Path, cells: Sequence[str]) -> None:
    """Notebook of code cells."""
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
    nbformat.write(notebook, path)


class Server:
    """A Jupyter server in a folder of its own; neither its settings nor its port are anybody else's."""

    def __init__(self, command: Sequence[str], folder: Path, status: str) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}"
        self.folder = folder
        config = folder / ".config"
        (config / "labconfig").mkdir(parents=True, exist_ok=True)
        # No dialog over everything: Open3D brings a source extension, for which Lab would ask to be built, and Lab
        # asks whether it may fetch news.
        settings = {
            "buildCheck": False,
            "buildAvailable": False,
            "disabledExtensions": {"@jupyterlab/apputils-extension:announcements": True},
        }
        (config / "labconfig" / "page_config.json").write_text(json.dumps(settings))
        environment = {
            **os.environ,
            "JUPYTER_CONFIG_DIR": str(config),
            "JUPYTER_RUNTIME_DIR": str(folder / ".runtime"),
            "JUPYTERLAB_SETTINGS_DIR": str(folder / ".settings"),
            "JUPYTERLAB_WORKSPACES_DIR": str(folder / ".workspaces"),
            "OPEN3D_DISABLE_WEB_VISUALIZER": "true",
        }
        self._log = (folder / "server.log").open("wb")
        self._process = subprocess.Popen(
            [sys.executable, "-m", *(part.format(port=self.port, folder=folder) for part in command)],
            env=environment, cwd=folder, stdout=self._log, stderr=subprocess.STDOUT,
        )  # fmt: skip
        self._wait(self.url + status)

    def _wait(self, url: str) -> None:
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        for _ in range(240):
            try:
                opener.open(url, timeout=5).close()
                return
            except OSError:
                if self._process.poll() is not None:
                    break
                time.sleep(0.25)
        raise RuntimeError(f"the server did not come up:\n{(self.folder / 'server.log').read_text()[-2000:]}")

    def stop(self) -> None:
        """End the server and its kernels."""
        self._process.terminate()
        try:
            self._process.wait(20)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._log.close()


def lab(folder: Path) -> Server:
    """JupyterLab on the notebooks of a folder."""
    return _jupyter("jupyterlab", folder)


def notebook(folder: Path) -> Server:
    """Jupyter Notebook 7 on the notebooks of a folder."""
    return _jupyter("notebook", folder)


def _jupyter(application: str, folder: Path) -> Server:
    command = [
        application, "--expose-app-in-browser", "--no-browser", "--allow-root", "--ServerApp.ip=127.0.0.1",
        "--ServerApp.port={port}", "--ServerApp.port_retries=0", "--IdentityProvider.token=",
        "--ServerApp.root_dir={folder}",
    ]  # fmt: skip
    return Server(command, folder, "/api/status")


def voila(folder: Path, name: str) -> Server:
    """Voila on one notebook of a folder."""
    command = ["voila", "--no-browser", "--port={port}", "--Voila.ip=127.0.0.1", name]
    return Server(command, folder, "/voila/static/voila.js")


class Notebook:
    """A notebook that is open in JupyterLab, or in Notebook 7 with ``tree="notebooks"``, and has been run."""

    def __init__(self, page: Any, server: Server, name: str, cells: Sequence[str], tree: str = "lab/tree") -> None:
        self.page = page
        write_notebook(server.folder / name, cells)
        page.goto(f"{server.url}/{tree}/{name}?reset", timeout=PATIENCE)
        page.wait_for_function("() => window.jupyterapp", timeout=PATIENCE)
        page.evaluate("async () => { await window.jupyterapp.restored }")
        page.wait_for_function(
            """() => {
                const panel = window.jupyterapp.shell.currentWidget;
                return panel && panel.sessionContext && panel.sessionContext.session
                    && panel.sessionContext.session.kernel && panel.sessionContext.session.kernel.status === 'idle';
            }""",
            timeout=PATIENCE,
        )
        if tree == "lab/tree":
            page.evaluate("() => window.jupyterapp.commands.execute('application:toggle-left-area')")
        page.evaluate("() => window.jupyterapp.commands.execute('notebook:run-all-cells')")

    def python(self, code: str) -> str:
        """What the code prints in the notebook's kernel."""
        return self.page.evaluate(
            """async (code) => {
                const kernel = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
                const future = kernel.requestExecute({code, store_history: false});
                let text = '';
                future.onIOPub = (m) => {
                    if (m.header.msg_type === 'stream') text += m.content.text;
                    if (m.header.msg_type === 'error') text += m.content.evalue;
                };
                await future.done;
                return text;
            }""",
            code,
        ).strip()

    def show(self, cell: str) -> None:
        """Put this cell in place of all but the first, and run it."""
        self.page.evaluate(
            """async (source) => {
                const panel = window.jupyterapp.shell.currentWidget;
                const cells = panel.content.model.sharedModel;
                cells.deleteCellRange(1, cells.cells.length);
                cells.insertCell(1, {cell_type: 'code', source, metadata: {}, outputs: []});
                panel.content.activeCellIndex = 1;
                await window.jupyterapp.commands.execute('notebook:run-cell');
            }""",
            cell,
        )

    def canvases(self, count: int) -> list[Any]:
        """The live canvases, once there are that many and all of them show something."""
        return live_canvases(self.page, count)


def live_canvases(page: Any, count: int) -> list[Any]:
    """Canvases of the widgets on a page, once that many are there and none is blank."""
    page.wait_for_function(f"() => document.querySelectorAll('{CANVAS}').length >= {count}", timeout=PATIENCE)
    found = page.locator(CANVAS)
    found.first.scroll_into_view_if_needed()
    canvases = [found.nth(k) for k in range(count)]
    for canvas in canvases:
        until(lambda canvas=canvas: pixels(canvas).std() > 15)
    return canvases


def pixels(element: Any) -> np.ndarray:
    """Picture of an element of the page, (h, w, 3) in 0 ... 255."""
    return 255.0 * matplotlib.image.imread(io.BytesIO(element.screenshot()), format="png")[..., :3]


def settled(element: Any) -> np.ndarray:
    """Picture of an element once it has stopped changing."""
    before = pixels(element)
    for _ in range(40):
        time.sleep(0.15)
        after = pixels(element)
        if np.array_equal(before, after):
            return after
        before = after
    return before


def until(condition: Any, seconds: float = 40.0) -> None:
    """Wait for something to become true; AssertionError if it does not."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.1)


def drag(page: Any, element: Any, dx: float, dy: float, *, release: bool = True) -> None:
    """Drag the mouse from the middle of an element."""
    box = element.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 9):
        page.mouse.move(x + dx * step / 8, y + dy * step / 8)
    if release:
        page.mouse.up()


class Fingers:
    """Fingers on a page whose context has touch, through Chromium's own protocol: `page.touchscreen` only taps."""

    def __init__(self, page: Any) -> None:
        self._session = page.context.new_cdp_session(page)

    def move(self, *ways: tuple[tuple[float, float], tuple[float, float]], steps: int = 8) -> None:
        """Put a finger down at the start of each way, bring all to the ends together, and lift them."""
        for step in range(steps + 1):
            share = step / steps
            points = [
                {"x": a + share * (c - a), "y": b + share * (d - b), "id": number}
                for number, ((a, b), (c, d)) in enumerate(ways)
            ]
            self._send("touchStart" if step == 0 else "touchMove", points)
        self._send("touchEnd", [])

    def _send(self, kind: str, points: list[dict[str, float]]) -> None:
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
