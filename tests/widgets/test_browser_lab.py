"""The widgets in a real JupyterLab, by mouse, in a headless Chromium."""

from __future__ import annotations

import time

import browser as tools
import numpy as np
import pytest
import shapes

from qgeo_filters import Surface
from qgeo_widgets.compared_colors import TEXTURE
from qgeo_widgets.rendering.backends import new_viewer
from qgeo_widgets.rendering.scene_placement import placement_of

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def books(chromium, lab, pair):
    """Function that gives the notebook of a backend, which is opened once: that takes longer than most tests."""
    opened = {}

    def book_of(backend):
        if backend not in opened:
            x, y, where = pair
            x.write(lab.folder / "x.ply")
            y.write(lab.folder / "y.ply")
            np.save(lab.folder / "where.npy", where)
            load = (
                "import numpy as np, qgeo_filters as qg, qgeo_widgets as qw\n"
                f"qw.backend({backend!r})\n"
                "x, y, where = qg.Surface.read('x.ply'), qg.Surface.read('y.ply'), np.load('where.npy')"
            )
            page = chromium.new_context(viewport={"width": 1280, "height": 1000}).new_page()
            opened[backend] = tools.Notebook(page, lab, f"{backend}.ipynb", [load])
        return opened[backend]

    yield book_of
    for book in opened.values():
        book.page.context.close()


@pytest.fixture
def book(books, each_backend):
    """A notebook in which x, y and where are known; the widget w of the test is closed after it."""
    book = books(each_backend)
    yield book
    book.python("w.close()")


def place_on_screen(surface, vertex: int, size: tuple[int, int], canvas) -> tuple[float, float]:
    """Where on the page the first view shows a vertex, and that it faces the viewer."""
    viewer = new_viewer([surface], [placement_of(surface)], size, ["X"])
    camera, placement = np.array(viewer.home), viewer.panes[0].placement
    viewer.close()
    x, y, z = placement.to_scene(surface.vertices[vertex])
    slope = np.tan(np.radians(26.0 / 2)) * (camera[2] - z)
    box = canvas.bounding_box()
    right = box["x"] + box["width"] * 0.5 * (1 + x / (slope * size[0] / size[1]))
    return right, box["y"] + box["height"] * 0.5 * (1 - y / slope)


def front_vertices(surface) -> list[int]:
    """Vertices that look at the viewer in the first view, most of all first."""
    return np.argsort(-(surface.vertex_normals @ placement_of(surface).axes[2])).tolist()


def test_compare_by_mouse(book, pair):
    x, _, where = pair
    page = book.page
    book.show("w = qw.compare(x, y, p2p=where, truth=where)\nw")
    left, right = book.canvases(2)
    before_left, before_right = tools.settled(left), tools.settled(right)

    # A drag on one view turns both while it lasts, and is no click, even if it is held still at its end.
    tools.drag(page, right, 70, 25, release=False)
    tools.until(lambda: np.abs(tools.pixels(left) - before_left).mean() > 1)
    tools.until(lambda: np.abs(tools.pixels(right) - before_right).mean() > 1)
    time.sleep(1.0)
    page.mouse.up()
    tools.until(lambda: book.python("print(w.camera != w._viewer.home)") == "True")
    assert book.python("print(w.picked)") == "None"
    page.get_by_role("button", name="reset view").click()
    tools.until(lambda: book.python("print(np.allclose(w.camera, w._viewer.home))") == "True")
    tools.until(lambda: np.abs(tools.pixels(left) - before_left).mean() < 0.5)

    # A click gives Python the vertex under the mouse, marks its partner, and shows distances.
    vertex = front_vertices(x)[0]
    page.mouse.click(*place_on_screen(x, vertex, (440, 400), left))
    seen = f"('x', {vertex}) [({vertex}, {where[vertex]})] distance from the picked point"
    tools.until(lambda: book.python("print(w.picked, w.pairs, w.mode)") == seen)
    for canvas, before in ((left, before_left), (right, before_right)):
        tools.until(lambda canvas=canvas, before=before: np.abs(tools.pixels(canvas) - before).mean() > 3)
    # The red ball stands in the middle of the darkest blue on both shapes.
    for canvas in (left, right):
        picture = tools.settled(canvas)
        assert ((picture[..., 0] > 150) & (picture[..., 1] < 70) & (picture[..., 2] < 80)).sum() > 20
    page.get_by_text(f"vertex {where[vertex]}", exact=True).wait_for()

    # A second click draws a path on both shapes and tells its length.
    second = next(v for v in front_vertices(x) if np.linalg.norm(x.vertices[v] - x.vertices[vertex]) > 0.5)
    page.mouse.click(*place_on_screen(x, second, (440, 400), left))
    tools.until(lambda: book.python("print(w.second)") == f"('x', {second})")
    page.get_by_text("quasi-geodesic", exact=True).wait_for()

    # The list of modes and the slider change the colours.
    page.get_by_label("colour").select_option("eigenfunction")
    tools.until(lambda: book.python("print(w.mode, w.k)") == "eigenfunction 1")
    first = tools.settled(left)
    page.get_by_text("φ₁").first.wait_for()  # the sliders are those of the mode
    page.locator(".widget-slider:visible .noUi-handle").first.press("ArrowRight")
    tools.until(lambda: book.python("print(w.k)") == "2")
    tools.until(lambda: np.abs(tools.pixels(left) - first).mean() > 3)

    # A mistake is a sentence on the page.
    assert book.python("w.mode = 'attribute: weight'") == ""
    page.get_by_text("There is no attribute 'weight' here").wait_for()

    # Closing takes the canvases away and leaves no widget behind.
    book.python("from ipywidgets.widgets.widget import _instances\nw.close()")
    tools.until(lambda: page.locator(tools.CANVAS).count() == 0)
    assert book.python("print(len(_instances))") == "0"


