"""The widget of a shape in motion, or of two side by side: one time for both."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from os import PathLike
from typing import Any

import numpy as np
import traitlets

from qgeo_filters._typing import FloatArray
from qgeo_filters.animation.pose_transfer import Transfer
from qgeo_filters.errors import ParameterError
from qgeo_filters.report.reel import standing_view, transfer_colors
from qgeo_filters.validation import checked_count
from qgeo_widgets.animation_input import animations_of
from qgeo_widgets.base import ShapeWidget
from qgeo_widgets.coloring import ATTRIBUTE, CARRIED
from qgeo_widgets.fields import ColorField, Field, number_field
from qgeo_widgets.player import FASTEST, LOOPS, REPEAT, SLOWEST, Player
from qgeo_widgets.rendering.backends import new_viewer
from qgeo_widgets.rendering.motion import Motion, placements_of
from qgeo_widgets.rendering.pane import CLAY
from qgeo_widgets.rendering.viewer import Viewer
from qgeo_widgets.shape import Shape
from qgeo_widgets.snapshot_figure import Form

PLAIN = "plain"


class AnimateWidget(ShapeWidget):
    """An animation with its controls; see `qgeo_widgets.animate`.

    Attributes
    ----------
    time : float
        What is shown, in the unit of the animation's times; between two frames on straight lines. While it plays, it
        follows the browser.
    playing : bool
    speed : float
        From 0.05 to 20; 1 is as given.
    loop : str
        At the end: "repeat", "back and forth" or "once".
    frame : int
        The frame nearest to the time; setting it sets the time.
    """

    _page_title = "A shape in motion"
    time = traitlets.Float(0.0)
    playing = traitlets.Bool(False)
    speed = traitlets.Float(1.0)
    loop: traitlets.Unicode[str, str | bytes] = traitlets.Unicode(REPEAT)
    frame = traitlets.Int(0)

    def __init__(self, animation: Any, *, size: tuple[int, int], seconds: float | None, attribute: str | None) -> None:
        super().__init__()
        self._ticking = False
        self._player: Player | None = None
        with self._guarded():
            named = animations_of(animation)
            self._times = named[-1][1].times
            self._shapes = [Shape(moving.surface, name, repair=False) for name, moving in named]
            animations = [moving for _, moving in named]
            player = Player(self._times, _checked_seconds(seconds, len(self._times)))
            transfer = animations[-1]
            if isinstance(transfer, Transfer) and len(animations) == 2 and transfer.place is not None:
                colors = transfer_colors(animations[0].surface, transfer.place, standing_view(transfer))
                self._modes[CARRIED] = partial(self._carried_field, colors)
            self._modes[PLAIN] = self._plain_field
            for name in {name: None for shape in self._shapes for name in shape.surface.attributes}:
                self._modes[ATTRIBUTE + name] = partial(self._attribute_field, name)
            mode = next(iter(self._modes)) if attribute is None else ATTRIBUTE + attribute
            if mode not in self._modes:
                there = (name for name in self._modes if name.startswith(ATTRIBUTE))
                known = ", ".join(name.removeprefix(ATTRIBUTE) for name in there) or "none"
                raise ParameterError(f"there is no attribute {attribute!r} (there are: {known})")
            placements = placements_of(animations)
            motions = [Motion(*each) for each in zip(animations, placements, strict=True)]
            titles = [f"<b>{shape.name}</b>, {shape.surface.n_vertices} vertices" for shape in self._shapes]
            viewer = new_viewer([shape.surface for shape in self._shapes], placements, size, titles, motions)
            self._player = player
            self.time = float(self._times[0])
            self._assemble(viewer, [shape.name for shape in self._shapes], mode)
            self._mode_list.layout.display = "" if len(self._modes) > 1 else "none"
            self.children = [*self.children[:2], player.row, *self.children[2:]]
            self._connect(player, viewer)

    def _connect(self, player: Player, viewer: Viewer) -> None:
        viewer.follow(player.clock)
        player.set_speed(self.speed)
        player.button.on_click(lambda _: self.set_trait("playing", not self.playing))
        player.clock.observe(self._ticked, "value")
        player.clock.observe(lambda change: self.set_trait("playing", change["new"]), "playing")
        player.slider.observe(self._slid, "value")
        traitlets.link((self, "speed"), (player.speed, "value"))
        traitlets.link((self, "loop"), (player.loop, "value"))
        self.observe(lambda _: self._show_time(), "time")
        self.observe(lambda change: self._go_to_frame(change["new"]), "frame")
        self.observe(lambda change: self._play_or_pause(change["new"]), "playing")
        self.observe(lambda change: player.set_speed(change["new"]), "speed")
        self.observe(lambda change: player.set_loop(change["new"]), "loop")

    # -- checks -------------------------------------------------------------------------------------

    @traitlets.validate("time")
    def _valid_time(self, proposal: Any) -> float:
        time = float(proposal["value"])
        if self._viewer is not None and not self._times[0] <= time <= self._times[-1]:
            raise ParameterError(f"time must be from {self._times[0]:g} to {self._times[-1]:g}, got {time!r}")
        return time

    @traitlets.validate("frame")
    def _valid_frame(self, proposal: Any) -> int:
        if self._viewer is None:
            return int(proposal["value"])
        return checked_count(proposal["value"], 0, len(self._times) - 1, "frame")

    @traitlets.validate("speed")
    def _valid_speed(self, proposal: Any) -> float:
        speed = float(proposal["value"])
        if not SLOWEST <= speed <= FASTEST:
            raise ParameterError(f"speed must be from {SLOWEST:g} to {FASTEST:g}, got {speed!r}")
        return speed

    @traitlets.validate("loop")
    def _valid_loop(self, proposal: Any) -> str:
        if proposal["value"] not in LOOPS:
            raise ParameterError(f"loop must be one of {', '.join(LOOPS)}, got {proposal['value']!r}")
        return str(proposal["value"])

    @traitlets.validate("playing")
    def _valid_playing(self, proposal: Any) -> bool:
        # Nothing moves where nothing is shown, or in a single frame.
        return bool(proposal["value"]) and self._viewer is not None and len(self._times) > 1

    # -- time ---------------------------------------------------------------------------------------

    def _ticked(self, change: Any) -> None:
        """The clock went on in the browser, which has drawn the shape at that time already."""
        if self._ticking or self._player is None:
            return
        self._ticking = True
        try:
            self.time = self._player.time_of(change["new"])
        finally:
            self._ticking = False

    def _slid(self, change: Any) -> None:
        if abs(change["new"] - self.time) > 1e-9 * (self._times[-1] - self._times[0]):
            self.time = float(np.clip(change["new"], self._times[0], self._times[-1]))

    def _show_time(self) -> None:
        if self._viewer is None or self._player is None:
            return
        self.frame = int(np.abs(self._times - self.time).argmin())
        self._player.show(self.time)
        if not self._ticking:
            self._ticking = True  # what the clock now says is not news
            try:
                self._player.go_to(self.time)
            finally:
                self._ticking = False
        if not self.playing:
            self._viewer.show_time(self.time)

    def _go_to_frame(self, frame: int) -> None:
        if self._viewer is not None and frame != int(np.abs(self._times - self.time).argmin()):
            self.time = float(self._times[frame])

    def _play_or_pause(self, playing: bool) -> None:
        if self._viewer is None or self._player is None:
            return
        self._player.run(playing)
        if playing:
            self._viewer.play()
        else:
            self._viewer.pause(self.time)

    # -- colours ------------------------------------------------------------------------------------

    def _columns(self, mode: str) -> int:
        if not mode.startswith(ATTRIBUTE):
            return 1
        return max(shape.columns(mode.removeprefix(ATTRIBUTE)) for shape in self._shapes)

    def _carried_field(self, colors: tuple[FloatArray, FloatArray], k: int) -> Field:
        return ColorField(list(colors), "each point of Y has the colour of its partner on X; on X it tells the place")

    def _plain_field(self, k: int) -> Field:
        return ColorField([np.tile(CLAY, (shape.surface.n_vertices, 1)) for shape in self._shapes], "")

    def _attribute_field(self, name: str, k: int) -> Field:
        return number_field([shape.attribute_or_nan(name, k) for shape in self._shapes], name)

    # -- pictures and pages -------------------------------------------------------------------------

    def snapshot(self, path: str | PathLike[str] | None = None, *, dpi: int = 144, form: Form | None = None) -> bytes:
        """PNG or SVG of what is shown at this time, see `ShapeWidget.snapshot`."""
        self._pose()
        return super().snapshot(path, dpi=dpi, form=form)

    def to_html(self, path: str | PathLike[str], *, modes: Sequence[str] | None = None) -> None:
        """Write one web page that plays anywhere, offline, with the controls of the widget.

        Parameters
        ----------
        path : path
        modes : sequence of str, optional
            Which of `modes` the page offers; all by default.

        Notes
        -----
        The page holds 16 characters for each vertex of each frame, at most about 45 million a shape: what is drawn is
        what the widget draws, see `qgeo_widgets.animate`.
        """
        super().to_html(path, modes=modes)

    def close(self) -> None:
        """Free everything, here and in the browser."""
        self._player = None
        super().close()

    def _draw_stills(self) -> None:
        self._pose()
        super()._draw_stills()

    def _pose(self) -> None:
        for pane in self._viewer.panes if self._viewer is not None else ():
            pane.pose(self.time)

    def _page_extras(self) -> dict[str, Any]:
        from qgeo_widgets.export import motion_data

        if self._player is None:
            return {}
        state = {"time": self.time, "speed": self.speed, "loop": str(self.loop), "seconds": self._player.seconds}
        return {"motion": motion_data(self._open_viewer.panes[0].motion, state)}


def _checked_seconds(seconds: float | None, frames: int) -> float:
    """How long one pass takes: as given, else a fifteenth of a second a frame, but neither a blink nor a wait."""
    if seconds is None:
        return float(np.clip(frames / 15, 2.0, 12.0))
    if isinstance(seconds, bool) or not isinstance(seconds, (int, float, np.number)) or not 0.1 <= seconds <= 3600:
        raise ParameterError(f"seconds must be a number from 0.1 to 3600, got {seconds!r}")
    return float(seconds)
