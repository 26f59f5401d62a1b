"""Values and names of a job as its files take them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """The value in JSON's own types; numbers that are not finite as the strings "inf", "-inf", "nan"."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, Mapping):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def as_title(name: str) -> str:
    """The name as pictures take it: no dollar begins a formula, bytes that are no text are escapes."""
    return name.encode(errors="backslashreplace").decode().replace("$", r"\$")


def numbered(names: Sequence[str]) -> list[str]:
    """The names, those that occur more than once, in whatever case, with -1, -2, ... behind them."""
    keys = [name.casefold() for name in names]  # one file where the system does not tell cases apart
    taken = {key for key in keys if keys.count(key) == 1}
    chosen = []
    for name, key in zip(names, keys, strict=True):
        if keys.count(key) > 1:
            name = next(one for one in (f"{name}-{k}" for k in itertools.count(1)) if one.casefold() not in taken)
            taken.add(name.casefold())
        chosen.append(name)
    return chosen
