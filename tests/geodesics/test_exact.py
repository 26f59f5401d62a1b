"""Exact distances against formulas on developable surfaces, and against what must not matter."""

from __future__ import annotations

import numpy as np
import pytest
import shapes
from hypothesis import given, settings
from hypothesis import strategies as st

from qgeo_filters import Surface
from qgeo_filters.errors import MeshError, NonManifoldError
from qgeo_filters.geodesics.metric import IntrinsicMesh, cartesian_metric
from qgeo_filters.geodesics.mmp.exact import exact_distances
from qgeo_filters.geodesics.unfolding import apexes, vertex_angles

# Sums of a few hundred rounded terms.
ROUNDING = 1e-12


def exact(vertices: np.ndarray, faces: np.ndarray, sources: object = None) -> np.ndarray:
    surface = Surface(vertices, faces)
    chosen = np.arange(surface.n_vertices) if sources is None else sources
    return exact_distances(cartesian_metric(surface).intrinsic(), chosen)


def intrinsic_disc(angles: np.ndarray, rings: int) -> IntrinsicMesh:
    """Cone of the given wedge angles about vertex 0 that need not fit into space, ring r at radius r."""
    n = len(angles)
    faces, lengths = [], []
    for j in range(n):
        chord = 2 * np.sin(angles[j] / 2)
        a, b = 1 + j, 1 + (j + 1) % n
        faces.append([0, a, b])
        lengths.append([1.0, chord, 1.0])
        for r in range(1, rings):
            lower, upper = (r - 1) * n, r * n
            diagonal = np.sqrt(r**2 + (r + 1) ** 2 - 2 * r * (r + 1) * np.cos(angles[j]))
            faces.append([lower + a, upper + a, upper + b])
            lengths.append([1.0, (r + 1) * chord, diagonal])
            faces.append([lower + a, upper + b, lower + b])
            lengths.append([diagonal, 1.0, r * chord])
    table = np.array(faces, dtype=np.int32)
    surface = Surface(np.random.default_rng(0).normal(size=(1 + n * rings, 3)), table)
    return IntrinsicMesh(table, np.array(lengths), surface.twins, surface.n_vertices)


