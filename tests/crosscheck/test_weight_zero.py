"""Distances of the surface's own metric against libigl and pygeodesic."""

from __future__ import annotations

import numpy as np

from qgeo_filters.geodesics.matrix import distances

# Both peers carry rounding of their own; pygeodesic also joins intervals shorter than 1e-6 of an edge.
PEERS_ROUNDING = 1e-9
# What the documentation promises of the graph: never below the exact distance, of which both are rounded (measured:
# +2e-14 and up), never above it by more than the accuracy, 1e-3 by default, and on average by about a tenth of that
# (measured: up to 1.04e-4).
ROUNDING, ACCURACY, MEAN = 1e-9, 1e-3, 1.5e-4


def test_exact_on_all_kinds_of_surfaces(surface, foreign_exact):
    for source in np.random.default_rng(0).choice(surface.n_vertices, 3, replace=False):
        ours = distances(surface, [source], method="exact")[0]
        np.testing.assert_allclose(ours, foreign_exact(surface, int(source)), rtol=PEERS_ROUNDING)


def test_exact_on_the_cow(cow, foreign_exact):
    for source in (0, 1234):
        ours = distances(cow, [source], method="exact")[0]
        np.testing.assert_allclose(ours, foreign_exact(cow, source), rtol=PEERS_ROUNDING)


def test_exact_on_tosca(tosca, foreign_exact):
    ours = distances(tosca, [77], method="exact")[0]
    np.testing.assert_allclose(ours, foreign_exact(tosca, 77), rtol=PEERS_ROUNDING)


def relative_error(surface, sources, **options):
    """Error of the graph method relative to the exact distance, sources left out."""
    exact = distances(surface, sources, method="exact")
    graph = distances(surface, sources, method="graph", **options)
    apart = exact > 0
    return graph[apart] / exact[apart] - 1


def test_graph_on_all_kinds_of_surfaces(surface):
    error = relative_error(surface, np.arange(0, surface.n_vertices, 7))
    assert error.min() > -ROUNDING
    assert error.mean() < MEAN
    assert error.max() <= ACCURACY


def test_graph_on_the_cow(cow):
    error = relative_error(cow, np.arange(0, cow.n_vertices, 97))
    assert error.min() > -ROUNDING
    assert error.mean() < MEAN
    assert error.max() <= ACCURACY


def test_graph_on_tosca(tosca):
    error = relative_error(tosca, np.arange(0, tosca.n_vertices, 97))
    assert error.min() > -ROUNDING
    assert error.mean() < MEAN
    assert error.max() <= ACCURACY
