"""A pane drawn by pythreejs objects, one canvas each."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pythreejs as three

from qgeo_filters._typing import FloatArray
from qgeo_filters.surface import Surface
from qgeo_widgets.rendering.disposal import close_tree
from qgeo_widgets.rendering.motion import Motion
from qgeo_widgets.rendering.pane import Pane, css_color
from qgeo_widgets.rendering.pythreejs_regions import RegionOverlay
from qgeo_widgets.rendering.scene_placement import ScenePlacement

BACKGROUND = "#f7f7f8"
# The mesh is pushed back a little, so that lines on it are not cut by it.
MATERIAL = {
    "vertexColors": "VertexColors",
    "side": "DoubleSide",
    "polygonOffset": True,
    "polygonOffsetFactor": 2.0,
    "polygonOffsetUnits": 2.0,
}
# A click may move the camera by this part of its distance: about two pixels of the mouse, as hands do.
_STILL = 0.03


class PythreejsPane(Pane):
    """A surface in a pythreejs scene; the camera and its controls are given, and may be shared.

    Parameters
    ----------
    surface, placement, motion
        See `Pane`.
    camera, orbit : pythreejs camera and OrbitControls
    size : (int, int)
        Of the canvas, in pixels.
    mark_radius : float
        Of the ball that marks a point, in scene units.
    """

    def __init__(
        self,
        surface: Surface,
        placement: ScenePlacement,
        camera: Any,
        orbit: Any,
        size: tuple[int, int],
        mark_radius: float,
        motion: Motion | None = None,
    ) -> None:
        super().__init__(surface, placement, motion)
        shown = self.display.shown
        self._points, normals = self._first_look()
        self._radius = mark_radius
        self._camera = camera
        self._pressed_from = camera.position
        self._balls: dict[str, Any] = {}
        self._strokes: dict[str, Any] = {}
        self._retired: list[Any] = []
        self._color_attribute = three.BufferAttribute(self.display.at_vertices(self.colors), normalized=False)
        mesh = self._make_mesh(
            {
                "position": vectors(self._points),
                "normal": vectors(normals),
                "color": self._color_attribute,
                "index": three.BufferAttribute(shown.faces.ravel().astype(np.uint32), normalized=False),
            }
        )
        self._scene = three.Scene(children=[*_lamps(), mesh], background=None)
        self._overlay = RegionOverlay(self._scene, self._points, normals, shown.faces)
        self.press = three.Picker(controlling=mesh, event="mousedown")
        self.press.observe(self._pressed, names="point")
        self.picker = three.Picker(controlling=mesh, event="click")
        self.picker.observe(self._picked, names="point")
        self.renderer = three.Renderer(
            scene=self._scene,
            camera=camera,
            controls=[orbit, self.press, self.picker],
            width=size[0],
            height=size[1],
            antialias=True,
            clearColor=BACKGROUND,
        )

    # -- for subclasses -----------------------------------------------------------------------------

    def _first_look(self) -> tuple[FloatArray, FloatArray]:
        """Positions and normals of the vertices that are drawn, in the scene."""
        shown = self.display.shown
        return self.placement.to_scene(shown.vertices), shown.vertex_normals @ self.placement.axes.T

    def _make_mesh(self, attributes: dict[str, Any]) -> Any:
        return three.Mesh(three.BufferGeometry(attributes=attributes), three.MeshLambertMaterial(**MATERIAL))

    # -- drawing ------------------------------------------------------------------------------------

    def _draw_colors(self) -> None:
        shown = self.colors
        if self.cells is not None:
            # A material of pythreejs knows no cells: the vertices alone are darker and lighter.
            odd = np.floor(self.cells).sum(axis=1) % 2 == 1
            shown = np.where(odd[:, None], np.float32(0.55) * shown, shown)
        # A new array: changes within one are not sent.
        self._color_attribute.array = self.display.at_vertices(shown)

    def _draw_cells(self) -> None:
        self._draw_colors()

    def _draw_regions(self) -> None:
        if self.regions is None:
            self._overlay.show(None, None)
        else:
            labels, palette = self.regions
            self._overlay.show(self.display.at_vertices(labels), palette)

    def _draw_mark(self, slot: str) -> None:
        mark, ball = self.marks.get(slot), self._balls.get(slot)
        if mark is None:
            if ball is not None:
                ball.visible = False
            return
        place, color = tuple(self.placement.to_scene(mark.point).tolist()), css_color(mark.color)
        if ball is None:
            ball = self._balls[slot] = three.Mesh(
                three.SphereGeometry(self._radius, 20, 14), three.MeshLambertMaterial(color=color), position=place
            )
            self._scene.add(ball)
            return
        ball.position = place
        ball.material.color = color
        ball.visible = True

    def _draw_line(self, slot: str) -> None:
        old = self._strokes.pop(slot, None)
        if old is not None:
            self._scene.remove(old)
            # Closed with the pane: the front end may still be drawing it.
            self._retired.append(old)
        line = self.lines.get(slot)
        if line is None:
            return
        geometry = three.LineGeometry(positions=self.placement.to_scene(line.points).astype(np.float32))
        material = three.LineMaterial(linewidth=line.width, color=css_color(line.color))
        stroke = self._strokes[slot] = three.Line2(geometry, material)
        self._scene.add(stroke)

    # -- picking ------------------------------------------------------------------------------------

    def _pressed(self, change: Any) -> None:
        self._pressed_from = self._camera.position

    def _dragged(self) -> bool:
        """Whether the mouse turned the surface between button down and up; the browser sends a click all the same."""
        # The points alone do not tell: at some depth the surface follows the mouse. The camera alone does not either:
        # while the kernel is busy its position may arrive after the click.
        slip = np.linalg.norm(np.subtract(self.picker.point, self.press.point))
        turn = np.linalg.norm(np.subtract(self._camera.position, self._pressed_from))
        return bool(slip > self._radius or turn > _STILL * np.linalg.norm(self._pressed_from))

    def _picked(self, change: Any) -> None:
        if self.picker.faceIndex is not None and not self._dragged():
            self.clicked(self.picker.face, self.picker.point)

    # -- the end ------------------------------------------------------------------------------------

    def close(self) -> None:
        """Free all that the pane holds, in the kernel and in the browser."""
        super().close()
        self._overlay.close()
        for item in (self.renderer, self._scene, *self._retired):
            close_tree(item)
        self._balls.clear()
        self._strokes.clear()
        self._retired.clear()


def vectors(array: npt.ArrayLike) -> Any:
    """Vectors (n, 3) as the browser gets them."""
    return three.BufferAttribute(np.asarray(array, dtype=np.float32), normalized=False)


def _lamps() -> list[Any]:
    """Light from all around, so that no side that the camera turns to is dark."""
    return [
        three.AmbientLight(intensity=0.52),
        three.DirectionalLight(position=[-4, 6, 8], intensity=0.42),
        three.DirectionalLight(position=[6, 1, -4], intensity=0.30),
        three.DirectionalLight(position=[-3, -4, -6], intensity=0.18),
    ]
