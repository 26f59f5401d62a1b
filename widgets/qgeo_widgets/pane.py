"""One picture of a surface in WebGL: mesh, colours, marks, lines and picking, on pythreejs objects."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pythreejs as three

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.surface import Surface
from qgeo_widgets.display_mesh import DisplayMesh
from qgeo_widgets.disposal import close_tree
from qgeo_widgets.region_overlay import RegionOverlay
from qgeo_widgets.scene_placement import ScenePlacement

Color = tuple[float, float, float]

BACKGROUND = "#f7f7f8"
CLAY = np.array([0.82, 0.83, 0.86], dtype=np.float32)
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
# Extent, in the scene, of a curve that runs from a point to itself but for rounding.
_NO_LENGTH = 1e-6


class Pane:
    """A surface in a scene of its own; the camera and its controls are given, and may be shared.

    Parameters
    ----------
    surface : Surface
    placement : ScenePlacement
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
    ) -> None:
        self.surface = surface
        self.placement = placement
        self.colors = np.tile(CLAY, (surface.n_vertices, 1))
        self.marks: dict[str, tuple[FloatArray, Color]] = {}
        self.lines: dict[str, tuple[FloatArray, Color]] = {}
        self.display = self._make_display()
        shown = self.display.shown
        self._points, normals = self._first_look()
        self._radius = mark_radius
        self._camera = camera
        self._pressed_from = camera.position
        self._balls: dict[str, Any] = {}
        self._strokes: dict[str, Any] = {}
        self._retired: list[Any] = []
        self._on_pick: list[Callable[[int], None]] = []
        self._color_attribute = three.BufferAttribute(self.display.at_vertices(self.colors), normalized=False)
        mesh = self._make_mesh(
            {
                "position": vectors(self._points),
                "normal": vectors(normals),
                "color": self._color_attribute,
                "index": three.BufferAttribute(shown.faces.ravel().astype(np.uint32), normalized=False),
            }
        )
        self.regions: tuple[IndexArray, FloatArray] | None = None
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

    def _make_display(self) -> DisplayMesh:
        """What is drawn of the surface."""
        return DisplayMesh(self.surface)

    def _first_look(self) -> tuple[FloatArray, FloatArray]:
        """Positions and normals of the vertices that are drawn, in the scene."""
        shown = self.display.shown
        return self.placement.to_scene(shown.vertices), shown.vertex_normals @ self.placement.axes.T

    def _make_mesh(self, attributes: dict[str, Any]) -> Any:
        return three.Mesh(three.BufferGeometry(attributes=attributes), three.MeshLambertMaterial(**MATERIAL))

    # -- for export ---------------------------------------------------------------------------------

    @property
    def page_mesh(self) -> DisplayMesh | None:
        """What a page shows in place of the surface; None is the surface itself."""
        return None

    @property
    def page_caption(self) -> str:
        """What a reader of a page has to know of it."""
        return ""

    # -- colours ------------------------------------------------------------------------------------

    def set_colors(self, colors: npt.ArrayLike) -> bool:
        """Show these colours (n, 3) in [0, 1]; whether anything had to be sent."""
        new = np.ascontiguousarray(colors, dtype=np.float32)
        if new.shape != self.colors.shape:
            raise ParameterError(f"colors have shape {new.shape}, expected {self.colors.shape}")
        if np.array_equal(new, self.colors):
            return False
        self.colors = new
        self._color_attribute.array = self.display.at_vertices(new)  # a new array: changes within one are not sent
        return True

    def set_regions(self, labels: IndexArray | None, palette: FloatArray | None = None) -> None:
        """Sharpen the borders between regions, rows (n,) of the palette (k, 3), over their colours; None undoes it."""
        self.regions = None if labels is None or palette is None else (labels, palette)
        self._overlay.show(None if labels is None else self.display.at_vertices(labels), palette)

    # -- marks and lines ----------------------------------------------------------------------------

    def set_mark(self, slot: str, point: npt.ArrayLike | None, color: Color = (0.86, 0.11, 0.16)) -> None:
        """Show a ball at a point (in the surface's coordinates), in place of the one in this slot; None hides it."""
        if point is None:
            self.marks.pop(slot, None)
            if slot in self._balls:
                self._balls[slot].visible = False
            return
        self.marks[slot] = np.asarray(point, dtype=np.float64), color
        place = tuple(self.placement.to_scene(point).tolist())
        ball = self._balls.get(slot)
        if ball is None:
            ball = self._balls[slot] = three.Mesh(
                three.SphereGeometry(self._radius, 20, 14), three.MeshLambertMaterial(color=_hex(color)), position=place
            )
            self._scene.add(ball)
            return
        ball.position = place
        ball.material.color = _hex(color)
        ball.visible = True

    def set_line(
        self, slot: str, points: npt.ArrayLike | None, color: Color = (0.86, 0.11, 0.16), width: float = 5.0
    ) -> None:
        """Show a curve through points (p, 3) of the surface, in place of the one in this slot; None removes it.

        A curve without length, like the path from a point to itself, shows nothing.
        """
        self.lines.pop(slot, None)
        old = self._strokes.pop(slot, None)
        if old is not None:
            self._scene.remove(old)
            # Closed with the pane: the front end may still be drawing it.
            self._retired.append(old)
        curve = np.empty((0, 3)) if points is None else np.asarray(points, dtype=np.float64)
        placed = self.placement.to_scene(curve)
        if len(curve) < 2 or np.ptp(placed, axis=0).max() <= _NO_LENGTH:
            return
        self.lines[slot] = curve, color
        geometry = three.LineGeometry(positions=placed.astype(np.float32))
        stroke = self._strokes[slot] = three.Line2(geometry, three.LineMaterial(linewidth=width, color=_hex(color)))
        self._scene.add(stroke)

    # -- picking ------------------------------------------------------------------------------------

    def on_pick(self, callback: Callable[[int], None]) -> None:
        """Call back with the vertex nearest to each point that is clicked; the end of a drag is no click."""
        self._on_pick.append(callback)

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
        if self.picker.faceIndex is None or self._dragged():
            return
        corners = np.asarray(self.picker.face, dtype=np.int64)
        if not ((corners >= 0) & (corners < len(self._points))).all():
            return
        vertex = self.display.vertex_at(corners, self.placement.to_surface(self.picker.point))
        for callback in self._on_pick:
            callback(vertex)

    # -- the end ------------------------------------------------------------------------------------

    def close(self) -> None:
        """Free all that the pane holds, in the kernel and in the browser."""
        self._on_pick.clear()
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


def _hex(color: Color) -> str:
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in color)
