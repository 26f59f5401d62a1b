"""Labels of ticks that stand apart: names at the rows of a table, numbers along a colour bar."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

_SIZE, _SMALLEST = 9.0, 5.0  # points
_UPRIGHT = 12  # more names stand upright under a table than lie across
_LONGEST = 24  # characters
_LINE = 1.5  # from line to line, as a multiple of the size: across, they need more than a line's height


def name_ticks(axes: Axes, names: Sequence[str], side: float) -> None:
    """Names at the rows and columns of a square table whose sides have so many inches.

    Smaller where there are many, and only every second, third ... where they could not be read; long ones are cut.
    """
    room = 72.0 * side / max(len(names), 1)
    step = 1
    while step * room / _LINE < _SMALLEST:
        step += 1
    size = min(_SIZE, step * room / _LINE)
    shown = range(0, len(names), step)
    labels = [_cut(name) for name in names[::step]]
    across: dict[str, Any] = {"rotation": 45, "ha": "right", "rotation_mode": "anchor"}
    axes.set_xticks(shown, labels, fontsize=size, **({"rotation": 90} if len(names) > _UPRIGHT else across))
    axes.set_yticks(shown, labels, fontsize=size)


def _cut(name: str) -> str:
    """The name without its middle where it is long: names of one series differ at their ends."""
    half = _LONGEST // 2
    return name if len(name) <= _LONGEST else f"{name[: half - 1]}…{name[-half:]}"


def name_room(names: Sequence[str]) -> float:
    """Inches that the longest name takes at the full size."""
    return 0.6 * _SIZE / 72.0 * min(max(map(len, names), default=0), _LONGEST)


def bar_locator(low: float, high: float) -> MaxNLocator:
    """Where a short colour bar has its numbers: fewer where they are long."""
    longest = max(len(f"{value:.4g}") for value in (low, high, 0.3 * low + 0.7 * high))
    return MaxNLocator(nbins=6 if longest <= 4 else 4, min_n_ticks=2)
