"""Paths against formulas, the exact distance, and the definition of a locally shortest path."""

from __future__ import annotations

import numpy as np
import pytest
import shapes
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from qgeo_filters import Surface
from qgeo_filters.errors import DisconnectedError, MeshError, NonManifoldError
from qgeo_filters.geodesics.metric import LiftedMetric, cartesian_metric
from qgeo_filters.geodesics.mmp.exact import exact_distances
from qgeo_filters.geodesics.path.geodesic_path import GeodesicPath
from qgeo_filters.geodesics.path.paths import quasi_geodesic, quasi_geodesics
from qgeo_filters.geodesics.unfolding import vertex_angles

ROUNDING = 1e-12
BOTH = pytest.mark.parametrize("initial", ["exact", "edges"])


def exact(surface: Surface, source: int, metric: LiftedMetric | None = None) -> np.ndarray:
    return exact_distances((metric or cartesian_metric(surface)).intrinsic(), [source])[0]


def slit_plate() -> tuple[Surface, int, int, int]:
    """Unit plate cut from the middle of one side to its centre; a vertex left and right of the slit, its end."""
    vertices, faces = shapes.grid(8)
    x, y = vertices[:, :2].T
    on_slit = np.flatnonzero((x == 0.5) & (y < 0.5))
    copies = np.full(len(vertices), -1)
    copies[on_slit] = len(vertices) + np.arange(len(on_slit))
    right = vertices[faces].mean(axis=1)[:, 0] > 0.5
    cut = np.where(right[:, None] & (copies[faces] >= 0), copies[faces], faces)

    def at(a, b):
        return int(np.argmin(np.hypot(x - a, y - b)))

    return Surface(np.concatenate([vertices, vertices[on_slit]]), cut), at(0.25, 0.125), at(0.75, 0.25), at(0.5, 0.5)


def side_lengths_of(path: GeodesicPath, metric: LiftedMetric) -> np.ndarray:
    """Length of each segment from barycentric coordinates and squared side lengths alone."""
    mesh = metric.intrinsic()
    segments = []
    for k in range(len(path.points) - 1):
        f = path.faces[k]
        ahead = barycentric_in(path, k + 1, f, mesh.faces)
        u = ahead - path.barycentric[k]
        l2 = mesh.lengths[f] ** 2  # sides 01, 12, 20
        segments.append(-(l2[0] * u[0] * u[1] + l2[1] * u[1] * u[2] + l2[2] * u[2] * u[0]))
    return np.sqrt(np.maximum(segments, 0.0))


def barycentric_in(path: GeodesicPath, k: int, face: int, faces: np.ndarray) -> np.ndarray:
    """Coordinates of point k in a triangle that holds it."""
    own = dict(zip(faces[path.faces[k]].tolist(), path.barycentric[k], strict=True))
    found = np.array([own.get(int(v), 0.0) for v in faces[face]])
    assert found.sum() == pytest.approx(1.0, abs=1e-12), "the point is not in the triangle of the one before"
    return found


def check_definition(path: GeodesicPath, surface: Surface, metric: LiftedMetric | None = None) -> None:
    """What every path must fulfil, from its arrays and the side lengths alone."""
    metric = metric or cartesian_metric(surface)
    p = len(path.points)
    assert path.faces.shape == path.vertices.shape == (p,)
    assert path.barycentric.shape == (p, 3)
    assert path.kappa_g.shape == path.left_angle.shape == path.right_angle.shape == (p - 2,)
    assert (path.barycentric >= 0).all()
    corners = surface.vertices[surface.faces[path.faces]]
    scale = np.abs(surface.vertices).max()
    np.testing.assert_allclose(np.einsum("ki,kij->kj", path.barycentric, corners), path.points, atol=1e-12 * scale)
    segments = side_lengths_of(path, metric)
    assert segments.sum() == pytest.approx(path.length, rel=1e-9)
    if metric.curvature_weight == 0:
        straight = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
        assert straight.sum() == pytest.approx(path.length, rel=1e-9)
    assert (np.diff(path.lengths) <= 1e-13 * path.length).all(), "a round made the path longer"
    assert path.lengths[-1] == path.length
    # Angles: the right total at vertices and on edges, eq. (1), and the certificate.
    total = path.left_angle + path.right_angle
    inner = path.vertices[1:-1]
    theta = np.where(inner >= 0, vertex_angles(metric.intrinsic())[inner], 2 * np.pi)
    np.testing.assert_allclose(total, theta, atol=1e-9)
    np.testing.assert_allclose(path.kappa_g, 2 * np.pi / theta * (theta / 2 - path.right_angle), atol=1e-8)
    assert path.converged
    on_edge = inner < 0
    assert (np.abs(path.kappa_g[on_edge]) < 1e-6).all()
    boundary = np.isin(inner, surface.boundary_vertices)
    narrow = np.minimum(path.left_angle, path.right_angle) < np.pi - 2e-6
    assert not (narrow & ~boundary & ~on_edge).any()


