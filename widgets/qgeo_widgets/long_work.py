"""A line that says how far long work has come, and cancels it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from html import escape

import ipywidgets
from IPython import get_ipython
from IPython.display import display

from qgeo_filters.errors import QgeoError
from qgeo_filters.parallel import watched
from qgeo_widgets import controls

# Seconds: what is done before is not worth a line, and no eye follows more changes.
_SHORT, _STEP = 0.4, 0.2


class CancelledWorkError(QgeoError):
    """Work that the user cancelled."""


class LongWork(ipywidgets.HBox):
    """Name, bar and button; hidden while there is nothing to wait for.

    Work in a thread of its own (`in_background`) is cancelled by the button, work that keeps the kernel by the
    notebook's own stop button: a busy kernel hears of no click. Either ends with `CancelledWorkError`, at the next step
    that the work reports (see `qgeo_filters.parallel.watched`).
    """

    def __init__(self) -> None:
        self._text = ipywidgets.HTML()
        self._bar = ipywidgets.IntProgress(layout={"width": "200px", "margin": "2px 10px"})
        self.cancel_button = controls.button("cancel", "leave it; what is shown stays")
        self.cancel_button.on_click(lambda _: self.cancel())
        self._depth = 0
        self._cancelled = False
        self._what, self._began, self._told = "", 0.0, 0.0
        self._thread: threading.Thread | None = None
        super().__init__([self._text, self._bar, self.cancel_button])
        self.layout.display = "none"

    @property
    def running(self) -> bool:
        """Whether something runs in the background."""
        return self._thread is not None and self._thread.is_alive()

    def cancel(self) -> None:
        """End what runs, at its next step."""
        self._cancelled = True

    @contextmanager
    def during(self, what: str, *, at_once: bool = False) -> Iterator[None]:
        """Say how far the work within has come, if it is long; what is within another such context is part of it.

        Parameters
        ----------
        what : str
            What is done, as a reader would say it: "Finding the symmetry".
        at_once : bool
            Show the line from the beginning, in the cell's output if the widget is not shown yet.
        """
        if self._depth == 0:
            self._cancelled, self._what, self._began, self._told = False, what, time.monotonic(), 0.0
            if at_once:
                self._show("")
        self._depth += 1
        try:
            with watched(self._moved):
                yield
        except KeyboardInterrupt:
            raise CancelledWorkError(self._verdict()) from None
        finally:
            self._depth -= 1
            if self._depth == 0:
                self.layout.display = "none"

    def in_background(self, what: str, work: Callable[[], None]) -> bool:
        """Do the work in a thread, with a button that cancels it; False, and nothing is done, while other work runs."""
        if self.running:
            return False

        def run() -> None:
            with self.during(what, at_once=True):
                work()

        self._thread = threading.Thread(target=run, daemon=True)
        self._thread.start()
        return True

    def announce(self) -> None:
        """Show the line in the output of the cell that is run, before the widget is."""
        if getattr(get_ipython(), "kernel", None) is not None:
            display(self)

    def join(self, seconds: float) -> None:
        """Wait for what runs in the background."""
        if self._thread is not None:
            self._thread.join(seconds)

    # -- inside -------------------------------------------------------------------------------------

    def _moved(self, step: str, done: int, total: int) -> None:
        if self._cancelled:
            raise CancelledWorkError(self._verdict())
        now = time.monotonic()
        if now - self._began < _SHORT or now - self._told < _STEP:
            return
        self._told = now
        self._bar.max, self._bar.value = max(total, 1), done
        self._show(f"{step} {done} of {total}".strip())

    def _show(self, step: str) -> None:
        here = self.running and threading.current_thread() is self._thread
        self.cancel_button.layout.display = "" if here else "none"
        how = "" if here else " The notebook's stop button cancels it."
        self._text.value = escape(f"{self._what} … {step}.{how}" if step else f"{self._what} …{how}")
        self.layout.display = ""

    def _verdict(self) -> str:
        return f"{self._what} was cancelled."
