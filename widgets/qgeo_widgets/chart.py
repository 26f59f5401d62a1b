"""The geodesic curvature along a path as an SVG picture with a cursor: light enough to follow a slider."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from qgeo_filters._typing import FloatArray

HEIGHT = 200
# Beside the plot area; the slider under it has the same ends.
LEFT, RIGHT = 64, 14
#: Of the whole: on a telephone what JupyterLab leaves of its width, of which 118 pixels are beside the cell.
WIDTH = "min(500px, calc(100vw - 124px))"
_TOP, _BOTTOM = 10, 40
_SMALLEST = 0.1  # radians: what is below looks flat


def curvature_chart(way: FloatArray, kappa: FloatArray, length: float, cursor: float) -> str:
    """SVG of the curvature (radians) at places along the way, with a vertical line at the cursor.

    It is as wide as there is room, up to 500 pixels, and its text as large in any width: places are shares of it.

    Parameters
    ----------
    way, kappa : (p,) float64
        Places from 0 to ``length``, and the values there.
    length : float
        Of the path, in the unit of the axis.
    cursor : float
        From 0 to ``length``.
    """
    finite = kappa[np.isfinite(kappa)]
    top = 1.15 * max(float(np.abs(finite).max(initial=0.0)), _SMALLEST)
    high = HEIGHT - _TOP - _BOTTOM

    def x(value: float) -> str:
        return f"{100 * value / (length or 1.0):.2f}%"

    def y(value: float) -> str:
        return f"{_TOP + high * (0.5 - 0.5 * value / top):.1f}"

    axis, plot = [], []
    for value in np.asarray(MaxNLocator(4).tick_values(-top, top)).tolist():
        if abs(value) <= top:
            shown = 0.0 if abs(value) < 1e-12 else value
            plot.append(_line("0%", y(value), "100%", y(value), "#888", 1.0 if shown == 0 else 0.25))
            axis.append(_text(str(LEFT - 6), y(value), f"{shown:g}".replace("-", "−"), "end", "0.35em"))
    bottom = str(HEIGHT - _BOTTOM)
    for value in np.asarray(MaxNLocator(6).tick_values(0, length or 1.0)).tolist():
        if value <= length * (1 + 1e-9):
            plot.append(_line(x(value), bottom, x(value), str(HEIGHT - _BOTTOM + 4), "#888", 1.0))
            plot.append(_text(x(value), str(HEIGHT - _BOTTOM + 17), f"{value:g}", "middle"))
    for place, value in zip(way.tolist(), kappa.tolist(), strict=True):
        if np.isfinite(value):
            plot.append(_line(x(place), y(0.0), x(place), y(value), "#2c5fa8", 1.4))
            plot.append(f'<circle cx="{x(place)}" cy="{y(value)}" r="2.4" fill="#2c5fa8"/>')
    plot.append(_line(x(cursor), str(_TOP), x(cursor), bottom, "#7b3fb5", 2.0))
    plot.append(_text("50%", str(HEIGHT - 6), "way along the path / √area", "middle"))
    middle = _TOP + high / 2
    turned = f'text-anchor="middle" transform="rotate(-90 13 {middle})"'
    axis.append(f'<text x="13" y="{middle}" {turned}>κ_g (radians)</text>')
    drawn = f'height="{HEIGHT}" font-family="sans-serif" font-size="11" fill="currentColor"'
    wide = f"flex:1;min-width:0;overflow:visible;margin-right:{RIGHT}px"
    return (
        '<div class="qgeo-chart" role="img" aria-label="geodesic curvature along the path" '
        f'style="display:flex;width:{WIDTH}">'
        f'<svg {drawn} width="{LEFT}" style="flex:none;max-width:none">{"".join(axis)}</svg>'
        f'<svg {drawn} width="100%" style="{wide}">{"".join(plot)}</svg></div>'
    )


def draw_curvature(axes: Axes, way: FloatArray, kappa: FloatArray, length: float, cursor: float) -> None:
    """The same in Matplotlib's axes, for pictures."""
    finite = np.isfinite(kappa)
    top = 1.15 * max(float(np.abs(kappa[finite]).max(initial=0.0)), _SMALLEST)
    axes.axhline(0.0, color="#888888", linewidth=0.7)
    axes.vlines(way[finite], 0.0, kappa[finite], color="#2c5fa8", linewidth=1.0)
    axes.plot(way[finite], kappa[finite], "o", color="#2c5fa8", markersize=2.6)
    axes.axvline(cursor, color="#7b3fb5", linewidth=1.6)
    axes.set(xlim=(0.0, length or 1.0), ylim=(-top, top), xlabel="way along the path / √area", ylabel="κ_g (radians)")


def _line(x1: str, y1: str, x2: str, y2: str, color: str, width: float) -> str:
    return f'<line x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}" stroke="{color}" stroke-width="{width}"/>'


def _text(x: str, y: str, text: str, anchor: str, shift: str = "0") -> str:
    return f'<text x="{x}" y="{y}" dy="{shift}" text-anchor="{anchor}">{text}</text>'
