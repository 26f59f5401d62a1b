"""Pictures and the report: silhouettes, hidden surfaces and colours that can be computed; pages that stand alone."""

from __future__ import annotations

import base64
import re
from html.parser import HTMLParser
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure
from shapes import grid, icosphere, moebius, torus

from qgeo_filters.errors import MeshError
from qgeo_filters.report import figures, panels
from qgeo_filters.report.charts import matrix_order
from qgeo_filters.report.colors import (
    DIVERGING,
    MISSING,
    ColorScale,
    distinct,
    diverging,
    ordered_colors,
    position_colors,
    sequential,
)
from qgeo_filters.report.glyphs import ball, tube
from qgeo_filters.report.html import Picture, StoredPicture, Table, formatted, report_page, write_report
from qgeo_filters.report.raster import rasterize
from qgeo_filters.report.render import render_mesh
from qgeo_filters.report.shading import corner_normals, crease_darkening, pixel_normals
from qgeo_filters.report.view import best_view, upright_axis, view_from
from qgeo_filters.surface import Surface

FRONT = view_from(0.0, 0.0)  # looks along -z: x to the right, y up


def frozen(*arrays: np.ndarray) -> list[np.ndarray]:
    for array in arrays:
        array.setflags(write=False)
    return list(arrays)


@pytest.fixture(scope="module")
def sphere() -> Surface:
    return Surface(*icosphere(3))


@pytest.fixture(scope="module")
def chords(sphere: Surface) -> np.ndarray:
    """Great-circle distances: a matrix of distances that needs no solver."""
    return np.arccos(np.clip(sphere.vertices @ sphere.vertices.T, -1, 1))


# -- the rasteriser ---------------------------------------------------------------------------------


def test_silhouette_of_a_sphere_has_the_area_of_a_disc() -> None:
    vertices, faces = icosphere(5)
    size = 400
    projection = FRONT.fit(vertices, size, size, margin=0.0)
    covered = (rasterize(projection.project(vertices), faces, size, size).face >= 0).sum()
    # The polyhedron lies inside the sphere: its silhouette is smaller by about the sagitta of an edge, .0003.
    assert covered / (np.pi * (size / 2) ** 2) == pytest.approx(1.0, abs=2e-3)


def test_depth_of_a_sphere_is_its_height() -> None:
    vertices, faces = icosphere(5)
    size = 201
    projection = FRONT.fit(vertices, size, size, margin=0.0)
    seen = rasterize(projection.project(vertices), faces, size, size)
    y, x = np.nonzero(seen.face >= 0)
    inside = (x + 0.5 - size / 2) ** 2 + (y + 0.5 - size / 2) ** 2 < (0.9 * size / 2) ** 2
    y, x = y[inside], x[inside]
    radius = projection.scale
    height = np.sqrt(radius**2 - (x + 0.5 - size / 2) ** 2 - (y + 0.5 - size / 2) ** 2)
    assert np.abs(seen.depth[y, x] - height).max() < 2e-3 * radius


def test_barycentric_weights_reproduce_the_pixel(sphere: Surface) -> None:
    points = FRONT.fit(sphere.vertices, 120, 90).project(sphere.vertices)
    seen = rasterize(points, sphere.faces, 120, 90)
    y, x = np.nonzero(seen.face >= 0)
    position = np.einsum("pc,pci->pi", seen.weights[y, x], points[sphere.faces[seen.face[y, x]]])
    np.testing.assert_allclose(position[:, :2], np.column_stack([x + 0.5, y + 0.5]), atol=1e-3)
    np.testing.assert_allclose(position[:, 2], seen.depth[y, x], rtol=1e-4, atol=1e-3)


def test_no_cracks_between_triangles() -> None:
    vertices, faces = grid(37, jitter=0.4)
    seen = rasterize(view_from(0, 0).fit(vertices, 300, 300, margin=-0.01).project(vertices), faces, 300, 300)
    assert (seen.face >= 0).all()


@pytest.mark.parametrize("reverse", [False, True])
def test_nearer_triangle_hides_the_farther_whatever_the_order(reverse: bool) -> None:
    far = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], float)
    vertices = np.concatenate([far, 0.5 * far + [0, 0, 1]])
    faces = np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    faces = faces[::-1] if reverse else faces
    points = FRONT.fit(vertices, 101, 101).project(vertices)
    seen = rasterize(points, faces, 101, 101)
    near = int(np.flatnonzero(faces[:, 0] == 3)[0])
    assert seen.face[55, 50] == near
    assert seen.face[95, 50] == 1 - near


