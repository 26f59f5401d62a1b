"""The solver object beside the one-shot calls, and methods of one's own in the table."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob

import qgeo_filters as qg
from qgeo_filters.geodesics.methods import METHODS
from qgeo_filters.surface import Surface


@pytest.fixture(scope="module")
def surface() -> Surface:
    return Surface(*blob(2))


@pytest.mark.parametrize("method", ["graph", "exact", "edges"])
@pytest.mark.parametrize("metric", ["cartesian", "lifted"])
def test_solver_gives_the_bits_of_the_one_shot_calls(surface: Surface, method: str, metric: str) -> None:
    solver = qg.GeodesicSolver(surface, metric, method, workers=2)
    for sources in ([5, 0, 5], [], [161]):
        expected = qg.distances(surface, sources, metric, method)
        np.testing.assert_array_equal(solver.distances(sources), expected)
    np.testing.assert_array_equal(solver.distance_matrix(), qg.distance_matrix(surface, metric, method))
    for initial in ("exact", "edges"):
        path, expected_path = (
            solver.path(3, 99, initial=initial),
            qg.quasi_geodesic(surface, 3, 99, metric, initial=initial),
        )
        np.testing.assert_array_equal(path.points, expected_path.points)
        assert path.length == expected_path.length


def test_what_is_prepared_is_prepared_once(surface: Surface, monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    graph = METHODS["graph"]
    monkeypatch.setitem(METHODS, "graph", lambda *arguments: made.append(arguments) or graph(*arguments))
    solver = qg.GeodesicSolver(surface, workers=1)
    for source in range(3):
        solver.distances([source])
    solver.distance_matrix()
    assert len(made) == 1


class Straight(qg.DistanceSolver):
    """Distances through space: a method that is no geodesic one, and easily checked."""

    def __init__(self, metric: qg.LiftedMetric, accuracy: float, workers: int | None) -> None:
        self.points = metric.surface.vertices

    @property
    def n_vertices(self) -> int:
        return len(self.points)

    def distances_into(self, out: np.ndarray, rows: np.ndarray, sources: np.ndarray) -> None:
        out[rows] = np.linalg.norm(self.points[sources][:, None] - self.points[None], axis=2)


def test_a_method_of_ones_own(surface: Surface) -> None:
    """One class and one call: functions, spectra, the solver and filters take its name."""
    before = dict(METHODS)
    try:
        qg.register_method("straight", Straight)
        full = np.linalg.norm(surface.vertices[:, None] - surface.vertices[None], axis=2)
        np.testing.assert_array_equal(qg.distances(surface, [7, 2], method="straight"), full[[7, 2]])
        matrix = qg.distance_matrix(surface, method="straight")
        np.testing.assert_array_equal(matrix, full.astype(np.float32))
        spectrum = qg.distance_spectrum(surface, 4, method="straight")
        again = qg.distance_spectrum(surface, 4, matrix=matrix)
        np.testing.assert_array_equal(spectrum.eigenvalues, again.eigenvalues)
        filtered = qg.QuasiGeodesicDistances(sources=7, method="straight")(surface)
        np.testing.assert_array_equal(filtered.attributes["qgeo_distance"], full[7])
        with pytest.raises(qg.ParameterError, match="there is a method 'straight' already"):
            qg.register_method("straight", Straight)
        with pytest.raises(qg.ParameterError, match="one of 'graph', 'exact', 'edges', 'straight', got 'heat'"):
            qg.GeodesicSolver(surface, method="heat")
    finally:
        METHODS.clear()
        METHODS.update(before)


def test_bad_requests(surface: Surface) -> None:
    for workers in (0, -1):
        with pytest.raises(qg.ParameterError, match="workers must be at least 1"):
            qg.GeodesicSolver(surface, workers=workers)
        for spectrum in (qg.distance_spectrum, qg.landmark_spectrum, qg.streamed_spectrum):
            with pytest.raises(qg.ParameterError, match="workers must be at least 1"):
                spectrum(surface, 3, landmarks=20, workers=workers)
    with pytest.raises(qg.ParameterError, match="mass must be 'area' or 'uniform', got 'cotangent'"):
        qg.distance_spectrum(surface, 3, mass="cotangent")
    with pytest.warns(DeprecationWarning, match="weights is now called mass"):
        old = qg.distance_spectrum(surface, 3, weights="uniform")
    np.testing.assert_array_equal(old.eigenvalues, qg.distance_spectrum(surface, 3, mass="uniform").eigenvalues)
    metric = qg.lifted_metric(surface, curvature_weight=0.02)
    with pytest.warns(DeprecationWarning, match=r"LiftedMetric.weight is now called curvature_weight"):
        assert metric.weight == metric.curvature_weight == 0.02
