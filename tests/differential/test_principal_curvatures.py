"""Fitted curvatures: they converge on irregular meshes, bear noise and detail, and the surface alone decides."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob, cone, cylinder, grid, icosphere, terrain, torus

import qgeo_filters as qg
from qgeo_filters.differential.curvature import PrincipalCurvatures, principal_curvatures
from qgeo_filters.errors import MeshError
from qgeo_filters.surface import Surface

Curvatures = tuple[np.ndarray, np.ndarray]


def irregular_torus(n: int) -> tuple[Surface, Curvatures]:
    """Torus of radii 1 and .4 with n vertices about its tube, the parameters of each moved by up to .3 of a step."""
    around, tube = np.divmod(np.arange(n * (5 * n // 2)), n)
    moved = np.random.default_rng(n).uniform(-0.3, 0.3, (2, len(tube)))
    s, t = 2 * np.pi * (around + moved[0]) / (5 * n // 2), 2 * np.pi * (tube + moved[1]) / n
    ring = 1 + 0.4 * np.cos(t)
    vertices = np.column_stack([ring * np.cos(s), ring * np.sin(s), 0.4 * np.sin(t)])
    return Surface(vertices, torus(5 * n // 2, n)[1]), (np.full(len(t), 2.5), np.cos(t) / ring)


def ellipsoid(level: int) -> tuple[Surface, Curvatures]:
    """Ellipsoid with axes 1.5, 1 and .7: triangles of three shapes, no umbilic but four points."""
    axes = np.array([1.5, 1.0, 0.7])
    vertices, faces = icosphere(level)
    vertices = vertices * axes
    height = 1 / np.linalg.norm(vertices / axes**2, axis=1)
    mean = height**3 * ((axes**2).sum() - (vertices**2).sum(axis=1)) / (2 * axes.prod() ** 2)
    root = np.sqrt(np.maximum(mean**2 - height**4 / axes.prod() ** 2, 0))
    return Surface(vertices, faces), (mean + root, mean - root)


def noisy(surface: Surface, amount: float) -> Surface:
    step = np.random.default_rng(0).normal(size=surface.vertices.shape) * surface.edge_lengths.mean()
    return Surface(surface.vertices + amount * step, surface.faces)


def error(found: PrincipalCurvatures, truth: Curvatures) -> float:
    """Root mean square error of (k1, k2) over the root mean square curvature."""
    wrong = np.hypot(found.k1 - truth[0], found.k2 - truth[1])
    return float(np.sqrt(np.mean(wrong**2) / np.mean(np.hypot(*truth) ** 2)))


@pytest.mark.parametrize(
    ("make", "sizes", "last"), [(irregular_torus, (16, 32, 48), 0.006), (ellipsoid, (3, 4, 5), 0.004)]
)
def test_error_falls_with_the_square_of_the_edge(make, sizes, last):
    samples = [make(size) for size in sizes]
    errors = [error(principal_curvatures(surface), truth) for surface, truth in samples]
    slope = np.polyfit(np.log([surface.edge_lengths.mean() for surface, _ in samples]), np.log(errors), 1)[0]
    assert slope > 1.8
    assert errors[-1] < last


@pytest.mark.parametrize(
    ("mesh", "truth", "bound"),
    [
        (icosphere(2), (1, 1), 0.08),
        (icosphere(3), (1, 1), 0.01),
        (cylinder(40, 20), (1, 0), 0.01),  # the vertices at its ends too
        (cylinder(16, 40, 1.0, 15.0), (1, 0), 0.12),
    ],
)
def test_default_is_right_on_coarse_meshes(mesh, truth, bound):
    principal = principal_curvatures(Surface(*mesh))
    np.testing.assert_allclose(principal.k1, truth[0], atol=bound)
    np.testing.assert_allclose(principal.k2, truth[1], atol=bound)


def test_noise_is_averaged_over_five_rings_where_it_is_all_that_three_miss():
    vertices, faces = icosphere(4)
    truth = np.ones(len(vertices)), np.ones(len(vertices))
    for amount, bound in ((0.01, 0.03), (0.05, 0.12)):
        surface = noisy(Surface(vertices, faces), amount)
        wide, narrow = (error(principal_curvatures(surface, radius), truth) for radius in (5, 3))
        assert wide < bound
        assert narrow > 3 * wide


def test_detail_of_few_edges_is_not_averaged_away():
    vertices, faces = grid(40, 0.2)
    wave, height = 2 * np.pi / (12 / 40), 0.1 / 40
    u, v = wave * vertices[:, 0], wave * vertices[:, 1]
    surface = Surface(np.column_stack([vertices[:, :2], height * np.sin(u) * np.sin(v)]), faces)
    # The graph is nearly flat (slopes up to .05), so that its curvatures are those of the Hessian.
    same, mixed = height * wave**2 * np.sin(u) * np.sin(v), height * wave**2 * np.cos(u) * np.cos(v)
    inner = (np.abs(vertices[:, :2] - 0.5) < 0.4).all(axis=1)
    for radius in (3, 5):
        found = principal_curvatures(surface, radius)
        wrong = np.hypot(found.k1 - same - np.abs(mixed), found.k2 - same + np.abs(mixed))[inner]
        assert np.sqrt(np.mean(wrong**2) / np.mean(2 * (same**2 + mixed**2)[inner])) < 0.12


@pytest.mark.parametrize("mesh", [torus(60, 24, 2.0, 0.7), icosphere(2), blob(4)])
def test_curvatures_of_one_filter_agree(mesh):
    found = qg.Curvatures()(Surface(*mesh)).attributes
    k1, k2 = found["qgeo_k1"], found["qgeo_k2"]
    size = np.sqrt(np.mean(k1**2 + k2**2) / 2)
    assert np.sqrt(np.mean(((k1 + k2) / 2 - found["qgeo_mean_curvature"]) ** 2)) < 0.08 * size
    assert np.sqrt(np.mean((k1 * k2 - found["qgeo_gaussian_curvature"]) ** 2)) < 0.15 * size**2


def needles() -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = terrain(400, 1, 0.02, 30.0)
    return vertices, faces


def flat() -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = blob(3)
    return vertices * [1, 1, 0.01], faces


@pytest.mark.parametrize(
    "mesh", [blob(2), icosphere(0), needles(), flat()], ids=["blob", "icosahedron", "needles", "flat"]
)
def test_only_the_surface_matters(mesh):
    vertices, faces = mesh
    rng = np.random.default_rng(0)
    expected = principal_curvatures(Surface(vertices, faces))
    size = np.abs([expected.k1, expected.k2]).max()
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    order = rng.permutation(len(vertices))
    renumbered = np.roll(np.argsort(order)[faces], 1, axis=1)[rng.permutation(len(faces))]
    inverse = np.argsort(order)
    for surface, scale, back in (
        (Surface(vertices[order], renumbered), 1.0, inverse),
        (Surface(vertices @ turn.T + [3, -2, 5], faces), 1.0, slice(None)),
        (Surface(1e-9 * vertices, faces), 1e-9, slice(None)),
        (Surface(1e9 * vertices, faces), 1e9, slice(None)),
    ):
        found = principal_curvatures(surface)
        np.testing.assert_array_equal(found.fitted[back], expected.fitted)
        np.testing.assert_allclose(found.k1[back] * scale, expected.k1, atol=1e-9 * size)
        np.testing.assert_allclose(found.k2[back] * scale, expected.k2, atol=1e-9 * size)
    inside_out = principal_curvatures(Surface(vertices, faces[:, ::-1]))
    np.testing.assert_allclose(inside_out.k1, -expected.k2, atol=1e-9 * size)
    np.testing.assert_allclose(inside_out.k2, -expected.k1, atol=1e-9 * size)


def test_directions_are_orthogonal_unit_tangents_that_turn_with_the_surface():
    surface, _ = ellipsoid(3)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    here = principal_curvatures(surface)
    there = principal_curvatures(Surface(surface.vertices @ turn.T, surface.faces))
    apart = here.k1 - here.k2 > 0.05  # at an umbilic any direction is principal
    for d, turned in ((here.d1, there.d1), (here.d2, there.d2)):
        np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, atol=1e-12)
        np.testing.assert_allclose(np.abs(np.einsum("ij,ij->i", d @ turn.T, turned))[apart], 1, atol=1e-9)
    np.testing.assert_allclose(np.einsum("ij,ij->i", here.d1, here.d2), 0, atol=1e-12)


def test_the_other_side_of_a_thin_plate_does_not_count():
    n = 12
    vertices, faces = grid(n)
    outline = Surface(vertices, faces)
    (rim,) = outline.boundary_loops
    a, b = rim, np.roll(rim, -1)
    half = {tuple(side) for k in range(3) for side in faces[:, [k, (k + 1) % 3]].tolist()}
    if (a[0], b[0]) not in half:
        a, b = b, a
    low = len(vertices)
    walls = np.concatenate([np.column_stack([b, a, a + low]), np.column_stack([b, a + low, b + low])])
    up = np.array([0, 0, 1e-3])
    plate = Surface(
        np.concatenate([vertices + up, vertices - up]),
        np.concatenate([faces, faces[:, ::-1] + low, walls]),
    )
    assert plate.is_closed
    assert plate.is_oriented
    principal = principal_curvatures(plate)
    inner = np.ones(plate.n_vertices, dtype=bool)
    inner[np.concatenate([rim, rim + low])] = False
    assert np.abs(principal.k1[inner]).max() < 1e-9
    assert np.abs(principal.k2[inner]).max() < 1e-9


def test_a_triangle_without_area_changes_little():
    vertices, faces = blob(3)
    a, b, c = faces[0]
    middle = len(vertices)
    # A vertex in the middle of a side, which the triangle beyond that side does not have.
    split = np.concatenate([faces[1:], [[a, middle, c], [middle, b, c], [a, b, middle]]])
    surface = Surface(np.vstack([vertices, (vertices[a] + vertices[b]) / 2]), split)
    assert surface.face_areas.min() < 1e-15
    before, after = principal_curvatures(Surface(vertices, faces)), principal_curvatures(surface)
    assert after.fitted.all()
    assert np.abs(after.k1[:-1] - before.k1).max() < 0.05 * np.abs(before.k1).max()
    assert np.abs(after.k2[:-1] - before.k2).max() < 0.05 * np.abs(before.k1).max()


def test_neighbours_on_one_conic_or_too_few_are_not_fitted():
    octahedron = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    sides = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]])
    with pytest.raises(MeshError, match="no vertex of the 6 has as many within 5 rings"):
        principal_curvatures(Surface(octahedron, sides))
    # Beside a sphere it keeps its zeros, and says so.
    vertices, faces = icosphere(2)
    both = principal_curvatures(
        Surface(np.concatenate([vertices, octahedron + 5]), np.concatenate([faces, sides + len(vertices)]))
    )
    assert both.fitted.tolist() == [True] * len(vertices) + [False] * 6
    assert (both.k1[-6:] == 0).all()
    assert (both.d1[-6:] == 0).all()


def test_a_plane_is_flat_up_to_its_boundary():
    principal = principal_curvatures(Surface(*grid(12, 0.3)))
    assert principal.fitted.all()
    assert (principal.k1 == 0).all()
    assert (principal.k2 == 0).all()


def test_a_hub_of_many_neighbours_is_fitted_as_others_are():
    # The curvature of the cone z = r is 1 / (sqrt(2) r) all around, inwards; sixty vertices share the apex.
    vertices, faces = cone(60, 12)
    found = principal_curvatures(Surface(vertices, faces))
    radius = np.hypot(*vertices[:, :2].T)
    away = radius > 3.5 / 12
    assert found.fitted.all()
    np.testing.assert_allclose(found.k2[away] * radius[away], -1 / np.sqrt(2), rtol=0.03)
    np.testing.assert_allclose(found.k1[away] * radius[away], 0, atol=0.03)


def test_one_vertex_far_off_a_plane_is_bent_and_all_is_finite():
    """Elsewhere the narrow jets miss nothing, by which the wide ones are measured."""
    vertices, faces = grid(6, 1.0)
    vertices = vertices.copy()
    spike = int(np.linalg.norm(vertices - vertices.mean(axis=0), axis=1).argmin())
    vertices[spike, 2] = 50 * np.ptp(vertices[:, 0])
    found = principal_curvatures(Surface(vertices, faces))
    assert np.isfinite(found.curvedness).all()
    assert found.curvedness[spike] > 1
