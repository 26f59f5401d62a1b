"""The widget of self-symmetry, driven through its traits."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import shapes

import qgeo_widgets as qw
from qgeo_filters import Surface
from qgeo_filters.matching.symmetry_measure import symmetry_regions, symmetry_sum
from qgeo_widgets import symmetry_widget as names


@pytest.fixture(scope="module")
def surface() -> Surface:
    """A shape that the mirror x -> -x maps to itself, vertex by vertex."""
    vertices, faces = shapes.icosphere(3)
    radius = 1 + 0.3 * vertices[:, 1] + 0.2 * vertices[:, 2] ** 2 + 0.15 * vertices[:, 1] * vertices[:, 2]
    return Surface(vertices * radius[:, None], faces)


@pytest.fixture(scope="module")
def mirror(surface) -> SimpleNamespace:
    """What `self_symmetry` finds on it."""
    far = np.linalg.norm(surface.vertices[:, None] * [-1, 1, 1] - surface.vertices, axis=2)
    p2p = far.argmin(axis=1)
    assert far.min(axis=1).max() < 1e-12
    side = np.where(np.abs(surface.vertices[:, 0]) < 1e-9, 0, np.sign(surface.vertices[:, 0])).astype(np.int8)
    return SimpleNamespace(found=True, reason="", p2p=p2p, side=side, asymmetry=np.abs(surface.vertices[:, 0]))


@pytest.fixture
def widget(surface, mirror):
    widget = qw.symmetry(surface, symmetry=mirror)
    assert widget.message == ""
    yield widget
    widget.close()


def test_mirror_images_have_one_color(widget, mirror):
    colors = widget._viewer.panes[0].colors
    assert widget.mode == names.MIRRORED
    np.testing.assert_allclose(colors, colors[mirror.p2p], atol=1e-6)
    assert len(np.unique(colors.round(4), axis=0)) > 100


def test_second_pane_shows_the_back(widget):
    front, back = (pane.placement for pane in widget._viewer.panes)
    np.testing.assert_allclose(back.axes[1], front.axes[1])
    np.testing.assert_allclose(back.axes[[0, 2]], -front.axes[[0, 2]])
    np.testing.assert_array_equal(widget._viewer.panes[0].colors, widget._viewer.panes[1].colors)


def test_a_pick_shows_its_mirror_image_on_both_panes(widget, surface, mirror):
    widget._viewer.panes[1]._on_pick[0](77)
    assert widget.picked == 77
    assert widget.image == mirror.p2p[77]
    for pane in widget._viewer.panes:
        np.testing.assert_allclose(pane.marks["image"][0], pane.marks["picked"][0] * [-1, 1, 1], atol=1e-9)
    assert f">{mirror.p2p[77]}</td>" in widget._info.value
    with pytest.raises(ValueError, match="picked is vertex 642"):
        widget.picked = surface.n_vertices


def test_the_axis_is_the_mirror_plane(widget):
    lines = widget._viewer.panes[0].lines
    assert list(lines) == ["axis 0"]
    curve = lines["axis 0"][0]
    np.testing.assert_array_equal(curve[0], curve[-1])
    np.testing.assert_allclose(curve[:, 0], 0, atol=1e-9)


def test_sides_have_two_colors_and_the_axis_a_third(widget, mirror):
    widget.mode = names.SIDES
    colors = widget._viewer.panes[0].colors
    for value in (-1, 0, 1):
        assert len(np.unique(colors[mirror.side == value], axis=0)) == 1
    assert len(np.unique(colors, axis=0)) == 3
    for name in ("side A", "side B", "on the axis"):
        assert name in widget._legend.value


def test_regions_follow_epsilon_and_k0(widget):
    widget.mode = names.REGIONS
    assert widget._epsilon_slider.layout.display == ""
    assert len(widget._field.key) <= 8
    spectrum = widget._shape.spectrum
    for epsilon, k0 in ((widget.epsilon, 20), (0.5 * widget.epsilon, 20), (0.5 * widget.epsilon, 5)):
        widget.epsilon, widget.k0 = epsilon, k0
        regions = symmetry_regions(spectrum, epsilon=epsilon, k0=k0)
        colors = widget._viewer.panes[0].colors
        for number in np.unique(regions):
            assert len(np.unique(colors[regions == number], axis=0)) == 1
        assert f"first {k0} eigenfunctions" in widget._legend.value
    for bad in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="epsilon must be a finite number above 0"):
            widget.epsilon = bad
    assert widget.epsilon == epsilon
    widget.mode = names.SUM
    np.testing.assert_allclose(widget._field.values[0], symmetry_sum(spectrum, 5))
    assert widget._epsilon_slider.layout.display == "none"


def test_asymmetry_is_what_was_given(widget, mirror):
    widget.mode = names.ASYMMETRY
    np.testing.assert_array_equal(widget._field.values[0], mirror.asymmetry)


def test_a_shape_without_symmetry_says_so_and_shows_regions(surface):
    none = SimpleNamespace(found=False, reason="no map keeps the distances", p2p=np.arange(642))
    widget = qw.symmetry(surface, symmetry=none)
    assert widget.message.startswith("No self-symmetry: no map keeps the distances. ")
    assert widget.mode == names.REGIONS
    assert names.MIRRORED not in widget.modes
    widget.picked = 3
    assert widget.image is None
    widget.close()


def test_a_mesh_in_two_pieces_is_a_sentence(surface):
    vertices = np.concatenate([surface.vertices, surface.vertices + 5.0])
    faces = np.concatenate([surface.faces, surface.faces + surface.n_vertices])
    widget = qw.symmetry((vertices, faces))
    assert "one piece" in widget.message
    widget.close()


def test_the_page_links_mirror_images(widget, mirror, tmp_path):
    widget.to_html(tmp_path / "page.html", modes=[names.MIRRORED, names.SIDES])
    assert "its mirror image is marked" in (tmp_path / "page.html").read_text()


def test_closing_frees_everything(surface, mirror, counted):
    widget = qw.symmetry(surface, symmetry=mirror)
    widget.picked = 5
    assert counted() > 50
    widget.close()
    assert counted() == 0
