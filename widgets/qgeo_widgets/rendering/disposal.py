"""Closing a widget together with everything that it is made of."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from ipywidgets import Widget


def widgets_within(root: Widget) -> list[Widget]:
    """Every widget that the root refers to through its synchronised traits, itself first."""
    found: dict[int, Widget] = {}
    waiting = [root]
    while waiting:
        widget = waiting.pop()
        if id(widget) in found:
            continue
        found[id(widget)] = widget
        for name in widget.keys:
            # Only what exists already: reading a trait may make its default.
            waiting.extend(_inside(widget._trait_values.get(name)))
    return list(found.values())


def close_tree(root: Widget) -> None:
    """Close a widget and all within it, here and in the browser, and let go of every callback."""
    for widget in widgets_within(root):
        widget.unobserve_all()
        if widget.comm is not None:
            Widget.close(widget)  # not an own close(), which may be what called this


def _inside(value: Any) -> Iterator[Widget]:
    if isinstance(value, Widget):
        yield value
    elif isinstance(value, dict):
        for item in value.values():
            yield from _inside(item)
    elif isinstance(value, Iterable) and isinstance(value, (list, tuple, set)):
        for item in value:
            yield from _inside(item)