@pytest.mark.slow
def test_matrix_by_mouse(book, pair):
    page = book.page
    book.show("w = qw.matrix(x)\nw")
    matrix, shape = book.canvases(2)
    before = tools.settled(shape)
    box = matrix.bounding_box()
    rows = len(pair[0].vertices)
    for fraction in (0.2, 0.7):
        page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + fraction * box["height"])
        tools.until(lambda f=fraction: abs(int(book.python("print(w.row)")) - f * rows) < 3)
    assert book.python("print(w.mode, w.picked == w._vertex_of_row[w.row])") == "distances of the row True"
    tools.until(lambda: np.abs(tools.pixels(shape) - before).mean() > 3)
    first = tools.settled(matrix)
    book.python("w.limits = (0.0, 0.3)")  # the matrix has the scale of the shape
    tools.until(lambda: np.abs(tools.pixels(matrix) - first).mean() > 10)


@pytest.mark.slow
def test_geodesics_by_mouse(book, pair):
    x = pair[0]
    page = book.page
    book.show("w = qw.geodesics(x)\nw")
    (canvas,) = book.canvases(1)
    before = tools.settled(canvas)
    source = front_vertices(x)[0]
    target = next(v for v in front_vertices(x) if np.linalg.norm(x.vertices[v] - x.vertices[source]) > 0.6)
    for name, vertex in (("source", source), ("target", target)):
        page.mouse.click(*place_on_screen(x, vertex, (500, 420), canvas))
        tools.until(lambda name=name, vertex=vertex: book.python(f"print(w.{name})") == str(vertex))
    page.get_by_label("geodesic curvature along the path").wait_for()
    tools.until(lambda: np.abs(tools.pixels(canvas) - before).mean() > 0.1)
    length = float(book.python("print(w.path.length)"))
    handle = page.locator(".widget-slider:visible .noUi-handle").first
    for _ in range(10):
        handle.press("ArrowRight")
    tools.until(lambda: float(book.python("print(w.curvature_weight)")) > 0.04)
    assert float(book.python("print(w.path.length)")) > length


