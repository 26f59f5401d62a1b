"""The compiler options of the window and path kernels.

Numba's cache looks at the file of the outermost function only: who edits a kernel touches all files that call
it (``touch qgeo_filters/geodesics/*.py``), or old code goes on running.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numba import njit

F = TypeVar("F", bound=Callable[..., Any])

# Arguments that are typed: of a literal Numba would make a type of its own, and compile once more for it.
NONE: Any = np.int64(-1)
ZERO: Any = np.int64(0)


INNER: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}


def inner(function: F) -> F:
    """The function compiled, to be called from compiled functions only: that halves the time to compile it."""
    return njit(**INNER)(function)


def kernel(function: F) -> F:
    """The function compiled as by `inner`, without reference counting of its arrays.

    A kernel works on the arrays that it is given and makes none. Counting references to them would be
    an atomic operation for each array in every call of a small function: measured, four fifths of the time
    of a window propagation. Who calls the outermost kernel holds the arrays.
    """
    return njit(**INNER, _nrt=False)(function)  # type: ignore[call-overload]