class TestFormulas:
    @BOTH
    @pytest.mark.parametrize("jitter", [0.0, 0.2])
    def test_plane_gives_the_straight_line(self, initial, jitter):
        surface = Surface(*shapes.grid(9, jitter=jitter))
        for i, j in [(0, 99), (5, 94), (12, 87), (3, 60), (0, 9)]:
            path = quasi_geodesic(surface, i, j, initial=initial)
            a, b = surface.vertices[[i, j]]
            assert path.length == pytest.approx(np.linalg.norm(b - a), rel=ROUNDING)
            off = np.cross(path.points - a, (b - a) / np.linalg.norm(b - a))
            np.testing.assert_allclose(off, 0.0, atol=1e-8)
            inside = ~np.isin(path.vertices[1:-1], surface.boundary_vertices)
            np.testing.assert_allclose(path.kappa_g[inside], 0.0, atol=1e-7)
            check_definition(path, surface)

    @BOTH
    def test_cylinder_gives_the_helix(self, initial):
        n_around, n_along = 24, 10
        surface = Surface(*shapes.cylinder(n_around, n_along, height=3.0))
        for step, rise in [(5, 8), (9, 3), (11, 10), (0, 10), (7, 0)]:
            path = quasi_geodesic(surface, 0, step + rise * n_around, initial=initial)
            width = 2 * np.sin(np.pi / n_around)
            assert path.length == pytest.approx(np.hypot(step * width, 0.3 * rise), rel=ROUNDING)
            # A helix climbs in proportion to the way around the prism.
            way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path.points, axis=0), axis=1))])
            np.testing.assert_allclose(path.points[:, 2], 0.3 * rise * way / path.length, atol=1e-9)
            check_definition(path, surface)

    def test_cone_goes_round_the_apex(self):
        n_around, n_along, slope = 30, 8, 2.0
        surface = Surface(*shapes.cone(n_around, n_along, slope))
        wedge = 2 * np.arcsin(np.sin(np.pi / n_around) / np.hypot(1, slope))
        ring = 1 + 5 * n_around
        radius = np.linalg.norm(surface.vertices[ring])
        for step in (3, 8, 15):
            path = quasi_geodesic(surface, ring, ring + step)
            assert path.length == pytest.approx(2 * radius * np.sin(step * wedge / 2), rel=ROUNDING)
            check_definition(path, surface)
        assert quasi_geodesic(surface, 0, ring).length == pytest.approx(radius, rel=ROUNDING)

    def test_sphere_converges_quadratically_to_the_great_circle(self):
        sizes, lengths, offsets = [], [], []
        for level in (2, 3, 4):
            surface = Surface(*shapes.icosphere(level))
            a, b = surface.vertices[[0, 7]]  # corners of the icosahedron, kept by refinement
            path = quasi_geodesic(surface, 0, 7)
            sizes.append(surface.edge_lengths.mean())
            lengths.append(abs(path.length - np.arccos(a @ b)))
            normal = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
            offsets.append(np.abs(path.points @ normal).max())
            check_definition(path, surface)
        assert 1.8 < np.polyfit(np.log(sizes), np.log(lengths), 1)[0] < 2.2
        assert offsets[-1] < 0.01

    @BOTH
    def test_slit_plate_bends_at_the_end_of_the_slit(self, initial):
        surface, i, j, tip = slit_plate()
        path = quasi_geodesic(surface, i, j, initial=initial)
        a, b, c = surface.vertices[[i, tip, j]]
        assert path.length == pytest.approx(np.linalg.norm(a - b) + np.linalg.norm(b - c), rel=ROUNDING)
        at = np.flatnonzero(path.vertices == tip)
        assert len(at) == 1
        assert abs(path.kappa_g[at[0] - 1]) > 0.3
        check_definition(path, surface)

    def test_saddle_vertex_holds_the_path(self):
        n = 12
        angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
        ring = np.column_stack([np.cos(angle), np.sin(angle), 1.2 * np.cos(2 * angle)])
        surface = Surface([[0, 0, 0], *ring], [[0, 1 + k, 1 + (k + 1) % n] for k in range(n)])
        assert surface.corner_angles[:, 0].sum() > 2.2 * np.pi
        path = quasi_geodesic(surface, 1, 1 + n // 2)
        assert path.vertices.tolist() == [1, 0, 1 + n // 2]
        assert path.left_angle[0] > np.pi
        assert path.right_angle[0] > np.pi
        check_definition(path, surface)

    def test_left_and_right(self):
        """A path that turns right about the end of the slit has the angle above pi on its left."""
        surface, i, j, tip = slit_plate()  # from left of the slit over its end to the right: a right turn
        path = quasi_geodesic(surface, i, j)
        k = int(np.flatnonzero(path.vertices == tip)[0]) - 1
        assert path.left_angle[k] > np.pi  # the plate beyond the slit
        assert path.right_angle[k] < np.pi  # the corner that the slit leaves
        assert path.kappa_g[k] > 0
        back = quasi_geodesic(surface, j, i)
        k = int(np.flatnonzero(back.vertices == tip)[0]) - 1
        assert back.kappa_g[k] < 0


class TestShortest:
    @pytest.mark.parametrize(
        "surface",
        [
            Surface(*shapes.blob(3)),
            Surface(*shapes.torus(24, 14)),
            Surface(*shapes.terrain(250, 1, 0.3)),
            Surface(*shapes.terrain(250, 2, 0.03)),
            Surface(*shapes.moebius(24, 3)),
        ],
        ids=["blob", "torus", "rough", "gentle", "moebius"],
    )
    def test_down_the_exact_distance_it_is_the_shortest_of_all(self, surface):
        metric = cartesian_metric(surface)
        for i in range(0, surface.n_vertices, surface.n_vertices // 4):
            d = exact(surface, i)
            for j in range(0, surface.n_vertices, 17):
                if i != j:
                    path = quasi_geodesic(surface, i, j)
                    assert path.length == pytest.approx(d[j], rel=1e-10)
                    check_definition(path, surface, metric)

    def test_from_edges_it_is_locally_shortest_and_never_below_the_distance(self):
        surface = Surface(*shapes.terrain(250, 3, 0.2))
        pairs = np.random.default_rng(0).choice(250, (60, 2))
        pairs = pairs[pairs[:, 0] != pairs[:, 1]]
        for (i, j), path in zip(pairs, quasi_geodesics(surface, pairs), strict=True):
            assert path.length >= exact(surface, i)[j] * (1 - ROUNDING)
            assert path.length <= path.lengths[0] * (1 + ROUNDING)
            assert len(path.initial_points) >= 2
            check_definition(path, surface)

    def test_in_a_lifted_metric(self):
        surface = Surface(*shapes.blob(3, seed=5))
        f = np.sin(3 * surface.vertices[:, 0]) + surface.vertices[:, 2] ** 2
        a, b = surface.edges.T
        metric = LiftedMetric(surface, f, 0.2, np.hypot(surface.edge_lengths, 0.2 * (f[a] - f[b])))
        d = exact(surface, 4, metric)
        for j in range(0, surface.n_vertices, 41):
            if j != 4:
                path = quasi_geodesic(surface, 4, j, metric)
                assert path.length == pytest.approx(d[j], rel=1e-10)
                check_definition(path, surface, metric)

    @settings(max_examples=60)
    @given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.05, 1.0]), st.booleans(), st.booleans())
    def test_on_random_meshes(self, seed, roughness, lattice, from_edges):
        rng = np.random.default_rng(seed)
        points = rng.uniform(size=(40, 2))
        if lattice:
            points = np.unique(np.round(points * 5), axis=0)
        faces = Delaunay(points).simplices
        surface = Surface(np.column_stack([points, roughness * rng.normal(size=len(points))]), faces)
        i, j = rng.choice(np.unique(faces), 2, replace=False)
        d = exact(surface, i)[j]
        path = quasi_geodesic(surface, int(i), int(j), initial="edges" if from_edges else "exact")
        assert path.length >= d * (1 - 1e-9)
        if not from_edges:
            assert path.length <= d * (1 + 1e-9)
        assert path.converged