def test_intersecting_triangles_are_cut_where_they_meet() -> None:
    """Two crossing rectangles: no order of painting whole triangles gives this picture."""
    vertices = np.array([[-1, -1, -1], [1, -1, 1], [1, 1, 1], [-1, 1, -1]], float)
    vertices = np.concatenate([vertices, vertices * [1, 1, -1]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.int32)
    seen = rasterize(FRONT.fit(vertices, 100, 100, margin=0).project(vertices), faces, 100, 100)
    assert (seen.face[:, :49] >= 2).all()  # the second rises to the left
    assert (seen.face[:, 51:] < 2).all()


def test_triangle_partly_outside_is_clipped() -> None:
    points = np.array([[-50.0, 5, 0], [50, -60, 0], [50, 70, 0]])
    seen = rasterize(points, np.array([[0, 1, 2]], np.int32), 10, 10)
    assert (seen.face == 0).all()


# -- rendering --------------------------------------------------------------------------------------


def test_background_and_shape_of_the_picture(sphere: Surface) -> None:
    picture = render_mesh(*frozen(*icosphere(2)), size=(60, 40), background=(0.0, 0.5, 1.0))
    assert picture.shape == (40, 60, 3)
    assert picture.dtype == np.uint8
    assert picture[0, 0].tolist() == [0, 128, 255]


def test_colours_at_known_pixels() -> None:
    vertices, faces = grid(4)
    colors = np.where(vertices[:, :1] < 0.5, [[1.0, 0, 0]], [[0, 0, 1.0]])
    picture = render_mesh(vertices, faces, colors=colors, view=FRONT, size=(101, 101)).astype(int)
    left, right = picture[50, 15], picture[50, 85]
    assert left[0] > 150
    assert left[1] == left[2] < 60
    assert right[2] > 150
    assert right[0] == right[1] < 60


def test_values_become_colours_pixel_by_pixel() -> None:
    """One triangle over the whole scale shows the middle of the scale too, not the mean of its end colours."""
    vertices = np.array([[0, 0, 0], [10, 0, 0], [0, 1, 0]], float)
    values = vertices[:, 0]
    scale = ColorScale(DIVERGING, 0.0, 10.0)
    picture = render_mesh(vertices, [[0, 1, 2]], values, scale=scale, view=FRONT, size=(220, 30), supersample=1) / 255
    x0, x1 = 0.03 * 220, 0.97 * 220
    bottom = 24
    for column in (30, 80, 112, 150):
        expected = scale(10 * (column + 0.5 - x0) / (x1 - x0))
        seen = picture[bottom, column]
        # One lamp for the whole flat triangle: the colour up to brightness.
        assert np.abs(seen / seen.max() - expected / expected.max()).max() < 0.08


def test_both_sides_are_lit_alike() -> None:
    vertices, faces = grid(3)
    front = render_mesh(vertices, faces, view=FRONT, size=(40, 40))
    flipped = render_mesh(vertices, faces[:, ::-1], view=FRONT, size=(40, 40))
    np.testing.assert_array_equal(front, flipped)


def test_a_checkerboard_lies_in_its_coordinates_whatever_the_triangles() -> None:
    vertices = np.array([[0.0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]])
    faces = [[0, 1, 2], [0, 2, 3]]
    white = np.ones((4, 3))
    plain, checkered = (
        render_mesh(vertices, faces, colors=white, cells=cells, view=FRONT, size=(200, 200)).astype(float)[..., 0]
        for cells in (None, vertices)
    )
    rows, columns = (np.flatnonzero((plain < 250).any(axis=axis)) for axis in (1, 0))
    top, left, side = rows[0], columns[0], len(rows)
    centres = (np.arange(4) + 0.5) * side / 4
    at = np.ix_((top + centres).astype(int), (left + centres).astype(int))
    shares = checkered[at] / plain[at]
    even = np.add.outer(np.arange(4), np.arange(4)) % 2 == 0
    dark, light = sorted((even, ~even), key=lambda cells: shares[cells].mean())
    np.testing.assert_allclose(shares[dark], 0.55, atol=0.02)
    np.testing.assert_allclose(shares[light], 1.0, atol=0.02)
    with pytest.raises(ValueError, match="cells have shape"):
        render_mesh(vertices, faces, colors=white, cells=np.zeros((3, 2)))


def test_labels_are_crisp_and_negative_ones_grey() -> None:
    vertices, faces = grid(10)
    labels = np.where(vertices[:, 0] < 0.45, 0, np.where(vertices[:, 0] > 0.75, -1, 1))
    picture = render_mesh(vertices, faces, colors=[[1, 0, 0], [0, 1, 0]], labels=labels, view=FRONT, size=(100, 100))
    colours = {tuple(c) for c in picture[20:80].reshape(-1, 3).tolist()}
    red, green, grey = (picture[50, c].tolist() for c in (20, 60, 90))
    assert red[0] > 2 * red[1]
    assert green[1] > 2 * green[0]
    assert grey[0] == grey[1] == grey[2]
    assert len(colours) < 40  # the three colours, the background, and mixtures at borders only


def test_missing_values_are_grey_and_do_not_spoil_the_rest(sphere: Surface) -> None:
    values = sphere.vertices[:, 1].copy()
    values[sphere.vertices[:, 0] > 0] = np.nan
    picture = render_mesh(sphere.vertices, sphere.faces, values, view=FRONT, size=(100, 100)).astype(int)
    assert np.ptp(picture[50, 80]) == 0
    assert np.ptp(picture[50, 25]) > 40


def test_isolines_have_constant_width_in_the_picture() -> None:
    """Lines of a function whose slope varies ninefold over the square are equally wide everywhere."""
    vertices, faces = grid(60)
    values = vertices[:, 0] ** 2
    levels = [0.15**2, 0.5**2, 0.9**2]
    plain = render_mesh(vertices, faces, values, view=FRONT, size=(300, 300)).astype(float).sum(axis=2)
    lined = render_mesh(vertices, faces, values, view=FRONT, size=(300, 300), isolines=levels).astype(float).sum(axis=2)
    darkness = (1 - lined / plain)[150]
    x = (np.arange(300) + 0.5 - 9) / 282
    widths = [darkness[np.abs(x - position) < 0.03].sum() for position in (0.15, 0.5, 0.9)]
    assert min(widths) > 0.5
    assert max(widths) < 1.15 * min(widths)
    assert darkness[np.abs(x - 0.3) < 0.03].sum() == 0


def test_glyphs_are_hidden_like_the_surface(sphere: Surface) -> None:
    red = (1.0, 0.0, 0.0)

    def redness(z: float) -> int:
        picture = render_mesh(
            sphere.vertices, sphere.faces, glyphs=[ball([0, 0, z], 0.1, red)], view=FRONT, size=(80, 80)
        )
        return int((picture[..., 0].astype(int) - picture[..., 1] > 100).sum())

    assert redness(1.0) > 20
    assert redness(-1.0) == 0
    assert redness(0.5) == 0


def test_crease_darkening_touches_only_what_lies_behind() -> None:
    depth = np.full((60, 60), -np.inf, np.float32)
    depth[:, 5:30] = 0.0
    depth[:, 30:55] = 40.0
    factor = crease_darkening(depth, 4.0)
    assert factor[30, 28] < 0.9
    assert factor[30, 32] == 1.0
    assert factor[30, 8] == pytest.approx(1.0)
    assert (factor[~np.isfinite(depth)] == 1.0).all()


def test_sharp_edges_keep_their_normals_and_round_ones_do_not(sphere: Surface) -> None:
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = np.array(
        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
         [1, 5, 7], [1, 7, 3]], np.int32,
    )  # fmt: skip
    box = Surface(cube, faces)
    np.testing.assert_array_equal(corner_normals(box), np.repeat(box.face_normals[:, None], 3, axis=1))
    np.testing.assert_allclose(corner_normals(sphere), sphere.vertices[sphere.faces], atol=0.02)


