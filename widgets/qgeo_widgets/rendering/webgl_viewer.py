"""The backend of our own browser module: all surfaces of a viewer in one WebGL context, through anywidget."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import ipywidgets
import numpy as np

from qgeo_filters.surface import Surface
from qgeo_widgets.rendering.disposal import close_tree
from qgeo_widgets.rendering.encoding import line_data, mark_data, paint_data, scene_data, with_bytes
from qgeo_widgets.rendering.motion import TICKS, Motion
from qgeo_widgets.rendering.pane import Pane
from qgeo_widgets.rendering.scene_placement import ScenePlacement
from qgeo_widgets.rendering.scene_widget import SceneWidget
from qgeo_widgets.rendering.viewer import Place, Viewer, checked_camera, place_of


class WebglPane(Pane):
    """A pane of a `SceneWidget`: whatever changes is sent with what changes on the others."""

    def __init__(
        self, surface: Surface, placement: ScenePlacement, motion: Motion | None, changed: Callable[[str], None]
    ) -> None:
        super().__init__(surface, placement, motion)
        self._changed = changed

    def _draw_colors(self) -> None:
        self._changed("paints")

    def _draw_regions(self) -> None:
        self._changed("paints")

    def _draw_values(self) -> None:
        self._changed("paints")

    def _draw_cells(self) -> None:
        self._changed("paints")

    def _draw_places(self) -> None:
        self._changed("paints")

    def _draw_mark(self, slot: str) -> None:
        self._changed("marks")

    def _draw_line(self, slot: str) -> None:
        self._changed("lines")


class WebglViewer(Viewer):
    """Surfaces in one canvas, a part of it each; see `Viewer`."""

    def _make(self, shown: Sequence[tuple[Surface, ScenePlacement, Motion | None]], titles: Sequence[str]) -> None:
        self._waiting: set[str] | None = None
        self.panes: Sequence[WebglPane] = [WebglPane(*each, self._changed) for each in shown]
        self._scene = SceneWidget(
            setup=with_bytes(scene_data(self, titles)),
            camera={"position": list(self.home), "target": [0.0, 0.0, 0.0]},
            **{name: self._data(name) for name in ("paints", "marks", "lines")},
            layout={"overflow": "visible"},  # the rest is the style sheet's
        )
        self._scene.observe(self._moved, names="camera")
        self._scene.on_msg(self._told)
        self._on_redraw: list[Callable[[], None]] = []
        self._clock_link: Any = None
        self._clock: Any = None
        self.widget = ipywidgets.HBox([self._scene], layout={"flex_flow": "row wrap", "overflow": "visible"})

    # -- the camera ---------------------------------------------------------------------------------

    @property
    def camera(self) -> Place:
        """Position of the camera in scene units."""
        return place_of(self._scene.camera["position"])

    @camera.setter
    def camera(self, position: Sequence[float]) -> None:
        self._scene.camera = {**self._scene.camera, "position": list(checked_camera(position))}

    @property
    def target(self) -> Place:
        """What the camera looks at."""
        return place_of(self._scene.camera["target"])

    @target.setter
    def target(self, point: Sequence[float]) -> None:
        self._scene.camera = {**self._scene.camera, "target": list(place_of(point))}

    def reset(self) -> None:
        """Back to where the camera was at first."""
        self._scene.camera = {"position": list(self.home), "target": [0.0, 0.0, 0.0]}

    @property
    def look(self) -> dict[str, Any]:
        """What the panel of the view sets."""
        return dict(self._scene.look)

    # -- what is shown ------------------------------------------------------------------------------

    @contextmanager
    def together(self) -> Iterator[None]:
        """What is changed meanwhile is sent at once."""
        self._waiting = set()
        try:
            yield
        finally:
            names, self._waiting = self._waiting, None
            for name in sorted(names):
                self._changed(name)

    def show_stills(self, urls: Sequence[str]) -> None:
        """Pictures of the panes, for where the browser has no WebGL."""
        self._scene.stills = list(urls)

    def _draw_texture(self) -> None:
        self._scene.texture = b"" if self.texture is None else self.texture.encoded.tobytes()

    def set_legend(self, drawing: str) -> None:
        """The legend as SVG, for pictures that the browser saves."""
        self._scene.legend = drawing

    def on_redraw(self, callback: Callable[[], None]) -> None:
        """Call back when a reader of such pictures asks for new ones."""
        self._on_redraw.append(callback)

    def set_brush(self, on: bool) -> None:
        """Whether a press on a shape paints, and does not turn it."""
        self._scene.brush = on

    # -- motion -------------------------------------------------------------------------------------

    def follow(self, clock: ipywidgets.Widget) -> None:
        """Take the time, in ticks, from the value of a clock in the browser, while it plays."""
        self._clock = clock

    def play(self) -> None:
        """Draw all the time, at the time of the clock."""
        if self._clock_link is None and self._clock is not None:
            self._clock_link = ipywidgets.jsdlink((self._clock, "value"), (self._scene, "tick"))

    def pause(self, time: float) -> None:
        """Draw no longer than needed, and show the shapes at a time."""
        if self._clock_link is not None:
            self._clock_link.unlink()
            self._clock_link = None
        self.show_time(time)

    def show_time(self, time: float) -> None:
        """The shapes at a time."""
        motion = self.panes[0].motion
        if motion is not None and len(motion.times) > 1:
            first, last = motion.times[[0, -1]]
            self._scene.tick = float(TICKS * (time - first) / (last - first))

    # -- inside -------------------------------------------------------------------------------------

    def _changed(self, name: str) -> None:
        if self._waiting is not None:
            self._waiting.add(name)
        else:
            setattr(self._scene, name, self._data(name))

    def _data(self, name: str) -> list[Any]:
        """What the browser gets of all panes under a name."""
        of_pane: dict[str, Callable[[Pane], Any]] = {
            "paints": paint_data,
            "marks": lambda pane: [mark_data(pane, *each) for each in pane.marks.items()],
            "lines": lambda pane: [line_data(pane, *each) for each in pane.lines.items()],
        }
        return with_bytes([of_pane[name](pane) for pane in self.panes])

    def _moved(self, change: Any) -> None:
        if not np.allclose(change["new"]["position"], change["old"].get("position", np.inf), rtol=1e-9, atol=1e-9):
            self._camera_moved()

    def _told(self, _: Any, content: dict[str, Any], buffers: Any) -> None:
        """A message of the view."""
        if content.get("kind") in ("pick", "paint") and 0 <= content["pane"] < len(self.panes):
            self.panes[content["pane"]].clicked(content["corners"], content["point"])
        elif content.get("kind") == "redraw":
            for callback in self._on_redraw:
                callback()

    def close(self) -> None:
        """Free everything, here and in the browser."""
        self._on_camera.clear()
        self._on_redraw.clear()
        for pane in self.panes:
            pane.close()
        if self._clock_link is not None:
            close_tree(self._clock_link)
        close_tree(self.widget)
