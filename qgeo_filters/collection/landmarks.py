"""Landmarks placed on one shape, on all shapes of a collection, and the table of them."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike

import numpy.typing as npt

from qgeo_filters.atomic import atomic_write
from qgeo_filters.collection.common import CommonShapes
from qgeo_filters.collection.composition import Maps, checked_maps
from qgeo_filters.errors import ParameterError
from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.io.vertex_table import table_text
from qgeo_filters.matching.map_landmarks import as_landmarks, images_on_target, landmarks_at, located
from qgeo_filters.surface import Surface

COLUMNS = ("shape", "landmark", "x", "y", "z")


def landmarks_on_all(
    landmarks: Landmarks | npt.ArrayLike, on: str, shapes: Mapping[str, Surface], maps: Maps, *, tolerance: float = 0.05
) -> dict[str, Landmarks]:
    """Landmarks of one shape on every shape, along the maps from it.

    Parameters
    ----------
    landmarks : Landmarks, array-like of int (k,), or array-like (k, 3)
        As `MatchResult.landmarks` takes them.
    on : str
        The shape that they are placed on.
    shapes : mapping of name to Surface
    maps : mapping of (x, y) to BarycentricMap or array-like of int
        Those from ``on`` to every other shape; others are not looked at.
    tolerance : float
        How far from the surface a landmark may be, as a share of the diagonal of its bounding box.

    Returns
    -------
    dict of name to Landmarks
        Points on the surface of each shape, the one that they were placed on included; NaN where one has no image.

    Raises
    ------
    ParameterError
        No such shape, no map to one, a landmark off the surface.
    """
    if on not in shapes:
        raise ParameterError(f"there is no shape called {on!r}, only {', '.join(shapes)}")
    missing = [name for name in shapes if name != on and (on, name) not in maps]
    if missing:
        raise ParameterError(f"no map from {on} to {missing[0]} ({len(missing)} such shapes)")
    checked = checked_maps(shapes, {(on, name): maps[on, name] for name in shapes if name != on})
    given = as_landmarks(landmarks)
    place = located(given, shapes[on], on, tolerance)
    found = {}
    for name, shape in shapes.items():
        image = place
        if name != on:
            there = checked[on, name]
            image = images_on_target(place, there.pulled_back(shape.vertices), there.nearest_corner, shape)
        found[name] = landmarks_at(given.names, image, shape)
    return found


def landmarks_on_common(
    landmarks: Landmarks | npt.ArrayLike, shapes: CommonShapes, *, tolerance: float = 0.05
) -> dict[str, Landmarks]:
    """Landmarks of the template on each of the shapes that have its connectivity: at the same place of a triangle."""
    given = as_landmarks(landmarks)
    place = located(given, shapes.template, "the template", tolerance)
    return {name: landmarks_at(given.names, place, shapes[name]) for name in shapes.names}


def landmark_table(landmarks: Mapping[str, Landmarks]) -> list[dict[str, object]]:
    """A row for each landmark of each shape, `COLUMNS` its keys: what ``pandas.DataFrame`` takes; NaN: no image."""
    return [
        dict(zip(COLUMNS, (shape, name, *point), strict=True))
        for shape, some in landmarks.items()
        for name, point in zip(some.names, some.points.tolist(), strict=True)
    ]


def write_landmark_table(path: str | PathLike[str], landmarks: Mapping[str, Landmarks]) -> None:
    """Write the rows of `landmark_table` as CSV, whole or not at all; a landmark without an image has empty cells."""
    rows = [[None if value != value else value for value in row.values()] for row in landmark_table(landmarks)]
    with atomic_write(path) as file:
        file.write(table_text(COLUMNS, rows))
