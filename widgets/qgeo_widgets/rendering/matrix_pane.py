"""A square matrix as a picture whose entries answer to the mouse; a backend draws it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import ipywidgets
import numpy as np
import numpy.typing as npt


class MatrixPane(ABC):
    """Picture of a square matrix, row 0 at the top; says which entry the mouse is over, and which is clicked.

    Parameters
    ----------
    image : (m, m, 3) uint8
    size : int
        Width and height in pixels.

    Attributes
    ----------
    widget : ipywidgets.Widget
        What is displayed.
    """

    widget: ipywidgets.Widget

    def __init__(self, image: npt.NDArray[np.uint8], size: int) -> None:
        self.image = image
        self.size = size
        self._on_hover: list[Callable[[int, int], None]] = []
        self._on_click: list[Callable[[int, int], None]] = []
        self._make()

    def set_image(self, image: npt.NDArray[np.uint8]) -> None:
        """Show another picture (m, m, 3) of the matrix."""
        if not np.array_equal(image, self.image):
            self.image = image
            self._draw_image()

    def on_hover(self, callback: Callable[[int, int], None]) -> None:
        """Call back with row and column whenever the mouse is over another place."""
        self._on_hover.append(callback)

    def on_click(self, callback: Callable[[int, int], None]) -> None:
        """Call back with row and column when the picture is clicked."""
        self._on_click.append(callback)

    def hovered(self, row: int, column: int) -> None:
        """The mouse is over an entry."""
        for callback in self._on_hover:
            callback(row, column)

    def clicked(self, row: int, column: int) -> None:
        """An entry was clicked."""
        for callback in self._on_click:
            callback(row, column)

    @abstractmethod
    def _make(self) -> None:
        """Make `widget`."""

    @abstractmethod
    def _draw_image(self) -> None:
        """Show `image`."""

    @abstractmethod
    def show(self, row: int, column: int | None = None) -> None:
        """Draw a line along a row and one along a column."""

    @abstractmethod
    def close(self) -> None:
        """Free everything, here and in the browser."""
