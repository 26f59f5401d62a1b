"""A metric belongs to its surface: every function that takes one refuses that of another, naming what differs."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import blob

import qgeo_filters as qg
from qgeo_filters.geodesics.metric import cartesian_metric, lifted_metric
from qgeo_filters.spectral.block_krylov import spectrum_by_pass
from qgeo_filters.spectral.landmarks import farthest_points
from qgeo_filters.surface import Surface

TAKERS = {
    "distances": lambda s, m: qg.distances(s, [0], m),
    "distances exact": lambda s, m: qg.distances(s, [0], m, "exact"),
    "distances edges": lambda s, m: qg.distances(s, [0], m, "edges"),
    "distance_matrix": qg.distance_matrix,
    "GeodesicSolver": lambda s, m: qg.GeodesicSolver(s, m).distances([0]),
    "quasi_geodesic": lambda s, m: qg.quasi_geodesic(s, 0, 9, m).points,
    "quasi_geodesics": lambda s, m: qg.quasi_geodesics(s, [[0, 9]], m)[0].points,
    "DistanceOperator": lambda s, m: qg.DistanceOperator(s, m) @ np.ones(s.n_vertices),
    "distance_spectrum": lambda s, m: qg.distance_spectrum(s, 3, m).eigenvalues,
    "distance_spectrum of a matrix": lambda s, m: (
        qg.distance_spectrum(s, 3, m, matrix=qg.distance_matrix(s)).eigenvalues
    ),
    "distance_spectrum of landmarks": lambda s, m: qg.distance_spectrum(s, 3, m, landmarks=20).eigenvalues,
    "landmark_spectrum": lambda s, m: qg.landmark_spectrum(s, 3, m, 20).eigenvalues,
    "streamed_spectrum": lambda s, m: qg.streamed_spectrum(s, 3, m, landmarks=20).eigenvalues,
    "spectrum_by_pass": lambda s, m: next(spectrum_by_pass(s, 3, m, landmarks=20)).eigenvalues,
    "farthest_points": lambda s, m: farthest_points(s, 5, m),
}
LIFTED = {name for name in TAKERS if "spectrum" in name}


@pytest.fixture(scope="module")
def pose() -> Surface:
    return Surface(*blob(2))


@pytest.mark.parametrize("name", TAKERS)
def test_the_metric_of_another_pose_is_refused(pose: Surface, name: str) -> None:
    """Same number of vertices and same faces: only the content tells the poses apart."""
    vertices = pose.vertices.copy()
    vertices[7, 2] += 1.0
    other = pose.with_vertices(vertices)
    with pytest.raises(qg.ParameterError, match=r"another surface: vertices\[7\] is .* \(1 of 162 vertices differ\)"):
        TAKERS[name](pose, lifted_metric(other))


@pytest.mark.parametrize("name", TAKERS)
def test_the_metric_of_other_triangles_is_refused(pose: Surface, name: str) -> None:
    other = Surface(pose.vertices, pose.faces[::-1])
    with pytest.raises(qg.ParameterError, match=r"another surface: faces\[0\] is .* faces differ"):
        TAKERS[name](pose, cartesian_metric(other))


@pytest.mark.parametrize("name", TAKERS)
def test_a_name_or_an_equal_surface_gives_the_same_bits(pose: Surface, name: str) -> None:
    """By name, by the metric of a copy, of a surface with attributes; None is the default, with a warning."""
    attributed = pose.with_attributes({"f": np.zeros(pose.n_vertices)})
    copy = Surface(pose.vertices.copy(), pose.faces.copy())
    for word, make in (("cartesian", cartesian_metric), ("lifted", lifted_metric)):
        expected = TAKERS[name](pose, make(pose))
        for metric in (word, make(attributed), make(copy)):
            np.testing.assert_array_equal(TAKERS[name](pose, metric), expected)
    if "matrix=" in name or name in ("GeodesicSolver", "distance_spectrum of a matrix"):
        return  # new, or without a metric of its own
    default = "lifted" if name in LIFTED else "cartesian"
    with pytest.warns(DeprecationWarning, match=f'metric=None is deprecated: say metric="{default}"'):
        by_default = TAKERS[name](pose, None)
    np.testing.assert_array_equal(by_default, TAKERS[name](pose, default))


@pytest.mark.parametrize("bad", ["euclidean", 0.01, ["lifted"]])
def test_unknown_metrics(pose: Surface, bad: object) -> None:
    with pytest.raises(qg.ParameterError, match='metric must be a LiftedMetric, "cartesian" or "lifted", got'):
        qg.distances(pose, [0], bad)  # type: ignore[arg-type]


def test_a_path_is_not_measured_with_the_metric_of_a_larger_square() -> None:
    """The fault as it was seen: sqrt(26) came back for sqrt(2)."""
    faces = [[0, 1, 2], [0, 2, 3]]
    square = Surface([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], faces)
    long = Surface([[0, 0, 0], [5, 0, 0], [5, 1, 0], [0, 1, 0]], faces)
    assert qg.quasi_geodesic(square, 0, 2).length == pytest.approx(np.sqrt(2), rel=1e-12)
    with pytest.raises(qg.ParameterError, match=r"2 of 4 vertices differ"):
        qg.quasi_geodesic(square, 0, 2, cartesian_metric(long))