class TestFormulas:
    # Rounding a side of a needle moves its apex by (length / width)^2 times as much.
    @pytest.mark.parametrize(("stretch", "tolerance"), [(1.0, ROUNDING), (1e-2, 1e-11), (1e-4, 1e-8)])
    def test_plane_gives_straight_lines(self, stretch, tolerance):
        vertices, faces = shapes.grid(9, jitter=0.15)
        vertices = vertices * [1.0, stretch, 1.0]
        straight = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
        np.testing.assert_allclose(exact(vertices, faces), straight, rtol=tolerance)

    def test_cylinder_gives_helices(self):
        # The mesh is a prism, which unrolls: sides of width 2 sin(pi / n).
        n_around, n_along = 12, 5
        vertices, faces = shapes.cylinder(n_around, n_along, height=3.0)
        step = np.abs(np.subtract.outer(np.arange(n_around), np.arange(n_around)))
        around = 2 * np.sin(np.pi / n_around) * np.minimum(step, n_around - step)
        up = 3.0 / n_along * np.subtract.outer(np.arange(n_along + 1), np.arange(n_along + 1))
        expected = np.hypot(np.kron(np.ones_like(up), around), np.kron(up, np.ones_like(around)))
        np.testing.assert_allclose(exact(vertices, faces), expected, rtol=ROUNDING)

    @pytest.mark.parametrize("total", [0.4, 1.0, 1.9, 2.0, 2.1, 3.0, 7.0])
    def test_cone_of_any_angle(self, total):
        """A straight line where the angle between two points is below pi, else by way of the apex."""
        n_around, rings = 24, 4
        weights = np.random.default_rng(1).uniform(0.5, 1.5, n_around)
        angles = total * np.pi * weights / weights.sum()
        radius = np.concatenate([[0.0], np.repeat(np.arange(1.0, rings + 1), n_around)])
        direction = np.concatenate([[0.0], np.tile(np.cumsum(angles) - angles, rings)])
        mesh = intrinsic_disc(angles, rings)
        turn = np.abs(np.subtract.outer(direction, direction))
        turn = np.minimum(np.minimum(turn, total * np.pi - turn), np.pi)
        r, s = radius[:, None], radius[None]
        expected = np.sqrt(np.maximum((r - s) ** 2 + 4 * r * s * np.sin(turn / 2) ** 2, 0.0))
        got = exact_distances(mesh, np.arange(len(radius)))
        # Near the rim a chord leaves the disc, whose border is a polygon; compare pairs whose chord stays inside.
        apothem = rings * np.cos(angles.max() / 2)
        inside = (np.maximum(r, s) <= apothem) | (turn == np.pi)
        assert inside.mean() > 0.5
        np.testing.assert_allclose(got[inside], expected[inside], rtol=ROUNDING, atol=ROUNDING)

    def test_l_shape_bends_at_the_inner_corner(self):
        vertices, faces = shapes.grid(8)
        centre = vertices[faces].mean(axis=1)
        kept = faces[~((centre[:, 0] > 0.5) & (centre[:, 1] > 0.5))]
        used = np.unique(kept)
        x, y = vertices[used, :2].T
        d = exact(vertices, kept, used)[:, used]
        expected = np.hypot(np.subtract.outer(x, x), np.subtract.outer(y, y))
        to_corner = np.hypot(x - 0.5, y - 0.5)
        for i, j in np.argwhere((x[:, None] <= 0.5) & (y[:, None] > 0.5) & (x > 0.5) & (y <= 0.5)):
            if y[i] + (0.5 - x[i]) / (x[j] - x[i]) * (y[j] - y[i]) > 0.5:  # the line leaves the plate
                expected[i, j] = expected[j, i] = to_corner[i] + to_corner[j]
        np.testing.assert_allclose(d, expected, rtol=ROUNDING, atol=ROUNDING)

    def test_slit_plate(self):
        """A plate cut from the middle of one side to its centre: paths across bend at the end of the slit."""
        n = 8
        vertices, faces = shapes.grid(n)
        x, y = vertices[:, 0], vertices[:, 1]
        on_slit = np.flatnonzero((x == 0.5) & (y < 0.5))
        copies = np.full(len(vertices), -1)
        copies[on_slit] = len(vertices) + np.arange(len(on_slit))
        right_of = vertices[faces].mean(axis=1)[:, 0] > 0.5
        cut = np.where(right_of[:, None] & (copies[faces] >= 0), copies[faces], faces)
        doubled = np.concatenate([vertices, vertices[on_slit]])
        d = exact(doubled, cut)
        tip = np.array([0.5, 0.5])
        to_tip = np.linalg.norm(doubled[:, :2] - tip, axis=1)
        straight = np.linalg.norm(doubled[:, None] - doubled[None], axis=2)
        side = np.where(doubled[:, 0] < 0.5, -1, np.where(doubled[:, 0] > 0.5, 1, 0))
        side[on_slit], side[len(vertices) :] = -1, 1
        side[(doubled[:, 0] == 0.5) & (doubled[:, 1] >= 0.5)] = 0
        expected = straight.copy()
        for i, j in np.argwhere(np.multiply.outer(side, side) < 0):
            p, q = doubled[i, :2], doubled[j, :2]
            gap = q[0] - p[0]
            height = p[1] if gap == 0 else p[1] + (0.5 - p[0]) / gap * (q[1] - p[1])
            if gap == 0 or height < 0.5:
                expected[i, j] = to_tip[i] + to_tip[j]
        np.testing.assert_allclose(d, expected, rtol=ROUNDING, atol=ROUNDING)

    def test_sphere_converges_quadratically(self):
        # The inscribed icosphere of edge h has distances that fall short of the great circle by O(h^2).
        errors, sizes = [], []
        for level in (2, 3, 4):
            vertices, faces = shapes.icosphere(level)
            arc = np.arccos(np.clip(vertices @ vertices[5], -1, 1))
            far = arc > 0.5
            errors.append(np.abs(exact(vertices, faces, [5])[0][far] / arc[far] - 1).mean())
            sizes.append(Surface(vertices, faces).edge_lengths.mean())
        slope = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
        assert 1.8 < slope < 2.2


