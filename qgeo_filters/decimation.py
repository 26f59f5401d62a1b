"""Proxies of surfaces: far fewer triangles of the same shape and topology, and the way back from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.edge_collapse.collapse import collapsed
from qgeo_filters.edge_collapse.places import nearest_places
from qgeo_filters.errors import ParameterError
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_count, frozen

# More vertices than asked for by this factor are a failure.
_TOO_MANY = 1.1


@dataclass(frozen=True, eq=False)
class Proxy(BarycentricMap):
    """A coarser surface, and the place on it of each vertex of the original.

    Attributes
    ----------
    faces : (n,) int64
        Triangle of the proxy nearest to each vertex of the original, on the same sheet where two pass close by.
    corners : (n, 3) int64
        Its vertices.
    coordinates : (n, 3) float64
        Barycentric coordinates of the nearest point, not negative, with sum 1.
    surface : Surface
        The proxy: m vertices, without attributes.
    vertices : (m,) int64
        Vertex of the original for each vertex of the proxy: the nearest of those that went into it, so that none
        occurs twice.

    Notes
    -----
    `pulled_back` takes values per vertex of the proxy to the vertices of the original.
    """

    surface: Surface
    vertices: IndexArray


def decimated(surface: Surface, n_vertices: int) -> Proxy:
    """Proxy of so many vertices, of the same topology and orientation.

    Parameters
    ----------
    surface : Surface
        Manifold and in one piece, but for vertices without faces. Its attributes are left behind.
    n_vertices : int
        At least 4. A surface that has no more vertices is its own proxy. Where the topology or the shape allow no
        further collapse, up to a tenth more are left.

    Returns
    -------
    Proxy

    Raises
    ------
    ParameterError
        So few vertices cannot be reached.
    NonManifoldError, DisconnectedError
    """
    n_vertices = checked_count(n_vertices, 4, None, "n_vertices")
    surface.require_manifold("a proxy")
    loose = surface.unreferenced_vertices
    if surface.components[0] - loose.size != 1:
        surface.require_connected("a proxy")
    if surface.n_vertices - loose.size <= n_vertices:
        return _itself(surface)
    # Vertices without faces stay out; unit size about the origin, so that few digits are lost.
    used = np.setdiff1d(np.arange(surface.n_vertices), loose) if loose.size else np.arange(surface.n_vertices)
    renumbered = np.zeros(surface.n_vertices, dtype=np.int32)
    renumbered[used] = np.arange(len(used))
    centre, unit = surface.vertices[used].mean(axis=0), np.sqrt(surface.area) or 1.0
    scaled = (surface.vertices - centre) / unit
    rim = np.zeros(len(surface.edges), dtype=bool)
    rim[surface.boundary_edges] = True
    points, faces, merged = collapsed(
        scaled[used], renumbered[surface.faces], surface.face_edges, renumbered[surface.edges], rim, n_vertices
    )
    if len(points) > _TOO_MANY * n_vertices:
        raise ParameterError(
            f"n_vertices = {n_vertices} cannot be reached: with {len(points)} vertices no edge can be collapsed any "
            "more without a change of topology or triangles that turn over"
        )
    starts = np.empty(surface.n_vertices, dtype=np.int64)
    starts[used] = merged
    if loose.size:
        starts[loose] = cKDTree(points).query(scaled[loose])[1]
    nearest, coordinates = nearest_places(scaled, starts, points, faces)
    vertices = used[_nearest_members(scaled[used], merged, points)]
    corners = faces[nearest].astype(np.int64)
    coarse = Surface(points * unit + centre, faces)
    return Proxy(frozen(nearest), frozen(corners), frozen(coordinates), coarse, frozen(vertices))


def _nearest_members(points: FloatArray, group: IndexArray, places: FloatArray) -> IndexArray:
    """Nearest member of each group to its place; each group has one."""
    order = np.lexsort((np.linalg.norm(points - places[group], axis=1), group))
    first: IndexArray = order[np.searchsorted(group[order], np.arange(len(places)))]
    return first


def _itself(surface: Surface) -> Proxy:
    """The surface as its own proxy: each vertex is a corner of its first triangle."""
    starts = np.arange(surface.n_vertices)
    loose = surface.unreferenced_vertices
    if loose.size:
        used = np.delete(starts, loose)
        starts[loose] = used[cKDTree(surface.vertices[used]).query(surface.vertices[loose])[1]]
    # copies, as kernels are compiled for arrays that can be written to
    vertices, triangles = surface.vertices.copy(), surface.faces.copy()
    faces, coordinates = nearest_places(vertices, starts, vertices, triangles)
    corners = surface.faces[faces].astype(np.int64)
    return Proxy(frozen(faces), frozen(corners), frozen(coordinates), surface, frozen(np.arange(surface.n_vertices)))
