"""What spectra of large surfaces need of a proxy: its interpolation as a matrix, and the surface's metric on it."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.decimation import Proxy, decimated
from qgeo_filters.geodesics.metric import LiftedMetric
from qgeo_filters.sampling import farthest_on_edges
from qgeo_filters.spectral.biharmonic import Product, biharmonic_interpolation
from qgeo_filters.validation import frozen


def interpolation_matrix(proxy: Proxy) -> sparse.csr_array:
    """Values on the surface (n) of a function on the proxy (m), linear in its triangles: a matrix (n, m)."""
    n = len(proxy.faces)
    start = np.arange(0, 3 * n + 1, 3)
    return sparse.csr_array(
        (proxy.coordinates.ravel(), proxy.corners.ravel(), start), shape=(n, proxy.surface.n_vertices)
    )


def metric_on_proxy(metric: LiftedMetric, proxy: Proxy) -> LiftedMetric:
    """The metric of the proxy that is lifted by the same scalar, averaged around each of its vertices."""
    surface, coarse = metric.surface, proxy.surface
    if coarse is surface:
        return metric
    weights = interpolation_matrix(proxy)
    areas = weights.T @ surface.vertex_areas
    total = weights.T @ (surface.vertex_areas * metric.scalar)
    scalar = np.divide(total, areas, out=metric.scalar[proxy.vertices], where=areas > 0)
    a, b = coarse.edges.T
    # Of the surface's area: a climb is as high on the proxy.
    climb = metric.curvature_weight * np.sqrt(surface.area) * (scalar[a] - scalar[b])
    return LiftedMetric(coarse, frozen(scalar), metric.curvature_weight, frozen(np.hypot(coarse.edge_lengths, climb)))


def interpolation_over_proxy(metric: LiftedMetric, count: int, vertices: int) -> tuple[IndexArray, Product, Product]:
    """Landmarks of a surface, (m,), and products with an interpolation (n, m) from them and with its transpose.

    As `biharmonic_interpolation`, on a proxy of so many vertices and from there linearly to the surface, whose own
    equations would take gigabytes to factorise. The landmarks are the vertices of the surface nearest to as many
    farthest points of the proxy, less those that are nearest to two.
    """
    proxy = decimated(metric.surface, vertices)
    coarse = metric_on_proxy(metric, proxy)
    mesh = coarse.surface
    start = int(np.linalg.norm(mesh.vertices - mesh.vertices.mean(axis=0), axis=1).argmax())
    chosen = farthest_on_edges(mesh.edges, coarse.edge_lengths, mesh.n_vertices, count, start)
    chosen = chosen[np.sort(np.unique(proxy.vertices[chosen], return_index=True)[1])]
    spread, gathered = biharmonic_interpolation(coarse, chosen)
    weights = interpolation_matrix(proxy)

    def spread_to_surface(values: FloatArray) -> FloatArray:
        return weights @ spread(values)

    def gathered_from_surface(values: FloatArray) -> FloatArray:
        return gathered(weights.T @ values)

    return proxy.vertices[chosen], spread_to_surface, gathered_from_surface
