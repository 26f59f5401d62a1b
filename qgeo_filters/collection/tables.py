"""Tables of a collection: one row for each pair, and labelled squares, as pandas.DataFrame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.collection.tasks import PROBLEM
from qgeo_filters.errors import require_package

#: Columns of `pair_table` that are read from a match, and the value of its record that each is.
VALUES = {
    "c_xy": "c_xy",
    "d_s": "d_s",
    "distortion": "score",
    "confident": "confident",
    "margin": "margin",
    "orientation": "orientation",
    "hks_agreement": "hks_agreement",
    "overlap_x": "overlap_x",
    "overlap_y": "overlap_y",
    "explanation": "explanation",
}
COLUMNS = ("x", "y", "group_x", "group_y", *VALUES, PROBLEM)
_FLAGS, _WORDS = ("confident",), ("x", "y", "group_x", "group_y", "explanation", PROBLEM)


def pair_table(
    rows: Iterable[tuple[str, str, Mapping[str, Any]]], groups: Mapping[str, str], extra: Sequence[str] = ()
) -> Any:
    """Table with a row for each pair, in their order.

    Parameters
    ----------
    rows : iterable of (str, str, mapping)
        Names, and the values of the record.
    groups : mapping of str to str
        Group of each name.
    extra : sequence of str
        Further values that become columns.

    Returns
    -------
    pandas.DataFrame
        NaN, False and the reason in the column ``problem`` for pairs that cannot be matched.
    """
    pandas = require_package("pandas", "collections", "a table of pairs")
    content = [
        {
            "x": x,
            "y": y,
            "group_x": groups[x],
            "group_y": groups[y],
            **{name: values.get(key) for name, key in VALUES.items()},
            PROBLEM: values.get(PROBLEM, ""),
            **{name: values.get(name) for name in extra},
        }
        for x, y, values in rows
    ]
    names = [*COLUMNS, *extra]
    return pandas.DataFrame({name: _column(name, [row[name] for row in content]) for name in names}, columns=names)


def square(values: npt.ArrayLike, names: Sequence[str]) -> Any:
    """Labelled square of numbers, (m, m), as pandas.DataFrame."""
    pandas = require_package("pandas", "collections", "a labelled square")
    return pandas.DataFrame(np.asarray(values, dtype=np.float64), index=list(names), columns=list(names))


def _column(name: str, values: list[Any]) -> Any:
    """Values of one type, whatever there are none of."""
    if name in _WORDS:
        return np.array([value or "" for value in values], dtype=object)
    if name in _FLAGS:
        return np.array([bool(value) for value in values], dtype=bool)
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
