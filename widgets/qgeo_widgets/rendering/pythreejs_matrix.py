"""A matrix drawn by pythreejs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ipywidgets
import numpy as np
import numpy.typing as npt
import pythreejs as three

from qgeo_widgets.rendering.disposal import close_tree
from qgeo_widgets.rendering.matrix_pane import MatrixPane
from qgeo_widgets.rendering.pythreejs_pane import BACKGROUND


class PythreejsMatrix(MatrixPane):
    """See `MatrixPane`."""

    def _make(self) -> None:
        image, size = self.image, self.size
        self._rows = len(image)
        self._retired: Any = None
        board = self._board = three.Mesh(three.PlaneBufferGeometry(2, 2), _picture(image))
        self._row_line = self._stripe(2.0, 0.008)
        self._column_line = self._stripe(0.008, 2.0)
        self._camera = three.OrthographicCamera(-1, 1, 1, -1, 0.1, 10, position=(0, 0, 5))
        self._scene = three.Scene(children=[board, self._row_line, self._column_line], background=None)
        self.hover = three.Picker(controlling=board, event="mousemove")
        self.click = three.Picker(controlling=board, event="click")
        self.renderer = three.Renderer(
            scene=self._scene,
            camera=self._camera,
            controls=[self.hover, self.click],
            width=size,
            height=size,
            clearColor=BACKGROUND,
        )
        self.widget = ipywidgets.Box([self.renderer], layout={"width": f"{size + 2}px"})
        self.widget.add_class("qgeo-pane")

        self.hover.observe(lambda _: self._report(self.hover, self.hovered), names="point")
        self.click.observe(lambda _: self._report(self.click, self.clicked), names="point")

    def _draw_image(self) -> None:
        # Closed one change later: the front end may still be drawing it.
        self._close_retired()
        self._retired = self._board.material
        self._board.material = _picture(self.image)

    def show(self, row: int, column: int | None = None) -> None:
        """Draw a line along a row and one along a column."""
        self._row_line.position = (0.0, 1.0 - 2.0 * (row + 0.5) / self._rows, 0.1)
        self._row_line.visible = True
        self._column_line.visible = column is not None
        if column is not None:
            self._column_line.position = (2.0 * (column + 0.5) / self._rows - 1.0, 0.0, 0.1)

    def close(self) -> None:
        """Free everything, here and in the browser."""
        self._close_retired()
        for item in (self.widget, self.renderer):
            close_tree(item)

    def _close_retired(self) -> None:
        if self._retired is not None:
            close_tree(self._retired)
            self._retired = None

    def _report(self, picker: Any, callback: Callable[[int, int], None]) -> None:
        if picker.faceIndex is None:
            return
        x, y, _ = picker.point
        last = self._rows - 1
        row = min(max(int((1.0 - y) / 2.0 * self._rows), 0), last)
        column = min(max(int((x + 1.0) / 2.0 * self._rows), 0), last)
        callback(row, column)

    def _stripe(self, width: float, height: float) -> Any:
        material = three.MeshBasicMaterial(color="#ff2d55")
        return three.Mesh(three.PlaneBufferGeometry(width, height), material, visible=False)


def _picture(image: npt.NDArray[np.uint8]) -> Any:
    """Material that shows an image, row 0 at the top."""
    texture = three.DataTexture(
        data=np.ascontiguousarray(image[::-1]),
        format="RGBFormat",
        type="UnsignedByteType",
        minFilter="LinearFilter",
        magFilter="NearestFilter",
        unpackAlignment=1,
    )
    return three.MeshBasicMaterial(map=texture)
