"""Legends as SVG, for pictures that browsers save: text stays text, and all is sharp at any size."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from html import escape

import numpy as np
import numpy.typing as npt

from qgeo_filters.report.colors import MISSING, ColorScale
from qgeo_widgets.legend import css, ticks

WIDTH = 400
_EDGE, _LINE, _LETTERS = 26, 16, 62  # pixels beside the bar, pixels and letters of a line
_LETTER = 6.4  # pixels, about


def bar_drawing(scale: ColorScale, label: str, *, missing: bool = False) -> str:
    """Colour bar with ticks at round numbers and its label; with a grey square if values are missing."""
    parts, y = _lines(label)
    if missing:
        parts += _named(np.array(MISSING), "no value", _EDGE, y)
        y += _LINE
    across = WIDTH - 2 * _EDGE
    values = np.linspace(scale.low, scale.high, 33) if scale.high > scale.low else np.full(2, scale.low)
    stops = "".join(
        f'<stop offset="{place:.4f}" stop-color="{css(color)}"/>'
        for place, color in zip(np.linspace(0.0, 1.0, len(values)).tolist(), scale(values), strict=True)
    )
    parts.append(
        f'<linearGradient id="qgeo-scale">{stops}</linearGradient><rect x="{_EDGE}" y="{y}" width="{across}" '
        'height="12" fill="url(#qgeo-scale)" stroke="#808080" stroke-width=".6"/>'
    )
    for place, text in ticks(scale.low, scale.high):
        x = _EDGE + across * place
        parts.append(f'<line x1="{x:.1f}" y1="{y + 12}" x2="{x:.1f}" y2="{y + 16}" stroke="#1d2026"/>')
        parts.append(f'<text x="{x:.1f}" y="{y + 28}" text-anchor="middle">{escape(text)}</text>')
    return _drawing(parts, y + 34)


def swatch_drawing(label: str, key: Sequence[tuple[npt.NDArray[np.float64], str]] = ()) -> str:
    """A sentence and, under it, coloured squares with their names."""
    parts, y = _lines(label)
    x = float(_EDGE)
    for color, text in key:
        wide = 18 + _LETTER * len(text) + 10
        if x > _EDGE and x + wide > WIDTH - 4:
            x, y = float(_EDGE), y + _LINE
        parts += _named(color, text, x, y)
        x += wide
    return _drawing(parts, y + (_LINE if key else 0) + 4)


def _lines(label: str) -> tuple[list[str], int]:
    """The label in lines, and where what is below it begins."""
    lines = textwrap.wrap(label, _LETTERS)
    parts = [f'<text x="{_EDGE}" y="{13 + _LINE * k}">{escape(line)}</text>' for k, line in enumerate(lines)]
    return parts, _LINE * len(lines) + 4


def _named(color: npt.NDArray[np.floating], text: str, x: float, y: float) -> list[str]:
    return [
        f'<rect x="{x:.1f}" y="{y}" width="11" height="11" fill="{css(color)}" stroke="#808080" stroke-width=".6"/>',
        f'<text x="{x + 16:.1f}" y="{y + 10}">{escape(text)}</text>',
    ]


def _drawing(parts: Sequence[str], height: int) -> str:
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}" '
        f'font-family="sans-serif" font-size="12" fill="#1d2026">{"".join(parts)}</svg>'
    )
