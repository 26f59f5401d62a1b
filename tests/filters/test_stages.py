"""The one door to expensive things: what enters keys, and what does not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from shapes import blob

import qgeo_filters as qg
from qgeo_filters.caching import StageCache
from qgeo_filters.errors import ParameterError
from qgeo_filters.filters import stages
from qgeo_filters.geodesics import methods
from qgeo_filters.geodesics.dgg import graph as graphs
from qgeo_filters.geodesics.metric import lifted_metric
from qgeo_filters.parallel import worker_count
from qgeo_filters.spectral import landmarks


@pytest.fixture
def cache(monkeypatch: pytest.MonkeyPatch) -> StageCache:
    fresh = StageCache()
    monkeypatch.setattr(stages, "cache", fresh)
    return fresh


def test_workers_and_progress_enter_no_key(cache: StageCache, monkeypatch: pytest.MonkeyPatch) -> None:
    surface, seen = qg.Surface(*blob(2)), []
    distance_matrix = stages.distance_matrix

    def spy(*arguments, **options):
        seen.append(worker_count(None))
        return distance_matrix(*arguments, **options)

    monkeypatch.setattr(stages, "distance_matrix", spy)
    metric = stages.metric_of(surface, "mean_curvature", 0.01)
    first = stages.matrix_of(metric, "graph", 1e-3, workers=3)
    assert seen == [3]  # all below is bounded by it
    assert stages.matrix_of(metric, "graph", 1e-3, progress=True) is first
    spectrum = stages.spectrum_of(metric, 4, "area", None, "graph", 1e-3)
    assert stages.spectrum_of(metric, 4, "area", None, "graph", 1e-3, True, 2) is spectrum
    assert seen == [3]


def test_workers_are_refused_whether_or_not_there_is_a_result(cache: StageCache) -> None:
    metric = stages.metric_of(qg.Surface(*blob(1)), "mean_curvature", 0.01)
    stages.matrix_of(metric, "edges", 1e-3)
    calls: list[Callable[[], object]] = [
        lambda: stages.matrix_of(metric, "edges", 1e-3, workers=0),
        lambda: stages.symmetry_of(metric.surface, workers=True),
        lambda: stages.correspondence_of(metric.surface, metric.surface, True, workers=-1),
    ]
    for call in calls:
        with pytest.raises(ParameterError, match="workers"):
            call()


def test_an_attribute_named_like_a_built_in_scalar_is_not_taken_for_it(cache: StageCache) -> None:
    """Before, the built-in's metric was kept under the attribute's content, and given for that content."""
    plain = qg.Surface(*blob(2))
    values = plain.vertices[:, 0]
    surface = plain.with_attributes({"mean_curvature": values, "height": values})
    built_in = stages.metric_of(surface, "mean_curvature", 0.05)
    for scalar in (values, "height"):
        mine = stages.metric_of(surface, scalar, 0.05)
        np.testing.assert_array_equal(mine.edge_lengths, lifted_metric(surface, scalar, 0.05).edge_lengths)
        assert not np.array_equal(mine.edge_lengths, built_in.edge_lengths)
    assert stages.metric_of(plain, "mean_curvature", 0.05) is built_in


def test_the_metric_of_a_function_is_not_kept(cache: StageCache) -> None:
    surface = qg.Surface(*blob(1))
    for axis in range(2):
        stages.metric_of(surface, lambda delta, axis=axis: delta[:, axis], 0.05)
    assert (cache.hits, cache.misses) == (0, 0)


def test_methods_of_ones_own_are_kept_for_this_process(cache: StageCache, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their code is not this package's: what another process kept on disk may be that of another method."""
    metric = stages.metric_of(qg.Surface(*blob(1)), "mean_curvature", 0.01)

    def doubled(metric, accuracy, workers):
        return methods.METHODS["edges"](metric, accuracy, workers)

    monkeypatch.setitem(methods.METHODS, "mine", doubled)
    mine = stages.matrix_of(metric, "mine", 1e-3)
    assert stages.matrix_of(metric, "mine", 1e-3) is mine
    edges = stages.matrix_of(metric, "edges", 1e-3)
    with monkeypatch.context() as later:
        later.setattr(stages, "PROCESS", "the next one")
        assert stages.matrix_of(metric, "mine", 1e-3) is not mine
        assert stages.matrix_of(metric, "edges", 1e-3) is edges


def test_the_spectrum_of_the_laplacian_is_kept(cache: StageCache) -> None:
    surface = qg.Surface(*blob(1))
    assert stages.laplacian_spectrum_of(surface, 4) is stages.laplacian_spectrum_of(surface, 4)
    assert stages.laplacian_spectrum_of(surface, 5).k == 5


def test_hints_enter_the_key_however_they_are_written(cache: StageCache, monkeypatch: pytest.MonkeyPatch) -> None:
    """And the filter hands them on."""
    surface, seen = qg.Surface(*blob(1)), []

    def spy(x, y, **options):
        seen.append((options["landmarks"], options["labels"]))
        return f"match {len(seen)}"

    monkeypatch.setattr(stages, "match", spy)
    monkeypatch.setattr(stages, "prepared_shape_of", lambda surface, *_, **__: surface)

    def found(**hints):
        return stages.correspondence_of(surface, surface, True, **hints)

    labels = np.repeat([0, 1], surface.n_vertices // 2), np.repeat([1, 0], surface.n_vertices // 2)
    assert found() == "match 1"
    assert seen == [(None, None)]
    assert found(landmarks=[(1, 2), (3, 4)]) == "match 2"
    assert found(landmarks=np.array([[1, 2], [3, 4]])) == "match 2"
    assert found(landmarks=(surface.vertices[[1, 3]], surface.vertices[[2, 4]])) == "match 2"
    assert found(landmarks=[(1, 2)]) == "match 3"
    assert found(labels=labels) == "match 4"
    assert found(labels=labels[::-1]) == "match 5"
    assert found() == "match 1"
    np.testing.assert_array_equal(seen[1][0], [[1, 2], [3, 4]])
    assert [entry[1] is None for entry in seen] == [True, True, True, False, False]
    with pytest.raises(ParameterError, match="landmark 0 is vertex 42 of Y"):
        qg.Correspondence(target=surface, landmarks=[(0, 42)])(surface)


def test_an_interrupted_spectrum_leaves_the_metric_and_its_graph(
    cache: StageCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    surface, made = qg.Surface(*blob(2)), []
    monkeypatch.setattr(stages, "lifted_metric", lambda *a, **o: made.append("metric") or lifted_metric(*a, **o))
    graph = graphs.geodesic_graph
    monkeypatch.setattr(graphs, "geodesic_graph", lambda *a, **o: made.append("graph") or graph(*a, **o))

    def interrupted(*arguments: object, **options: object) -> None:
        raise KeyboardInterrupt

    descriptor = qg.QuasiGeodesicSpectrum(k=4, landmarks=40)
    with monkeypatch.context() as during:
        during.setattr(landmarks, "landmark_operator", interrupted)
        with pytest.raises(KeyboardInterrupt):
            descriptor.compute(surface)
    descriptor.compute(surface)
    assert made == ["metric", "graph"]
