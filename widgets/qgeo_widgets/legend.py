"""Legends as HTML: a colour bar with round ticks, or named swatches. Light, sharp, and the same offline."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
import numpy.typing as npt
from matplotlib.ticker import MaxNLocator

from qgeo_filters.report.colors import MISSING, ColorScale

_STOPS = 24
# Of the bar; on a telephone what JupyterLab leaves of its width, of which 118 pixels are beside the cell and 48 beside
# the bar. Not a share of the row: where that is as wide as what is in it there would be no width at all.
_WIDTH = "min(340px, calc(100vw - 170px))"


def color_bar(scale: ColorScale, label: str, *, missing: bool = False) -> str:
    """Colour bar of a scale with ticks at round numbers and its label; with a grey swatch if values are missing."""
    values = np.linspace(scale.low, scale.high, _STOPS + 1) if scale.high > scale.low else np.full(2, scale.low)
    gradient = ", ".join(map(css, scale(values)))
    marks = "".join(
        f'<span style="position:absolute;left:{100 * place:.2f}%;transform:translateX(-50%);white-space:nowrap">'
        f'<span style="display:block;width:1px;height:4px;background:currentColor;margin:0 auto"></span>{text}</span>'
        for place, text in ticks(scale.low, scale.high)
    )
    note = f"&ensp;{_swatch(np.array(MISSING))} no value" if missing else ""
    return (
        f'<div style="width:{_WIDTH};padding:0 24px 2px;font-size:12px;line-height:1.3">'
        f'<div style="padding-bottom:3px">{escape(label)}{note}</div>'
        f'<div style="height:12px;border:1px solid rgba(128,128,128,.6);'
        f'background:linear-gradient(to right, {gradient})"></div>'
        f'<div style="position:relative;height:21px">{marks}</div></div>'
    )


def swatches(label: str, key: Sequence[tuple[npt.NDArray[np.float64], str]] = ()) -> str:
    """A sentence and, under it, coloured squares with their names."""
    items = "".join(
        f'<span style="display:inline-block;margin-right:9px;white-space:nowrap">{_swatch(color)} {escape(text)}</span>'
        for color, text in key
    )
    return (
        f'<div style="padding:0 24px 2px;max-width:760px;font-size:12px;line-height:1.5">{escape(label)}'
        f"{'<br>' if items else ''}{items}</div>"
    )


def css(color: npt.NDArray[np.floating]) -> str:
    """The colour as CSS writes it."""
    return "#" + "".join(f"{round(255 * float(channel)):02x}" for channel in color)


def _swatch(color: npt.NDArray[np.floating]) -> str:
    return (
        f'<span style="display:inline-block;width:11px;height:11px;vertical-align:-1px;background:{css(color)};'
        'border:1px solid rgba(128,128,128,.6)"></span>'
    )


def ticks(low: float, high: float) -> list[tuple[float, str]]:
    """Places from 0 to 1 and texts of round numbers between the limits."""
    if not high > low:
        return [(0.5, f"{low:.4g}")]
    values = np.asarray(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high))
    slack = 1e-9 * (high - low)
    values = values[(values >= low - slack) & (values <= high + slack)]
    values = np.where(np.abs(values) < 1e-12 * (high - low), 0.0, values)
    return [((v - low) / (high - low), f"{v:.6g}".replace("-", "−")) for v in values.tolist()]
