"""Triangles whose corners lie on one line, or nearly so: they close gaps and must not lengthen any path."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapes

from qgeo_filters import Surface
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.geodesics.metric import cartesian_metric
from qgeo_filters.geodesics.path.paths import quasi_geodesic
from qgeo_filters.geodesics.unfolding import unfolded

# Sums of a few hundred rounded terms.
ROUNDING = 1e-12
SEEDS = range(24)


def rough_mesh(rng: np.random.Generator) -> shapes.Mesh:
    """A terrain, a closed blob or a torus whose vertices are saddles and peaks in turn."""
    kind = rng.integers(3)
    if kind == 0:
        return shapes.terrain(int(rng.integers(12, 40)), int(rng.integers(1000)), 0.3)
    vertices, faces = shapes.blob(1, seed=int(rng.integers(1000))) if kind == 1 else shapes.torus(8, 6)
    return vertices + 0.12 * rng.normal(size=vertices.shape), faces


def opened(mesh: shapes.Mesh, rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, and two lists of faces of one surface: with gaps along edges closed by flat triangles, and without gaps.

    Up to three points split an edge for the faces on one side, up to three others for those on the other side; between
    the two chains lies a polygon without area, triangulated at random. Without gaps, both sides know all points. New
    points out of the plane of each face behind make the points of the edge saddles, so that shortest paths bend there.
    """
    points, used = [*mesh[0]], set()
    closed, whole = [], []
    surface = Surface(*mesh)
    faces, twins = surface.faces, surface.twins.ravel()
    for h in rng.permutation(np.flatnonzero(twins >= 0)):
        f, g = h // 3, twins[h] // 3
        if len(used) >= 2 * count or f in used or g in used:
            continue
        used |= {f, g}
        u, v, apex = np.roll(faces[f], -(h % 3))
        other_apex = faces[g][(twins[h] % 3 + 2) % 3]
        chains = []
        for size in rng.permutation([rng.integers(1, 4), rng.integers(0, 4)]):
            fractions = np.sort(rng.uniform(0.05, 0.95, size))
            chains.append([(t, len(points) + i) for i, t in enumerate(fractions)])
            points += [(1 - t) * points[u] + t * points[v] for t in fractions]
        for chain, tip, order in ((chains[0], apex, (0, 1, 2)), (chains[1], other_apex, (1, 0, 2))):
            ends = [(0.0, u), *chain, (1.0, v)]
            for (s, a), (t, b) in pairwise(ends):
                top = len(points)
                lift = 0.3 * rng.uniform() * np.linalg.norm(points[v] - points[u]) * rng.normal(size=3)
                points.append((points[a] + points[b] + points[tip]) / 3 + lift)
                behind = [np.array(corners)[list(order)] for corners in ((b, tip, top), (tip, a, top))]
                closed += [*behind, np.array((a, b, top))[list(order)]]
                between = [a, *(i for w, i in sorted(chains[0] + chains[1]) if s < w < t), b]
                pieces = pairwise(between)
                whole += [*behind, *(np.array((c, d, top))[list(order)] for c, d in pieces)]
        polygon = [u, *(i for _, i in chains[1]), v, *(i for _, i in chains[0][::-1])]
        while len(polygon) > 2:
            k = rng.integers(len(polygon))
            closed.append(np.array((polygon[k - 1], polygon[k], polygon[(k + 1) % len(polygon)])))
            del polygon[k]
    rest = [face for i, face in enumerate(faces) if i not in used]
    return np.array(points), np.array(rest + closed), np.array(rest + whole)


@pytest.fixture(params=SEEDS)
def two(request):
    """One surface twice: with flat triangles, and without."""
    rng = np.random.default_rng(request.param)
    points, closed, whole = opened(rough_mesh(rng), rng, int(rng.integers(1, 8)))
    return Surface(points, closed), Surface(points, whole)


