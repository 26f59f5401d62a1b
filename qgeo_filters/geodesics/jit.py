"""The compiler options of the window kernels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """The function compiled, for use from several threads and without reference counting of its arrays.

    A kernel works on the arrays that it is given and makes none. Counting references to them would be
    an atomic operation for each array in every call of a small function: measured, four fifths of the time
    of a window propagation. Who calls the outermost kernel holds the arrays.
    """
    return njit(cache=True, nogil=True, error_model="numpy", _nrt=False)(function)  # type: ignore[call-overload]
