"""Compilation of all kernels ahead of the first real call."""

from __future__ import annotations

import numpy as np

from qgeo_filters.decimation import decimated
from qgeo_filters.deformation.arap_sums import covariances, rotated_edge_sums, rotation_misfit
from qgeo_filters.deformation.fit_rotations import fit_rotations
from qgeo_filters.deformation.interpolation import InterpolationPath
from qgeo_filters.differential.normals import vertex_normals
from qgeo_filters.geodesics.matrix import distance_matrix, distances
from qgeo_filters.geodesics.path.paths import quasi_geodesic
from qgeo_filters.matching.maps.map_distance import coarse_distortions
from qgeo_filters.matching.partial.distance_bounds import added_costs, profile_costs
from qgeo_filters.report.raster import rasterize
from qgeo_filters.surface import Surface


def warmup() -> None:
    """Compile every kernel of the package, or load it from the cache on disk.

    Takes some seconds once after installation or an update, and well under a second from then on. Without it, the
    first call of each method takes that time.

    Examples
    --------
    >>> qg.warmup()
    """
    _geodesics()
    _matching()
    rasterize(np.zeros((3, 3)), np.array([[0, 1, 2]], dtype=np.int32), 1, 1)


def _geodesics() -> None:
    x, y = np.divmod(np.arange(25.0), 5)
    corner = np.arange(20)[np.arange(20) % 5 < 4]
    faces = np.concatenate(
        [np.stack([corner, corner + 5, corner + 6], axis=1), np.stack([corner, corner + 6, corner + 1], axis=1)]
    )
    square = np.stack([x, y, 0 * x], axis=1)
    # Sides of very different lengths are kept in other numbers, by other kernels.
    spike = 1e-9 * square
    spike[-1] = 1
    for vertices in (square, spike):
        surface = Surface(vertices, faces)
        distance_matrix(surface)
        distances(surface, [0])
    surface = Surface(square, faces)
    decimated(surface, 12)
    vertex_normals(surface)
    distances(surface, [0], method="exact")
    quasi_geodesic(surface, 0, 24, initial="exact")
    quasi_geodesic(surface, 0, 24, initial="edges")
    InterpolationPath(surface, square + 1.0)(0.5)


def _matching() -> None:
    """Two vertices joined by an edge, in arrays of the types and orders that a match has."""
    half_edges = np.array([0, 1, 2]), np.array([1, 0]), np.ones(2), np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    positions = np.array([[1.0, 0, 0], [0.0, 0, 0]])
    for order in (positions, np.asfortranarray(positions)):  # of a surface, and as a solver returns them
        rotations = fit_rotations(covariances(*half_edges, order))
    rotated_edge_sums(*half_edges, rotations)
    rotation_misfit(*half_edges, rotations, np.asfortranarray(positions))
    near = np.zeros((2, 2), np.float32)
    coarse_distortions(near, near, np.zeros((1, 2), np.int64))
    added_costs(near[1, :1], near[1, :1], near, np.zeros((1, 1), np.int64), 0.1, 0.3)
    profile_costs(near, near, near, near, np.zeros(2, np.int64), 0.1, 0.3)
