"""Picture of what a match looked at: how much each map distorts distances, and what the best of them cost."""

from __future__ import annotations

import textwrap

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from qgeo_filters.errors import ParameterError
from qgeo_filters.matching.match_log import CHOSEN, LoggedMap, MatchLog
from qgeo_filters.report.panels import STYLE, new_figure

_CHOSEN, _ENDED, _PREVIEWED, _DROPPED = "#b2352f", "#2c5fa8", "#7fa6d6", "#a9a9a9"
# Of words: what is pale enough for a dot is too pale to be read on paper.
_WORDS = {_PREVIEWED: "#3f6fae", _DROPPED: "#666666"}
# Letters of a rule that fit beside the picture, on each of two lines.
_LONGEST = 58


def plot_match_log(log: MatchLog, most: int = 24) -> Figure:
    """Figure of the maps of a log, the chosen one first: distortion, cost in the preview and at the end, and fate.

    Parameters
    ----------
    log : MatchLog
        As `match` returns it with ``log=True``.
    most : int
        Rows at most; those that came least far are left out.

    Raises
    ------
    ParameterError
        A log without maps.
    """
    if not len(log):
        raise ParameterError("the log has no maps to draw")
    shown = log.ranked()[:most]
    figure = new_figure(9.2, 1.1 + 0.23 * len(shown))
    with matplotlib.rc_context(STYLE):
        left, middle, right = figure.subplots(1, 3, sharey=True, width_ratios=(1.0, 1.4, 1.5))
        _distortions(left, shown)
        _costs(middle, shown)
        right.axis("off")
        for row, entry in enumerate(shown):
            _words(right, row, entry)
        left.set_yticks(range(len(shown)), [f"#{entry.number}" for entry in shown], fontsize=7.5)
        left.set_ylim(len(shown) - 0.4, -0.6)
    return figure


def _distortions(axes: Axes, shown: list[LoggedMap]) -> None:
    for row, entry in enumerate(shown):
        # The open ones reverse the orientation.
        filled = entry.orientation is None or entry.orientation > 0
        face = _color(entry) if filled else "none"
        axes.plot([0, entry.mean_distortion], [row, row], color=_color(entry), linewidth=0.8)
        axes.plot(entry.mean_distortion, row, "o", markersize=5, color=_color(entry), markerfacecolor=face)
    axes.set_xlim(0, 1.08 * max(entry.mean_distortion for entry in shown) or 1.0)
    axes.set_xlabel("distortion (√area)\nopen: reverses the orientation")


def _costs(axes: Axes, shown: list[LoggedMap]) -> None:
    """Costs as multiples of the least one of either kind, on a logarithmic axis."""
    axes.set_xscale("log")
    axes.set_xlabel("cost / least cost")
    for name, marker, label in (("preview_cost", "s", "in the preview"), ("end_cost", "D", "at the end")):
        costs = [(row, getattr(entry, name)) for row, entry in enumerate(shown) if getattr(entry, name) is not None]
        if costs:
            rows, values = np.array([row for row, _ in costs]), np.array([cost for _, cost in costs], dtype=np.float64)
            ratios = values / max(float(values.min()), np.finfo(np.float64).tiny)
            colors = [_color(shown[row]) for row in rows]
            axes.scatter(ratios, rows, c=colors, marker=marker, s=24, label=label, zorder=3)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, fontsize=7.5, loc="lower right")
    axes.grid(axis="x", linewidth=0.3)


def _color(entry: LoggedMap) -> str:
    if entry.fate == CHOSEN:
        return _CHOSEN
    if entry.end_cost is not None:
        return _ENDED
    return _PREVIEWED if entry.preview_cost is not None else _DROPPED


def _words(axes: Axes, row: int, entry: LoggedMap) -> None:
    """What became of a map, on two lines if it is long."""
    lines = textwrap.wrap(entry.fate, _LONGEST, max_lines=2, placeholder="…")
    color = _WORDS.get(_color(entry), _color(entry))
    weight, size = "bold" if entry.fate == CHOSEN else "normal", 7.5 if len(lines) == 1 else 6.5
    axes.text(0, row, "\n".join(lines), va="center", color=color, fontsize=size, weight=weight, linespacing=1.0)