class TestInvariances:
    def test_symmetric_and_a_metric(self):
        vertices, faces = shapes.terrain(60, 3, 0.3)
        d = exact(vertices, faces)
        np.testing.assert_allclose(d, d.T, rtol=ROUNDING)
        assert (np.diagonal(d) == 0).all()
        assert (d[:, None, :] <= d[:, :, None] + d[None] + ROUNDING).all()

    def test_numbering_and_orientation_do_not_matter(self):
        vertices, faces = shapes.blob(2)
        rng = np.random.default_rng(4)
        renumbered = rng.permutation(len(vertices))  # old -> new
        moved = np.empty_like(vertices)
        moved[renumbered] = vertices
        mixed = np.array([np.roll(renumbered[f], rng.integers(3))[:: rng.choice([-1, 1])] for f in faces])
        mixed = mixed[rng.permutation(len(mixed))]
        d = exact(vertices, faces)
        np.testing.assert_allclose(exact(moved, mixed)[np.ix_(renumbered, renumbered)], d, rtol=ROUNDING)

    def test_only_side_lengths_matter(self):
        flat, faces = shapes.grid(7, jitter=0.2)
        rolled = np.column_stack([np.cos(flat[:, 0]), np.sin(flat[:, 0]), flat[:, 1]])
        surface = Surface(rolled, faces)
        mesh = cartesian_metric(Surface(flat, faces)).intrinsic()
        on_other_coordinates = IntrinsicMesh(surface.faces, mesh.lengths, surface.twins, surface.n_vertices)
        np.testing.assert_array_equal(exact_distances(on_other_coordinates, [0, 9]), exact_distances(mesh, [0, 9]))

    def test_splitting_triangles_does_not_matter(self):
        import igl

        vertices, faces = shapes.blob(2)
        fine, fine_faces = igl.upsample(vertices, faces)
        n = len(vertices)
        split = exact(fine, fine_faces, np.arange(0, n, 10))[:, :n]
        np.testing.assert_allclose(split, exact(vertices, faces, np.arange(0, n, 10)), rtol=ROUNDING)

    @pytest.mark.parametrize("scale", [1e-9, 1e9])
    def test_scale(self, scale):
        vertices, faces = shapes.terrain(80, 5, 0.2)
        np.testing.assert_allclose(exact(scale * vertices, faces), scale * exact(vertices, faces), rtol=ROUNDING)

    def test_power_of_two_gives_the_same_bits(self):
        vertices, faces = shapes.terrain(80, 5, 0.2)
        np.testing.assert_array_equal(exact(2.0**-30 * vertices, faces), 2.0**-30 * exact(vertices, faces))

    def test_threads_do_not_matter(self):
        mesh = cartesian_metric(Surface(*shapes.torus(20, 10))).intrinsic()
        every = np.arange(0, 200, 7)
        one = exact_distances(mesh, every, workers=1)
        np.testing.assert_array_equal(exact_distances(mesh, every, workers=2, progress=True), one)


class TestHardMeshes:
    def test_pieces_and_loose_vertices_are_unreachable(self):
        vertices, faces = shapes.icosphere(1)
        n = len(vertices)
        both = np.concatenate([vertices, vertices + 3, [[9.0, 9, 9]]])
        d = exact(both, np.concatenate([faces, faces + n]), [0, n, 2 * n])
        assert np.isfinite(d[0, :n]).all()
        assert np.isinf(d[0, n:]).all()
        assert np.isinf(d[1, :n]).all()
        np.testing.assert_allclose(d[0, :n], d[1, n : 2 * n], rtol=ROUNDING)
        assert np.isinf(d[2, : 2 * n]).all()
        assert d[2, 2 * n] == 0

    def test_one_triangle(self):
        vertices = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])
        np.testing.assert_allclose(exact(vertices, [[0, 1, 2]]), [[0, 3, 4], [3, 0, 5], [4, 5, 0]], rtol=1e-15)

    def test_moebius_band_is_half_of_its_double_cover(self):
        vertices, faces = shapes.moebius(16, 3)
        surface = Surface(vertices, faces)
        assert not surface.is_oriented
        mesh = cartesian_metric(surface).intrinsic()
        n = surface.n_vertices
        # Two copies of every face; crossing a flipped edge changes the copy.
        flipped = np.zeros(surface.twins.shape, dtype=bool)
        own, other = np.arange(surface.twins.size).reshape(-1, 3), surface.twins
        has = other >= 0
        flipped[has] = surface.faces.ravel()[own[has]] == surface.faces.ravel()[other[has]]
        corner_copy = _double_cover(surface.faces, other, flipped)
        cover_faces = np.concatenate([corner_copy[0], corner_copy[1]])
        origin = np.empty(cover_faces.max() + 1, dtype=int)
        origin[cover_faces] = np.concatenate([surface.faces, surface.faces])
        assert len(origin) == 2 * n
        cover = exact(vertices[origin], cover_faces)
        expected = np.full((n, n), np.inf)
        np.minimum.at(expected, (origin[:, None], origin[None]), cover)
        np.testing.assert_allclose(exact_distances(mesh, np.arange(n)), expected, rtol=ROUNDING, atol=ROUNDING)

    @pytest.mark.parametrize("offset", [0.0, 1e-13, 1e-9])
    def test_collinear_triangles_change_nothing(self, offset):
        """Triangles without area put on the edges of a mesh leave the distances of its vertices."""
        vertices, faces = shapes.blob(2)
        rng = np.random.default_rng(6)
        points, table = list(vertices), [list(f) for f in faces]
        for _ in range(120):
            i = rng.integers(len(table))
            a, b, c = table[i]
            t = rng.uniform(0.1, 0.9)
            points.append((1 - t) * points[a] + t * points[b] + offset * rng.normal(size=3))
            m = len(points) - 1
            table[i] = [a, m, c]
            table += [[m, b, c], [a, b, m]]
        d = exact(np.array(points), np.array(table), np.arange(0, 160, 9))[:, : len(vertices)]
        # A side that is off by rounding gives the flat triangle a height of its square root, 1e-8.
        tolerance = 1e-7 + 10 * offset
        np.testing.assert_allclose(d, exact(vertices, faces, np.arange(0, 160, 9)), rtol=tolerance)

    @pytest.mark.parametrize("gap", [1e-9, 1e-12, 1e-14, 0.0])
    def test_vertices_that_nearly_or_quite_coincide(self, gap):
        vertices, faces = shapes.blob(2)
        together, apart = vertices.copy(), vertices.copy()
        rng = np.random.default_rng(1)
        for i in range(10, 60, 7):
            a, b = faces[i, :2]
            offset = rng.normal(size=3)
            together[a], apart[a] = together[b] + gap * offset, apart[b] + 1e-7 * offset
        d = exact(together, faces)
        np.testing.assert_allclose(d, exact(apart, faces), atol=1e-5)
        np.testing.assert_allclose(d, d.T, atol=1e-12)

    def test_nothing_is_changed(self):
        surface = Surface(*shapes.torus(12, 8))
        mesh = cartesian_metric(surface).intrinsic()
        assert not mesh.faces.flags.writeable
        lengths = mesh.lengths.copy()
        lengths.setflags(write=False)
        sources = np.array([3, 1])
        sources.setflags(write=False)
        exact_distances(mesh._replace(lengths=lengths), sources)
        np.testing.assert_array_equal(lengths, mesh.lengths)


