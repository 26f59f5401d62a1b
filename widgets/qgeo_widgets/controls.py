"""Controls that the widgets share, laid out so that labels stay whole and nothing overlaps."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import ipywidgets

# Left and right of what may be as wide as its row.
_LEFT, _RIGHT = 2, 14


def choice(label: str, options: Sequence[str], value: str) -> ipywidgets.Dropdown:
    """Dropdown list with a label."""
    return ipywidgets.Dropdown(
        options=list(options),
        value=value,
        description=label,
        style={"description_width": "auto"},
        layout=at_most("340px") | {"width": "auto"},
    )


def whole(label: str, value: int, low: int, high: int) -> ipywidgets.IntSlider:
    """Slider over whole numbers."""
    return ipywidgets.IntSlider(
        value=value,
        min=low,
        max=high,
        description=label,
        style={"description_width": "auto"},
        layout=at_most("250px"),
    )


def number(
    label: str,
    value: float,
    low: float,
    high: float,
    step: float,
    *,
    live: bool = True,
    digits: str = ".3f",
    width: str = "330px",
) -> ipywidgets.FloatSlider:
    """Slider over numbers; one that is not live reports when it is let go."""
    return ipywidgets.FloatSlider(
        value=value,
        min=low,
        max=high,
        step=step,
        description=label,
        continuous_update=live,
        readout_format=digits,
        style={"description_width": "auto"},
        layout=at_most(width),
    )


def span() -> ipywidgets.FloatRangeSlider:
    """Slider with two handles for the limits of the colours, in per cent of the values' range.

    Its own ends never change: a browser that is told new ends answers with its old values.
    """
    return ipywidgets.FloatRangeSlider(
        value=(0.0, 100.0),
        min=0.0,
        max=100.0,
        step=0.5,
        description="range %",
        readout_format=".0f",
        style={"description_width": "auto"},
        layout=at_most("380px"),
    )


def tick(label: str, value: bool, tooltip: str) -> ipywidgets.Checkbox:
    """Box to tick."""
    return ipywidgets.Checkbox(
        value=value,
        description=label,
        indent=False,
        tooltip=tooltip,
        layout={"width": "auto", "margin": "2px 14px 2px 2px"},
    )


def button(label: str, tooltip: str) -> ipywidgets.Button:
    """Button as wide as its text."""
    return ipywidgets.Button(description=label, tooltip=tooltip, layout={"width": "auto", "margin": "2px 6px 2px 2px"})


def at_most(width: str) -> dict[str, str]:
    """Layout of a control that is so wide, but no wider than its row: that of a telephone, say."""
    room = f"min({width}, calc(100% - {_LEFT + _RIGHT}px))"
    return {"width": width, "max_width": room, "margin": f"2px {_RIGHT}px 2px {_LEFT}px"}


def row(*children: ipywidgets.Widget) -> ipywidgets.HBox:
    """Controls side by side, in further lines where the notebook is narrow."""
    return ipywidgets.HBox(children, layout={"flex_flow": "row wrap", "align_items": "center", "overflow": "visible"})


def sentence(text: str) -> str:
    """A message to the reader as HTML."""
    if not text:
        return ""
    return (
        '<div style="margin:4px 2px;padding:6px 10px;border-left:4px solid #d08a00;background:#fff6e0;color:#40300a;'
        f'line-height:1.4">{escape(text)}</div>'
    )


def advice(text: str) -> str:
    """What the reader may do next, as HTML."""
    return f'<div style="margin:4px 2px;padding:2px 10px;line-height:1.4">{escape(text)}</div>' if text else ""


def table(rows: Sequence[Sequence[str]], head: Sequence[str] = ()) -> str:
    """A small table as HTML."""
    if not rows:
        return ""
    cell = 'style="padding:1px 14px 1px 0;text-align:left;vertical-align:top;font-weight:{w}"'
    # A corner without text is no heading.
    heads = [f"<th {cell.format(w=600)}>{escape(h)}</th>" if h else "<td></td>" for h in head]
    lines = [f"<tr>{''.join(heads)}</tr>"] if head else []
    for entries in rows:
        lines.append("<tr>" + "".join(f"<td {cell.format(w=400)}>{escape(e)}</td>" for e in entries) + "</tr>")
    return (
        '<table style="border-collapse:collapse;font-size:12px;line-height:1.4;font-variant-numeric:tabular-nums">'
        f"{''.join(lines)}</table>"
    )
