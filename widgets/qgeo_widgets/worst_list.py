"""The places of a shape where a number is largest, as a list to click."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import ipywidgets

from qgeo_filters._typing import FloatArray
from qgeo_filters.report.worst_places import worst_places
from qgeo_filters.surface import Surface
from qgeo_widgets import controls
from qgeo_widgets.rendering.disposal import close_tree

_MOST = 10
#: Of one place from the next, in sqrt(area): so far, and the list is not ten neighbours of the worst.
_APART = 0.08


class WorstList(ipywidgets.VBox):
    """A button for each place; hidden while there is none.

    Parameters
    ----------
    go : callable
        Called with the vertex of the place whose button is clicked.
    """

    def __init__(self, go: Callable[[int], None]) -> None:
        self._go = go
        self.vertices: Sequence[int] = ()
        self._buttons = ipywidgets.HBox(layout={"flex_flow": "row wrap", "overflow": "visible"})
        title = ipywidgets.HTML("worst places on X, to look at:")
        super().__init__([title, self._buttons], layout={"overflow": "visible", "display": "none"})

    def show(self, surface: Surface, values: FloatArray | None) -> None:
        """List the worst places of a number (n,) of which 0 is good; None lists nothing."""
        found = [] if values is None else worst_places(surface, values, _MOST, apart=_APART).tolist()
        self.vertices = [vertex for vertex in found if values is not None and values[vertex] > 0]
        old = self._buttons.children
        self._buttons.children = [] if values is None else [self._button(v, float(values[v])) for v in self.vertices]
        self.layout.display = "" if self.vertices else "none"
        for button in old:
            close_tree(button)

    def _button(self, vertex: int, value: float) -> ipywidgets.Button:
        button = controls.button(f"{vertex}: {value:.3f}", f"look at vertex {vertex} of X, where it is {value:.4f}")
        button.on_click(lambda _: self._go(vertex))
        return button