def test_exact_distances_are_those_without_the_flat_triangles(two):
    with_flat, without = two
    assert (with_flat.face_areas <= 1e-15).any()
    every = np.arange(without.n_vertices)
    d = distances(with_flat, every, method="exact")
    np.testing.assert_allclose(d, distances(without, every, method="exact"), rtol=ROUNDING)
    np.testing.assert_allclose(d, d.T, rtol=ROUNDING)


def test_graph_keeps_its_bound(two):
    with_flat, without = two
    every = np.arange(without.n_vertices)
    exact = distances(without, every, method="exact")
    graph = distances(with_flat, every, method="graph")
    assert (graph >= exact * (1 - 1e-9)).all()
    assert (graph <= exact * (1 + 1e-3)).all()


@pytest.mark.parametrize("height", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14])
def test_nearly_flat_triangles(height):
    """Both methods agree on one surface, from either end, and differ from another triangulation by the height only."""
    for seed in range(6):
        rng = np.random.default_rng(seed)
        points, closed, whole = opened(rough_mesh(rng), rng, 5)
        points = points + height * rng.normal(size=points.shape)
        every = np.arange(len(points))
        surface = Surface(points, closed)
        d = distances(surface, every, method="exact")
        np.testing.assert_allclose(d, d.T, rtol=1e-10)
        graph = distances(surface, every, method="graph")
        assert (graph >= d * (1 - 1e-9)).all()
        assert (graph <= d * (1 + 1e-3)).all()
        # Sides that are rounded leave a height of 1e-8 unknown.
        np.testing.assert_allclose(d, distances(Surface(points, whole), every, method="exact"), atol=50 * height + 1e-7)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_path_bends_at_a_saddle_on_the_edge_of_one_face(scale):
    """From behind a saddle in the middle of an edge, the shortest path goes through it into the face opposite."""
    vertices = scale * np.array(
        [[-1.0, 0, 0], [0, 0, 0], [1, 0, 0], [0.2, 1, 0], [-1, -1, 1.5], [0, -1, -1.5], [1, -1, 1.5]]
    )
    closed = [[0, 2, 3], [0, 1, 2], [0, 4, 1], [4, 5, 1], [5, 6, 1], [6, 2, 1]]
    surface = Surface(vertices, closed)
    assert unfolded(cartesian_metric(surface).intrinsic()).angles[1] > 2.5 * np.pi
    to_saddle = np.linalg.norm(vertices[1] - vertices[[3, 5]], axis=1)
    d = distances(surface, [3, 5], method="exact")
    assert d[0, 5] == pytest.approx(to_saddle.sum(), rel=ROUNDING)
    assert d[1, 3] == pytest.approx(to_saddle.sum(), rel=ROUNDING)
    for i, j in ((3, 5), (5, 3)):
        path = quasi_geodesic(surface, i, j)
        assert path.length == pytest.approx(to_saddle.sum(), rel=1e-7)
        assert 1 in path.vertices


def test_paths_over_flat_triangles_have_angles_and_none_is_shorter_than_the_exact_distance(two):
    """Several edges cross in one place there, from one to the next of which a path has no direction."""
    surface, _ = two
    d = distances(surface, np.arange(surface.n_vertices), method="exact")
    for i, j in np.random.default_rng(0).choice(surface.n_vertices, size=(12, 2)):
        if i != j and np.isfinite(d[i, j]):
            path = quasi_geodesic(surface, int(i), int(j))
            assert path.length >= d[i, j] * (1 - 1e-7)
            total = path.left_angle + path.right_angle
            on_edge = path.vertices[1:-1] < 0
            np.testing.assert_allclose(total[on_edge], 2 * np.pi, atol=1e-6)
            assert np.isfinite(path.kappa_g).all()


def test_tidy_meshes_have_no_views():
    for mesh in (shapes.blob(2), shapes.torus(12, 8), shapes.grid(6), shapes.terrain(60, 1, 0.2)):
        surface = Surface(*mesh)
        assert len(unfolded(cartesian_metric(surface).intrinsic()).views) == 0
