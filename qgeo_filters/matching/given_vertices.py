"""Results on the vertices and faces that were given, from those on the repaired shapes that were matched."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.maps.barycentric import BarycentricMap
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.validation import frozen

if TYPE_CHECKING:
    from qgeo_filters.matching.symmetry_result import Symmetry


def match_on_given(found: MatchResult, x: PreparedShape, y: PreparedShape) -> MatchResult:
    """The result of matching ``x.full`` and ``y.full`` for ``x.given`` and ``y.given``.

    Parameters
    ----------
    found : MatchResult
        On the vertices and faces of the repaired shapes.
    x, y : PreparedShape

    Returns
    -------
    MatchResult
        Given vertices that were joined have one image; where one was split, the image is that of its first. A vertex
        that is gone has the image -1, the region -1, and NaN for distortion, position and barycentric coordinates.
        Images are the first of the vertices that were joined; triangles and their corners are those that were given.
    """
    if x.repair is None and y.repair is None:
        return found
    return replace(
        found,
        x=x.given,
        y=y.given,
        p2p=indices_on_given(found.p2p, x.repair, y.repair),
        inverse=indices_on_given(found.inverse, y.repair, x.repair),
        distortion=_values(found.distortion, x.repair),
        regions_x=_values(found.regions_x, x.repair),
        regions_y=_values(found.regions_y, y.repair),
        positions=_values(found.positions, x.repair),
        barycentric=_places(found.barycentric, x.repair, y.repair),
        repairs=(*_sentences("X", x.repair), *_sentences("Y", y.repair)),
    )


def symmetry_on_given(found: Symmetry, x: PreparedShape) -> Symmetry:
    """The symmetry of ``x.full`` for ``x.given``.

    Returns
    -------
    Symmetry
        A vertex that is gone has the mirror vertex -1, the side 0, the region -1 and NaN for its asymmetry, and is not
        on the axis. Vertices that were joined have one mirror vertex, the first of those there: ``p2p`` is an
        involution up to vertices that lie on each other.
    """
    if x.repair is None:
        return found
    side = _values(found.side, x.repair).copy()
    side[x.repair.vertex_of_original < 0] = 0
    return replace(
        found,
        p2p=indices_on_given(found.p2p, x.repair, x.repair),
        nearest=indices_on_given(found.nearest, x.repair, x.repair),
        side=frozen(side),
        fixed=_values(found.fixed, x.repair),
        asymmetry=_values(found.asymmetry, x.repair),
        regions=_values(found.regions, x.repair),
        barycentric=_places(found.barycentric, x.repair, x.repair),
        repairs=tuple(x.repair.report),
    )


def _values(values: np.ndarray, repair: Repair | None) -> np.ndarray:
    """Values at the given vertices."""
    return values if repair is None else frozen(repair.map_back(values))


def indices_on_given(images: IndexArray, of: Repair | None, on: Repair | None) -> IndexArray:
    """Given vertex of one shape for each given vertex of another."""
    if on is not None:
        images = np.where(images >= 0, on.origin[np.maximum(images, 0)], -1)
    return _values(frozen(images), of)


def _places(places: BarycentricMap, of: Repair | None, on: Repair | None) -> BarycentricMap:
    """Points of given triangles, for each given vertex."""
    faces, corners, coordinates = places.faces, places.corners, places.coordinates
    if on is not None:
        there = faces >= 0
        chosen = np.maximum(faces, 0)
        given = on.face_origin[chosen]
        faces = np.where(there, given, -1)
        corners = np.where(there[:, None], on.given.faces[given].astype(np.int64), -1)
        coordinates = np.where(on.turned[chosen][:, None], coordinates[:, ::-1], coordinates)
    return BarycentricMap(
        _values(frozen(faces), of),
        _values(frozen(corners), of),
        _values(frozen(coordinates), of),
    )


def _sentences(name: str, repair: Repair | None) -> tuple[str, ...]:
    return () if repair is None else tuple(f"{name}: {sentence}" for sentence in repair.report)
