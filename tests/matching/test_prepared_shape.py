"""What a descriptor computes, how often, and in which unit."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from functools import partial

import numpy as np
import pytest
from scipy.linalg import eigh
from shapes import blob

import qgeo_filters as qg
from qgeo_filters.caching import cache
from qgeo_filters.defaults import CURVATURE_WEIGHT
from qgeo_filters.filters import stages
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.geodesics.metric import LiftedMetric, lifted_metric
from qgeo_filters.matching import intrinsic_shape as module
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.parameters import MatchingParameters
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.surface import Surface

#: Weights of the metrics that propose maps.
WEIGHTS = MatchingParameters().curvature_weights


class Spy:
    """Computes distance matrices, and remembers the weight of each metric."""

    def __init__(self) -> None:
        self.weights: list[float] = []

    def __call__(self, *args: object, **kwargs: object) -> np.ndarray:
        metric = next(arg for arg in args if isinstance(arg, LiftedMetric))
        self.weights.append(metric.curvature_weight)
        options = {name: value for name, value in kwargs.items() if name != "progress"}
        return distance_matrix(metric.surface, metric, **options)  # type: ignore[arg-type]


@pytest.fixture
def spy(monkeypatch: pytest.MonkeyPatch) -> Iterator[Spy]:
    """Stands for distance_matrix where filters and descriptors look for it, with an empty cache."""
    one = Spy()
    monkeypatch.setattr(stages, "distance_matrix", one)
    monkeypatch.setattr(module, "distance_matrix", one)
    cache.clear()
    yield one
    cache.clear()


@pytest.fixture(scope="module")
def surface() -> Surface:
    """A blob of 642 vertices, of no particular size."""
    vertices, faces = blob(3)
    return Surface(7.5 * vertices + [100, -20, 3], faces)


def test_filters_share_each_matrix(spy: Spy) -> None:
    shape = Surface(*blob(2))
    pipeline = qg.QuasiGeodesicSpectrum(k=5) | qg.SelfSymmetry(k0=5) | qg.Correspondence(target=shape)
    pipeline(shape)
    # The symmetry is sought in all metrics; the default of the spectrum is one of them.
    assert sorted(spy.weights) == sorted(WEIGHTS)


def test_a_cache_of_other_weights_is_not_taken(spy: Spy, monkeypatch: pytest.MonkeyPatch) -> None:
    """As one on disk may be, that an earlier version filled."""
    shape = Surface(*blob(2))
    first = stages.symmetry_of(shape)
    assert stages.symmetry_of(shape) is first
    monkeypatch.setattr(stages, "MatchingParameters", partial(MatchingParameters, curvature_weights=(0.0, 0.2)))
    assert stages.prepared_shape_of(shape).parameters.curvature_weights == (0.0, 0.2)
    assert stages.symmetry_of(shape) is not first
    assert sorted(spy.weights) == sorted([*WEIGHTS, 0.2])  # that of weight 0 is shared


def test_a_descriptor_takes_matrices_from_its_caller(surface: Surface) -> None:
    spy = Spy()
    given = PreparedShape(surface, matrix=spy).prepare()
    own = PreparedShape(surface).prepare()
    assert spy.weights == [WEIGHTS[-1]]  # the others only where one is not enough
    for one, other in zip(given.embeddings, own.embeddings, strict=True):
        np.testing.assert_array_equal(one.eigenvalues, other.eigenvalues)
        np.testing.assert_array_equal(one.eigenfunctions, other.eigenfunctions)
        np.testing.assert_array_equal(one.fps_distances, other.fps_distances)
    np.testing.assert_array_equal(given.fps, own.fps)


def test_the_mirror_image_costs_no_distances(surface: Surface) -> None:
    spy = Spy()
    shape = PreparedShape(surface, matrix=spy).prepare()
    image = shape.mirrored.prepare()
    assert spy.weights == [WEIGHTS[-1]]
    assert image.embedding(0) is shape.embedding(0)
    assert spy.weights == [WEIGHTS[-1], WEIGHTS[0]]
    assert image.laplacian is shape.laplacian
    np.testing.assert_array_equal(image.distances([0, 5]), shape.distances([0, 5]))
    np.testing.assert_allclose(image.normals, shape.normals * [-1, 1, 1], atol=1e-12)


def test_everything_is_that_of_the_shape_at_unit_area(surface: Surface) -> None:
    """The same to the rounding of float32 as computed on a copy of unit area."""
    shape = PreparedShape(surface)
    unit = Surface((surface.vertices - surface.vertices.mean(axis=0)) / np.sqrt(surface.area), surface.faces)
    assert unit.area == pytest.approx(1)
    np.testing.assert_allclose(shape.areas, unit.vertex_areas, rtol=1e-12)
    for view in shape.embeddings:
        matrix = distance_matrix(unit, lifted_metric(unit, curvature_weight=view.curvature_weight))
        rows = matrix[shape.fps[: len(view.fps_distances)]]
        np.testing.assert_allclose(view.fps_distances, rows, rtol=2e-6, atol=1e-7)
        expected = qg.distance_spectrum(unit, view.spectrum.k, matrix=matrix)
        np.testing.assert_allclose(view.spectrum.eigenvalues, expected.eigenvalues, rtol=1e-5)
        np.testing.assert_array_equal(view.spectrum.areas, shape.areas)
        gram = view.spectrum.eigenfunctions.T @ (shape.areas[:, None] * expected.eigenfunctions)
        np.testing.assert_allclose(np.abs(np.diag(gram)), 1, atol=1e-4)
    np.testing.assert_allclose(shape.distances(shape.fps[:3]), shape.fps_distances[:3], rtol=1e-6, atol=1e-7)


def test_the_first_eigenfunctions_are_exact_and_the_last_good(surface: Surface) -> None:
    view = PreparedShape(surface, curvature_weights=(CURVATURE_WEIGHT,)).embeddings[0]
    matrix = distance_matrix(surface, lifted_metric(surface)).astype(np.float64) / np.sqrt(surface.area)
    root = np.sqrt(surface.vertex_areas / surface.area)
    values, vectors = eigh(root[:, None] * matrix * root)
    order = np.argsort(-np.abs(values))[:60]
    np.testing.assert_allclose(view.eigenvalues, values[order], rtol=1e-4)
    np.testing.assert_allclose(view.eigenvalues[:20], values[order[:20]], rtol=2e-6)
    for count, sine in ((20, 3e-5), (55, 5e-3)):
        found = root[:, None] * view.eigenfunctions[:, :count].astype(np.float64)
        beyond = found - vectors[:, order] @ (vectors[:, order].T @ found)
        assert np.linalg.norm(beyond, 2) < sine


def test_nothing_depends_on_what_is_computed_first(surface: Surface) -> None:
    one, other = PreparedShape(surface), PreparedShape(surface)
    assert other.laplacian.shape[0] == surface.n_vertices  # before the distances, as `match` does of Y
    one.prepare()
    other.prepare()
    for name in ("fps", "fps_distances", "laplacian", "log_hks", "smoothed_mean_curvature", "relief"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(one.spectrum.eigenfunctions, other.spectrum.eigenfunctions)


def test_shapes_of_different_size_are_refused_before_any_distance(surface: Surface, spy: Spy) -> None:
    larger = surface.with_vertices(2 * surface.vertices)
    with pytest.raises(ValueError, match=r"the areas of X and Y are .* normalize=True"):
        match(surface, larger, normalize=False)
    with pytest.raises(ValueError, match="normalize=True"):
        qg.Correspondence(target=larger, normalize=False)(surface)
    assert spy.weights == []


def test_a_descriptor_outlives_its_process(surface: Surface) -> None:
    """A cache on disk holds descriptors: with the function that gave them their distances."""
    shape = stages.prepared_shape_of(surface)
    again = pickle.loads(pickle.dumps(shape))
    np.testing.assert_array_equal(again.embeddings[1].fps_distances, shape.embeddings[1].fps_distances)
    np.testing.assert_array_equal(again.fps, shape.fps)
