"""Farthest points, smooth interpolation, and the spectrum from a few rows of the matrix."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from shapes import blob, cylinder, grid, moebius, torus

from qgeo_filters.errors import DisconnectedError
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.metric import cartesian_metric, lifted_metric
from qgeo_filters.spectral.biharmonic import biharmonic_interpolation, intrinsic_laplacian
from qgeo_filters.spectral.canonical import subspace_sine
from qgeo_filters.spectral.distance_spectrum import distance_spectrum
from qgeo_filters.spectral.landmarks import farthest_points, landmark_operator, landmark_spectrum
from qgeo_filters.spectral.spectrum import spectrum_of_matrix
from qgeo_filters.surface import Surface


def edge_matrix(surface: Surface, lengths: np.ndarray) -> np.ndarray:
    a, b = surface.edges.T
    return dijkstra(csr_matrix((lengths, (a, b)), shape=(surface.n_vertices,) * 2), directed=False)


@pytest.mark.parametrize("mesh", [blob(3), grid(12, 0.3), torus(24, 12), moebius()])
@pytest.mark.parametrize("weight", [0.0, 0.05])
def test_every_point_is_the_farthest_from_those_before(mesh, weight):
    surface = Surface(*mesh)
    metric = lifted_metric(surface, surface.vertices[:, 0], weight)
    points = farthest_points(surface, 40, metric)
    table = edge_matrix(surface, metric.edge_lengths)
    assert len(set(points.tolist())) == 40
    nearest = table[points[0]]
    for point in points[1:]:
        assert nearest[point] == pytest.approx(nearest.max(), rel=1e-12)
        nearest = np.minimum(nearest, table[point])
    # Gonzalez: spacing of the points and covering radius are one number.
    spacing = table[np.ix_(points, points)][np.triu_indices(40, 1)].min()
    assert nearest.max() <= spacing * (1 + 1e-12)


def test_sequences_nest_and_reach_all_vertices():
    surface = Surface(*grid(6))
    everything = farthest_points(surface, 49)
    assert sorted(everything.tolist()) == list(range(49))
    np.testing.assert_array_equal(farthest_points(surface, 10), everything[:10])
    assert farthest_points(surface, 3, start=17)[0] == 17


def test_coinciding_vertices_are_taken_once():
    vertices, faces = grid(3)
    vertices = vertices.copy()
    vertices[5] = vertices[6]
    points = farthest_points(Surface(vertices, faces), 16)
    assert sorted(points.tolist()) == list(range(16))


def test_start_does_not_depend_on_the_numbering():
    vertices, faces = blob(2)
    order = np.random.default_rng(0).permutation(len(vertices))
    shuffled = Surface(vertices[order], np.argsort(order)[faces])
    points = farthest_points(Surface(vertices, faces), 20)
    np.testing.assert_array_equal(order[farthest_points(shuffled, 20)], points)


@pytest.mark.parametrize("mesh", [blob(3), grid(12, 0.3), cylinder(24, 8), moebius()])
def test_interpolation_keeps_its_values_and_constants_and_has_a_transpose(mesh):
    surface = Surface(*mesh)
    metric = lifted_metric(surface, surface.vertices[:, 0], 0.05)
    points = farthest_points(surface, 30, metric)
    spread, gathered = biharmonic_interpolation(metric, points)
    rng = np.random.default_rng(0)
    values, function = rng.normal(size=(30, 2)), rng.normal(size=(surface.n_vertices, 2))
    np.testing.assert_array_equal(spread(values)[points], values)
    np.testing.assert_allclose(spread(np.ones((30, 1))), 1, atol=1e-9)
    np.testing.assert_allclose((spread(values) * function).sum(), (values * gathered(function)).sum(), rtol=1e-9)


def test_interpolation_is_that_of_least_energy():
    surface = Surface(*blob(2))
    metric = cartesian_metric(surface)
    points = farthest_points(surface, 20)
    stiffness, areas = intrinsic_laplacian(metric)
    energy = lambda f: float((stiffness @ f) @ ((stiffness @ f) / areas))  # noqa: E731
    rng = np.random.default_rng(0)
    best = biharmonic_interpolation(metric, points)[0](rng.normal(size=(20, 1)))[:, 0]
    for _ in range(10):
        change = rng.normal(size=surface.n_vertices)
        change[points] = 0
        assert energy(best + 1e-3 * change) > energy(best)


@pytest.fixture(scope="module")
def lifted() -> tuple:
    surface = Surface(*blob(4, seed=1))
    metric = lifted_metric(surface)
    return surface, metric, distance_matrix(surface, metric)


def test_operator_is_symmetric_and_reproduces_the_landmarks_rows():
    surface = Surface(*blob(3))
    metric = lifted_metric(surface)
    matrix = distance_matrix(surface, metric)
    points = farthest_points(surface, 60, metric)
    operator = landmark_operator(metric, points, matrix[points])
    dense = operator @ np.eye(surface.n_vertices)
    scale = matrix.max()
    np.testing.assert_allclose(dense, dense.T, atol=1e-5 * scale)
    np.testing.assert_allclose(dense[points], matrix[points], atol=1e-5 * scale)


def test_all_vertices_as_landmarks_is_the_matrix():
    surface = Surface(*blob(2))
    matrix = distance_matrix(surface)
    points = np.random.default_rng(0).permutation(surface.n_vertices)
    operator = landmark_operator(cartesian_metric(surface), points, matrix[points])
    np.testing.assert_allclose(operator @ np.eye(surface.n_vertices), matrix, atol=1e-5)


def test_spectrum_converges_to_that_of_all_vertices(lifted):
    surface, metric, matrix = lifted
    full = spectrum_of_matrix(matrix, surface.vertex_areas, 20)
    ten = full.truncated(10)
    sines = []
    for count in (125, 350, 1000):
        points = farthest_points(surface, count, metric)
        spectrum = spectrum_of_matrix(landmark_operator(metric, points, matrix[points]), surface.vertex_areas, 20)
        sines.append(subspace_sine(spectrum.truncated(10).eigenfunctions, ten.eigenfunctions, surface.vertex_areas))
    assert (np.sign(spectrum.eigenvalues) == np.sign(full.eigenvalues)).all()
    np.testing.assert_allclose(spectrum.eigenvalues, full.eigenvalues, rtol=0.01)
    assert subspace_sine(spectrum.eigenfunctions, full.eigenfunctions, surface.vertex_areas) < 0.02
    # At least as fast as the area of a landmark's cell shrinks.
    assert np.polyfit(np.log([125.0, 350, 1000]), np.log(sines), 1)[0] < -1


def test_from_the_surface_alone():
    surface = Surface(*blob(3))
    metric = lifted_metric(surface)
    matrix = distance_matrix(surface, metric)
    spectrum = distance_spectrum(surface, 10, landmarks=200)
    points = farthest_points(surface, 200, metric)
    same = landmark_spectrum(surface, 10, metric, points)
    np.testing.assert_array_equal(spectrum.eigenvalues, same.eigenvalues)
    full = spectrum_of_matrix(matrix, surface.vertex_areas, 10)
    np.testing.assert_allclose(spectrum.eigenvalues, full.eigenvalues, rtol=0.05)
    uniform = distance_spectrum(surface, 6, metric, "uniform", 200)
    plain = spectrum_of_matrix(matrix, surface.vertex_areas, 6, "uniform")
    np.testing.assert_allclose(uniform.eigenvalues, plain.eigenvalues, rtol=0.05)


def test_bad_requests():
    surface = Surface(*grid(4))
    metric = cartesian_metric(surface)
    with pytest.raises(ValueError, match="between 1 and the number of vertices, 25, got 26"):
        farthest_points(surface, 26)
    with pytest.raises(ValueError, match="start is vertex 25"):
        farthest_points(surface, 3, start=25)
    with pytest.raises(ValueError, match="need more landmarks than that, got 5"):
        landmark_spectrum(surface, 5, metric, 5)
    with pytest.raises(ValueError, match="different vertices"):
        landmark_operator(metric, [1, 1], np.zeros((2, 25)))
    with pytest.raises(ValueError, match=r"rows must have shape \(2, 25\), got \(2, 24\)"):
        landmark_operator(metric, [1, 2], np.zeros((2, 24)))
    vertices, faces = grid(2)
    with pytest.raises(DisconnectedError, match="farthest point sampling"):
        farthest_points(Surface(np.vstack([vertices, [[5.0, 5, 5]]]), faces), 3)
