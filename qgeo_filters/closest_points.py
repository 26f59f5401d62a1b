"""Closest points of a surface: in space, or on the sheet that faces the same way where two pass close to each other."""

from __future__ import annotations

import igl
import numpy as np
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.barycentric import BarycentricMap, nearest_in_triangles
from qgeo_filters.parallel import worker_count
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen

# Candidates that are looked at where the nearest one faces away.
_CANDIDATES = 32
# Weight of normals beside places on a surface of unit area: a sheet's other side, which differs by 2 in its normal, is
# as far as a fifth of the surface's size.
_TURN = 0.1
# Length, in sqrt(area), for which opposite normals count: sheets nearer than this are told apart by the side they face.
_NORMAL_LENGTH = 0.03


def closest_points(points: FloatArray, surface: Surface) -> BarycentricMap:
    """Point of the surface closest in space to each point, (k, 3); none where a coordinate is not finite."""
    known = np.isfinite(points).all(axis=1)
    vertices, scaled = _unit(surface, surface.vertices), _unit(surface, points[known])
    faces = surface.faces.astype(np.int64)
    place = BarycentricMap.unknown(len(points))
    if known.any():
        _, face, _ = igl.point_mesh_squared_distance(scaled, vertices, faces)
        place.faces[known], place.corners[known] = face, faces[face]
        place.coordinates[known], _ = nearest_in_triangles(scaled, vertices[faces[face]])
    return BarycentricMap(frozen(place.faces), frozen(place.corners), frozen(place.coordinates))


def closest_facing_points(points: FloatArray, normals: FloatArray, surface: Surface) -> tuple[IndexArray, FloatArray]:
    """Point of the surface closest to each point, of those whose triangle does not face away from its normal.

    Parameters
    ----------
    points, normals : (k, 3) float64
        A normal may be zero: then any triangle will do.
    surface : Surface

    Returns
    -------
    faces : (k,) int64
    coordinates : (k, 3) float64
        Barycentric, not negative, with sum 1.

    Notes
    -----
    Where the closest triangle faces away, the nearest ones that face the same way are compared, nearest by their
    centroids; where none of those does, the closest triangle stands.
    """
    vertices, points = _unit(surface, surface.vertices), _unit(surface, points)
    _, nearest, _ = igl.point_mesh_squared_distance(points, vertices, surface.faces.astype(np.int64))
    faces: IndexArray = nearest.astype(np.int64)
    corners = vertices[surface.faces]
    away = np.flatnonzero(np.einsum("ij,ij->i", normals, surface.face_normals[faces]) < 0)
    if away.size:
        found = _nearest_facing(points[away], normals[away], corners.mean(axis=1), surface.face_normals)
        owner, place = np.nonzero(found >= 0)
        candidates = found[owner, place]
        _, gaps = nearest_in_triangles(points[away[owner]], corners[candidates])
        order = np.lexsort((candidates, gaps, owner))
        first = order[np.unique(owner[order], return_index=True)[1]]
        faces[away[owner[first]]] = candidates[first]
    coordinates, _ = nearest_in_triangles(points, corners[faces])
    return faces, coordinates


def with_normals(points: FloatArray, normals: FloatArray, target: Surface) -> FloatArray:
    """Points with their normals (n, 6), as they are compared on a surface: in its unit of length."""
    return np.column_stack([points, _NORMAL_LENGTH * np.sqrt(target.area) * normals])


def nearest_facing_vertices(places: FloatArray, vertices: FloatArray, surface: Surface) -> IndexArray:
    """Vertex near each place that faces the same way; -1 where a place is NaN.

    Parameters
    ----------
    places, vertices : (k, 6), (m, 6) float64
        Points beside their normals; vertices that are NaN are none.
    surface : Surface
        Whose unit of length tells how much normals count.
    """
    known, candidates = (np.flatnonzero(np.isfinite(one).all(axis=1)) for one in (places, vertices))
    here, there = (with_normals(one[:, :3], one[:, 3:], surface) for one in (places[known], vertices[candidates]))
    found = np.full(len(places), -1, dtype=np.int64)
    found[known] = candidates[cKDTree(there).query(here, workers=worker_count())[1]]
    return found


def _unit(surface: Surface, points: FloatArray) -> FloatArray:
    """Points where the surface has its centre in the origin and unit area: libigl's tree has absolute tolerances."""
    scaled: FloatArray = (points - surface.vertices.mean(axis=0)) / (np.sqrt(surface.area) or 1.0)
    return scaled


def _nearest_facing(points: FloatArray, normals: FloatArray, places: FloatArray, facing: FloatArray) -> IndexArray:
    """Nearest places (k, c) that face the way of each point, in the order of their distance, -1 where there are none.

    Nearest in space and direction together; only those that agree in direction are listed.
    """
    count = min(_CANDIDATES, len(places))
    tree = cKDTree(np.hstack([places, _TURN * facing]))
    _, found = tree.query(np.hstack([points, _TURN * normals]), k=np.arange(1, count + 1))
    agrees = np.einsum("ij,ikj->ik", normals, facing[found]) > 0
    gaps = np.where(agrees, np.linalg.norm(places[found] - points[:, None], axis=2), np.inf)
    order = np.argsort(gaps, axis=1, kind="stable")
    nearest: IndexArray = np.take_along_axis(np.where(agrees, found, -1), order, axis=1)
    return nearest
