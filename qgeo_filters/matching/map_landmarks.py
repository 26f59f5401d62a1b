"""Landmarks of one shape on the other, along a map."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.array_likes import as_array
from qgeo_filters.closest_points import closest_points
from qgeo_filters.errors import ParameterError
from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.matching.maps.barycentric import BarycentricMap, nearest_around
from qgeo_filters.repair.welding import welded
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_indices


def as_landmarks(given: Landmarks | npt.ArrayLike) -> Landmarks:
    """Landmarks of vertices (k,), of points (k, 3), or as they are."""
    if isinstance(given, Landmarks):
        return given
    array = as_array(given)
    if array.ndim <= 1 and (array.dtype.kind in "iu" or not array.size):
        return Landmarks(vertices=np.atleast_1d(array).astype(np.int64))
    if array.ndim == 2 and array.shape[1] == 3 and array.dtype.kind in "iuf":
        return Landmarks(points=array)
    raise ParameterError(
        f"landmarks are Landmarks, vertices of shape (k,) or points of shape (k, 3), got {array.dtype} of shape "
        f"{array.shape}"
    )


def located(landmarks: Landmarks, surface: Surface, name: str, tolerance: float = 0.05) -> BarycentricMap:
    """Point of the surface for each landmark: that closest in space, or its vertex where it has no position.

    Raises
    ------
    ParameterError
        A landmark farther from the surface than ``tolerance`` times its bounding box's diagonal, or a vertex that
        there is not, or that no face has.
    """
    checked_indices(landmarks.vertices, surface.n_vertices, f"landmarks of {name}", missing=True)
    by_vertex = np.isnan(landmarks.points[:, 0]) & (landmarks.vertices >= 0)
    points = landmarks.points.copy()
    points[by_vertex] = surface.vertices[landmarks.vertices[by_vertex]]
    place = closest_points(points, surface)
    gap = _gaps(points, place, surface)
    far = np.flatnonzero(gap > tolerance)
    if far.size:
        worst = far[0]
        turned = points * [-1.0, -1.0, 1.0]
        mirrored = _gaps(turned, closest_points(turned, surface), surface)
        hint = (
            "; with x and y negated all are on it: give the landmarks in the other of the frames RAS and LPS"
            if not (mirrored > tolerance).any()
            else ": is it in the unit and frame of the shape?"
        )
        raise ParameterError(
            f"landmark {worst} ({landmarks.names[worst]!r}) is {gap[worst]:.3g} times the extent of {name} away from "
            f"it, more than {tolerance:g} ({far.size} such){hint}"
        )
    return place


def images_on_target(place: BarycentricMap, positions: FloatArray, p2p: IndexArray, target: Surface) -> BarycentricMap:
    """Points of the target for points within triangles of a source that was deformed onto it.

    Parameters
    ----------
    place : BarycentricMap
        Of the source, one for each point.
    positions : (n, 3) float64
        The source, deformed.
    p2p : (n,) int64
        Vertex of the target for each vertex of the source; -1: none.
    """
    near = place.nearest_corner
    starts = np.where(near >= 0, p2p[near], -1)
    # Corners that have no image are left out, so that a point beside a rim still has one.
    finite = np.asarray(np.isfinite(positions).all(axis=1))
    weights = np.where(finite[place.corners], place.coordinates, 0.0)
    total = weights.sum(axis=1, keepdims=True)
    weights = np.divide(weights, total, out=np.full_like(weights, np.nan), where=total > 0)
    points = np.einsum("ij,ijk->ik", weights, np.nan_to_num(positions)[place.corners])
    return nearest_around(points, starts, target.vertices, target.faces, welded(target.vertices, target.faces)[0])


def landmarks_at(names: tuple[str, ...], place: BarycentricMap, surface: Surface) -> Landmarks:
    """Landmarks at points of a surface, each with the vertex nearest to it."""
    points = place.pulled_back(surface.vertices)
    lengths = np.linalg.norm(surface.vertices[place.corners] - points[:, None], axis=2)
    nearest = np.take_along_axis(place.corners, lengths.argmin(axis=1)[:, None], axis=1)[:, 0]
    return Landmarks(names, points, nearest)


def _gaps(points: FloatArray, place: BarycentricMap, surface: Surface) -> FloatArray:
    """Distance of each point from its place, as a share of the diagonal of the surface's bounding box."""
    extent = float(np.linalg.norm(np.ptp(surface.vertices, axis=0))) or 1.0
    gaps: FloatArray = np.linalg.norm(place.pulled_back(surface.vertices) - points, axis=1) / extent
    return gaps
