"""The places of a shape where a number is largest, as a list to click."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import ipywidgets
import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray
from qgeo_widgets import controls
from qgeo_widgets.rendering.disposal import close_tree

_MOST = 10
#: Of one place from the next, in sqrt(area): so far, and the list is not ten neighbours of the worst.
_APART = 0.08


def worst_places(values: npt.ArrayLike, points: npt.ArrayLike, apart: float, most: int = _MOST) -> list[int]:
    """Vertices of the largest finite values above zero, no two nearer to each other than so far, worst first.

    Parameters
    ----------
    values : array-like, shape (n,)
    points : array-like, shape (n, 3)
    apart : float
        Least distance, in the unit of the points.
    most : int
        How many at most.
    """
    table, places = np.asarray(values, dtype=np.float64), np.asarray(points, dtype=np.float64)
    tree = cKDTree(places)
    left = np.isfinite(table) & (table > 0)
    found: list[int] = []
    for vertex in np.argsort(-np.where(left, table, -np.inf), kind="stable"):
        if len(found) == most or not np.isfinite(table[vertex]) or table[vertex] <= 0:
            break
        if left[vertex]:
            found.append(int(vertex))
            left[tree.query_ball_point(places[vertex], apart)] = False
    return found


class WorstPlaces(ipywidgets.VBox):
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

    def show(self, values: FloatArray | None, points: FloatArray, unit: float) -> None:
        """List the worst places of a number (n,) without unit at the points (n, 3); None lists nothing."""
        self.vertices = () if values is None else worst_places(values, points, _APART * unit)
        old = self._buttons.children
        self._buttons.children = [] if values is None else [self._button(v, float(values[v])) for v in self.vertices]
        self.layout.display = "" if self.vertices else "none"
        for button in old:
            close_tree(button)

    def _button(self, vertex: int, value: float) -> ipywidgets.Button:
        button = controls.button(f"{vertex}: {value:.3f}", f"look at vertex {vertex} of X, where it is {value:.4f}")
        button.on_click(lambda _: self._go(vertex))
        return button
