"""Which widgets a notebook's cell made when it was run before: they are closed when it is run again."""

from __future__ import annotations

import weakref
from typing import Any, Protocol

from IPython import get_ipython


class Closable(Protocol):
    """What can be closed."""

    def close(self) -> None:
        """Free it."""


# Cell, the run of it that was last, and what that run made. A widget that is not closed stays in the kernel for good,
# with all that it is made of, also when its cell shows another one.
_made: dict[str, tuple[str, list[weakref.ref[Any]]]] = {}


def replace_earlier(widget: Closable) -> None:
    """Close what an earlier run of this cell made, and remember the widget as made by this one.

    Where the front end does not say which cell is run (scripts, consoles, Voila) nothing is closed.
    """
    cell, run = _here()
    if not cell:
        return
    last, others = _made.get(cell, ("", []))
    if last != run:
        for reference in others:
            other = reference()
            if other is not None:
                other.close()
        others = []
    _made[cell] = run, [*others, weakref.ref(widget)]


def _here() -> tuple[str, str]:
    """Cell that is run and the message that runs it; empty outside of notebooks."""
    kernel = getattr(get_ipython(), "kernel", None)
    if kernel is None:
        return "", ""
    parent = kernel.get_parent("shell")
    header, metadata = parent.get("header", {}), parent.get("metadata", {})
    if header.get("msg_type") != "execute_request":
        return "", ""
    return str(metadata.get("cellId", "")), str(header.get("msg_id", ""))
