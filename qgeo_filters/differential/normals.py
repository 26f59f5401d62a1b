"""Vertex normals, corrected to stay inside the solid angle of the incident faces (paper, Fig. 2d)."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.differential.cone_projection import projected_on_cones
from qgeo_filters.differential.coordinates import differential_coordinates
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface

# Below this fraction of the vertex's edges, a differential coordinate has no direction but rounding.
_VANISHING = 1e-9


def vertex_normals(surface: SurfaceLike, corrected: bool = True) -> FloatArray:
    r"""Unit normal of each vertex, shape (n, 3).

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    corrected : bool
        True: the direction of the uniform differential coordinate, turned to the side of the angle-weighted
        normal and projected on the convex cone that the normals :math:`n_f` of the incident faces span,
        :math:`\min_{w \ge 0} |\sum_f w_f n_f - d|`. Where the coordinate vanishes (a plane) or the projection is zero,
        the angle-weighted normal. False: the angle-weighted normal everywhere.

    Returns
    -------
    (n, 3) float64
        Always a non-negative combination of the normals of the incident faces. Zero for a vertex without
        faces, or with none of positive area.

    References
    ----------
    Das and Bhandarkar, CVPR Workshops 2018, sec. 4 and Fig. 2(d).

    Examples
    --------
    >>> surface = qg.testing.sample_surface()
    >>> normals = qg.vertex_normals(surface)
    >>> np.allclose(np.linalg.norm(normals, axis=1), 1)
    True
    >>> bool((np.einsum("ij,ij->i", normals, surface.vertices) > 0).all())  # outwards
    True
    """
    surface = as_surface(surface)
    weighted = surface.vertex_normals
    if not corrected:
        return weighted
    delta = differential_coordinates(surface)
    direction = np.where(np.einsum("ij,ij->i", delta, weighted)[:, None] < 0, -delta, delta)
    length = np.linalg.norm(direction, axis=1)
    reach = np.zeros(surface.n_vertices)
    for end in surface.edges.T:
        np.maximum.at(reach, end, surface.edge_lengths)
    usable = length > _VANISHING * reach
    corners = np.argsort(surface.faces.ravel(), kind="stable")
    start = np.searchsorted(surface.faces.ravel()[corners], np.arange(surface.n_vertices + 1))
    unit = np.divide(direction, length[:, None], out=np.zeros_like(direction), where=usable[:, None])
    projection = projected_on_cones(surface.face_normals, start, corners // 3, unit)
    size = np.linalg.norm(projection, axis=1, keepdims=True)
    return np.divide(projection, size, out=weighted.copy(), where=size > _VANISHING)
