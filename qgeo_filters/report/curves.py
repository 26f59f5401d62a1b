"""Charts of how well a map does: histograms, error curves, and a matrix of pairwise numbers."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from qgeo_filters.errors import ParameterError
from qgeo_filters.evaluation.benchmarks import Published
from qgeo_filters.evaluation.errors import THRESHOLDS, error_curve
from qgeo_filters.report.colors import sequential
from qgeo_filters.report.panels import STYLE, new_figure
from qgeo_filters.report.ticks import name_room, name_ticks

_BLUE, _RED, _AMBER, _PURPLE = "#2c5fa8", "#b2352f", "#c98a1b", "#7b4fa3"
_KEY_WIDTH = 70  # characters in a line of a key below a chart
_MOST_NUMBERS = 12
_NAME_ROOM = 0.5  # inches, of names beside it
_PAIRWISE_SIDE = 2.8  # inches, of the table between its names and its colour bar


def plot_histogram(values: npt.ArrayLike, weights: npt.ArrayLike, label: str) -> Figure:
    """Figure of the share of the area that has each value, with the mean.

    Parameters
    ----------
    values, weights : array-like, shape (n,)
        Value and area of each vertex; values that are not finite are left out.
    label : str
        Name and unit of the value.
    """
    values, weights = np.asarray(values, dtype=np.float64), np.asarray(weights, dtype=np.float64)
    known = np.isfinite(values)
    found, areas = np.asarray(values)[known], np.asarray(weights)[known]
    share = 100.0 * areas / (areas.sum() or 1.0)
    mean = float(share @ found / 100.0)
    figure = new_figure(4.6, 2.8)
    with matplotlib.rc_context(STYLE):
        axes = figure.add_subplot()
        axes.hist(found, bins=40, range=(0.0, float(found.max(initial=0.0)) or 1.0), weights=share, color=_BLUE)
        axes.axvline(mean, color=_RED, linewidth=1.2, label=f"mean {mean:.3g}")
        axes.set(xlabel=label, ylabel="share of the area (%)")
        axes.legend(frameon=False)
    return figure


def plot_error_curve(
    errors: npt.ArrayLike,
    *,
    label: str = "this map",
    largest: float = 0.25,
    mean: float | None = None,
    published: Sequence[Published] = (),
) -> Figure:
    """Figure of the share of points whose error is at most each threshold (Princeton protocol).

    Parameters
    ----------
    errors : array-like, shape (n,)
        In units of sqrt(area).
    label : str
    largest : float
        Threshold at the right end.
    mean : float, optional
        Mean error, marked and named beside those of others: that over pairs, if they took theirs so.
    published : sequence of Published
        Mean errors of others, marked by lines: those of methods that were not trained on the set, and of those that
        were. Curves are published as pictures only.
    """
    thresholds = np.linspace(0.0, largest, 251)
    others = {
        learned: sorted((one for one in published if one.learned == learned), key=lambda one: one.error)
        for learned in (False, True)
    }
    figure = new_figure(4.6, 3.0 + 0.5 * bool(published))
    with matplotlib.rc_context(STYLE):
        axes = figure.add_subplot()
        (curve,) = axes.plot(thresholds, 100.0 * error_curve(errors, thresholds), color=_BLUE, label=label)
        for threshold in THRESHOLDS:
            if threshold < largest:
                axes.axvline(threshold, color="0.85", linewidth=0.8, zorder=0)
        keys: list[Artist] = [curve]
        if mean is not None:
            keys.append(axes.axvline(mean, color=_BLUE, linestyle="--", linewidth=1.2, label=f"its mean: {mean:.3f}"))
        for learned, color, kind in ((False, _AMBER, "not trained on it"), (True, _PURPLE, "trained on it")):
            lines = [axes.axvline(one.error / 100, color=color, linewidth=1.0, zorder=1) for one in others[learned]]
            named = [
                f"{one.short_name} {one.error / 100:.3f}{' (beyond)' if one.error / 100 > largest else ''}"
                for one in others[learned]
            ]
            if lines:
                lines[0].set_label(fill(f"published means, {kind}: {', '.join(named)}", _KEY_WIDTH))
                keys.append(lines[0])
        axes.set(xlabel="geodesic error (√area)", ylabel="points within (%)", xlim=(0.0, largest), ylim=(0.0, 101.0))
        if published:
            figure.legend(handles=keys, frameon=False, loc="outside lower left", fontsize=7.5)
        else:
            axes.legend(handles=keys, frameon=False, loc="lower right")
    return figure


def plot_pairwise(matrix: npt.ArrayLike, names: Sequence[str], label: str) -> Figure:
    """Figure of a symmetric table of numbers between things with names, such as C_XY between poses.

    Parameters
    ----------
    matrix : array-like, shape (p, p)
    names : sequence of str
    label : str
        Of the colour bar.
    """
    values = np.asarray(matrix, dtype=np.float64)
    if values.shape != (len(names), len(names)):
        raise ParameterError(f"the matrix has shape {values.shape}, but there are {len(names)} names")
    scale = sequential(values)
    more = name_room(names) - _NAME_ROOM
    figure = new_figure(4.8 + max(more, 0.0), 4.0 + max(more, 0.0))
    with matplotlib.rc_context(STYLE):
        axes = figure.add_subplot()
        image = axes.imshow(values, cmap=scale.colormap, norm=scale.norm)
        name_ticks(axes, names, _PAIRWISE_SIDE)
        if len(names) <= _MOST_NUMBERS:
            middle = 0.5 * (scale.low + scale.high)
            for (i, j), value in np.ndenumerate(values):
                color = "white" if value < middle else "black"
                axes.text(j, i, f"{value:.3g}", ha="center", va="center", color=color, fontsize=7.5)
        figure.colorbar(image, ax=axes, fraction=0.046, pad=0.03).set_label(label)
    return figure
