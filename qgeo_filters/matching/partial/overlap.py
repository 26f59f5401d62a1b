"""Who has a partner: which vertices of a part lie on the whole, and which of the whole are covered by the part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.barycentric import BarycentricMap, nearest_in_triangles
from qgeo_filters.closest_points import closest_facing_points
from qgeo_filters.matching.partial.part_registration import PartMap
from qgeo_filters.matching.partial.part_shape import PartShape
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen


@dataclass(frozen=True, eq=False)
class Overlap:
    """A part on the whole, at full resolution; no partner is -1, and NaN for coordinates.

    Attributes
    ----------
    on_whole : BarycentricMap
        Point of the whole for each vertex of the part, (n_part,).
    on_part : BarycentricMap
        Point of the part for each vertex of the whole, (n_whole,).
    positions : (n_part, 3) float64
        The part deformed onto the whole, in the whole's place and unit.
    share_of_part, share_of_whole : float
        Of the area that has a partner.
    """

    on_whole: BarycentricMap
    on_part: BarycentricMap
    positions: FloatArray
    share_of_part: float
    share_of_whole: float


def overlap(part: PartShape, whole: PartShape, found: PartMap) -> Overlap:
    """Who has a partner along the map of a part to the whole.

    A vertex of the part has one if it came to lie on the whole; one of the whole, if the deformed part covers it: if
    the point of the part nearest to it is near, and does not lie on the rim with the vertex beyond.
    """
    given, unit = part.given, whole.unit
    positions = part.proxy.pulled_back(found.positions) * unit + whole.centre
    deformed = part.full.with_vertices(positions)
    there = _places(positions, deformed.vertex_normals, whole.full)
    near = _gaps(positions, there, whole.full.vertices) <= given.overlap_gap * unit
    back = _places(whole.full.vertices, whole.full.vertex_normals, deformed)
    gaps = _gaps(whole.full.vertices, back, positions)
    covered = (gaps <= given.overlap_gap * unit) & (~_on_rim(back, deformed) | (gaps <= given.rim_gap * unit))
    return Overlap(
        _only(there, near),
        _only(back, covered),
        positions,
        _share(part.full, near),
        _share(whole.full, covered),
    )


def _share(surface: Surface, chosen: npt.NDArray[np.bool_]) -> float:
    return float(surface.vertex_areas[chosen].sum() / surface.vertex_areas.sum())


def _places(points: FloatArray, normals: FloatArray, surface: Surface) -> BarycentricMap:
    faces, coordinates = closest_facing_points(points, normals, surface)
    return BarycentricMap(faces, surface.faces[faces].astype(np.int64), coordinates)


def _gaps(points: FloatArray, places: BarycentricMap, vertices: FloatArray) -> FloatArray:
    there = np.einsum("ij,ijk->ik", places.coordinates, vertices[places.corners])
    return np.asarray(np.linalg.norm(points - there, axis=1))


def _on_rim(places: BarycentricMap, surface: Surface) -> npt.NDArray[np.bool_]:
    """Whether each place lies on the boundary: at a vertex of it, or between two."""
    rim = np.zeros(surface.n_vertices, dtype=bool)
    rim[surface.boundary_vertices] = True
    inside = places.coordinates > _LEAST_COORDINATE
    return np.asarray((rim[places.corners] | ~inside).all(axis=1) & ~inside.all(axis=1))


# Barycentric coordinates below this are those of a side.
_LEAST_COORDINATE = 1e-6


def _only(places: BarycentricMap, kept: npt.NDArray[np.bool_]) -> BarycentricMap:
    return BarycentricMap(
        frozen(np.where(kept, places.faces, -1)),
        frozen(np.where(kept[:, None], places.corners, -1)),
        frozen(np.where(kept[:, None], places.coordinates, np.nan)),
    )


def in_faces_of(places: BarycentricMap, surface: Surface) -> BarycentricMap:
    """The same points with the corners in the order of the surface's faces, which may have been turned over."""
    known = places.faces >= 0
    corners, coordinates = places.corners.copy(), places.coordinates.copy()
    corners[known] = surface.faces[places.faces[known]]
    turned = corners[:, 0] != places.corners[:, 0]
    turned |= (corners != places.corners).any(axis=1)
    points = np.einsum("ij,ijk->ik", places.coordinates[turned], surface.vertices[places.corners[turned]])
    coordinates[turned], _ = nearest_in_triangles(points, surface.vertices[corners[turned]])
    return BarycentricMap(places.faces, frozen(corners), frozen(coordinates))
