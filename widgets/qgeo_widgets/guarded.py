"""A widget in which what a user can mend is a sentence, and a bug is raised where it happens."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import ipywidgets
import traitlets

from qgeo_filters.errors import QgeoError
from qgeo_widgets import controls
from qgeo_widgets.long_work import LongWork

# What the library's advice calls an argument of other functions: what there is to call where a widget has none.
_ADVICE = {
    "repair=True": "qg.repair_surface(mesh)",
    "repair='force'": "qg.repair_surface(mesh, force=True)",
    "repair='wrap'": "qg.wrap_surface(mesh)",
}


class GuardedWidget(ipywidgets.VBox):
    """A column with a line for messages, and one for long work.

    Attributes
    ----------
    message : str
        The sentence that the widget shows on what went wrong; empty when all is well.
    hint : str
        What there is to do before the mode can be shown; empty when it is shown.
    """

    _takes_repair = False  # what the library's advice calls an argument is one of the widget, too

    message = traitlets.Unicode()
    hint = traitlets.Unicode()

    def __init__(self) -> None:
        self._guards = 0
        self._message_line = ipywidgets.HTML()
        self._long = LongWork()
        super().__init__([self._message_line, self._long])
        self.layout.overflow = "visible"

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        """Turn what a user can mend into a sentence in the widget; guards within a guard leave its sentence.

        That is a `QgeoError`, or what the system says of a file. Any other exception is a bug, and is raised.
        """
        self._guards += 1
        try:
            if self._guards == 1:
                self.message = ""
            yield
        except (QgeoError, OSError) as error:
            sentence = " ".join(str(error).split())
            self.message = sentence if self._takes_repair else _for_notebooks(sentence)
        finally:
            self._guards -= 1

    @traitlets.observe("message", "hint")
    def _show_message(self, change: Any) -> None:
        self._message_line.value = controls.sentence(self.message) + controls.advice(self.hint)


def _for_notebooks(sentence: str) -> str:
    for said, meant in _ADVICE.items():
        sentence = sentence.replace(said, meant)
    return sentence
