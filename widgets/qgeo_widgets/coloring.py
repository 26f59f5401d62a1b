"""What colours the shapes of a widget: its modes, their limits and legend, and the controls of all that."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ipywidgets
import numpy as np
import traitlets

from qgeo_filters.errors import ParameterError, QgeoError
from qgeo_widgets import controls
from qgeo_widgets.fields import ColorField, Field, RegionField, ScalarField
from qgeo_widgets.guarded import GuardedWidget
from qgeo_widgets.rendering.viewer import Viewer

EIGENFUNCTION = "eigenfunction"
CARRIED = "colours carried from X to Y"
ATTRIBUTE = "attribute: "


class ColoredWidget(GuardedWidget):
    """A choice of modes that colour shapes, with a legend and a range slider.

    Attributes
    ----------
    mode : str
        What colours the shapes, one of `modes`. One that is unknown, or cannot be shown, leaves the mode and sets
        `message`: the traits always say what the picture shows.
    k : int
        Which eigenfunction, or which column of an attribute, from 1.
    limits : (float, float) or None
        Values of the first and the last colour, finite and ascending; None is automatic. Set to None by a change of
        mode. Others, or any where colours stand for no numbers, raise `ParameterError`.
    """

    mode: traitlets.Unicode[str, str | bytes] = traitlets.Unicode()
    k = traitlets.Int(1, min=1)
    limits = traitlets.Tuple(traitlets.Float(), traitlets.Float(), default_value=None, allow_none=True)

    def __init__(self) -> None:
        self._modes: dict[str, Callable[[int], Field]] = {}
        self._viewer: Viewer | None = None
        self._field: Field | None = None
        self._shown: tuple[str, int] | None = None
        self._settling = False
        super().__init__()

    def _make_color_controls(self, mode: str) -> None:
        """List of modes, sliders of k and of the range, legend."""
        self._mode_list = controls.choice("colour", list(self._modes), mode)
        self._k_slider = controls.whole("k", 1, 1, 20)
        self._span_slider = controls.span()
        self._legend = ipywidgets.HTML(layout={"margin": "0 10px 0 0"})

    def _watch_color_controls(self) -> None:
        """Let traits follow the controls, the controls the traits, and the picture both."""
        self.observe(self._mode_set, "mode")
        self.observe(self._k_set, "k")
        self.observe(lambda _: self._refresh(), "limits")
        self._mode_list.observe(lambda change: self._choose(change["new"]), "value")
        self._k_slider.observe(lambda change: self.set_trait("k", change["new"]), "value")
        self._span_slider.observe(self._span_moved, "value")

    @property
    def _open_viewer(self) -> Viewer:
        """The viewer, where there must be one."""
        if self._viewer is None:
            raise RuntimeError("the widget was closed, or never came to show anything")
        return self._viewer

    def _missing(self, mode: str) -> str:
        """What there is to do before the mode can be shown, as a sentence; empty when nothing is."""
        return ""

    def _columns(self, mode: str) -> int:
        """How many values k has in a mode; 1 hides its slider."""
        return 1

    def _refresh(self, *, new_mode: bool = False) -> None:
        """Show the current mode: colours, legend and range; what did not change is not sent."""
        if self._viewer is None or self._settling or self.mode not in self._modes:
            return
        with self._guarded():
            self.hint = self._missing(self.mode)
            if self.hint:
                return
            try:
                self._paint(new_mode)
            except QgeoError:
                self._go_back()
                raise

    def _paint(self, new_mode: bool) -> None:
        """Colours, legend and controls of the current mode; nothing is changed where it cannot be shown."""
        viewer, mode = self._open_viewer, str(self.mode)
        count = max(self._columns(mode), 1)
        k = self.k if self._shown is not None and self._shown[0] == mode else min(self.k, count)
        with self._long.during(f"Finding what {mode!r} shows"):
            field = self._modes[mode](k)
        if str(self.mode) != mode:  # another was chosen meanwhile
            return
        limits = None if new_mode else self.limits
        colors = field.colors(limits)
        self._field = field
        self._settle(mode, k, count, new_mode)
        with viewer.together():
            for number, (pane, each) in enumerate(zip(viewer.panes, colors, strict=True)):
                pane.set_colors(each)
                if isinstance(field, RegionField):
                    pane.set_regions(field.numbers()[number], field.palette)
                    pane.set_values(field.numbers()[number], field.names)
                else:
                    pane.set_regions(None)
                    pane.set_values(field.values[number] if isinstance(field, ScalarField) else None)
                pane.set_cells(field.cells[number] if isinstance(field, ColorField) and field.cells else None)
                pane.set_places(field.places[number] if isinstance(field, ColorField) and field.places else None)
            viewer.set_legend(field.drawing(limits))
        self._legend.value = field.legend(limits)

    def _settle(self, mode: str, k: int, count: int, new_mode: bool) -> None:
        """Controls and traits say what is shown, and nothing is drawn anew for it."""
        self._shown = mode, k
        self._settling = True
        try:
            self._k_slider.max = count
            self._k_slider.layout.display = "" if count > 1 else "none"
            self.k = k
            if new_mode:
                self.set_trait("limits", None)
            if self._field is not None:
                self._show_span(self._field)
        finally:
            self._settling = False

    def _go_back(self) -> None:
        """To the mode that is still shown, after one that could not be."""
        if self._shown is None:
            return
        self._settling = True
        try:
            self.mode, self.k = self._shown
            self._mode_list.value = self.mode
        finally:
            self._settling = False

    @property
    def modes(self) -> tuple[str, ...]:
        """Names that `mode` can take."""
        return tuple(self._modes)

    # -- inside -------------------------------------------------------------------------------------

    @traitlets.validate("mode")
    def _known_mode(self, proposal: Any) -> str:
        wanted = proposal["value"]
        if self._modes and wanted not in self._modes:
            kind = (
                f"attribute {wanted.removeprefix(ATTRIBUTE)!r}" if wanted.startswith(ATTRIBUTE) else f"mode {wanted!r}"
            )
            self.message = f"There is no {kind} here; choose one of: {', '.join(self._modes)}."
            return self.mode
        return wanted

    @traitlets.validate("k")
    def _valid_k(self, proposal: Any) -> int:
        k, mode = int(proposal["value"]), str(self.mode)
        count = 0 if self._viewer is None or self._settling or mode not in self._modes else self._columns(mode)
        if count > 1 and k > count:
            raise ParameterError(f"k must be from 1 to {count} for {mode!r}, got {k}")
        return k

    @traitlets.validate("limits")
    def _valid_limits(self, proposal: Any) -> Any:
        limits = proposal["value"]
        if limits is None or self._viewer is None:
            return limits
        if not np.isfinite(limits).all() or not limits[0] < limits[1]:
            raise ParameterError(f"limits must be two finite numbers, the smaller one first, got {limits!r}")
        if self._field is not None and self._field.bounds is None:
            raise ParameterError(f"colours of {self.mode!r} stand for no numbers that limits could be of")
        return limits

    def _takes_long(self, mode: str) -> bool:
        """Whether a mode has to be computed first, for seconds and more."""
        return False

    def _choose(self, mode: str) -> None:
        """Show the mode that was chosen in the list; one that takes long in the background."""
        if mode == self.mode or not self._takes_long(mode):
            self.set_trait("mode", mode)
        elif not self._long.in_background(f"Finding what {mode!r} shows", lambda: self.set_trait("mode", mode)):
            self._mode_list.value = self.mode

    def _mode_set(self, change: Any) -> None:
        self._mode_list.value = self.mode
        self._refresh(new_mode=True)

    def _k_set(self, change: Any) -> None:
        self._k_slider.value = self.k
        self._refresh(new_mode=True)

    def _show_span(self, field: Field) -> None:
        bounds = field.bounds
        self._span_slider.layout.display = "none" if bounds is None or not bounds[1] > bounds[0] else ""
        if self.limits is None or bounds is None:
            self._span_slider.value = (0.0, 100.0)
        else:
            low, high = ((limit - bounds[0]) / ((bounds[1] - bounds[0]) or 1.0) for limit in self.limits)
            # In whole steps: a browser answers others with its own, and limits would become what it rounded them to.
            step = self._span_slider.step
            self._span_slider.value = tuple(step * round(100 * min(max(part, 0.0), 1.0) / step) for part in (low, high))

    def _span_moved(self, change: Any) -> None:
        if self._settling or self._field is None or self._field.bounds is None:
            return
        low, high = change["new"]
        if isinstance(self._field, ScalarField) and self._field.signed:
            # The scale stays centred: the handle that was moved decides.
            reach = abs(low - 50) if low != change["old"][0] else abs(high - 50)
            low, high = 50 - reach, 50 + reach
        if high > low:
            bottom, top = self._field.bounds
            self.limits = tuple(bottom + 0.01 * part * (top - bottom) for part in (low, high))