def test_normals_turn_to_the_viewer_on_a_surface_without_sides() -> None:
    band = Surface(*moebius())
    view = best_view(band.vertices, band.faces)
    seen = rasterize(view.fit(band.vertices, 90, 90).project(band.vertices), band.faces, 90, 90)
    pixels = type(seen)(*(array[seen.face >= 0] for array in seen))
    normals = pixel_normals(corner_normals(band), pixels, view.axes)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
    assert (normals[:, 2] > -0.2).all()


def test_scale_of_the_mesh_does_not_matter(sphere: Surface) -> None:
    one = render_mesh(sphere.vertices, sphere.faces, view=FRONT, size=(50, 50)).astype(int)
    for factor in (1e-9, 1e9):
        other = render_mesh(factor * sphere.vertices, sphere.faces, view=FRONT, size=(50, 50)).astype(int)
        assert np.abs(one - other).max() <= 1


def test_vertices_without_faces_do_not_change_the_picture(sphere: Surface) -> None:
    far = np.concatenate([sphere.vertices, [[99.0, 99, 99]]])
    np.testing.assert_array_equal(
        render_mesh(far, sphere.faces, size=(40, 40)), render_mesh(sphere.vertices, sphere.faces, size=(40, 40))
    )


def test_one_triangle_and_one_seen_edge_on_are_drawn() -> None:
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    assert (render_mesh(triangle, [[0, 1, 2]], size=(40, 40)) < 255).any()
    edge_on = render_mesh(triangle, [[0, 1, 2]], view=view_from(90, 0), size=(40, 40))
    assert (edge_on == 255).all()


