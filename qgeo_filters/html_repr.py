"""Results as small cards of HTML, for notebooks: a title, facts, a chart of bars; one screen, in light and dark.

All styles stand in the elements themselves and take the colours of the page that shows them: notebooks drop style
sheets of what is not trusted, and have themes of their own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt

MOST_ROWS = 12
_LONGEST = 300  # characters of one fact
_LINE = "border:0;border-top:1px solid rgba(128,128,128,.3)"
_BARS = 24


def card(
    title: str,
    facts: Mapping[str, Any],
    *,
    subtitle: str = "",
    table: Sequence[Sequence[Any]] = (),
    columns: Sequence[str] = (),
    bars: npt.ArrayLike | None = None,
    bars_label: str = "",
) -> str:
    """HTML of a result; everything that is given is escaped.

    Parameters
    ----------
    title : str
        What it is: the name of its class.
    facts : mapping
        Name and value; floats have four digits, None is left out.
    subtitle : str
        A sentence under the title.
    table : sequence of rows
        Under the facts; of more than 12 rows the first are shown, and how many there are.
    columns : sequence of str
        Headings of the table.
    bars : array-like, shape (k,), optional
        Heights of bars, from zero.
    bars_label : str
        What they are.
    """
    rows = [(name, shown(value)) for name, value in facts.items() if value is not None]
    parts = [
        f'<div style="font-weight:600">{escape(title)}</div>',
        f'<div style="opacity:.75">{escape(_cut(subtitle))}</div>' if subtitle else "",
        _table([], rows),
        _chart(np.asarray(bars, dtype=np.float64), bars_label) if bars is not None else "",
        _table(columns, [[shown(value) for value in row] for row in table[:MOST_ROWS]]) if len(table) else "",
    ]
    if len(table) > MOST_ROWS:
        parts.append(f'<div style="opacity:.75">the first {MOST_ROWS} of {len(table)}</div>')
    style = "font-size:.9em;line-height:1.45;max-width:46em;color:inherit"
    return f'<div class="qgeo-result" style="{style}">{"".join(parts)}</div>'


def histogram(values: npt.ArrayLike, weights: npt.ArrayLike | None = None) -> np.ndarray:
    """Heights of the bars of a histogram from zero to the largest finite value, shape (24,)."""
    array = np.asarray(values, dtype=np.float64)
    known = np.isfinite(array)
    top = float(array[known].max(initial=0.0)) or 1.0
    weight = None if weights is None else np.asarray(weights)[known]
    return np.histogram(array[known], _BARS, (0.0, top), weights=weight)[0].astype(np.float64)


def shown(value: Any) -> str:
    """A value as text: four digits or all of a whole number, yes or no, long text and lists cut short."""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (float, np.floating)):
        number = float(value)
        return f"{number:.0f}" if 1e4 <= abs(number) < 1e7 else f"{number:.4g}"
    if isinstance(value, (list, tuple)):
        return _cut(", ".join(map(shown, value[:8])) + (f", ... ({len(value)})" if len(value) > 8 else ""))
    return _cut(str(value))


def span(values: npt.ArrayLike) -> str:
    """Smallest and largest finite value, as text."""
    array = np.asarray(values, dtype=np.float64)
    known = array[np.isfinite(array)]
    return f"{shown(float(known.min()))} to {shown(float(known.max()))}" if known.size else "none"


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 4]} ..."


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    if not rows:
        return ""
    cell = f"text-align:left;vertical-align:top;background:none;color:inherit;padding:.1em 1.2em .1em 0;{_LINE}"
    head = "".join(f'<th style="{cell};opacity:.75;font-weight:600">{escape(name)}</th>' for name in columns)
    body = "".join(f'<tr style="background:none">{"".join(_cells(cell, row))}</tr>' for row in rows)
    head = f'<thead><tr style="background:none">{head}</tr></thead>' if head else ""
    return f'<table style="border-collapse:collapse;margin:.3em 0;color:inherit">{head}<tbody>{body}</tbody></table>'


def _cells(style: str, row: Sequence[str]) -> list[str]:
    first, *others = row
    return [f'<td style="{style};opacity:.75;white-space:nowrap">{escape(first)}</td>'] + [
        f'<td style="{style}">{escape(text)}</td>' for text in others
    ]


def _chart(heights: np.ndarray, label: str) -> str:
    """Bars in the colour of the text."""
    heights = np.where(np.isfinite(heights), np.abs(heights), 0.0)
    if not heights.size or not heights.max() > 0:
        return ""
    tall = 30.0 * heights / heights.max()
    bars = "".join(
        f'<rect x="{8 * k}" y="{31 - height:.1f}" width="7" height="{height + 1:.1f}"/>'
        for k, height in enumerate(tall)
    )
    size = f'width="{8 * len(tall)}" height="32" viewBox="0 0 {8 * len(tall)} 32"'
    picture = f'<svg role="img" aria-label="{escape(label)}" {size} fill="currentColor" opacity=".6">{bars}</svg>'
    return f'<div style="margin:.3em 0">{picture}<div style="opacity:.75">{escape(label)}</div></div>'
