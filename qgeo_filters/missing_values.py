"""What stands where a map has no partner: NaN, -1, False, "" or None, by the kind of the values."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import ParameterError

_MISSING: dict[str, Any] = {"f": np.nan, "c": np.nan, "i": -1, "b": False, "U": "", "S": b"", "O": None}


def with_missing(values: np.ndarray, missing: npt.NDArray[np.bool_], fill: Any = None) -> np.ndarray:
    """The values, (k, ...), with another one in the rows where there is none.

    Parameters
    ----------
    values : array, shape (k, ...)
        Its rows that are missing may hold anything, and are written to.
    missing : (k,) bool
    fill : optional
        What stands there; by default NaN, -1, False, "" or None.

    Raises
    ------
    ParameterError
        Rows are missing of unsigned numbers, of which none says so, and no ``fill`` is given; or one that the type of
        the values cannot hold.
    """
    if not missing.any():
        return values
    if fill is None and values.dtype.kind not in _MISSING:
        raise ParameterError(
            f"{int(missing.sum())} points have no partner, which {values.dtype} has no value for: say what stands "
            "there, or give numbers with a sign"
        )
    one = np.asarray(_MISSING[values.dtype.kind] if fill is None else fill)
    if values.dtype.kind in "US" and one.dtype.kind == values.dtype.kind:
        values = values.astype(np.promote_types(values.dtype, one.dtype), copy=False)  # a longer text is not cut off
    elif values.dtype.kind != "O":
        with np.errstate(invalid="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            same = one.dtype.kind not in "USO" and np.array_equal(one.astype(values.dtype), one, equal_nan=True)
        if not same:
            raise ParameterError(f"{fill!r} cannot stand for a missing partner among values of type {values.dtype}")
    values[missing] = one
    return values
