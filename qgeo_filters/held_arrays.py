"""The arrays that a result holds, wherever in it they are, and how large it is by them."""

from __future__ import annotations

import types
from collections.abc import Iterator, Mapping, Set
from typing import Any

import numpy as np


def arrays_of(value: Any) -> Iterator[np.ndarray]:
    """Each array that a result holds, once: in sequences, mappings, dataclasses, sparse matrices and other objects."""
    seen: dict[int, Any] = {}
    waiting = [value]
    while waiting:
        one = waiting.pop()
        if id(one) in seen or isinstance(one, (str, bytes, int, float, np.generic, type, types.ModuleType, type(None))):
            continue
        seen[id(one)] = one
        if isinstance(one, np.ndarray):
            yield one
        elif isinstance(one, Mapping):
            waiting += one.values()
        elif isinstance(one, (list, tuple, Set)):
            waiting += one
        elif not isinstance(one, types.FunctionType):
            waiting += vars(one).values() if hasattr(one, "__dict__") else ()
            slots = (getattr(kind, "__slots__", ()) for kind in type(one).__mro__)
            names = [name for some in slots for name in ([some] if isinstance(some, str) else some)]
            waiting += [getattr(one, name) for name in names if name != "__dict__" and hasattr(one, name)]


def size_in_bytes(value: Any) -> int:
    """Bytes of the arrays that a result holds, memory that two of them share counted once; at least 64."""
    held = {}
    for array in arrays_of(value):
        while isinstance(array.base, np.ndarray):
            array = array.base
        held[id(array)] = array.nbytes
    return max(64, sum(held.values()))
