"""Shapes for the widgets, and the servers and the browser that all browser tests share."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import browser as tools
import numpy as np
import pytest
import shapes
from ipywidgets import Widget
from known_match import known, without_partners

import qgeo_filters as qg
import qgeo_widgets as qw
from qgeo_filters import Surface

#: Of wraps in tests: few vertices, so that they are matched in a second.
WRAP_ALPHA = 0.07


@pytest.fixture(scope="session")
def pair() -> tuple[Surface, Surface, np.ndarray]:
    """A shape without symmetry, the same turned, scaled, with its vertices shuffled, and the true map."""
    vertices, faces = shapes.blob(2, seed=3)
    shuffle = np.random.default_rng(0).permutation(len(vertices))
    where = np.argsort(shuffle)
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    x = Surface(vertices, faces, {"height": vertices[:, 2]})
    y = Surface(3.0 * vertices[shuffle] @ turn.T + 1.0, where[faces])
    return x, y, where


def hollow(positions: np.ndarray, faces: np.ndarray) -> Surface:
    """A closed shape with a small sphere inside, every third face turned over."""
    ball, ball_faces = shapes.icosphere(1)
    both = np.concatenate([faces, ball_faces + len(positions)])
    both[::3] = both[::3, ::-1]
    return Surface(np.concatenate([positions, 0.25 * ball]), both, {"number": np.arange(len(positions) + len(ball))})


@pytest.fixture(scope="module")
def pair_of_wraps() -> SimpleNamespace:
    """Two hollow shapes, the closed surfaces around them, and a match of those, on the vertices that were given."""
    positions, faces = shapes.creature(level=2)
    x, y = hollow(positions, faces), hollow(shapes.bent(positions, 0.3), faces)
    inside = np.arange(x.n_vertices) >= len(positions)
    same = known(x, y, np.array(y.vertices), p2p=np.arange(x.n_vertices), wrap_x=WRAP_ALPHA, wrap_y=WRAP_ALPHA)
    found = without_partners(same, inside, inside)
    wraps = [qg.wrap_surface(mesh, alpha=WRAP_ALPHA) for mesh in (x, y)]
    for wrap in wraps:
        np.testing.assert_array_equal(wrap.vertex_of_original < 0, inside)
    return SimpleNamespace(x=x, y=y, inside=inside, found=found, wraps=wraps)


@pytest.fixture
def counted() -> Iterator[Any]:
    """How many more widgets are open than when the test began."""
    from ipywidgets.widgets.widget import _instances

    before = set(_instances)
    yield lambda: len(set(_instances) - before)
    for key in set(_instances) - before:
        Widget.close(_instances[key])


@pytest.fixture(params=["webgl", "pythreejs"])
def each_backend(request: pytest.FixtureRequest) -> Iterator[str]:
    """The test is run with each backend."""
    yield qw.backend(request.param)
    qw.backend("webgl")


@pytest.fixture
def pythreejs() -> Iterator[None]:
    """The test is run with the backend of pythreejs."""
    qw.backend("pythreejs")
    yield
    qw.backend("webgl")


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """A headless Chromium; the test is skipped, saying so, where there is none."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="browser tests need playwright")
    path = tools.chromium()
    if path is None:
        pytest.skip("browser tests need chromium: apt-get install chromium")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, headless=True, args=tools.CHROMIUM_FLAGS)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def lab(chromium: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tools.Server]:
    """One JupyterLab for all browser tests."""
    pytest.importorskip("jupyterlab", reason="browser tests need jupyterlab")
    server = tools.lab(tmp_path_factory.mktemp("lab"))
    yield server
    server.stop()


@pytest.fixture
def page(chromium: Any) -> Iterator[Any]:
    """A fresh page of 1280 x 1000 pixels."""
    context = chromium.new_context(viewport={"width": 1280, "height": 1000})
    yield context.new_page()
    context.close()
