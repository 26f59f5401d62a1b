"""Controls of an animation, and its clock: which ticks in the browser, so that the motion needs no kernel."""

from __future__ import annotations

import ipywidgets
import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_widgets import controls
from qgeo_widgets.rendering.motion import TICKS

REPEAT, BACK_AND_FORTH, ONCE = "repeat", "back and forth", "once"
LOOPS = (REPEAT, BACK_AND_FORTH, ONCE)
SLOWEST, FASTEST = 0.05, 20.0
_INTERVAL = 40  # milliseconds between ticks


class Player:
    """A row of controls (play, time, speed, loop) and a clock that runs from 0 to `TICKS`, or twice that and so back.

    Parameters
    ----------
    times : (k,) float64
        Of the frames.
    seconds : float
        From the first to the last at speed 1.
    """

    def __init__(self, times: FloatArray, seconds: float) -> None:
        self._first, self._last = float(times[0]), float(times[-1])
        self.seconds = seconds
        span = self._last - self._first
        # Only what is in the page ticks, so that it is there, unseen: its own buttons know neither speed nor way back.
        self.clock = ipywidgets.Play(
            min=0, max=TICKS, value=0, interval=_INTERVAL, repeat=True, layout={"display": "none"}
        )
        self.button = controls.button("play", "play or pause")
        self.button.icon = "play"
        digits = 2 if span <= 0 else max(0, 2 - int(np.floor(np.log10(span))))
        self.slider = controls.number(
            "time",
            self._first,
            self._first,
            self._last,
            span / 1000 or 1.0,
            digits=f".{min(digits, 6)}f",
            width="420px",
        )
        self.speed = ipywidgets.FloatLogSlider(
            value=1.0, base=10, min=np.log10(SLOWEST), max=np.log10(FASTEST), step=0.01, description="speed",
            readout_format=".2f", style={"description_width": "auto"},
            layout=controls.at_most("230px"),
        )  # fmt: skip
        self.loop = controls.choice("loop", LOOPS, REPEAT)
        self.row = controls.row(self.clock, self.button, self.slider, self.speed, self.loop)
        if span == 0:
            self.row.layout.display = "none"  # a single frame

    def time_of(self, tick: int) -> float:
        """Time at a tick of the clock."""
        there = 1.0 - abs(tick / TICKS - 1.0) if tick > TICKS else tick / TICKS
        # Weighted so that the ends are exact.
        return float((1.0 - there) * self._first + there * self._last)

    def go_to(self, time: float) -> None:
        """Set the clock to a time; where it runs back, it goes on back."""
        span = self._last - self._first
        tick = round(TICKS * (time - self._first) / span) if span else 0
        if self.time_of(self.clock.value) != time:
            self.clock.value = 2 * TICKS - tick if self.clock.value > TICKS else tick

    def show(self, time: float) -> None:
        """Put the slider to a time."""
        self.slider.value = time

    def run(self, playing: bool) -> None:
        """Start or stop the clock."""
        if playing and self.clock.value >= self.clock.max:
            self.clock.value = 0
        self.clock.playing = playing
        self.button.description = "pause" if playing else "play"
        self.button.icon = "pause" if playing else "play"

    def set_speed(self, speed: float) -> None:
        """How many times as fast as at first."""
        self.clock.step = max(1, round(TICKS * speed * 0.001 * _INTERVAL / self.seconds))

    def set_loop(self, loop: str) -> None:
        """What happens at the end, one of `LOOPS`."""
        end = 2 * TICKS if loop == BACK_AND_FORTH else TICKS
        if self.clock.value > end:
            self.clock.value = 2 * TICKS - self.clock.value
        self.clock.max = end
        self.clock.repeat = loop != ONCE
