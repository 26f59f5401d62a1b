"""Triangles of polygons cover each of them exactly once, whatever its shape and wherever it lies."""

from __future__ import annotations

import numpy as np
import pytest

from qgeo_filters.errors import MeshError
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.io.formats import read_raw
from qgeo_filters.io.polygons import Polygons, strip_triangles, triangulated

ARROW = np.array([[0, 0], [4, 0], [4, 4], [2, 1], [0, 4.0]])
CORNER_WITH_MIDPOINTS = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [0, 1.0]])
KEYHOLE = np.array([[0, 0], [6, 0], [6, 6], [0, 6], [0, 0], [2, 2], [2, 4], [4, 4], [4, 2], [2, 2.0]])
SQUARE_WITH_MIDPOINTS = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1.0]])
ARROWHEAD = np.array([[0, 0], [2, 1], [0, 2], [0.5, 1.0]])
COMB = np.array([[0, 0], [9, 0], *([[9 - k, 3 * (k % 2) + 1] for k in range(10)])], dtype=float)


def star(seed):
    """Polygon with a random radius at random angles about a point inside."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(5, 40))
    angle = 2 * np.pi * (np.arange(n) + 0.8 * rng.random(n)) / n
    radius = rng.uniform(0.05, 1, n)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


SHAPES = {
    "arrow": ARROW,
    "corner": CORNER_WITH_MIDPOINTS,
    "keyhole": KEYHOLE,
    "midpoints": SQUARE_WITH_MIDPOINTS,
    "arrowhead": ARROWHEAD,
    "comb": COMB,
    **{f"star {seed}": star(seed) for seed in range(20)},
}


def placed(plane, seed=0, scale=1.0, offset=0.0):
    """Points of the plane z = 0 turned, scaled and moved in space."""
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    if np.linalg.det(turn) < 0:
        turn[:, 0] *= -1
    return scale * (np.column_stack([plane, np.zeros(len(plane))]) @ turn.T + offset), turn[:, 2]


def shoelace(plane):
    x, y = plane.T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


def signed_areas(points, faces, normal):
    a, b, c = (points[faces[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a) @ normal


def assert_covers_once(plane, points, faces, normal, scale=1.0):
    """Triangles that are all turned as the polygon and together as large cover a simple polygon exactly once."""
    true = shoelace(plane) * scale**2
    areas = signed_areas(points, faces, normal) * np.sign(true)
    assert areas.min() > -1e-12 * abs(true)
    assert areas.sum() == pytest.approx(abs(true), rel=1e-9)
    assert len(faces) == len(plane) - 2
    assert set(faces.ravel()) == set(range(len(plane)))  # a neighbour may need each of the corners


@pytest.mark.parametrize("name", SHAPES)
def test_every_start_and_both_ways_round(name):
    plane = SHAPES[name]
    points, normal = placed(plane)
    around = np.arange(len(plane))
    for start in range(len(plane)):
        for order in (np.roll(around, start), np.roll(around[::-1], start)):
            faces, notes = triangulated(points[order], Polygons.of_rows([around]), repair=True)
            assert_covers_once(plane[order], points[order], faces, normal)
            assert notes == (f"1 polygon split into {len(plane) - 2} triangles",)


@pytest.mark.parametrize("scale", [1e-90, 1e-9, 1e9, 1e90])
@pytest.mark.parametrize("name", ["arrow", "arrowhead", "corner", "star 1"])
def test_every_size(name, scale):
    plane = SHAPES[name]
    points, normal = placed(plane, seed=3, scale=scale)
    faces, _ = triangulated(points, Polygons.of_rows([range(len(plane))]), repair=True)
    assert_covers_once(plane, points / scale, faces, normal)


def test_far_from_the_origin():
    points, normal = placed(ARROW, seed=3, offset=1e6)
    faces, _ = triangulated(points, Polygons.of_rows([range(5)]), repair=True)
    assert signed_areas(points, faces, normal).min() > 1
    assert signed_areas(points, faces, normal).sum() == pytest.approx(10, rel=1e-6)


def test_a_convex_polygon_keeps_the_fan_at_its_first_corner():
    angle = 2 * np.pi * np.arange(7) / 7
    points = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(7)])
    faces, _ = triangulated(points, Polygons.of_rows([range(7)]), repair=True)
    np.testing.assert_array_equal(faces, [[0, k, k + 1] for k in range(1, 6)])


@pytest.mark.parametrize("bend", [0.1, 0.5])
def test_polygons_that_are_not_flat(bend):
    for plane in (ARROW, ARROWHEAD, CORNER_WITH_MIDPOINTS):
        points = np.column_stack([plane, bend * plane[:, 0] * plane[:, 1] / 4])
        faces, _ = triangulated(points, Polygons.of_rows([range(len(plane))]), repair=True)
        assert_covers_once(plane, points, faces, np.array([0, 0, 1.0]))


def test_faces_of_all_sizes_stay_in_order():
    points, _ = placed(np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.2, 0.5]]))
    faces, notes = triangulated(points, Polygons.of_rows([[0, 1, 4], [0, 1, 2, 3], [2, 3, 4], [0, 1, 2, 3, 4]]), True)
    np.testing.assert_array_equal(faces[[0, 3]], [[0, 1, 4], [2, 3, 4]])
    np.testing.assert_array_equal(faces[[1, 2]], [[0, 1, 2], [0, 2, 3]])
    assert len(faces) == 7
    assert notes == ("2 polygons split into 5 triangles",)


def test_faces_of_too_few_corners_are_removed_by_repair_and_counted():
    points, _ = placed(ARROW)
    polygons = Polygons.of_rows([[0, 1], [0, 1, 2], [], [3], [0, 2, 3]])
    with pytest.raises(MeshError, match=r"face 0 has 2 corners \(3 faces .*three corners\); repair=True removes them"):
        triangulated(points, polygons, repair=False)
    faces, notes = triangulated(points, polygons, repair=True)
    np.testing.assert_array_equal(faces, [[0, 1, 2], [0, 2, 3]])
    assert notes == ("3 faces with fewer than three corners removed (face 0, 2, 3)",)


def test_a_triangle_written_as_a_quadrilateral_is_one_triangle():
    points, _ = placed(ARROW)
    for row in ([0, 1, 2, 2], [0, 0, 1, 2], [0, 1, 2, 0], [0, 1, 1, 1, 2]):
        faces, notes = triangulated(points, Polygons.of_rows([row]), repair=True)
        np.testing.assert_array_equal(faces, [[0, 1, 2]])
        assert "that only repeat the one beside" in notes[0]


def test_polygons_with_lost_corners_go_as_a_whole_and_are_named():
    points, _ = placed(ARROW)
    points[3, 1] = np.nan
    faces, notes = triangulated(points, Polygons.of_rows([[0, 1, 2, 9], [0, 1, 2, 4], [0, 1, 2, 3], [0, 1, 9]]), True)
    assert notes[0] == "2 polygons removed, of which a corner is no vertex or is not finite (face 0, 2)"
    np.testing.assert_array_equal(faces[-1], [0, 1, 9])  # for those who check triangles
    assert len(faces) == 3


def test_what_crosses_itself_is_said():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    for row in ([0, 1, 3, 2], [0, 2, 1, 3]):
        faces, notes = triangulated(square, Polygons.of_rows([[0, 1, 2, 3], row]), repair=True)
        assert len(faces) == 4
        assert notes[-1] == "1 polygon that cannot be covered without overlaps, as it crosses itself (face 1)"


def test_a_polygon_without_area_keeps_its_corners():
    line = np.column_stack([np.arange(5.0), np.zeros(5), np.zeros(5)])
    for points in (line, np.zeros((5, 3))):
        faces, notes = triangulated(points, Polygons.of_rows([range(5)]), repair=True)
        assert len(faces) == 3
        assert set(faces.ravel()) == set(range(5))
        assert notes == ("1 polygon split into 3 triangles",)


def test_corners_that_are_no_whole_numbers():
    with pytest.raises(MeshError, match=r"face 1 refers to vertex 2\.5, which is no whole number"):
        Polygons.of_flat(np.array([0, 1, 2, 0, 1, 2.5]), [3, 3])
    with pytest.raises(MeshError, match="face 0 refers to vertex nan"):
        Polygons.of_flat(np.array([0, np.nan, 2]), [3])


def test_concave_quadrilaterals_of_a_pair():
    points, _ = placed(ARROWHEAD)
    for start in range(4):
        surface = as_surface((points, [np.roll(np.arange(4), start)]), repair=True)
        assert surface.area == pytest.approx(abs(shoelace(ARROWHEAD)), rel=1e-12)


def test_faces_of_different_sizes_of_a_pair():
    points, _ = placed(ARROW)
    rows = [[0, 1, 3], [1, 2, 3], [3, 4, 0], [0, 1]]
    assert as_surface((points, rows), repair=True).area == pytest.approx(10, rel=1e-12)
    assert as_surface((points, [[0, 1, 2, 3], [0, 3, 4]]), repair=True).area == pytest.approx(10, rel=1e-12)
    with pytest.raises(MeshError, match="faces must be whole numbers in rows of three"):
        as_surface((points, rows))
    for wrong in ([[0, 1, 2, 3], 5], [[0, 1, 2], [0, "x"]], [[0, 1, 2], [[0, 1], [1, 2]]], [["a", "b", "c", "d"]]):
        with pytest.raises(MeshError, match="faces must"):
            as_surface((points, wrong), repair=True)


@pytest.mark.parametrize("suffix", ["off", "obj"])
def test_concave_polygons_of_files(tmp_path, suffix):
    file = tmp_path / f"arrow.{suffix}"
    rows = [f"{x:g} {y:g} 0" for x, y in ARROW]
    for start in range(5):
        face = np.roll(np.arange(5), start)
        if suffix == "off":
            file.write_text("\n".join(["OFF 5 1 0", *rows, " ".join(map(str, [5, *face]))]))
        else:
            file.write_text("\n".join([*(f"v {row}" for row in rows), " ".join(map(str, ["f", *(face + 1)]))]))
        raw = read_raw(file, repair=True)
        areas = signed_areas(np.asarray(raw.vertices), np.asarray(raw.faces), np.array([0, 0, 1.0]))
        assert areas.min() > 0
        assert areas.sum() == pytest.approx(10, rel=1e-12)


def test_strips_turn_every_other_triangle():
    np.testing.assert_array_equal(strip_triangles(np.array([0, 1, 2, 3])), [[0, 1, 2], [2, 1, 3]])
    # Each strip begins anew; what divides them may stand at the ends, or twice.
    strips = np.array([-1, 7, 0, 1, 2, 3, -1, -1, 4, 5, 6, -1, 8, 9, -1])
    np.testing.assert_array_equal(strip_triangles(strips), [[7, 0, 1], [1, 0, 2], [1, 2, 3], [4, 5, 6]])
    # A vertex that stands twice leads to the next strip and keeps the count.
    np.testing.assert_array_equal(strip_triangles(np.array([0, 1, 2, 2, 3, 4])), [[0, 1, 2], [3, 2, 4]])
    assert strip_triangles(np.array([0, 1], dtype=np.int64)).shape == (0, 3)


@pytest.mark.parametrize("length", [5, 8, 13])
def test_a_strip_of_a_flat_band_faces_one_way(length):
    points = np.array([[k // 2, k % 2, 0] for k in range(length)], dtype=float)
    faces = strip_triangles(np.arange(length))
    areas = signed_areas(points, faces, np.array([0, 0, 1.0]))
    np.testing.assert_allclose(np.abs(areas), 0.5)
    assert len(set(np.sign(areas))) == 1
