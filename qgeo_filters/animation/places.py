"""The map along which a surface is moved: found, or taken from the caller and checked."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import RepairOption
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.wrap import Wrap, wrap_surface
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.maps.orientation import orientation
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_indices

#: What this floor takes for a map: a match in either direction; for each vertex of Y a point of X, or a vertex.
MapLike: TypeAlias = MatchResult | BarycentricMap | npt.ArrayLike


_REVERSED = "the map reverses the orientation, as that of a left hand onto a right one: reflect one of the shapes first"
# Mean cosine of normals, see `orientation`, below which a map that was given reverses it: a mirrored one has -.7.
_TURNED_OVER = -0.3


@dataclass(frozen=True, eq=False)
class Places:
    """Point of X for each vertex of Y, the match that it comes from, if there is one, and what is to be said of it.

    ``size`` is how many times as large Y is as X: the root of the areas of what was matched. ``wraps`` are those of X
    and of Y, where they were wrapped.
    """

    on_x: BarycentricMap
    size: float
    match: MatchResult | None = None
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    wraps: tuple[Wrap | None, Wrap | None] = (None, None)


def places_on(
    x: Surface,
    y: Surface,
    correspondence: MapLike | None,
    accept_unsure: bool,
    by_landmarks: bool = True,
    repair: RepairOption = "auto",
    wraps: tuple[Wrap | None, Wrap | None] = (None, None),
) -> Places:
    """Point of X for each vertex of Y.

    Parameters
    ----------
    x, y : Surface
    correspondence : MatchResult, BarycentricMap or array-like of int, optional
        A match of X and Y, or of Y and X (of shapes of equal counts it goes by where the vertices are); points of X for
        the vertices of Y, or the vertices nearest to them, (n_y,), -1: none. Found by `match` if it is not given.
    accept_unsure : bool
        Whether a match that is not sure is used all the same: the caller is to warn of the doubts.
    by_landmarks : bool
        Whether the caller could steer such a match by landmarks, which the error then says.
    repair : bool, "auto", "force" or "wrap"
        What `match` repairs.
    wraps : (Wrap or None, Wrap or None)
        Of X and of Y, where a map that is no match goes by them; a match has its own.

    Raises
    ------
    ParameterError
        A map of other shapes, or without any point; one that is not sure, or reverses the orientation.
    """
    if correspondence is None:
        correspondence = match(x, y, repair=repair)
    if isinstance(correspondence, MatchResult):
        return _of_match(x, y, correspondence, accept_unsure, by_landmarks)
    if isinstance(correspondence, BarycentricMap):
        return Places(_checked(x, y, correspondence), _size(x, y, wraps), wraps=wraps)
    vertices = checked_indices(correspondence, x.n_vertices, "correspondence", missing=True)
    if len(vertices) != y.n_vertices:
        raise ParameterError(
            f"correspondence must hold a vertex of X for each of the {y.n_vertices} of Y, got {len(vertices)}"
        )
    place = BarycentricMap.at_vertices(vertices, x.faces, x.n_vertices)
    return Places(_checked(x, y, place), _size(x, y, wraps), wraps=wraps)


def warned(doubts: Iterable[str]) -> None:
    """Warn of doubts, in the name of whoever called the function that calls this one."""
    for doubt in doubts:
        warnings.warn(doubt, stacklevel=3)


def _of_match(x: Surface, y: Surface, found: MatchResult, accept_unsure: bool, by_landmarks: bool) -> Places:
    there, back = (_alike(found.x, a) and _alike(found.y, b) for a, b in ((x, y), (y, x)))
    if there and back:  # shapes of equal counts: told by where their vertices are
        back = np.array_equal(found.x.vertices, y.vertices) and not np.array_equal(found.x.vertices, x.vertices)
    if back:
        place = found.barycentric
    elif there:
        place = found.inverse_barycentric
    else:
        raise ParameterError(
            f"the match is one of {found.x.n_vertices} and {found.y.n_vertices} vertices, "
            f"the shapes have {x.n_vertices} and {y.n_vertices}"
        )
    doubt = "" if found.confident else f"the correspondence is not sure: {found.explanation}"
    if found.orientation < 0:
        raise ParameterError(f"{_REVERSED}{'; and ' if doubt else ''}{doubt}")
    if doubt and not accept_unsure:
        more = "more " if len(found.landmark_errors) else ""
        landmarks = f"give {more}landmarks (correspondence=match(x, y, landmarks=...)), " if by_landmarks else ""
        raise ParameterError(f"{doubt}. Look at it, {landmarks}or say accept_unsure=True")
    wraps = _wrap(x, found, not back), _wrap(y, found, back)
    size = _size(x, y, wraps)
    return Places(_checked(x, y, place), size, found, found.repairs, (doubt,) if doubt else (), wraps)


def _wrap(shape: Surface, found: MatchResult, is_x: bool) -> Wrap | None:
    """The wrap that was matched in place of a shape, which may be that of the match elsewhere, or of another size."""
    given, alpha = (found.x, found.wrap_x) if is_x else (found.y, found.wrap_y)
    if alpha and not np.array_equal(given.vertices, shape.vertices):
        return wrap_surface(shape, alpha=alpha)
    return found.around_x if is_x else found.around_y


def _size(x: Surface, y: Surface, wraps: tuple[Wrap | None, Wrap | None]) -> float:
    # Raw CT has walls inside: what tells its size is the area of its wrap.
    area_x, area_y = (one.area if w is None else w.surface.area for one, w in zip((x, y), wraps, strict=True))
    return float(np.sqrt(area_y / area_x))


def _alike(one: Surface, other: Surface) -> bool:
    return (one.n_vertices, one.n_faces) == (other.n_vertices, other.n_faces)


def _checked(x: Surface, y: Surface, place: BarycentricMap) -> BarycentricMap:
    if len(place.faces) != y.n_vertices or place.faces.max() >= x.n_faces:
        raise ParameterError(
            f"the map has {len(place.faces)} points on triangles up to {place.faces.max()}, but Y has {y.n_vertices} "
            f"vertices and X {x.n_faces} triangles"
        )
    if (place.faces < 0).all():
        raise ParameterError("no vertex of Y has a partner on X")
    if _turns_over(x, y, place):
        raise ParameterError(_REVERSED)
    return place


def _turns_over(x: Surface, y: Surface, place: BarycentricMap) -> bool:
    """Whether a map of all vertices of Y takes its outside to the inside of X, both known."""
    sides = {x.winding, y.winding}
    if (place.faces < 0).any() or not sides <= {"outward", "inward"}:
        return False
    sign = 1 if len(sides) == 1 else -1
    return sign * orientation(y, x, place.nearest_corner) < _TURNED_OVER
