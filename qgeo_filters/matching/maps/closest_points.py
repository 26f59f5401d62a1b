"""Point of a surface closest in space to each point."""

from __future__ import annotations

import igl
import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.barycentric import BarycentricMap, nearest_in_triangles
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen


def closest_points(points: FloatArray, surface: Surface) -> BarycentricMap:
    """Point of the surface closest in space to each point, (k, 3); none where a coordinate is not finite."""
    known = np.isfinite(points).all(axis=1)
    # libigl's tree compares with absolute tolerances: give it a surface of unit size.
    centre, unit = surface.vertices.mean(axis=0), np.sqrt(surface.area) or 1.0
    vertices = (surface.vertices - centre) / unit
    faces = surface.faces.astype(np.int64)
    scaled = (points[known] - centre) / unit
    place = BarycentricMap.unknown(len(points))
    if known.any():
        _, face, _ = igl.point_mesh_squared_distance(scaled, vertices, faces)
        place.faces[known], place.corners[known] = face, faces[face]
        place.coordinates[known], _ = nearest_in_triangles(scaled, vertices[faces[face]])
    return BarycentricMap(frozen(place.faces), frozen(place.corners), frozen(place.coordinates))
