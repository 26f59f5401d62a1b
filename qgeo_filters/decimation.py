"""Proxies of surfaces: far fewer triangles of the same shape and topology, and the way back from them."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.closest_points import closest_facing_points, closest_facing_vertices
from qgeo_filters.errors import ParameterError
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_count, frozen

# More vertices than asked for by this factor are a failure.
_TOO_MANY = 1.25


@dataclass(frozen=True, eq=False)
class Proxy(BarycentricMap):
    """A coarser surface, and the place on it of each vertex of the original.

    Attributes
    ----------
    faces : (n,) int64
        Triangle of the proxy nearest to each vertex of the original, of those that do not face away from it.
    corners : (n, 3) int64
        Its vertices.
    coordinates : (n, 3) float64
        Barycentric coordinates of the nearest point, not negative, with sum 1.
    surface : Surface
        The proxy: m vertices, without attributes.
    vertices : (m,) int64
        Vertex of the original nearest to each vertex of the proxy, of those that do not face away from it.

    Notes
    -----
    `pulled_back` takes values per vertex of the proxy to the vertices of the original.
    """

    surface: Surface
    vertices: IndexArray


def decimated(surface: Surface, n_vertices: int) -> Proxy:
    """Proxy of about so many vertices, of the same topology and orientation.

    Parameters
    ----------
    surface : Surface
        Manifold and in one piece, but for vertices without faces. Its attributes are left behind.
    n_vertices : int
        At least 4. A surface that has no more vertices is its own proxy.

    Returns
    -------
    Proxy

    Raises
    ------
    ParameterError
        So few vertices cannot be reached: the boundary or the handles need more.
    NonManifoldError, DisconnectedError

    References
    ----------
    Garland & Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997.
    """
    n_vertices = checked_count(n_vertices, 4, None, "n_vertices")
    surface.require_manifold("a proxy")
    loose = surface.unreferenced_vertices.size
    if surface.components[0] - loose != 1:
        surface.require_connected("a proxy")
    if surface.n_vertices - loose <= n_vertices:
        return _itself(surface)
    coarse = _collapsed(surface, n_vertices)
    faces, coordinates = closest_facing_points(surface.vertices, surface.vertex_normals, coarse)
    vertices = closest_facing_vertices(coarse.vertices, coarse.vertex_normals, surface)
    corners = coarse.faces[faces].astype(np.int64)
    return Proxy(frozen(faces), frozen(corners), frozen(coordinates), coarse, frozen(vertices))


def _collapsed(surface: Surface, n_vertices: int) -> Surface:
    """Surface with edges collapsed until it has about so many vertices."""
    # The costs of collapses are compared with absolute tolerances: unit size. Vertices without faces stay out.
    used = np.setdiff1d(np.arange(surface.n_vertices), surface.unreferenced_vertices)
    renumbered = np.zeros(surface.n_vertices, dtype=np.int64)
    renumbered[used] = np.arange(len(used))
    centre, unit = surface.vertices[used].mean(axis=0), np.sqrt(surface.area) or 1.0
    # Euler: a closed surface has 2 (n - chi) triangles; a boundary has about as many edges as its share of vertices.
    shrunk = np.sqrt(n_vertices / len(used))
    n_faces = round(2 * (n_vertices - surface.euler_characteristic) - shrunk * surface.boundary_edges.size)
    points, faces, _, _ = igl.qslim(
        (surface.vertices[used] - centre) / unit, renumbered[surface.faces], max(n_faces, 1)
    )
    if len(faces) == 0 or len(points) > max(_TOO_MANY * n_vertices, n_vertices + 2):
        raise ParameterError(
            f"n_vertices = {n_vertices} cannot be reached: no edge can be collapsed any more at {len(points)} vertices "
            "without a change of topology"
        )
    coarse = Surface(points * unit + centre, faces)
    same = coarse.is_manifold and coarse.euler_characteristic == surface.euler_characteristic
    if not same or len(coarse.boundary_loops) != len(surface.boundary_loops):
        raise ParameterError(f"n_vertices = {n_vertices} cannot be reached without a change of topology; ask for more")
    return coarse


def _itself(surface: Surface) -> Proxy:
    """The surface as its own proxy: each vertex is a corner of its first triangle."""
    n, corner = surface.n_vertices, surface.faces.ravel()
    first = np.zeros(n, dtype=np.int64)
    first[corner[::-1]] = np.arange(3 * surface.n_faces)[::-1]
    faces, place = first // 3, first % 3
    coordinates = np.zeros((n, 3))
    coordinates[np.arange(n), place] = 1.0
    loose = surface.unreferenced_vertices
    if loose.size:
        faces[loose], coordinates[loose] = closest_facing_points(
            surface.vertices[loose], np.zeros((loose.size, 3)), surface
        )
    corners = surface.faces[faces].astype(np.int64)
    return Proxy(frozen(faces), frozen(corners), frozen(coordinates), surface, frozen(np.arange(n)))