def test_bad_input_is_named(sphere: Surface) -> None:
    V, F = sphere.vertices, sphere.faces
    with pytest.raises(ValueError, match=r"values have shape \(3,\), but there are 642 vertices"):
        render_mesh(V, F, [1, 2, 3])
    with pytest.raises(ValueError, match=r"colors have shape \(2, 3\), expected \(642, 3\)"):
        render_mesh(V, F, colors=np.ones((2, 3)))
    with pytest.raises(ValueError, match="one RGB row for each label up to 4"):
        render_mesh(V, F, colors=np.ones((2, 3)), labels=np.full(642, 4))
    with pytest.raises(ValueError, match="not both"):
        render_mesh(V, F, V[:, 0], colors=np.ones((642, 3)))
    with pytest.raises(ValueError, match="labels need colors"):
        render_mesh(V, F, labels=np.zeros(642, int))
    with pytest.raises(ValueError, match="at least 1 x 1 pixels, got 0 x 15"):
        render_mesh(V, F, size=(0, 5), view=FRONT)
    with pytest.raises(MeshError, match="faces"):
        render_mesh(V, [[0, 1, 999]])


# -- views ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_views_are_rotations_with_the_axis_up(up: str) -> None:
    for azimuth in (0, 75, 200):
        view = view_from(azimuth, 20, up)
        np.testing.assert_allclose(view.axes @ view.axes.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(view.axes) == pytest.approx(1)
        vertical = np.eye(3)["xyz".index(up)]
        assert view.axes[1] @ vertical == pytest.approx(np.cos(np.radians(20)))
        assert abs(view.axes[0] @ vertical) < 1e-14
        np.testing.assert_allclose(view.turned(360).axes, view.axes, atol=1e-12)
        np.testing.assert_allclose(view.turned(30).axes, view_from(azimuth + 30, 20, up).axes, atol=1e-12)
    with pytest.raises(ValueError, match="'x', 'y' or 'z', got 'w'"):
        view_from(0, up="w")


def table(up: int) -> tuple[np.ndarray, np.ndarray]:
    """A slab on a column with a broad foot, standing along one axis."""
    vertices, faces = icosphere(2)
    slab = vertices * [2.0, 1.0, 0.1] + [0, 0, 1.5]
    foot = vertices * [0.6, 0.6, 0.1] + [0, 0, 0.1]
    column = vertices * [0.2, 0.2, 0.8] + [0, 0, 0.8]
    points = np.concatenate([slab, foot, column])
    return np.roll(points, up + 1, axis=1), np.concatenate([faces + k * len(vertices) for k in range(3)])


@pytest.mark.parametrize(("up", "name"), [(1, "y"), (2, "z")])
def test_upright_axis_is_the_one_the_shape_stands_on(up: int, name: str) -> None:
    vertices, _ = table(up)
    assert upright_axis(vertices) == name
    assert upright_axis(1000 * vertices) == name


def test_best_view_looks_at_the_broad_side_from_three_quarters() -> None:
    vertices, faces = table(2)
    view = best_view(vertices, faces.astype(np.int32))
    toward = view.axes[2]
    assert toward[2] > 0  # from above
    # The slab is widest along its long axis: rolled by 3 for up = z, that is x.
    assert np.degrees(np.arctan2(abs(toward[0]), abs(toward[1]))) == pytest.approx(30, abs=15)


# -- colours ----------------------------------------------------------------------------------------


def test_scales() -> None:
    scale = sequential([1.0, np.inf, 3.0])
    assert (scale.low, scale.high) == (1.0, 3.0)
    np.testing.assert_allclose(scale(1.0), matplotlib.colormaps["viridis"](0.0)[:3])
    np.testing.assert_allclose(scale(99.0), matplotlib.colormaps["viridis"](1.0)[:3])
    assert np.ptp(scale(np.nan)) == 0
    both = diverging([-1.0, 4.0], quantile=1.0)
    assert (both.low, both.high) == (-4.0, 4.0)
    assert np.ptp(both(0.0)) < 0.02  # zero has no hue
    assert both(4.0)[0] > both(4.0)[2]
    assert both(-4.0)[2] > both(-4.0)[0]
    assert sequential([]).high == 1.0
    assert diverging([0.0, 0.0]).high == 1.0


def test_lightness_of_the_diverging_scale_is_symmetric_and_monotone() -> None:
    rgb = DIVERGING(np.linspace(0, 1, 65))[:, :3]
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    lightness = np.cbrt(linear @ [0.2126, 0.7152, 0.0722])
    assert (np.diff(lightness[:33]) > 0).all()
    assert (np.diff(lightness[32:]) < 0).all()
    assert np.abs(lightness - lightness[::-1]).max() < 0.08


def test_palettes_tell_apart() -> None:
    for count in (1, 2, 7, 12):
        colors = distinct(count)
        assert colors.shape == (count, 3)
        assert ((colors >= 0) & (colors <= 1)).all()
        gaps = np.linalg.norm(colors[:, None] - colors, axis=2) + 9 * np.eye(count)
        assert gaps.min() > 0.1
    assert distinct(0).shape == (0, 3)


def test_eight_regions_and_the_grey_stay_apart_for_the_color_blind() -> None:
    """By full protanopia, deuteranopia and tritanopia of Machado et al. 2009; distances in CIELAB."""
    colors = np.vstack([distinct(8), [MISSING]])
    simulated = [
        np.eye(3),
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    ]
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    linear = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    for seen in simulated:
        xyz = np.clip(linear @ np.transpose(seen), 0, 1) @ to_xyz.T / [0.9505, 1.0, 1.089]
        f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
        lab = np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)
        gaps = np.linalg.norm(lab[:, None] - lab, axis=2)[np.triu_indices(len(lab), 1)]
        assert gaps.min() > 12  # five times what is just noticed


