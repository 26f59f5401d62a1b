"""Differential coordinates: each vertex seen from the mean of its neighbours (paper, sec. 4)."""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy import sparse

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.surface import Surface


def differential_coordinates(surface: SurfaceLike, weights: Literal["uniform", "cotangent"] = "uniform") -> FloatArray:
    r"""Differential coordinate of each vertex, shape (n, 3).

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    weights : {"uniform", "cotangent"}
        ``"uniform"``: :math:`\delta_i = x_i - \frac{1}{|N(i)|} \sum_{j \in N(i)} x_j`, a length in the unit of the
        vertices; it depends on how the surface is sampled.
        ``"cotangent"``: :math:`\delta_i = \frac{1}{2 A_i} \sum_j (\cot\alpha_{ij} + \cot\beta_{ij}) (x_i - x_j)`
        with the mixed Voronoi area :math:`A_i` of `mixed_voronoi_areas`, in units of 1 / length. It does not
        depend on the sampling: inside the surface it tends to 2 H n, twice the mean curvature times the normal
        (2 / r on a sphere of radius r).

    Returns
    -------
    (n, 3) float64
        Zero for a vertex without faces. At the boundary the neighbourhood is one-sided, so that either form
        has a tangential part which does not vanish with the edge length.

    Raises
    ------
    ValueError
        Unknown ``weights``.

    References
    ----------
    Das and Bhandarkar, CVPR Workshops 2018, sec. 4. Meyer, Desbrun, Schroeder, Barr, "Discrete
    differential-geometry operators for triangulated 2-manifolds", VisMath 2002 (the cotangent form).

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> bent = np.linalg.norm(qg.differential_coordinates(surface, "cotangent"), axis=1)
    >>> bent.shape, round(float(np.median(bent)), 2)  # twice the mean curvature
    ((162,), 1.87)
    """
    surface = as_surface(surface)
    if weights == "uniform":
        return _umbrella(surface)
    if weights == "cotangent":
        areas = mixed_voronoi_areas(surface)[:, None]
        gradient = area_gradient(surface)
        return np.divide(gradient, areas, out=np.zeros_like(gradient), where=areas > 0)
    raise ParameterError(f"weights must be 'uniform' or 'cotangent', got {weights!r}")


def _umbrella(surface: Surface) -> FloatArray:
    # Differences first, then their mean: a mesh far from the origin loses no digits.
    a, b = surface.edges.T
    step = surface.vertices[a] - surface.vertices[b]
    ends = np.concatenate([a, b])
    total = _summed(ends, np.concatenate([step, -step]), surface.n_vertices)
    valence = np.bincount(ends, minlength=surface.n_vertices)
    return total / np.maximum(valence, 1)[:, None]


def area_gradient(surface: Surface) -> FloatArray:
    r"""Gradient of the total area with respect to each vertex, shape (n, 3), in the unit of the vertices.

    It equals :math:`\frac12 \sum_j (\cot\alpha_{ij} + \cot\beta_{ij}) (x_i - x_j)` (Pinkall and Polthier,
    "Computing discrete minimal surfaces and their conjugates", 1993), summed here over the triangles as
    half the opposite side turned by 90 degrees. No cotangent occurs, so that a needle contributes no more than
    the length of its sides and a triangle without area contributes nothing.
    """
    x, faces = surface.vertices, surface.faces
    total = np.zeros_like(x)
    for k in range(3):
        opposite = x[faces[:, (k + 2) % 3]] - x[faces[:, (k + 1) % 3]]
        total += _summed(faces[:, k], 0.5 * np.cross(surface.face_normals, opposite), len(x))
    return total


def mixed_voronoi_areas(surface: Surface) -> FloatArray:
    """Mixed Voronoi area of each vertex, shape (n,); they sum to the area of the surface.

    Each triangle gives its corners the part of it that is nearest to them; an obtuse triangle gives half of
    its area to the obtuse corner and a quarter to the others (Meyer et al. 2002, sec. 3.3). With this
    area, unlike with a third of the triangles, curvatures are exact in the limit at vertices of any valence.
    """
    squared = (surface.edge_lengths**2)[surface.face_edges]  # side k runs from corner k to corner k + 1
    area = surface.face_areas
    beside = squared + np.roll(squared, 1, axis=1)
    dot = (beside - np.roll(squared, -1, axis=1)) / 2  # <edge, edge> at corner k; negative where obtuse
    obtuse = dot < 0
    with np.errstate(divide="ignore", invalid="ignore"):
        cot = dot / (2 * area)[:, None]
        # Corner k: its two sides k and k - 1 lie opposite to corners k + 2 and k + 1.
        voronoi = (squared * np.roll(cot, -2, axis=1) + np.roll(squared, 1, axis=1) * np.roll(cot, -1, axis=1)) / 8
    share = np.where(obtuse, 0.5, 0.25) * area[:, None]
    use_share = obtuse.any(axis=1) | (area == 0)
    corner = np.where(use_share[:, None], share, voronoi)
    return np.bincount(surface.faces.ravel(), corner.ravel(), minlength=surface.n_vertices).astype(np.float64)


def spread_to_neighbours(surface: Surface, values: FloatArray, known: npt.NDArray[np.bool_]) -> FloatArray:
    """Values (n,) with the unknown ones replaced by the mean over known neighbours, ring after ring.

    A vertex that no known one can be reached from becomes 0.
    """
    a, b = surface.edges.T
    n = surface.n_vertices
    ones = np.ones(2 * len(a))
    adjacency = sparse.csr_matrix((ones, (np.concatenate([a, b]), np.concatenate([b, a]))), shape=(n, n))
    filled, known = np.where(known, values, 0.0), known.copy()
    while not known.all():
        support = adjacency @ known.astype(np.float64)
        fresh = ~known & (support > 0)
        if not fresh.any():
            break
        filled[fresh] = (adjacency @ filled)[fresh] / support[fresh]
        known |= fresh
    return filled


def _summed(index: npt.NDArray[np.int32], rows: FloatArray, size: int) -> FloatArray:
    """Sum of the rows (m, 3) that share an index, shape (size, 3)."""
    return np.column_stack([np.bincount(index, rows[:, k], minlength=size) for k in range(3)])