@pytest.mark.slow
def test_symmetry_by_mouse(book, lab):
    vertices, faces = shapes.icosphere(3)
    lumpy = vertices * (1 + 0.3 * vertices[:, 1:2] + 0.2 * vertices[:, 2:] ** 2)
    surface = Surface(lumpy, faces)
    mirror = np.linalg.norm(lumpy[:, None] * [-1, 1, 1] - lumpy, axis=2).argmin(axis=1)
    surface.write(lab.folder / "s.ply")
    np.save(lab.folder / "mirror.npy", mirror)
    page = book.page
    book.show(
        "from types import SimpleNamespace\n"
        "s, T = qg.Surface.read('s.ply'), np.load('mirror.npy')\n"
        "sides = np.sign(s.vertices[:, 0].round(6)).astype(int)\n"
        "known = SimpleNamespace(found=True, reason='', p2p=T, side=sides, asymmetry=0.0 * sides)\n"
        "w = qw.symmetry(s, symmetry=known)\nw"
    )
    front, back = book.canvases(2)
    before = tools.settled(front), tools.settled(back)
    tools.drag(page, front, 50, 10, release=False)
    for canvas, old in zip((front, back), before, strict=True):
        tools.until(lambda canvas=canvas, old=old: np.abs(tools.pixels(canvas) - old).mean() > 0.5)
    time.sleep(1.0)
    page.mouse.up()
    assert book.python("print(w.picked)") == "None"
    # A click is one right after a drag too, also if the hand is not quite still.
    tools.drag(page, front, 1, 0)
    tools.until(lambda: book.python("print(w.picked)") != "None")
    page.get_by_role("button", name="reset view").click()
    tools.until(lambda: book.python("print(np.allclose(w.camera, w._viewer.home))") == "True")
    book.python("w.picked = None")
    tools.until(lambda: np.abs(tools.pixels(front) - before[0]).mean() < 0.5)
    vertex = front_vertices(surface)[0]
    page.mouse.click(*place_on_screen(surface, vertex, (440, 400), front))
    tools.until(lambda: book.python("print(w.picked)") == str(vertex))
    assert book.python("print(w.image)") == str(mirror[vertex])
    page.get_by_text("mirror image", exact=True).wait_for()
    page.get_by_label("colour").select_option("regions of eq. (3)")
    tools.until(lambda: book.python("print(w.mode)") == "regions of eq. (3)")
    first = tools.settled(front)
    handle = page.locator(".widget-slider:visible .noUi-handle").first
    for _ in range(6):
        handle.press("ArrowRight")
    tools.until(lambda: np.abs(tools.pixels(front) - first).mean() > 0.5)


@pytest.mark.slow
def test_a_page_without_webgl_shows_a_picture_and_a_sentence(chromium, lab, pair):
    pair[0].write(lab.folder / "x.ply")
    browser = chromium.browser_type.launch(
        executable_path=tools.chromium(), headless=True, args=["--no-sandbox", "--disable-gpu", "--disable-3d-apis"]
    )
    page = browser.new_page(viewport={"width": 1280, "height": 1000})
    cells = ["import qgeo_filters as qg, qgeo_widgets as qw", "w = qw.geodesics(qg.Surface.read('x.ply'))\nw"]
    tools.Notebook(page, lab, "no_webgl.ipynb", cells)
    page.get_by_text("This browser shows no WebGL").wait_for(timeout=tools.PATIENCE)
    picture = page.get_by_alt_text("the shape, drawn in software")
    tools.until(lambda: tools.pixels(picture).std() > 15)
    assert page.get_by_text("This browser shows no WebGL").is_visible()
    browser.close()


@pytest.mark.slow
def test_an_animation_plays_while_the_kernel_is_busy(book):
    page = book.page
    book.show(
        "frames = [x.with_vertices(x.vertices * [1, 1, 1 + 0.4 * k]) for k in range(4)]\n"
        "w = qw.animate(frames, seconds=2.0)\nw"
    )
    (canvas,) = book.canvases(1)
    first = tools.settled(canvas)
    page.locator(".widget-slider:visible .noUi-handle").first.press("End")
    tools.until(lambda: book.python("print(w.time, w.frame)") == "3.0 3")
    tools.until(lambda: np.abs(tools.pixels(canvas) - first).mean() > 1)
    book.python("w.frame = 0")
    tools.until(lambda: np.abs(tools.pixels(canvas) - first).mean() < 0.1)

    page.get_by_title("play or pause").click()
    tools.until(lambda: book.python("print(w.playing, w.time > 0)") == "True True")
    page.evaluate(
        """() => {
            const kernel = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
            window.busy = true;
            kernel.requestExecute({code: 'import time; time.sleep(15)'}).done.then(() => { window.busy = false; });
        }"""
    )
    time.sleep(0.5)
    before = tools.pixels(canvas)
    tools.until(lambda: np.abs(tools.pixels(canvas) - before).mean() > 0.5)
    assert page.evaluate("window.busy")
    page.get_by_title("play or pause").click()
    tools.until(lambda: book.python("print(w.playing)") == "False")
    still = tools.settled(canvas)
    time.sleep(1.0)
    np.testing.assert_array_equal(tools.pixels(canvas), still)
    book.python("w.time = 0.0")
    tools.until(lambda: np.abs(tools.pixels(canvas) - first).mean() < 0.1)


