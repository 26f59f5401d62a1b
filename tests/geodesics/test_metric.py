"""The lifted metric as the metric of a graph in R^4."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import blob, grid, icosphere, moebius

from qgeo_filters.differential.scalar import surface_scalar
from qgeo_filters.geodesics.metric import lifted_metric
from qgeo_filters.surface import Surface


@given(weight=st.floats(0.001, 2.0), seed=st.integers(0, 100))
@settings(max_examples=20)
def test_edges_are_those_of_the_graph_in_four_dimensions(weight, seed):
    surface = Surface(*blob(2))
    values = np.random.default_rng(seed).normal(size=surface.n_vertices)
    metric = lifted_metric(surface, values, weight)
    lift = np.column_stack([surface.vertices, weight * np.sqrt(surface.area) * surface_scalar(surface, values)])
    a, b = surface.edges.T
    np.testing.assert_allclose(metric.edge_lengths, np.linalg.norm(lift[a] - lift[b], axis=1), rtol=1e-12)
    assert (metric.edge_lengths >= surface.edge_lengths).all()
    # Edges in R^4 close to triangles: the kernel may rely on it.
    sides = metric.intrinsic().lengths
    assert (2 * sides.max(axis=1) <= sides.sum(axis=1) * (1 + 1e-12)).all()


def test_weight_zero_is_the_surface_itself_and_needs_no_scalar():
    surface = Surface(*moebius())  # on which the mean curvature has no sign
    metric = lifted_metric(surface, curvature_weight=0)
    np.testing.assert_array_equal(metric.edge_lengths, surface.edge_lengths)
    assert metric.curvature_weight == 0
    assert (metric.scalar == 0).all()


def test_sphere_is_not_lifted():
    surface = Surface(*icosphere(3))
    np.testing.assert_array_equal(lifted_metric(surface).edge_lengths, surface.edge_lengths)


@pytest.mark.parametrize("factor", [1e-9, 1e6])
def test_lengths_scale_with_the_mesh(factor):
    vertices, faces = blob(3)
    small, large = (lifted_metric(Surface(s * vertices, faces), smoothing=0.02) for s in (1.0, factor))
    np.testing.assert_allclose(large.edge_lengths, factor * small.edge_lengths, rtol=1e-8)


@pytest.mark.parametrize("weight", [-0.1, np.nan, np.inf])
def test_bad_weight(weight):
    with pytest.raises(ValueError, match="0 or more"):
        lifted_metric(Surface(*grid(3)), curvature_weight=weight)


def test_arrays_are_read_only():
    metric = lifted_metric(Surface(*blob(2)))
    assert not metric.scalar.flags.writeable
    assert not metric.edge_lengths.flags.writeable