def test_ordered_colors_are_even() -> None:
    assert np.abs(np.diff(ordered_colors(100) ** 2.2, axis=0)).max() < 0.05  # in light, not in code values


def test_position_colors_are_continuous_and_injective(sphere: Surface) -> None:
    colors = position_colors(sphere.vertices, FRONT.axes)
    assert ((colors >= 0) & (colors <= 1)).all()
    step = np.abs(colors[sphere.edges[:, 0]] ** 2.2 - colors[sphere.edges[:, 1]] ** 2.2)
    assert step.max() < 0.25
    assert len(np.unique(colors.round(3), axis=0)) > 0.9 * sphere.n_vertices


# -- glyphs -----------------------------------------------------------------------------------------


def test_tube_keeps_its_radius_and_ball_its_centre() -> None:
    line = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0.5, 0], [2, 0.5, 1]], float)
    vertices, faces, _ = tube(line, 0.05, (1, 0, 0))
    assert Surface(vertices, faces).is_manifold
    kept = line[[0, 1, 3, 4]]
    radius = np.linalg.norm(vertices.reshape(4, -1, 3) - kept[:, None], axis=2)
    np.testing.assert_allclose(radius, 0.05, rtol=1e-9)
    center = ball([1, 2, 3], 0.5, (1, 0, 0)).vertices
    np.testing.assert_allclose(np.linalg.norm(center - [1, 2, 3], axis=1), 0.5)
    with pytest.raises(ValueError, match="two different points"):
        tube([[0, 0, 0], [0, 0, 0]], 0.1, (1, 0, 0))
    hairpin = tube([[0, 0, 0], [1, 0, 0], [0, 0, 0]], 0.1, (1, 0, 0))
    assert np.isfinite(hairpin.vertices).all()