@pytest.mark.slow
def test_a_region_is_painted_by_dragging(books, pair):
    book = books("webgl")
    page = book.page
    book.show("w = qw.compare(x, y, p2p=where)\nw")
    left, right = book.canvases(2)
    before = tools.settled(right)
    page.get_by_label("paint").check()
    tools.until(lambda: book.python("print(w.brush, w._viewer._scene.brush)") == "True True")
    camera = book.python("print(w.camera)")
    tools.drag(page, left, 110, 30)
    tools.until(lambda: int(book.python("print(len(w.painted))")) > 1)
    assert book.python("print(w.camera)") == camera  # nothing was turned
    assert book.python("print(w.mode, w.picked)") == "painted region None"
    tools.until(lambda: np.abs(tools.pixels(right) - before).mean() > 1)
    page.get_by_role("button", name="wipe").click()
    tools.until(lambda: book.python("print(len(w.painted))") == "0")
    book.python("w.close()")


@pytest.mark.slow
def test_limits_stay_what_they_were_set_to_and_a_lost_canvas_is_drawn_anew(books, pair):
    """The browser's slider has steps: it answered limits between them with its own, and all was drawn twice."""
    book = books("webgl")
    page = book.page
    book.show("w = qw.compare(x, y, p2p=where, texture=np.arange(48, dtype=np.uint8).reshape(4, 4, 3) * 5)\nw")
    book.canvases(2)
    book.python("w.mode = 'attribute: height'\nsent = []\nw._viewer._scene.observe(sent.append, 'paints')")
    low, high = np.quantile(pair[0].attributes["height"], [0.2137, 0.7911]).tolist()
    book.python(f"w.limits = ({low!r}, {high!r})")
    page.wait_for_timeout(1000)
    assert book.python("print(w.limits, len(sent))") == f"({low!r}, {high!r}) 1"

    page.evaluate(
        """() => { window.others = Array.from({length: 24}, () => {
            const canvas = document.createElement('canvas');
            canvas.getContext('webgl2').clear(16384);
            return canvas;
        }); }"""
    )
    page.get_by_role("button", name="draw anew").click()
    left, _ = book.canvases(2)
    assert not page.get_by_role("button", name="draw anew").is_visible()
    before = tools.settled(left)
    book.python(f"w.mode = {TEXTURE!r}")  # the new view follows the model, and has its texture
    tools.until(lambda: np.abs(tools.pixels(left) - before).mean() > 3)
    assert np.abs(tools.settled(left)[..., 0] - tools.settled(left)[..., 2]).max() < 40  # dark grey, as the texture is
    book.python("w.close()\ndel sent")


@pytest.mark.slow
def test_on_a_telephone_nothing_is_cut_off_and_a_finger_turns(chromium, lab, pair):
    x, y, where = pair
    x.write(lab.folder / "x.ply")
    y.write(lab.folder / "y.ply")
    np.save(lab.folder / "where.npy", where)
    size = {"width": 390, "height": 844}
    page = chromium.new_context(viewport=size, has_touch=True, is_mobile=True, device_scale_factor=2).new_page()
    load = (
        "import numpy as np, qgeo_filters as qg, qgeo_widgets as qw\n"
        "x, y, where = qg.Surface.read('x.ply'), qg.Surface.read('y.ply'), np.load('where.npy')"
    )
    book = tools.Notebook(page, lab, "telephone.ipynb", [load])
    book.show("w = qw.compare(x, y, p2p=where)\nw")
    first, second = book.canvases(2)
    boxes = first.bounding_box(), second.bounding_box()
    assert boxes[0]["x"] == boxes[1]["x"]
    assert boxes[0]["y"] + boxes[0]["height"] <= boxes[1]["y"]
    output = page.locator(".jp-OutputArea-output:has(.qgeo-view)").first
    for mode in sorted(book.python("print(*w.modes, sep='\\n')").splitlines(), key="eigenfunction".__eq__):
        book.python(f"w.mode = {mode!r}")
        page.wait_for_timeout(300)
        widths = output.evaluate("e => [e.scrollWidth, e.clientWidth]")
        assert widths[0] <= widths[1] + 1, mode
    bar = page.locator('.widget-html-content [style*="linear-gradient(to right"]').first
    assert bar.bounding_box()["width"] > 200
    before = tools.settled(first)
    box = first.bounding_box()
    across, down = (box["x"] + 0.4 * box["width"], box["x"] + 0.6 * box["width"]), box["y"] + box["height"] / 2
    tools.Fingers(page).move(((across[0], down), (across[1], down)))
    tools.until(lambda: np.abs(tools.pixels(first) - before).mean() > 1)
    tools.until(lambda: book.python("print(w.camera != w._viewer.home)") == "True")
    page.context.close()
