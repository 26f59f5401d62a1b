"""The geodesic curvature along a path as an SVG picture with a cursor: light enough to follow a slider."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from qgeo_filters._typing import FloatArray

WIDTH, HEIGHT = 500, 200
LEFT, RIGHT = 64, 14  # room beside the plot area; the slider under it has the same ends
_TOP, _BOTTOM = 10, 40
_SMALLEST = 0.1  # radians: what is below looks flat


def curvature_chart(way: FloatArray, kappa: FloatArray, length: float, cursor: float) -> str:
    """SVG of the curvature (radians) at places along the way, with a vertical line at the cursor.

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
    across, along = WIDTH - LEFT - RIGHT, HEIGHT - _TOP - _BOTTOM

    def x(value: float) -> float:
        return LEFT + across * value / (length or 1.0)

    def y(value: float) -> float:
        return _TOP + along * (0.5 - 0.5 * value / top)

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
        'font-family="sans-serif" font-size="11" fill="currentColor" role="img" '
        'aria-label="geodesic curvature along the path">'
    ]
    for value in np.asarray(MaxNLocator(4).tick_values(-top, top)).tolist():
        if abs(value) <= top:
            shown = 0.0 if abs(value) < 1e-12 else value
            parts.append(_line(LEFT, y(value), WIDTH - RIGHT, y(value), "#888", 1.0 if shown == 0 else 0.25))
            parts.append(_text(LEFT - 6, y(value) + 4, f"{shown:g}".replace("-", "−"), "end"))
    for value in np.asarray(MaxNLocator(6).tick_values(0, length or 1.0)).tolist():
        if value <= length * (1 + 1e-9):
            parts.append(_line(x(value), HEIGHT - _BOTTOM, x(value), HEIGHT - _BOTTOM + 4, "#888", 1.0))
            parts.append(_text(x(value), HEIGHT - _BOTTOM + 17, f"{value:g}", "middle"))
    for place, value in zip(way.tolist(), kappa.tolist(), strict=True):
        if np.isfinite(value):
            parts.append(_line(x(place), y(0.0), x(place), y(value), "#2c5fa8", 1.4))
            parts.append(f'<circle cx="{x(place):.1f}" cy="{y(value):.1f}" r="2.4" fill="#2c5fa8"/>')
    parts.append(_line(x(cursor), _TOP, x(cursor), HEIGHT - _BOTTOM, "#7b3fb5", 2.0))
    parts.append(_text(LEFT + across / 2, HEIGHT - 6, "way along the path / √area", "middle"))
    parts.append(
        f'<text x="13" y="{_TOP + along / 2}" text-anchor="middle" '
        f'transform="rotate(-90 13 {_TOP + along / 2})">κ_g (radians)</text></svg>'
    )
    return "".join(parts)


def draw_curvature(axes: Axes, way: FloatArray, kappa: FloatArray, length: float, cursor: float) -> None:
    """The same in Matplotlib's axes, for pictures."""
    finite = np.isfinite(kappa)
    top = 1.15 * max(float(np.abs(kappa[finite]).max(initial=0.0)), _SMALLEST)
    axes.axhline(0.0, color="#888888", linewidth=0.7)
    axes.vlines(way[finite], 0.0, kappa[finite], color="#2c5fa8", linewidth=1.0)
    axes.plot(way[finite], kappa[finite], "o", color="#2c5fa8", markersize=2.6)
    axes.axvline(cursor, color="#7b3fb5", linewidth=1.6)
    axes.set(xlim=(0.0, length or 1.0), ylim=(-top, top), xlabel="way along the path / √area", ylabel="κ_g (radians)")


def _line(x1: float, y1: float, x2: float, y2: float, color: str, width: float) -> str:
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{color}" stroke-width="{width}"/>'


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{text}</text>'
