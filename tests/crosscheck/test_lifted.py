"""Distances of lifted metrics: the lift (x, y, lambda sqrt(A) f) of a plane lies in space, where peers are exact."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay

from qgeo_filters import Surface
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.geodesics.metric import lifted_metric

# What the documentation promises of the graph, see `test_weight_zero`; measured: mean errors up to 6.7e-5.
ROUNDING, ACCURACY, MEAN = 1e-9, 1e-3, 1.5e-4

SCALARS = {
    "wave": lambda x, y: np.sin(7 * x) * np.cos(5 * y),
    "bump": lambda x, y: np.exp(-20 * ((x - 0.4) ** 2 + (y - 0.5) ** 2)),
    "step": lambda x, y: np.tanh(40 * (x + 0.3 * y - 0.6)),
    "noise": lambda x, y: np.random.default_rng(8).normal(size=x.shape),
}


@pytest.fixture(params=SCALARS)
def lifted(request):
    """Flat surface, lifted metric of weight ``w``, and the surface in space that has this metric."""

    def make(weight: float):
        points = np.random.default_rng(5).uniform(size=(350, 2))
        x, y = points.T
        flat = Surface(np.column_stack([points, 0 * x]), Delaunay(points).simplices)
        metric = lifted_metric(flat, SCALARS[request.param](x, y), weight)
        height = weight * np.sqrt(flat.area) * metric.scalar
        return flat, metric, flat.with_vertices(np.column_stack([points, height]))

    return make


@pytest.mark.parametrize("weight", [0.03, 0.3])
def test_exact_distance_is_that_of_the_lift(lifted, foreign_exact, weight):
    flat, metric, space = lifted(weight)
    for source in (0, 111):
        ours = distances(flat, [source], metric, method="exact")[0]
        np.testing.assert_allclose(ours, foreign_exact(space, source), rtol=1e-9)


@pytest.mark.parametrize("weight", [0.03, 0.3])
def test_graph_distance_is_near_that_of_the_lift(lifted, weight):
    flat, metric, space = lifted(weight)
    sources = np.arange(0, 350, 10)
    exact = distances(space, sources, method="exact")
    graph = distances(flat, sources, metric, method="graph")
    apart = exact > 0
    error = graph[apart] / exact[apart] - 1
    assert error.min() > -ROUNDING
    assert error.mean() < MEAN
    assert error.max() <= ACCURACY


def test_weight_makes_nothing_nearer(lifted):
    flat, metric, _ = lifted(0.1)
    own = distances(flat, [3], method="exact")[0]
    assert (distances(flat, [3], metric, method="exact")[0] >= own * (1 - 1e-12)).all()
