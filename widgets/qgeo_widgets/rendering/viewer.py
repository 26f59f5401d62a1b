"""A few pictures of surfaces under one camera: what the widgets see of whatever draws them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, ClassVar

import ipywidgets
import numpy as np

from qgeo_filters.errors import ParameterError
from qgeo_filters.surface import Surface
from qgeo_widgets.rendering.camera_view import CameraView
from qgeo_widgets.rendering.motion import Motion
from qgeo_widgets.rendering.pane import Pane
from qgeo_widgets.rendering.scene_placement import ScenePlacement, reach
from qgeo_widgets.texture import Texture

FIELD_OF_VIEW = 26.0

Place = tuple[float, float, float]


class Viewer(ABC):
    """Surfaces side by side, turned together.

    Parameters
    ----------
    surfaces, placements : sequence of Surface and of ScenePlacement
        At least one, at most `MOST_SHAPES`.
    size : (int, int)
        Of each canvas, in pixels.
    titles : sequence of str
        HTML.
    motions : sequence of Motion, optional
        Of surfaces that move; the first view then shows all that they come to, whole.

    Attributes
    ----------
    home : (float, float, float)
        Where the camera stands at first, in scene units; it looks at the origin.
    mark_radius : float
        Of the balls that mark points, in scene units.
    texture : Texture or None
    widget : ipywidgets.Widget
        What is displayed.
    """

    #: How many surfaces one viewer can show.
    MOST_SHAPES: ClassVar[int] = 24
    widget: ipywidgets.Box
    panes: Sequence[Pane]

    def __init__(
        self,
        surfaces: Sequence[Surface],
        placements: Sequence[ScenePlacement],
        size: tuple[int, int],
        titles: Sequence[str],
        motions: Sequence[Motion] = (),
    ) -> None:
        if not 1 <= len(surfaces) <= self.MOST_SHAPES:
            raise ParameterError(f"a viewer shows 1 to {self.MOST_SHAPES} shapes, not {len(surfaces)}")
        slope, aspect = float(np.tan(np.radians(FIELD_OF_VIEW / 2))), size[0] / size[1]
        if motions:
            radius, distance = np.max([motion.reach(slope, aspect) for motion in motions], axis=0).tolist()
        else:
            placed = zip(surfaces, placements, strict=True)
            seen = [placement.to_scene(surface.vertices[np.unique(surface.faces)]) for surface, placement in placed]
            radius, distance = np.max([reach(points, slope, aspect) for points in seen], axis=0).tolist()
        self.size = size
        self.radius = radius
        self.home: Place = (0.0, 0.0, 1.05 * distance)
        self.mark_radius = 0.022 * radius
        self.texture: Texture | None = None
        self._on_camera: list[Callable[[Place], None]] = []
        moving: Sequence[Motion | None] = motions or [None] * len(surfaces)
        self._make(list(zip(surfaces, placements, moving, strict=True)), titles)

    # -- the camera ---------------------------------------------------------------------------------

    @property
    @abstractmethod
    def camera(self) -> Place:
        """Position of the camera in scene units; it looks at `target`."""

    @camera.setter
    @abstractmethod
    def camera(self, position: Sequence[float]) -> None: ...

    @property
    @abstractmethod
    def target(self) -> Place:
        """What the camera looks at: the origin unless it was moved."""

    @target.setter
    @abstractmethod
    def target(self, point: Sequence[float]) -> None: ...

    @abstractmethod
    def reset(self) -> None:
        """Back to where the camera was at first."""

    @property
    def zoom(self) -> float:
        """How many times as large as from where it stands the camera shows things."""
        return 1.0

    @property
    def look(self) -> dict[str, Any]:
        """How the shapes are drawn, as the panel of the view sets it; empty where nothing was set, or can be."""
        return {}

    def camera_view(self) -> CameraView:
        """What the camera sees, for pictures of it."""
        slope = float(np.tan(np.radians(FIELD_OF_VIEW / 2))) / self.zoom
        return CameraView(np.asarray(self.camera), np.asarray(self.target), slope, self.size[0] / self.size[1])

    def on_camera(self, callback: Callable[[Place], None]) -> None:
        """Call back with the camera's position whenever it was moved."""
        self._on_camera.append(callback)

    # -- what else widgets do -----------------------------------------------------------------------

    def on_pick(self, callback: Callable[[int, int], None]) -> None:
        """Call back with the number of the pane and the vertex nearest to each point that is clicked."""
        for number, pane in enumerate(self.panes):
            pane.on_pick(partial(callback, number))

    def put_beside(self, widget: ipywidgets.Widget, *, first: bool = False) -> None:
        """Put a widget after the pictures, or before them."""
        self.widget.children = (widget, *self.widget.children) if first else (*self.widget.children, widget)

    @abstractmethod
    def set_brush(self, on: bool) -> None:
        """Whether a press on a shape paints, and does not turn it: each point that is painted is a pick."""

    @contextmanager
    def together(self) -> Iterator[None]:
        """What is changed meanwhile is sent at once."""
        yield

    def set_texture(self, texture: Texture | None) -> None:
        """The picture that panes show at the places of their vertices, see `Pane.set_places`."""
        self.texture = texture
        self._draw_texture()

    @abstractmethod
    def _draw_texture(self) -> None:
        """Send `texture`, where the backend shows any."""

    @abstractmethod
    def set_legend(self, drawing: str) -> None:
        """The legend as SVG, for pictures that the browser saves, where it does."""

    @abstractmethod
    def show_stills(self, urls: Sequence[str]) -> None:
        """Pictures of the panes, for where the browser can draw nothing itself."""

    @abstractmethod
    def on_redraw(self, callback: Callable[[], None]) -> None:
        """Call back when a reader of such pictures asks for new ones."""

    # -- motion -------------------------------------------------------------------------------------

    @abstractmethod
    def follow(self, clock: ipywidgets.Widget) -> None:
        """Take the time, in ticks, from the value of a clock in the browser, while it plays."""

    @abstractmethod
    def play(self) -> None:
        """Draw all the time, at the time of the clock."""

    @abstractmethod
    def pause(self, time: float) -> None:
        """Draw no longer than needed, and show the shapes at a time."""

    @abstractmethod
    def show_time(self, time: float) -> None:
        """The shapes at a time."""

    # -- for backends, and the end ------------------------------------------------------------------

    @abstractmethod
    def _make(self, shown: Sequence[tuple[Surface, ScenePlacement, Motion | None]], titles: Sequence[str]) -> None:
        """Make `panes` and `widget`."""

    def _camera_moved(self) -> None:
        for callback in self._on_camera:
            callback(self.camera)

    @abstractmethod
    def close(self) -> None:
        """Free everything, here and in the browser."""


def checked_camera(position: Sequence[float]) -> Place:
    """Where a camera can stand, or `ParameterError`."""
    place = np.asarray(position, dtype=np.float64)
    if place.shape != (3,) or not np.isfinite(place).all() or not place.any():
        raise ParameterError(f"camera must be three finite numbers, not all zero, got {position!r}")
    x, y, z = place.tolist()
    return x, y, z


def place_of(values: Any) -> Place:
    """Three numbers as a tuple."""
    x, y, z = (float(value) for value in values)
    return x, y, z
