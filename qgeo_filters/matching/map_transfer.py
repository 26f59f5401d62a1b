"""Values of one shape on the other, along a map: numbers interpolated, labels by majority."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.array_likes import as_array
from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.maps.barycentric import BarycentricMap
from qgeo_filters.missing_values import with_missing


def interpolated(values: np.ndarray, place: BarycentricMap, fill: Any = None) -> np.ndarray:
    """Values (n, ...) of the source at points of its triangles, (k, ...); whole numbers become float64."""
    numbers = values.astype(np.float64) if values.dtype.kind in "iub" else values
    found = np.einsum("ij,ij...->i...", place.coordinates, numbers[place.corners])
    return with_missing(found.astype(numbers.dtype), place.faces < 0, fill)


def elected(
    values: np.ndarray, areas: FloatArray, images: IndexArray, place: BarycentricMap, fill: Any = None
) -> np.ndarray:
    """Label of each vertex of the target that most of the source has which is mapped there.

    Parameters
    ----------
    values : (n, ...) array
        Labels of the source: of any type; those of several columns are taken as one.
    areas : (n,) float64
        Of the vertices of the source: their votes.
    images : (n,) int64
        Vertex of the target for each of the source; -1: none.
    place : BarycentricMap
        Point of the source for each vertex of the target: it decides where nothing is mapped to, by the weights of the
        corners, and where there is none nothing is decided.

    Returns
    -------
    (k, ...) array
    """
    first, label = _numbered(values)
    voters = np.flatnonzero((images >= 0) & (areas > 0))
    bare = np.setdiff1d(np.flatnonzero(place.faces >= 0), images[voters])
    target = np.concatenate([images[voters], np.repeat(bare, 3)])
    choice = np.concatenate([label[voters], label[place.corners[bare]].ravel()])
    weight = np.concatenate([areas[voters], place.coordinates[bare].ravel()])
    ballot, which = np.unique(target * len(first) + choice, return_inverse=True)
    total = np.bincount(which, weight, minlength=len(ballot))
    order = np.lexsort((-ballot, total))  # of equals the first label
    winner = np.zeros(len(place.faces), dtype=np.int64)
    winner[ballot[order] // len(first)] = ballot[order] % len(first)
    return with_missing(values[first[winner]], place.faces < 0, fill)


def _numbered(values: np.ndarray) -> tuple[IndexArray, IndexArray]:
    """Where each different value, or row of values, comes first, and the number of each."""
    if values.dtype.kind == "O":  # not all can be compared: text and None
        rows = [tuple(row.ravel()) for row in values] if values.ndim > 1 else values.tolist()
        places: dict[Any, int] = {}
        label = np.array([places.setdefault(row, len(places)) for row in rows])
        return np.unique(label, return_index=True)[1], label
    _, starts, label = np.unique(values, axis=0 if values.ndim > 1 else None, return_index=True, return_inverse=True)
    return starts, label.reshape(-1)


def checked_values(values: npt.ArrayLike, count: int, other: int, source: str, target: str) -> np.ndarray:
    """Values of a shape of so many vertices as an array, or `ParameterError`."""
    array = as_array(values)
    if array.ndim and len(array) == count:
        return array
    hint = f"; values of {target} go to={source.lower()!r}" if array.ndim and len(array) == other else ""
    raise ParameterError(f"values have shape {array.shape}, but {source} has {count} vertices{hint}")