class TestInvariances:
    def test_the_way_back_is_the_mirror_image(self):
        surface = Surface(*shapes.blob(3))
        there, back = quasi_geodesic(surface, 5, 300), quasi_geodesic(surface, 300, 5)
        assert there.length == pytest.approx(back.length, rel=ROUNDING)
        np.testing.assert_allclose(there.points, back.points[::-1], atol=1e-7)
        np.testing.assert_allclose(there.left_angle, back.right_angle[::-1], atol=1e-6)

    @pytest.mark.parametrize("scale", [1e-9, 1e9])
    def test_scale(self, scale):
        vertices, faces = shapes.blob(3)
        one, other = (
            quasi_geodesic(Surface(vertices, faces), 7, 400),
            quasi_geodesic(Surface(scale * vertices, faces), 7, 400),
        )
        assert other.length == pytest.approx(scale * one.length, rel=ROUNDING)
        np.testing.assert_allclose(other.points, scale * one.points, atol=1e-9 * scale)

    def test_orientation_of_faces_does_not_matter(self):
        vertices, faces = shapes.blob(2)
        rng = np.random.default_rng(3)
        mixed = np.array([f[:: rng.choice([-1, 1])] for f in faces])
        for j in range(1, 160, 13):
            one, other = quasi_geodesic(Surface(vertices, faces), 0, j), quasi_geodesic(Surface(vertices, mixed), 0, j)
            assert one.length == pytest.approx(other.length, rel=ROUNDING)
            assert other.converged

    def test_threads_do_not_matter(self):
        surface = Surface(*shapes.torus(20, 10))
        pairs = np.random.default_rng(1).choice(200, (40, 2))
        one = quasi_geodesics(surface, pairs, workers=1)
        two = quasi_geodesics(surface, pairs, workers=2, progress=True)
        for a, b in zip(one, two, strict=True):
            np.testing.assert_array_equal(a.points, b.points)

    def test_arrays_are_read_only(self):
        path = quasi_geodesic(Surface(*shapes.icosphere(1)), 0, 20)
        assert not path.points.flags.writeable
        assert not path.kappa_g.flags.writeable


