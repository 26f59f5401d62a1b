"""Spectrum of the distances of a large surface, from those of a proxy of it."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from qgeo_filters._typing import FloatArray
from qgeo_filters.decimation import decimated
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.geodesics.metric import Metric, metric_for
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.spectral.landmarks import farthest_points, landmark_operator
from qgeo_filters.spectral.proxies import interpolation_matrix, metric_on_proxy
from qgeo_filters.spectral.spectrum import Mass, Spectrum, check_areas, check_count, check_mass, spectrum_of_matrix
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_count

#: Vertices of the proxy.
PROXY_VERTICES = 10_000
# Landmarks among them, at least, and for each eigenpair.
_LANDMARKS, _PER_PAIR = 1000, 10


def proxy_spectrum(
    surface: SurfaceLike,
    k: int = 20,
    metric: Metric | None = "lifted",
    mass: Mass = "area",
    *,
    vertices: int = PROXY_VERTICES,
    method: str = "graph",
    accuracy: float = 1e-3,
    workers: int | None = None,
    progress: bool = False,
) -> Spectrum:
    r"""Spectrum of the distances of a surface of any size, from a proxy of some thousand vertices; in memory O(n k).

    The surface is decimated (`qgeo_filters.decimation`), the eigenfunctions of the proxy are found from landmarks
    (`landmark_operator`), interpolated in its triangles at the points nearest to the vertices of the surface, and made
    orthonormal there.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        In one piece and manifold.
    k : int
        Number of eigenpairs, at most the vertices of the proxy.
    metric : LiftedMetric, "lifted" or "cartesian"
        By name: `lifted_metric` of the surface as it is, or the surface's own metric.
    mass : {"area", "uniform"}
        As in `distance_spectrum`. A vertex of the proxy has the mass of what lies around it on the surface.
    vertices : int
        Size of the proxy; a surface that has no more is its own.
    method, accuracy, workers, progress
        As in `distances`.

    Returns
    -------
    Spectrum
        Its `approximation` says how it was found.

    Raises
    ------
    MeshError, ParameterError
        As in `distance_spectrum`; a surface that has no proxy of so few vertices.

    Notes
    -----
    In the surface's own metric the error falls with the area of the proxy's triangles: measured on a person, the span
    of the first twenty eigenfunctions is off by a sine of .034 with 5000 vertices, that of the first ten by .006. The
    scalar of a lifted metric is averaged around each vertex of the proxy: what it does within the proxy's triangles,
    the noise of a scan above all, lengthens no way there, though it does on the surface itself, the more the finer
    that is. So this is **another spectrum** where the scalar is rough (a sine of .2 for the first ten, with the mean
    curvature at its default weight); take landmarks there, as `distance_spectrum` does.

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> spectrum = qg.proxy_spectrum(surface, k=3, metric="cartesian", vertices=100)
    >>> spectrum.eigenfunctions.shape, spectrum.approximation
    ((162, 3), 'a proxy of 100 vertices, 100 of them landmarks')
    """
    surface = as_surface(surface)
    surface.require_connected("the spectrum of the distances")
    check_count(k, min(surface.n_vertices, vertices))
    check_areas(surface.vertex_areas)
    check_mass(mass)
    chosen = metric_for(surface, metric, "lifted")
    proxy = decimated(surface, checked_count(vertices, 4, None, "vertices"))
    coarse = proxy.surface
    own = surface.vertex_areas if mass == "area" else np.ones(surface.n_vertices)
    carried = metric_on_proxy(chosen, proxy)
    count = min(max(_LANDMARKS, _PER_PAIR * k), coarse.n_vertices)
    points = farthest_points(coarse, count, carried)
    rows = distances(coarse, points, carried, method, accuracy=accuracy, workers=workers, progress=progress)
    found = spectrum_of_matrix(
        landmark_operator(carried, points, rows), _gathered(interpolation_matrix(proxy), own, coarse), k
    )
    functions = _orthonormal(proxy.pulled_back(found.eigenfunctions), own)
    said = f"a proxy of {coarse.n_vertices} vertices, {count} of them landmarks"
    return Spectrum.of(found.eigenvalues, functions, own, approximation=said)


def _gathered(weights: sparse.csr_array, mass: FloatArray, coarse: Surface) -> FloatArray:
    """Mass (m,) of the vertices of the proxy; one that nothing is nearest to takes its share of the proxy's area."""
    gathered = weights.T @ mass
    none = ~(gathered > 0)
    gathered[none] = coarse.vertex_areas[none] * (mass.sum() / coarse.area)
    return gathered


def _orthonormal(functions: FloatArray, mass: FloatArray) -> FloatArray:
    """Orthonormal functions (n, k) that differ from these, nearly so, as little as any (Loewdin 1950)."""
    values, turn = np.linalg.eigh(functions.T @ (mass[:, None] * functions))
    return functions @ ((turn / np.sqrt(values)) @ turn.T)
