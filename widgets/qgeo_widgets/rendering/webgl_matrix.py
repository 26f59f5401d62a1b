"""A matrix drawn by our own browser module."""

from __future__ import annotations

from typing import Any

import anywidget
import numpy as np
import traitlets

from qgeo_widgets.rendering.browser_module import matrix_module, style
from qgeo_widgets.rendering.disposal import close_tree
from qgeo_widgets.rendering.matrix_pane import MatrixPane


class MatrixModel(anywidget.AnyWidget):
    """What the browser shows: a picture (count, count, 3) in bytes, and row and column that are lined, -1 for none."""

    _esm = matrix_module()
    _css = style()
    count = traitlets.Int().tag(sync=True)
    height = traitlets.Int().tag(sync=True)
    image = traitlets.Bytes().tag(sync=True)
    shown = traitlets.List([-1, -1]).tag(sync=True)


class WebglMatrix(MatrixPane):
    """See `MatrixPane`."""

    widget: MatrixModel

    def _make(self) -> None:
        self.widget = MatrixModel(
            count=len(self.image),
            height=self.size,
            image=self._bytes(),
            layout={"flex": "1 1 auto", "min_width": "0"},
        )
        self.widget.on_msg(self._told)

    def _bytes(self) -> bytes:
        return np.ascontiguousarray(self.image, dtype=np.uint8).tobytes()

    def _draw_image(self) -> None:
        self.widget.image = self._bytes()

    def show(self, row: int, column: int | None = None) -> None:
        """Draw a line along a row and one along a column."""
        self.widget.shown = [row, -1 if column is None else column]

    def _told(self, _: Any, content: dict[str, Any], buffers: Any) -> None:
        """A message of the picture."""
        act = {"hover": self.hovered, "click": self.clicked}.get(str(content.get("kind")))
        row, column = (int(content.get(name, -1)) for name in ("row", "column"))
        if act is not None and min(row, column) >= 0 and max(row, column) < len(self.image):
            act(row, column)

    def close(self) -> None:
        """Free everything, here and in the browser."""
        close_tree(self.widget)
