"""A large surface is drawn as a proxy; colours, clicks and captions are those of the surface."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob

import qgeo_filters as qg
from qgeo_widgets.rendering import display_mesh
from qgeo_widgets.rendering.backends import new_viewer
from qgeo_widgets.rendering.display_mesh import DisplayMesh
from qgeo_widgets.rendering.scene_placement import placement_of


@pytest.fixture
def surface(monkeypatch: pytest.MonkeyPatch) -> qg.Surface:
    monkeypatch.setattr(display_mesh, "SHOWN_AS_IT_IS", 1000)
    monkeypatch.setattr(display_mesh, "SHOWN_OF_LARGER", 400)
    return qg.Surface(*blob(4, seed=2))


def test_what_the_browser_gets_is_the_proxy(surface: qg.Surface) -> None:
    viewer = new_viewer([surface], [placement_of(surface)], (300, 200), ["<b>shape</b>, 2562 vertices"])
    (pane,) = viewer.panes
    shown = pane.display.shown
    assert 300 < shown.n_vertices < 500
    colors = np.random.default_rng(0).random((surface.n_vertices, 3))
    assert pane.set_colors(colors)
    sent = np.frombuffer(viewer._scene.paints[0]["rgb"], np.uint8).reshape(-1, 3)
    assert sent.shape == (shown.n_vertices, 3)
    np.testing.assert_array_equal(pane.colors, colors.astype(np.float32))  # pictures have all of them
    near = np.linalg.norm(surface.vertices[:, None] - shown.vertices, axis=2).argmin(axis=0)
    assert (sent == np.rint(255 * pane.colors[near])).all(axis=1).mean() > 0.95
    shape = viewer._scene.setup["panes"][0]
    assert f"2562 vertices, drawn as a mesh of {shown.n_vertices}" in shape["title"]
    numbers = np.frombuffer(shape["numbers"], np.int32)  # what is said of a vertex under the mouse
    assert (numbers == near).mean() > 0.95
    viewer.close()


def test_a_click_means_the_nearest_vertex_of_the_surface(surface: qg.Surface) -> None:
    viewer = new_viewer([surface], [placement_of(surface)], (300, 200), [""])
    (pane,) = viewer.panes
    clicked: list[int] = []
    pane.on_pick(clicked.append)
    corners = pane.display.shown.faces[7]
    place = pane.display.shown.vertices[corners].mean(axis=0)
    pane.clicked(corners, pane.placement.to_scene(place))
    assert clicked == [int(np.linalg.norm(surface.vertices - place, axis=1).argmin())]
    viewer.close()


def test_a_small_surface_and_one_without_a_proxy_are_drawn_as_they_are(surface: qg.Surface) -> None:
    small = qg.Surface(*blob(2))
    assert DisplayMesh(small).shown is small
    assert DisplayMesh(small).caption == ""
    two = qg.Surface(
        np.concatenate([surface.vertices, surface.vertices + 9]),
        np.concatenate([surface.faces, surface.faces + surface.n_vertices]),
    )
    assert DisplayMesh(two).shown is two
    assert not DisplayMesh(two).is_proxy


def test_a_placement_goes_back(surface: qg.Surface) -> None:
    placement = placement_of(surface)
    np.testing.assert_allclose(placement.to_surface(placement.to_scene(surface.vertices)), surface.vertices, atol=1e-12)
