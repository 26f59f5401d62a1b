"""Maps between the shapes of a collection, checked, and one after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy.typing as npt

from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.map_landmarks import images_on_target
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_indices

#: Two shapes of a collection, by name: a map goes from the first to the second.
Pair: TypeAlias = tuple[str, str]
#: For each vertex of the first shape of a pair the point, or vertex (-1: none), of the second.
Maps: TypeAlias = Mapping[Pair, BarycentricMap | npt.ArrayLike]


def checked_maps(shapes: Mapping[str, Surface], maps: Maps) -> dict[Pair, BarycentricMap]:
    """The maps as points in triangles.

    Raises
    ------
    ParameterError, MeshError
        A map of a shape that there is not, of another number of vertices, or to a vertex or triangle out of range; the
        message names the pair.
    """
    found = {}
    for (x, y), given in maps.items():
        for name in (x, y):
            if name not in shapes:
                raise ParameterError(f"there is a map {x} - {y}, but no shape called {name!r}")
        found[x, y] = _checked(given, shapes[x], shapes[y], f"the map {x} - {y}")
    return found


def composed(first: BarycentricMap, then: BarycentricMap, target: Surface) -> BarycentricMap:
    """The second map after the first: where the target's points for the corners of each triangle meet.

    Parameters
    ----------
    first : BarycentricMap
        From X to Y.
    then : BarycentricMap
        From Y to Z.
    target : Surface
        Z.

    Returns
    -------
    BarycentricMap
        From X to Z; no point where one of the two has none.
    """
    return images_on_target(first, then.pulled_back(target.vertices), then.nearest_corner, target)


def along(path: Sequence[str], shapes: Mapping[str, Surface], maps: Mapping[Pair, BarycentricMap]) -> BarycentricMap:
    """The maps from each shape of a path, of two or more, to the next, one after the other."""
    found = maps[path[0], path[1]]
    for here, there in pairwise(path[1:]):
        found = composed(found, maps[here, there], shapes[there])
    return found


def _checked(given: BarycentricMap | npt.ArrayLike, x: Surface, y: Surface, name: str) -> BarycentricMap:
    if isinstance(given, BarycentricMap):
        count, last = len(given.faces), int(given.faces.max(initial=-1))
        if last >= y.n_faces:
            raise ParameterError(f"{name} goes to triangle {last}, but there are {y.n_faces}, numbered from 0")
        place = given
    else:
        vertices = checked_indices(given, y.n_vertices, name, missing=True)
        count, place = len(vertices), BarycentricMap.at_vertices(vertices, y.faces, y.n_vertices)
    if count != x.n_vertices:
        raise ParameterError(f"{name} has {count} entries, but its first shape has {x.n_vertices} vertices")
    return place
