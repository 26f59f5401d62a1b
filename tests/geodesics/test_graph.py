"""The graph method against exact MMP: the bound, the invariances, the odd meshes."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
import shapes
from graph_cases import MANIFOLDS, exact_rows, lifted_plane, relative_error
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from qgeo_filters.errors import MeshError, NonManifoldError
from qgeo_filters.geodesics.dgg.construction import direct_geodesics_from
from qgeo_filters.geodesics.dgg.graph import geodesic_graph
from qgeo_filters.geodesics.matrix import distance_matrix, distances
from qgeo_filters.geodesics.metric import cartesian_metric
from qgeo_filters.geodesics.unfolding import unfolded_sides
from qgeo_filters.surface import Surface

BELOW = -1e-9  # pygeodesic's own rounding; the graph's lengths are rounded up


@pytest.mark.parametrize("name", MANIFOLDS)
def test_error_bound_on_every_kind_of_mesh(name: str) -> None:
    vertices, faces = MANIFOLDS[name]()
    sources = np.arange(0, len(vertices), len(vertices) // 12)
    error = relative_error(distances(Surface(vertices, faces), sources), exact_rows(vertices, faces, sources))
    assert error.min() > BELOW
    assert error.max() < 1e-3
    assert error.mean() < 3e-4


@pytest.mark.parametrize("accuracy", [1e-1, 1e-2, 1e-4, 1e-5])
def test_accuracy_is_kept(accuracy: float) -> None:
    vertices, faces = shapes.blob(3, seed=4)
    sources = np.arange(0, len(vertices), 60)
    error = relative_error(
        distances(Surface(vertices, faces), sources, accuracy=accuracy), exact_rows(vertices, faces, sources)
    )
    assert error.min() > BELOW
    assert error.max() < accuracy
    assert error.max() > accuracy / 50  # the bound is no bluff: a coarser graph is really used


@pytest.mark.parametrize("weight", [0.03, 0.3, 2.0])
def test_lifted_metric_is_the_surface_in_space(weight: float) -> None:
    metric, lifted = lifted_plane(weight)
    sources = np.arange(0, len(lifted), 20)
    error = relative_error(
        distances(metric.surface, sources, metric), exact_rows(lifted, metric.surface.faces, sources)
    )
    assert error.min() > BELOW
    assert error.max() < 1e-3


@pytest.mark.parametrize("name", ["blob", "sharp cone", "irregular plane", "Moebius band"])
def test_every_edge_of_the_graph_against_exact_distances(name: str) -> None:
    """An edge is a straight line: never shorter than the distance, and nearly always just that long."""
    vertices, faces = MANIFOLDS[name]()
    surface = Surface(vertices, faces)
    sources = np.arange(0, len(vertices), 10, dtype=np.int32)
    counts, ends, lengths = direct_geodesics_from(
        *unfolded_sides(cartesian_metric(surface).intrinsic()), sources, 1e-3, np.inf
    )
    exact = exact_rows(vertices, faces, sources)[np.repeat(np.arange(len(sources)), counts), ends]
    excess = relative_error(lengths, exact)
    assert excess.min() > -1e-9
    assert np.mean(excess < 1e-9) > 0.95


def test_edges_cover_all_directions() -> None:
    """In the plane the covering condition can be checked: some edge leads to every vertex with a small detour."""
    vertices, faces = shapes.terrain(500, 2)
    surface = Surface(vertices, faces)
    epsilon = 1e-3
    counts, ends, lengths = direct_geodesics_from(
        *unfolded_sides(cartesian_metric(surface).intrinsic()), np.arange(500, dtype=np.int32), epsilon, np.inf
    )
    straight = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    start = np.concatenate([[0], np.cumsum(counts)])
    for v in range(0, 500, 7):
        hop, end = lengths[start[v] : start[v + 1]], ends[start[v] : start[v + 1]]
        slack = straight[v][None] + epsilon * hop[:, None] - (hop[:, None] + straight[end])
        assert slack.max(axis=0)[np.arange(500) != v].min() > -1e-12


@settings(max_examples=25)
@given(seed=st.integers(0, 10**6), n=st.integers(4, 60), stretch=st.floats(1, 1000), weight=st.floats(0, 3))
def test_random_lifted_triangulations(seed: int, n: int, stretch: float, weight: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.random((n, 2))
    faces = Delaunay(points).simplices
    vertices = np.column_stack([points[:, 0] * stretch, points[:, 1], weight * rng.normal(size=n)])
    matrix = distance_matrix(Surface(vertices, faces))
    error = relative_error(matrix[:3].astype(float), exact_rows(vertices, faces, np.arange(3)))
    assert np.array_equal(matrix, matrix.T)
    assert error.min() > -1e-6
    assert error.max() < 1e-3


def test_plane_is_euclidean() -> None:
    vertices, faces = shapes.grid(20, jitter=0.3)
    straight = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    error = relative_error(distance_matrix(Surface(vertices, faces)).astype(float), straight)
    assert error.min() > -1e-6
    assert error.max() < 1e-3


def test_cylinder_is_its_own_unrolling() -> None:
    around, along, height = 48, 12, 2.0
    vertices, faces = shapes.cylinder(around, along, 1.0, height)
    side = 2 * np.sin(np.pi / around)  # of the prism that the mesh is
    k = np.arange(around)
    turned = np.minimum(k, around - k) * side
    expected = np.sqrt(turned[None] ** 2 + (np.arange(along + 1) * height / along)[:, None] ** 2).ravel()
    error = relative_error(distances(Surface(vertices, faces), [0])[0], expected)
    assert error.min() > -1e-9
    assert error.max() < 1e-3


def test_cone_unrolls_to_a_sector() -> None:
    around, along, slope = 40, 10, 3.0
    vertices, faces = shapes.cone(around, along, slope)
    side = np.linalg.norm(vertices[-1]) / along
    wedge = 2 * np.arcsin(np.linalg.norm(vertices[1] - vertices[2]) / 2 / side)  # angle of one side face at the apex
    ring, k = np.divmod(np.arange(around * along), around)
    angle = np.minimum(k, around - k) * wedge
    radius = (ring + 1) * side
    source = side * 5  # vertex 1 + 4 * around
    apart = np.sqrt(radius**2 + source**2 - 2 * radius * source * np.cos(np.minimum(angle, np.pi)))
    expected = np.concatenate([[source], np.where(angle >= np.pi, radius + source, apart)])
    error = relative_error(distances(Surface(vertices, faces), [1 + 4 * around])[0], expected)
    assert error.min() > -1e-9
    assert error.max() < 1e-3


def test_sphere_converges_with_the_square_of_the_edge_length() -> None:
    errors = []
    for level in (1, 2, 3, 4):
        vertices, faces = shapes.icosphere(level)
        row = distances(Surface(vertices, faces), [0], accuracy=1e-4)[0]
        errors.append(np.abs(row - np.arccos(np.clip(vertices @ vertices[0], -1, 1))).max())
    slopes = np.diff(np.log2(errors))
    assert np.all(slopes < -1.5), errors


def test_invariances() -> None:
    vertices, faces = shapes.blob(3, seed=2)
    rng = np.random.default_rng(0)
    reference = distance_matrix(Surface(vertices, faces)).astype(float)
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    permutation = rng.permutation(len(vertices))
    back = np.argsort(permutation)
    flipped = faces.copy()
    flipped[::3] = flipped[::3, ::-1]
    others = {
        "rigid motion": (vertices @ rotation.T + [3, 1, 2], faces, 1.0),
        "1e-9 times": (1e-9 * vertices, faces, 1e-9),
        "1e9 times": (1e9 * vertices, faces, 1e9),
        "order of faces": (vertices, faces[rng.permutation(len(faces))], 1.0),
        "turned faces": (vertices, flipped, 1.0),
        "rolled faces": (vertices, np.roll(faces, 1, axis=1), 1.0),
    }
    for name, (v, f, scale) in others.items():
        other = distance_matrix(Surface(v, f)).astype(float) / scale
        assert np.abs(relative_error(other, reference)).max() < 1e-3, name
    permuted = distance_matrix(Surface(vertices[permutation], back[faces])).astype(float)
    assert np.abs(relative_error(permuted[np.ix_(back, back)], reference)).max() < 1e-3


def test_power_of_two_scales_bit_for_bit() -> None:
    vertices, faces = shapes.blob(2)
    one, other = distance_matrix(Surface(vertices, faces)), distance_matrix(Surface(vertices * 2.0**-40, faces))
    assert np.array_equal(other, one * np.float32(2.0**-40))


def test_needles_and_zero_edges() -> None:
    vertices, faces = shapes.grid(12, jitter=0.2)
    vertices = vertices.copy()
    rng = np.random.default_rng(1)
    for a, b, _ in faces[rng.permutation(len(faces))[:10]]:
        vertices[a] = vertices[b] + [1e-12 * rng.normal(), 1e-12 * rng.normal(), 0]
    surface = Surface(vertices, faces)
    matrix = distance_matrix(surface)
    assert np.isfinite(matrix).all()
    assert np.array_equal(matrix, matrix.T)
    sources = np.arange(0, len(vertices), 12)
    exact = exact_rows(vertices, faces, sources)
    far = exact > 1e-9  # the oracle loses its digits below
    error = relative_error(distances(surface, sources), exact)[far]
    assert error.min() > -1e-7
    assert error.max() < 1e-3
    flat = Surface(np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2], [1, 3, 2]]))
    assert np.allclose(distance_matrix(flat), [[0, 1, 1, 2], [1, 0, 0, 1], [1, 0, 0, 1], [2, 1, 1, 0]])


def test_pieces_and_loose_vertices_are_infinitely_far() -> None:
    a, b = shapes.torus(20, 10), shapes.blob(2)
    n, m = len(a[0]), len(b[0])
    both = Surface(np.vstack([[[9.0, 9, 9]], a[0], b[0] + 5, [[8.0, 8, 8]]]), np.vstack([a[1] + 1, b[1] + 1 + n]))
    matrix = distance_matrix(both)
    piece = np.concatenate([[0], np.full(n, 1), np.full(m, 2), [3]])
    assert np.array_equal(np.isinf(matrix), piece[:, None] != piece[None])
    assert not np.diag(matrix).any()
    alone = distance_matrix(Surface(*a))
    assert np.abs(relative_error(matrix[1 : n + 1, 1 : n + 1].astype(float), alone.astype(float))).max() < 1e-3


def test_arguments_are_checked() -> None:
    surface = Surface(*shapes.grid(3))
    with pytest.raises(ValueError, match=r"accuracy is a relative error from 1e-6 to 0\.1, got 0"):
        distances(surface, [0], accuracy=0)
    with pytest.raises(ValueError, match="method must be one of 'graph', 'exact', 'edges', got 'heat'"):
        distances(surface, [0], method="heat")
    with pytest.raises(MeshError, match=r"sources\[1\] is vertex 99"):
        distances(surface, [0, 99])
    with pytest.raises(ValueError, match="workers must be at least 1, got 0"):
        distance_matrix(surface, workers=0)
    with pytest.raises(ValueError, match="the metric belongs to a surface of 25 vertices"):
        distances(surface, [0], cartesian_metric(Surface(*shapes.grid(4))))
    with pytest.raises(NonManifoldError, match=r"edge \(0, 1\) has 3 faces"):
        distance_matrix(Surface(*shapes.fan()))
    with pytest.raises(NonManifoldError, match="more than one fan"):
        distance_matrix(Surface(*shapes.bow_tie()))
    with pytest.raises(MeshError, match="float32 does not hold such distances"):
        distance_matrix(Surface(shapes.grid(3)[0] * 1e40, shapes.grid(3)[1]))


def test_graph_is_kept_and_let_go() -> None:
    from qgeo_filters.geodesics.dgg.graph import graph_of

    surface = Surface(*shapes.blob(2))
    kept = weakref.ref(graph_of(cartesian_metric(surface), 1e-3, 1))
    assert graph_of(cartesian_metric(surface), 1e-3, 1) is kept()
    assert graph_of(cartesian_metric(surface), 1e-2, 1).accuracy == 1e-2
    del surface
    gc.collect()
    assert kept() is None


def test_lengths_are_whole_ticks() -> None:
    """Sums of whole numbers are exact: this is why the matrix is symmetric, whatever the order of the sums."""
    vertices, faces = shapes.grid(8, jitter=0.3)
    fixed = geodesic_graph(cartesian_metric(Surface(vertices, faces)).intrinsic()).fixed
    assert fixed.length.dtype == np.uint32
    assert fixed.near.size == 0

    few = vertices.copy()  # one short edge: 32 bits, and its neighbourhood apart
    few[40] = few[41] + [1e-8, 0, 0]
    graph = geodesic_graph(cartesian_metric(Surface(few, faces)).intrinsic())
    assert graph.fixed.length.dtype == np.uint32
    assert sorted(graph.vertex[graph.fixed.near].tolist()) == [40, 41]
    assert np.allclose(distances(Surface(few, faces), [40])[0, 41], 1e-8, rtol=1e-12)

    many = 1e-9 * vertices  # nearly all are: float64
    many[-1] = 1
    fixed = geodesic_graph(cartesian_metric(Surface(many, faces)).intrinsic()).fixed
    assert fixed.length.dtype == np.float64
    assert np.array_equal(fixed.length, np.round(fixed.length))
    for each in (few, many):
        matrix = distance_matrix(Surface(each, faces))
        assert np.array_equal(matrix, matrix.T)
        exact = distances(Surface(each, faces), np.arange(len(each)), method="exact")
        assert np.abs(relative_error(matrix.astype(float), exact)).max() < 1e-3
