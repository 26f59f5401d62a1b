"""The backend of pythreejs: a canvas for each surface, one camera and one set of controls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import ipywidgets
import numpy as np
import pythreejs as three

from qgeo_filters.surface import Surface
from qgeo_widgets.rendering.disposal import close_tree
from qgeo_widgets.rendering.motion import Motion
from qgeo_widgets.rendering.pythreejs_fallback import STYLE, FallbackImage
from qgeo_widgets.rendering.pythreejs_moving_pane import MovingPane
from qgeo_widgets.rendering.pythreejs_pane import PythreejsPane
from qgeo_widgets.rendering.scene_placement import ScenePlacement
from qgeo_widgets.rendering.viewer import FIELD_OF_VIEW, Place, Viewer, checked_camera, place_of


class PythreejsViewer(Viewer):
    """Surfaces in a canvas each; see `Viewer`.

    One camera and one set of orbit controls serve every canvas, which keeps the views in step during a drag, not only
    after it.
    """

    # pythreejs keeps eight WebGL contexts; other canvases are frozen to pictures, which cannot be clicked.
    MOST_SHAPES: ClassVar[int] = 8

    def _make(self, shown: Sequence[tuple[Surface, ScenePlacement, Motion | None]], titles: Sequence[str]) -> None:
        size, radius = self.size, self.radius
        self._camera = three.PerspectiveCamera(
            fov=FIELD_OF_VIEW, aspect=size[0] / size[1], position=self.home, near=0.02 * radius, far=60 * radius
        )
        self._orbit = three.OrbitControls(controlling=self._camera)
        shared = self._camera, self._orbit, size, self.mark_radius
        self._moving = [MovingPane(motion, *shared) for _, _, motion in shown if motion is not None]
        self.panes: Sequence[PythreejsPane] = self._moving or [
            PythreejsPane(surface, placement, *shared) for surface, placement, _ in shown
        ]
        self._camera.observe(self._moved, names="position")
        self._fallbacks = [FallbackImage() for _ in self.panes]
        style = ipywidgets.HTML(STYLE, layout={"display": "none"})
        self.widget = ipywidgets.HBox(
            [*map(self._framed, self.panes, self._fallbacks, titles), style],
            layout={"flex_flow": "row wrap", "overflow": "visible"},
        )

    @property
    def camera(self) -> Place:
        """Position of the camera in scene units."""
        return place_of(self._camera.position)

    @camera.setter
    def camera(self, position: Sequence[float]) -> None:
        self._camera.position = checked_camera(position)
        self._orbit.exec_three_obj_method("update")

    @property
    def target(self) -> Place:
        """What the camera looks at."""
        return place_of(self._orbit.target)

    @target.setter
    def target(self, point: Sequence[float]) -> None:
        self._orbit.target = place_of(point)

    @property
    def zoom(self) -> float:
        """How many times as large as from where it stands the camera shows things."""
        return float(self._camera.zoom)

    def reset(self) -> None:
        """Back to where the camera was at first."""
        self._orbit.target = (0.0, 0.0, 0.0)
        self._camera.up = (0.0, 1.0, 0.0)
        self._camera.zoom = 1.0
        self.camera = self.home

    def set_brush(self, on: bool) -> None:
        """Controls of pythreejs turn whatever is dragged: clicks alone paint, and they are picks anyway."""

    def _draw_texture(self) -> None:
        """Nothing: pythreejs shows the colours of a texture at the vertices, which are those of the field."""

    def set_legend(self, drawing: str) -> None:
        """Nothing: pythreejs saves no pictures."""

    def show_stills(self, urls: Sequence[str]) -> None:
        """Pictures of the panes, for where the browser has no WebGL."""
        for fallback, url in zip(self._fallbacks, urls, strict=True):
            fallback.show(url)

    def on_redraw(self, callback: Callable[[], None]) -> None:
        """Call back when a reader of such pictures asks for new ones."""
        for fallback in self._fallbacks:
            fallback.redraw.on_click(lambda _: callback())

    def follow(self, clock: ipywidgets.Widget) -> None:
        """Take the time, in ticks, from the value of a clock in the browser, while it plays."""
        for pane in self._moving:
            pane.follow(clock)

    def play(self) -> None:
        """Draw all the time, at the time of the clock."""
        for pane in self._moving:
            pane.play()

    def pause(self, time: float) -> None:
        """Draw no longer than needed, and show the shapes at a time."""
        for pane in self._moving:
            pane.pause(time)

    def show_time(self, time: float) -> None:
        """The shapes at a time."""
        for pane in self._moving:
            pane.show(time)

    def close(self) -> None:
        """Free everything, here and in the browser."""
        self._on_camera.clear()
        for pane in self.panes:
            pane.close()
        for item in (self.widget, self._orbit, self._camera):
            close_tree(item)

    def _framed(self, pane: PythreejsPane, fallback: FallbackImage, title: str) -> ipywidgets.VBox:
        box = ipywidgets.Box([pane.renderer, fallback], layout={"width": f"{self.size[0] + 2}px"})
        box.add_class("qgeo-pane")
        return ipywidgets.VBox(
            [ipywidgets.HTML(title + pane.caption), box],
            layout={"margin": "0 6px 4px 0", "overflow": "visible"},
        )

    def _moved(self, change: Any) -> None:
        # Orbit controls report once at first, without having been touched.
        if not np.allclose(change["new"], change["old"], rtol=1e-6, atol=1e-6):
            self._camera_moved()
