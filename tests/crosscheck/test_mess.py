"""Distances on random meshes as they come: needles, holes, handles, any scale, far from the origin.

The graph never leaves its bound above the exact distance, and what the numbering and the scale may change is stated.
Where the exact distance differs from that of pygeodesic on needles, the straight line tells who is right.
"""

from __future__ import annotations

import numpy as np
import pygeodesic.geodesic as pygeodesic
import pytest
import shapes

from qgeo_filters import Surface, surface_scalar
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.geodesics.metric import lifted_metric

ROUNDING, ACCURACY = 1e-9, 1e-3
BUILT_IN = ("mean_curvature", "gaussian_curvature", "differential_norm")


def two_handles() -> shapes.Mesh:
    """A closed surface of genus 2: a torus and its mirror image, joined where each lacks one triangle."""
    vertices, faces = shapes.torus(14, 7)
    hole = faces[np.argmax(vertices[faces][..., 0].min(axis=1))]
    faces = faces[(faces != hole).any(axis=1)]
    n = len(vertices)
    far = vertices * [-1, 1, 1] + [2.1 * vertices[hole, 0].max(), 0, 0]
    twin = np.arange(n) + n
    twin[hole] = hole  # the image of a corner of the hole is that corner
    used, compact = np.unique(np.vstack([faces, twin[faces[:, ::-1]]]), return_inverse=True)
    return np.vstack([vertices, far])[used], compact.reshape(-1, 3)


def messy(seed: int) -> Surface:
    """A terrain, a blob, a body with two handles or a plate of needles, with holes, noise, a scale and an offset."""
    rng = np.random.default_rng(seed)
    kind = seed % 4
    if kind == 0:
        vertices, faces = shapes.terrain(
            int(rng.integers(12, 80)), seed, 0.3 * rng.uniform(), rng.choice([1, 0.05, 1e-3])
        )
    elif kind == 1:
        vertices, faces = shapes.blob(2, seed=seed)
    elif kind == 2:
        vertices, faces = two_handles()
    else:
        vertices, faces = shapes.grid(int(rng.integers(4, 9)), jitter=0.2)
        vertices = vertices * [1, 10.0 ** -rng.integers(1, 9), 1]
    vertices = vertices + rng.choice([0, 1e-6, 0.02]) * rng.normal(size=vertices.shape)
    surface = Surface(vertices, faces[rng.uniform(size=len(faces)) > rng.choice([0, 0.1])])
    while surface.nonmanifold_vertices.size:  # holes that touch
        keep = ~np.isin(surface.faces, surface.nonmanifold_vertices).any(axis=1)
        surface = Surface(vertices, surface.faces[keep])
    offset = rng.choice([0, 0, 1e6]) * rng.normal(size=3)
    return surface.with_vertices((surface.vertices + offset) * 10.0 ** rng.integers(-9, 10))


@pytest.mark.filterwarnings("ignore:distances between the:UserWarning")  # holes leave pieces
@pytest.mark.parametrize("seed", range(40))
def test_graph_keeps_its_bound_in_any_mess(seed):
    surface = messy(seed)
    every = np.arange(0, surface.n_vertices, 1 + surface.n_vertices // 40)
    exact = distances(surface, every, method="exact")
    graph = distances(surface, every, method="graph")
    reached = np.isfinite(exact)
    np.testing.assert_array_equal(np.isfinite(graph), reached)
    assert (graph[reached] >= exact[reached] * (1 - ROUNDING)).all()
    assert (graph[reached] <= exact[reached] * (1 + ACCURACY)).all()
    among = exact[:, every]
    np.testing.assert_allclose(among, among.T, rtol=ROUNDING)


@pytest.mark.parametrize("stretch", [1e-3, 1e-4, 1e-5])
def test_on_needles_the_straight_line_is_nearer_to_ours_than_to_pygeodesic(stretch):
    """In a convex plane plate the truth is the straight line: sides of needles, rounded, are all that is off."""
    ours, theirs = [], []
    for seed in range(6):
        vertices, faces = shapes.grid(8, jitter=0.2, seed=seed)
        vertices = vertices * [1, stretch, 1]
        surface = Surface(vertices, faces)
        sources = np.arange(0, len(vertices), 9)
        straight = np.linalg.norm(vertices[sources][:, None] - vertices[None], axis=2)
        solver = pygeodesic.PyGeodesicAlgorithmExact(surface.vertices, surface.faces)
        apart = straight > 0
        for found, rows in (
            (ours, distances(surface, sources, method="exact")),
            (theirs, np.array([solver.geodesicDistances([int(s)], None)[0] for s in sources])),
        ):
            found.append(np.abs(rows[apart] / straight[apart] - 1).max())
    # A side moves the apex by (length / width)^2 times its own rounding.
    assert max(ours) < 50 * np.finfo(float).eps / stretch**2
    assert max(ours) < max(theirs)


def renumbered(surface: Surface, rng: np.random.Generator) -> tuple[Surface, np.ndarray]:
    """The surface with vertices, faces and corners in another order, and the new number of each vertex."""
    number = rng.permutation(surface.n_vertices)
    vertices = np.empty_like(surface.vertices)
    vertices[number] = surface.vertices
    faces = np.array([np.roll(number[face], rng.integers(3)) for face in surface.faces])
    return Surface(vertices, rng.permutation(faces)), number


@pytest.mark.parametrize("seed", range(12))
def test_scalar_depends_on_neither_numbering_nor_scale(seed):
    rng = np.random.default_rng(seed)
    surface = messy(seed)
    other, number = renumbered(surface.with_vertices(surface.vertices * 2.0 ** rng.integers(-30, 30)), rng)
    for name in BUILT_IN:
        f, g = (surface_scalar(s, name, clip=None) for s in (surface, other))
        np.testing.assert_allclose(g[number], f, rtol=1e-7, atol=1e-7 * np.abs(f).max())


def test_ties_at_a_percentile_are_the_one_thing_that_numbering_decides():
    """On a coarse torus rings of vertices have one value: clipping differs by the share of a vertex, and no more."""
    surface = Surface(*shapes.torus(7, 5))
    f = surface_scalar(surface)
    apart = []
    for seed in range(20):
        other, number = renumbered(surface, np.random.default_rng(seed))
        apart.append(np.abs(surface_scalar(other)[number] - f).max())
    assert max(apart) < 0.1


@pytest.mark.parametrize("seed", range(6))
def test_rows_of_a_lifted_metric_depend_on_neither_numbering_nor_scale(seed):
    """Where no values are tied: exact rows up to rounding, those of the graph within its bound."""
    rng = np.random.default_rng(seed)
    vertices, faces = (shapes.blob(2, seed=seed), two_handles())[seed % 2]
    surface = Surface((vertices + 0.01 * rng.normal(size=vertices.shape)) * [1, 1, rng.choice([1, 0.01])], faces)
    scale = 10.0 ** rng.integers(-9, 10)
    other, number = renumbered(surface.with_vertices(scale * surface.vertices), rng)
    sources = np.arange(0, surface.n_vertices, 20)
    metrics = lifted_metric(surface), lifted_metric(other)
    d = distances(surface, sources, metrics[0], method="exact")
    e = distances(other, number[sources], metrics[1], method="exact")[:, number] / scale
    np.testing.assert_allclose(e, d, rtol=1e-8)
    near = distances(surface, sources, metrics[0]), distances(other, number[sources], metrics[1])[:, number] / scale
    for graph in near:
        assert (graph >= d * (1 - ROUNDING)).all()
        assert (graph <= d * (1 + ACCURACY)).all()