# -- figures ----------------------------------------------------------------------------------------


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures of fewer pixels, to save time."""
    monkeypatch.setattr(panels, "DPI", 60)


def drawn(figure: Figure) -> np.ndarray:
    """Pixels of a figure; everything in it has been laid out."""
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[..., :3]  # type: ignore[attr-defined]


def labels_of(figure: Figure) -> list[str]:
    return [axes.get_xlabel() + axes.get_ylabel() for axes in figure.axes]


@pytest.mark.usefixtures("coarse")
def test_figures_leave_pyplot_and_its_settings_alone(sphere: Surface) -> None:
    import matplotlib.pyplot as plt

    before, known = dict(matplotlib.rcParams), plt.get_fignums()
    figure = figures.plot_scalar(sphere, sphere.vertices[:, 0])
    assert type(figure) is Figure
    assert dict(matplotlib.rcParams) == before
    assert plt.get_fignums() == known


@pytest.mark.usefixtures("coarse")
def test_plot_scalar_chooses_its_scale_and_names_it(sphere: Surface) -> None:
    signed = figures.plot_scalar(sphere, sphere.vertices[:, 0], "height (m)")
    assert len(signed.axes) == 2
    assert "height (m)" in labels_of(signed)
    low, high = signed.axes[1].get_xlim()
    assert low == -high
    positive = figures.plot_scalar(sphere, 2 + sphere.vertices[:, 0])
    assert positive.axes[1].get_xlim() == (1.0, 3.0)


@pytest.mark.usefixtures("coarse")
def test_plot_eigenfunctions_has_a_panel_each_and_one_scale(sphere: Surface) -> None:
    spectrum = SimpleNamespace(
        eigenvalues=np.array([3.0, -2, -1, 0.5]), eigenfunctions=sphere.vertices[:, [0, 1, 2, 0]]
    )
    figure = figures.plot_eigenfunctions(sphere, spectrum)
    assert len(figure.axes) == 5
    assert "-2" in figure.axes[1].get_title()
    assert drawn(figure).std() > 10
    assert len(figures.plot_eigenfunctions(sphere, spectrum, [1, 2]).axes) == 3
    with pytest.raises(MeshError, match="index is vertex 9"):
        figures.plot_eigenfunctions(sphere, spectrum, [9])


@pytest.mark.usefixtures("coarse")
def test_plot_distance_matrix_shows_the_matrix(sphere: Surface, chords: np.ndarray) -> None:
    figure = figures.plot_distance_matrix(chords)
    image = figure.axes[0].images[0]
    shown = np.asarray(image.get_array())
    order = matrix_order(chords)
    np.testing.assert_allclose(shown, chords[np.ix_(order, order)], atol=1e-12)
    np.testing.assert_allclose(shown, shown.T)
    assert image.get_clim() == (0.0, pytest.approx(np.pi))
    assert "distance (mesh units)" in labels_of(figure)
    beside = figures.plot_distance_matrix(chords, sphere)
    assert len(beside.axes) >= 3
    pixels = drawn(beside)
    assert (pixels[0] == 255).all()  # nothing is cut off at the edges
    assert (pixels[-1] == 255).all()
    with pytest.raises(ValueError, match=r"square, got shape \(2, 3\)"):
        figures.plot_distance_matrix(np.zeros((2, 3)))
    with pytest.raises(ValueError, match="has 642 rows"):
        figures.plot_distance_matrix(chords, order=np.arange(5))


def test_matrix_order_is_a_permutation_that_keeps_neighbours_together(chords: np.ndarray) -> None:
    shuffled = np.random.default_rng(0).permutation(len(chords))
    matrix = chords[np.ix_(shuffled, shuffled)]
    order = matrix_order(matrix)
    np.testing.assert_array_equal(np.sort(order), np.arange(len(chords)))
    steps = matrix[order[:-1], order[1:]]
    assert steps.mean() < 0.35 * matrix[np.arange(641), np.arange(1, 642)].mean()
    line = np.abs(np.subtract.outer(np.arange(1000.0), np.arange(1000.0)))
    assert np.abs(np.diff(matrix_order(line))).max() <= 3  # more rows than are shown
    apart = np.full((6, 6), np.inf)
    apart[:3, :3] = apart[3:, 3:] = 1.0
    np.fill_diagonal(apart, 0)
    assert set(matrix_order(apart[::2, ::2][:2, :2]).tolist()) == {0, 1}
    assert {frozenset(matrix_order(apart)[:3].tolist()), frozenset(matrix_order(apart)[3:].tolist())} == {
        frozenset({0, 1, 2}),
        frozenset({3, 4, 5}),
    }


@pytest.mark.usefixtures("coarse")
def test_plot_spectrum_shows_magnitudes_and_signs() -> None:
    figure = figures.plot_spectrum([4.0, -2.0, 1.0])
    axes = figure.axes[0]
    assert axes.get_yscale() == "log"
    np.testing.assert_allclose(axes.lines[0].get_ydata(), [1, 0.5, 0.25])
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["positive (2)", "negative (1)"]
    with pytest.raises(ValueError, match=r"shape \(k,\)"):
        figures.plot_spectrum([])


@pytest.mark.usefixtures("coarse")
def test_plot_distance_field_names_the_spacing_of_its_lines(sphere: Surface, chords: np.ndarray) -> None:
    figure = figures.plot_distance_field(sphere, chords[7], 7)
    assert "a line every 0.2" in figure.axes[1].get_xlabel()
    assert figure.axes[1].get_xlim() == (0.0, pytest.approx(np.pi))
    pixels = drawn(figure).astype(int)
    assert ((pixels[..., 0] > 170) & (pixels[..., 1] < 60) & (pixels[..., 2] < 80)).sum() > 20  # the source's mark
    far = chords[7].copy()
    far[chords[7] > 2] = np.inf
    assert figures.plot_distance_field(sphere, far).axes[1].get_xlim()[1] <= 2
    with pytest.raises(MeshError, match="vertex 642"):
        figures.plot_distance_field(sphere, chords[0], 642)


@pytest.mark.usefixtures("coarse")
def test_plot_path_draws_on_the_side_that_is_seen(sphere: Surface) -> None:
    for side in (1.0, -1.0):
        angle = np.linspace(0, 1.5, 30)
        points = 1.002 * np.column_stack([np.sin(angle - 0.75), 0 * angle, side * np.cos(angle - 0.75)])
        figure = figures.plot_path(sphere, SimpleNamespace(points=points, length=1.5))
        pixels = drawn(figure).astype(int)
        assert "1.5" in figure.axes[0].get_title()
        assert ((pixels[..., 0] - pixels[..., 1] > 100) & (pixels[..., 2] < 90)).sum() > 300
    assert figures.plot_path(sphere, SimpleNamespace(points=points[:1], length=0.0)).axes


@pytest.mark.usefixtures("coarse")
def test_plot_path_curvature_is_drawn_over_the_way_gone() -> None:
    path = SimpleNamespace(
        points=np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0], [1, 2, 4.0]]), kappa_g=np.array([0.5, -0.25])
    )
    axes = figures.plot_path_curvature(path).axes[0]
    points = axes.lines[-1]
    np.testing.assert_allclose(points.get_xdata(), [1, 3])
    np.testing.assert_allclose(points.get_ydata(), [0.5, -0.25])
    assert axes.get_xlim() == (0.0, 7.0)
    straight = SimpleNamespace(points=np.array([[0, 0, 0], [1.0, 0, 0]]), kappa_g=np.empty(0))
    assert figures.plot_path_curvature(straight).axes[0].get_ylim() == (-1e-3, 1e-3)


@pytest.mark.usefixtures("coarse")
def test_plot_symmetry_gives_matched_places_one_colour() -> None:
    ring = Surface(*torus())
    mirror = np.argmin(np.linalg.norm(ring.vertices[:, None] * [-1, 1, 1] - ring.vertices, axis=2), axis=1)
    figure = figures.plot_symmetry(ring, p2p=mirror)
    assert len(figure.axes) == 2
    assert drawn(figure).std() > 10
    labels = (ring.vertices[:, 1] > 0).astype(int)
    assert len(figures.plot_symmetry(ring, labels, title="regions").axes) == 2
    with pytest.raises(ValueError, match="one of them"):
        figures.plot_symmetry(ring)


def test_symmetric_map_gives_a_mirrored_picture() -> None:
    """Seen along y, the torus coloured by its x-mirror is its own mirror image."""
    ring = Surface(*torus())
    mirror = np.argmin(np.linalg.norm(ring.vertices[:, None] * [-1, 1, 1] - ring.vertices, axis=2), axis=1)
    middle = 0.5 * (ring.vertices + ring.vertices[mirror])
    colors = position_colors(middle, FRONT.axes)
    np.testing.assert_allclose(colors, colors[mirror], atol=1e-12)


@pytest.mark.usefixtures("coarse")
def test_plot_correspondence_carries_colours_over(sphere: Surface) -> None:
    shuffled = np.random.default_rng(1).permutation(sphere.n_vertices)
    inverse = np.argsort(shuffled)
    other = Surface(sphere.vertices[shuffled], inverse[sphere.faces])
    view = view_from(30)
    figure = figures.plot_correspondence(sphere, other, inverse, views=(view, view))
    left, right = (axes.images[0].get_array() for axes in figure.axes)
    assert np.abs(np.asarray(left, int) - np.asarray(right, int)).mean() < 0.5  # one picture twice
    with pytest.raises(ValueError, match=r"p2p has shape \(3,\), but X has 642"):
        figures.plot_correspondence(sphere, other, [0, 1, 2])


# -- the page ---------------------------------------------------------------------------------------


class Reader(HTMLParser):
    """Collects tags, checks that they close, and keeps what the page refers to."""

    VOID = frozenset({"meta", "img", "link", "br", "hr"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.references: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.references += [value or "" for name, value in attrs if name in ("src", "href", "srcset", "data", "action")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def read(page: str) -> Reader:
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert reader.open == []
    return reader


@pytest.mark.usefixtures("coarse")
def test_page_is_self_contained_and_well_formed() -> None:
    picture = Picture("spectrum", figures.plot_spectrum([2.0, -1.0]), 'Eigenvalues <of> "D" & more')
    tables = [Table.of("Mesh", {"vertices": 12, "closed": True, "genus": None}), Table("Rows", [(1, 0.5)], ("k", "γ"))]
    page = report_page("Cow & <calf>", subtitle="12 vertices", pictures=[picture], tables=tables, footer="version 0")
    reader = read(page)
    assert not re.search(r"https?:", page)
    assert all(reference.startswith("data:image/png;base64,") for reference in reader.references)
    assert "script" not in reader.tags
    assert "link" not in reader.tags
    assert "url(" not in page
    assert "@import" not in page
    assert "Cow & <calf>" in reader.text
    assert 'Eigenvalues <of> "D" & more' in reader.text
    assert "prefers-color-scheme: dark" in page
    data = base64.b64decode(reader.references[0].split(",", 1)[1])
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert data == Picture("again", picture.figure, "").png  # the same figure gives the same bytes


def test_stored_picture_is_shown_as_the_figure_it_was(tmp_path) -> None:  # type: ignore[no-untyped-def]
    for figure in (figures.plot_spectrum([2.0, -1.0]), panels.new_figure(7.0, 1.0)):
        picture = Picture("one", figure, "a caption")
        path = tmp_path / "one.png"
        path.write_bytes(picture.png)
        assert report_page("", pictures=[StoredPicture(path, "a caption")]) == report_page("", pictures=[picture])


@pytest.mark.parametrize(
    ("widths", "kinds"),
    [
        ("n", " "),
        ("nw", "aw"),
        ("nwn", " w "),
        ("nwnwn", " w wa"),
        ("nnnw", "  aw"),
        ("wnw", "waw"),
        ("ww", "ww"),
    ],
)
def test_no_row_of_the_page_is_half_empty(widths: str, kinds: str) -> None:
    """Wide, alone, or one of two: later ones fill up a row."""
    figures_of = {"n": panels.new_figure(3.0, 1.0), "w": panels.new_figure(7.0, 1.0)}
    page = report_page("", pictures=[Picture("one", figures_of[width], "") for width in widths])
    found = re.findall(r'<figure(?: class="(\w)\w+")?>', page)
    assert "".join(kind or " " for kind in found) == kinds
    assert "grid-auto-flow: dense" in page


def test_only_long_cells_are_sentences() -> None:
    page = report_page("", tables=[Table("Pairs", [("a - b", "sure", 40 * "long ")], ("pair", "is", "why"))])
    assert re.findall(r'<td( class="\w+")?>(\w+)', page) == [("", "sure"), (' class="sentence"', "long")]


def test_numbers_come_first_where_asked() -> None:
    table = Table("Numbers", [(1, 2)])
    before, after = (report_page("", tables=[table], tables_first=first) for first in (True, False))
    assert before.index('"tables"') < before.index('"pictures"')
    assert after.index('"pictures"') < after.index('"tables"')
    assert before.count("Numbers</h2>") == after.count("Numbers</h2>") == 1


def test_long_table_takes_the_width_of_the_page() -> None:
    assert 'class="table wide"' in report_page("", tables=[Table("", [("a" * 60, "b" * 60)])])
    assert 'class="table wide"' not in report_page("", tables=[Table("", [("a" * 60, 1)], ("name", "value"))])


def test_numbers_are_legible() -> None:
    assert formatted(0.123456789) == "0.123457"
    assert formatted(-2.0) == "−2"
    assert formatted(True) == "yes"
    assert formatted(None) == "–"
    assert formatted(list(range(20))).endswith("… (20)")
    assert formatted({"a": 1.0}) == "a = 1"
    assert formatted([]) == "–"
    assert formatted([[1, 2], [4, 5]]) == "1, 2; 4, 5"


def test_report_is_written_whole_or_not_at_all(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "report.html"
    write_report(path, "first")
    before = path.read_bytes()
    broken = Picture("x", None, "x")  # type: ignore[arg-type]
    with pytest.raises(AttributeError):
        write_report(path, "second", pictures=[broken])
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]