def _double_cover(faces: np.ndarray, twins: np.ndarray, flipped: np.ndarray) -> np.ndarray:
    """Faces (2, m, 3) of the oriented double cover, corners glued across the sides."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    m = len(faces)
    pairs = []
    for f, k in np.argwhere(twins >= 0):
        g, j = divmod(int(twins[f, k]), 3)
        for copy in (0, 1):
            there = copy ^ int(flipped[f, k])
            ends = (3 * g + j, 3 * g + (j + 1) % 3) if flipped[f, k] else (3 * g + (j + 1) % 3, 3 * g + j)
            for mine, yours in zip((3 * f + k, 3 * f + (k + 1) % 3), ends, strict=True):
                pairs.append((copy * 3 * m + mine, there * 3 * m + yours))
    rows, columns = np.array(pairs).T
    graph = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(6 * m, 6 * m))
    labels = connected_components(graph, directed=False)[1]
    return labels.reshape(2, m, 3)


class TestBadInput:
    def test_source_out_of_range(self):
        mesh = cartesian_metric(Surface(*shapes.icosphere(0))).intrinsic()
        with pytest.raises(MeshError, match=r"sources\[1\] is vertex 12, but there are 12 vertices"):
            exact_distances(mesh, [0, 12])

    def test_no_source_gives_no_row(self):
        mesh = cartesian_metric(Surface(*shapes.icosphere(0))).intrinsic()
        assert exact_distances(mesh, np.array([], dtype=int)).shape == (0, 12)

    def test_not_a_surface(self):
        with pytest.raises(NonManifoldError, match=r"edge \(0, 1\) has 3 faces"):
            cartesian_metric(Surface(*shapes.fan())).intrinsic()


class TestUnfolding:
    @settings(max_examples=200)
    @given(st.floats(1e-8, 1.0), st.floats(-1.0, 2.0), st.floats(1e-9, 1.0))
    def test_apexes_keep_the_lengths(self, length, x, y):
        points = np.array([[0, 0], [length, 0], [x, y]])
        sides = np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1)
        apex = apexes(sides[None])[0]
        np.testing.assert_allclose(np.hypot(apex[:, 0], apex[:, 2]), np.roll(sides, 1), rtol=1e-7)
        np.testing.assert_allclose(np.hypot(apex[:, 1], apex[:, 2]), np.roll(sides, -1), rtol=1e-7)

    def test_angles_meet_gauss_bonnet(self):
        for vertices, faces in (shapes.blob(2), shapes.torus(12, 8)):
            surface = Surface(vertices, faces)
            angles = vertex_angles(cartesian_metric(surface).intrinsic())
            defect = (2 * np.pi - angles).sum()
            assert defect == pytest.approx(2 * np.pi * surface.euler_characteristic, abs=1e-9)
