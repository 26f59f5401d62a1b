"""How well distances between shapes find those of the same group: nearest neighbour, first and second tier, mAP.

References
----------
Shilane, Min, Kazhdan, Funkhouser, "The Princeton Shape Benchmark", SMI 2004, for the tiers.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import ParameterError


@dataclass(frozen=True)
class Retrieval:
    """Means over the queries: every shape whose group has another member, by its distances to all others.

    Attributes
    ----------
    nearest_neighbor : float
        Share of the queries whose nearest shape is of their group.
    first_tier, second_tier : float
        Share of the query's c fellows among its c, and 2 c, nearest shapes.
    mean_average_precision : float
        Mean over the fellows of the share of fellows among all that are as near as that one.
    n_queries : int
        How many there are.
    """

    nearest_neighbor: float
    first_tier: float
    second_tier: float
    mean_average_precision: float
    n_queries: int


def retrieval_scores(distances: Any, groups: Mapping[str, Hashable] | Sequence[Hashable]) -> Retrieval:
    """How well distances find shapes of the same group.

    Parameters
    ----------
    distances : DataFrame or array-like, shape (m, m)
        Rows are queries; the diagonal is not looked at. NaN: not known, farther than all that is.
    groups : sequence, or mapping of name to group
        Of each shape, in the order of the rows; by the labels of the rows, if it is a mapping.

    Raises
    ------
    ParameterError
        No square, columns in another order than the rows, a group for each shape that is not there, or no group of two.

    Notes
    -----
    Shapes that are equally far count as if each order of them came equally often for the nearest neighbour and the
    tiers, and as near as the last of them for the average precision: a distance that tells nothing apart gains nothing.
    """
    square = _square(distances)
    labels = _groups(distances, groups, len(square))
    scores = [_of_query(np.delete(row, i), np.delete(labels == labels[i], i)) for i, row in enumerate(square)]
    known = [score for score in scores if score is not None]
    if not known:
        raise ParameterError("no group has two shapes: there is nothing to be found")
    first, second, third, precision = np.mean(known, axis=0).tolist()
    return Retrieval(first, second, third, precision, len(known))


def _square(distances: Any) -> FloatArray:
    index, columns = getattr(distances, "index", None), getattr(distances, "columns", None)
    if index is not None and columns is not None and list(index) != list(columns):
        raise ParameterError("the columns of the distances must have the names of the rows, in the same order")
    square = np.asarray(distances, dtype=np.float64)
    if square.ndim != 2 or square.shape[0] != square.shape[1]:
        raise ParameterError(f"the distances must be square, got shape {square.shape}")
    return np.where(np.isnan(square), np.inf, square)


def _groups(distances: Any, groups: Mapping[str, Hashable] | Sequence[Hashable], count: int) -> npt.NDArray[np.int64]:
    """Number of each shape's group."""
    given: list[Hashable]
    if isinstance(groups, Mapping):
        names = getattr(distances, "index", None)
        if names is None:
            raise ParameterError("groups by name need distances with names: a DataFrame")
        missing = [name for name in names if name not in groups]
        if missing:
            raise ParameterError(f"there is no group of {missing[0]!r} ({len(missing)} such shapes)")
        given = [groups[name] for name in names]
    else:
        given = list(groups)
    if len(given) != count:
        raise ParameterError(f"there are {len(given)} groups for {count} shapes")
    numbers = {group: number for number, group in enumerate(dict.fromkeys(given))}
    return np.array([numbers[group] for group in given], dtype=np.int64)


def _of_query(row: FloatArray, fellow: npt.NDArray[np.bool_]) -> tuple[float, float, float, float] | None:
    """Nearest neighbour, tiers and average precision of one query; None without fellows."""
    count = int(fellow.sum())
    if not count:
        return None
    first, second = (_among(row, fellow, some) / count for some in (count, 2 * count))
    precision = [fellow[row <= gap].mean() for gap in row[fellow]]
    return _among(row, fellow, 1), first, second, float(np.mean(precision))


def _among(row: FloatArray, fellow: npt.NDArray[np.bool_], some: int) -> float:
    """Expected number of fellows among so many nearest, those equally far in any order."""
    some = min(some, len(row))
    last = np.sort(row)[some - 1]
    before, tied = row < last, row == last
    return float(fellow[before].sum() + fellow[tied].mean() * (some - before.sum()))