class TestSpecialPairs:
    def test_to_itself_the_length_is_zero(self):
        surface = Surface(*shapes.icosphere(1))
        path = quasi_geodesic(surface, 3, 3)
        assert path.length == 0.0
        assert path.converged
        np.testing.assert_array_equal(path.points, surface.vertices[[3, 3]])
        assert path.kappa_g.shape == (0,)

    @BOTH
    def test_to_a_neighbour_it_is_the_edge_or_shorter(self, initial):
        surface = Surface(*shapes.terrain(120, 9, 0.5))
        for (i, j), length in zip(surface.edges[::9], surface.edge_lengths[::9], strict=True):
            path = quasi_geodesic(surface, i, j, initial=initial)
            assert path.length <= length * (1 + ROUNDING)
            check_definition(path, surface)

    def test_one_triangle(self):
        surface = Surface([[0, 0, 0], [3, 0, 0], [0, 4, 0]], [[0, 1, 2]])
        path = quasi_geodesic(surface, 1, 2)
        assert path.length == 5
        assert path.vertices.tolist() == [1, 2]

    @BOTH
    def test_along_the_boundary(self, initial):
        surface = Surface(*shapes.grid(4))
        path = quasi_geodesic(surface, 0, 4, initial=initial)
        assert path.length == pytest.approx(1.0, rel=ROUNDING)
        assert path.converged

    @BOTH
    def test_an_edge_without_length_is_no_trap(self, initial):
        vertices, faces = shapes.grid(4)
        vertices = vertices.copy()
        vertices[7] = vertices[12]
        surface = Surface(vertices, faces)
        d = exact(surface, 18)
        for i in range(25):
            assert quasi_geodesic(surface, i, 18, initial=initial).length >= d[i] * (1 - ROUNDING)
            if initial == "exact":
                assert quasi_geodesic(surface, i, 18).length == pytest.approx(d[i], rel=ROUNDING)

    @pytest.mark.parametrize("gap", [1e-12, 0.0])
    @BOTH
    def test_past_vertices_that_nearly_coincide(self, initial, gap):
        vertices, faces = shapes.blob(2)
        vertices = vertices.copy()
        for k in range(10, 60, 7):
            a, b = faces[k, :2]
            vertices[a] = vertices[b] + gap
        surface = Surface(vertices, faces)
        d = exact(surface, 2)
        for j in range(3, 160, 11):
            path = quasi_geodesic(surface, 2, j, initial=initial)
            assert path.length >= d[j] - 1e-9
            assert np.isfinite(path.points).all()
            if initial == "exact":
                assert path.length == pytest.approx(d[j], abs=1e-9)


class TestBadInput:
    def test_other_piece(self):
        vertices, faces = shapes.icosphere(0)
        both = Surface(np.concatenate([vertices, vertices + 3]), np.concatenate([faces, faces + 12]))
        for initial in ("exact", "edges"):
            with pytest.raises(DisconnectedError, match=r"vertices 1 and 13 lie in different pieces .*2 pieces"):
                quasi_geodesic(both, 1, 13, initial=initial)

    def test_not_a_vertex(self):
        with pytest.raises(MeshError, match="j is vertex 12, but there are 12 vertices"):
            quasi_geodesic(Surface(*shapes.icosphere(0)), 0, 12)

    def test_not_a_surface(self):
        with pytest.raises(NonManifoldError, match="a geodesic path needs a manifold mesh"):
            quasi_geodesic(Surface(*shapes.fan()), 0, 2)

    def test_unknown_first_path(self):
        with pytest.raises(ValueError, match="initial must be one of 'exact', 'edges', got 'heat'"):
            quasi_geodesic(Surface(*shapes.icosphere(0)), 0, 2, initial="heat")

    def test_pairs_of_wrong_shape(self):
        with pytest.raises(MeshError, match=r"pairs must have shape \(k, 2\), got \(3,\)"):
            quasi_geodesics(Surface(*shapes.icosphere(0)), [0, 2, 3])
