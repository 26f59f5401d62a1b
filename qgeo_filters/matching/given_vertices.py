"""Results on the vertices and faces that were given, from those on the repaired shapes that were matched."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.closest_points import nearest_facing_vertices
from qgeo_filters.hosts.given_images import given_places, images_on_given, keep_vertices
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.matching.maps.barycentric import BarycentricMap, barycentric_map
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
    positions = _values(found.positions, x.repair)
    if keep_vertices(x.repair, y.repair):
        p2p = images_on_given(found.p2p, x.repair, y.repair, y.full)
        inverse = images_on_given(found.inverse, y.repair, x.repair, x.full)
        places = _places(found.barycentric, x.repair, y.repair)
    else:
        p2p, inverse = _carried(found, x, y)
        places = barycentric_map(positions, p2p, y.given)
    on_given = replace(
        found,
        x=x.given,
        y=y.given,
        p2p=frozen(p2p),
        inverse=frozen(inverse),
        distortion=_values(found.distortion, x.repair),
        regions_x=_values(found.regions_x, x.repair),
        regions_y=_values(found.regions_y, y.repair),
        positions=positions,
        barycentric=places,
        repairs=(*_sentences("X", x.repair), *_sentences("Y", y.repair)),
        wrap_x=_wrap_alpha(x.repair),
        wrap_y=_wrap_alpha(y.repair),
    )
    for name, repair in (("around_x", x.repair), ("around_y", y.repair)):
        if not keep_vertices(repair):
            on_given.__dict__[name] = repair  # which it would make again
    return on_given


def symmetry_on_given(found: Symmetry, x: PreparedShape) -> Symmetry:
    """The symmetry of ``x.full`` for ``x.given``.

    Returns
    -------
    Symmetry
        A vertex that is gone has the mirror vertex -1, the side 0, the region -1 and NaN for its asymmetry, and is not
        on the axis. Vertices that were joined have one mirror vertex, the first of those there: ``p2p`` is an
        involution up to vertices that lie on each other; of a shape that was wrapped it is ``nearest``, and none.
    """
    if x.repair is None:
        return found
    if x.repair.keeps_vertices:
        p2p, nearest = (images_on_given(images, x.repair, x.repair, x.full) for images in (found.p2p, found.nearest))
        places = _places(found.barycentric, x.repair, x.repair)
    else:
        there = np.column_stack([x.full.vertices, x.full.vertex_normals])
        mirrored = x.repair.map_back(found.barycentric.pulled_back(there))
        p2p = nearest = nearest_facing_vertices(mirrored, given_places(x.repair, x.full), x.full)
        places = barycentric_map(mirrored[:, :3], nearest, x.given)
    side = _values(found.side, x.repair).copy()
    side[x.repair.vertex_of_original < 0] = 0
    return replace(
        found,
        p2p=frozen(p2p),
        nearest=frozen(nearest),
        side=frozen(side),
        fixed=_values(found.fixed, x.repair),
        asymmetry=_values(found.asymmetry, x.repair),
        regions=_values(found.regions, x.repair),
        barycentric=places,
        repairs=tuple(x.repair.report),
    )


def _carried(found: MatchResult, x: PreparedShape, y: PreparedShape) -> tuple[IndexArray, IndexArray]:
    """Nearest given vertex of the other shape for each, where the deformed wrap takes it: a wrap has few vertices.

    None where there is none on the wraps. Normals are those that look outwards, however the faces are written.
    """
    deformed = x.oriented.with_vertices(found.positions)
    normals = deformed.vertex_normals * (1.0 if found.orientation >= 0 else -1.0)
    here = _values(np.column_stack([found.positions, normals]), x.repair)
    there = given_places(y.repair, y.oriented)
    p2p, inverse = nearest_facing_vertices(here, there, y.full), nearest_facing_vertices(there, here, y.full)
    p2p[_values(found.p2p, x.repair) < 0] = -1
    inverse[_values(found.inverse, y.repair) < 0] = -1
    return p2p, inverse


def _values(values: np.ndarray, repair: Repair | None) -> np.ndarray:
    """Values at the given vertices."""
    return values if repair is None else frozen(repair.map_back(values))


def _places(places: BarycentricMap, of: Repair | None, on: Repair | None) -> BarycentricMap:
    """Points of given triangles, for each given vertex."""
    if on is not None:
        places = on.places_on_given(places)
    return BarycentricMap(
        _values(frozen(places.faces), of),
        _values(frozen(places.corners), of),
        _values(frozen(places.coordinates), of),
    )


def _sentences(name: str, repair: Repair | None) -> tuple[str, ...]:
    return () if repair is None else tuple(f"{name}: {sentence}" for sentence in repair.report)


def _wrap_alpha(repair: Repair | None) -> float:
    return 0.0 if repair is None else repair.wrap_alpha
