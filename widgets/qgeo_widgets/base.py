"""What every widget of the package has: modes that colour shapes, limits, camera, messages, snapshots, pages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any

import ipywidgets
import traitlets

from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import ParameterError
from qgeo_widgets import controls
from qgeo_widgets.disposal import close_tree
from qgeo_widgets.fields import Field, ScalarField
from qgeo_widgets.guarded import GuardedWidget
from qgeo_widgets.offscreen import data_url, pane_picture, png_url, snapshot
from qgeo_widgets.viewer import Viewer

EIGENFUNCTION = "eigenfunction"
ATTRIBUTE = "attribute: "


def chosen(vertex: int | None) -> int:
    """The vertex, where one must have been chosen."""
    if vertex is None:
        raise RuntimeError("no vertex was chosen, and what needs one was asked for")
    return vertex


class ShapeWidget(GuardedWidget):
    """Shapes coloured by a choice of modes, with a legend, a range slider and a line for messages.

    A subclass makes its viewer, fills ``_modes`` and calls ``_assemble``, all within ``_guarded``: what a user can
    mend is then a sentence in the widget, and the widget stays usable. A bug is raised where it happens.

    Attributes
    ----------
    mode : str
        What colours the shapes, one of `modes`. An unknown name leaves the mode and sets `message`.
    k : int
        Which eigenfunction, or which column of an attribute, from 1.
    limits : (float, float) or None
        Values of the first and the last colour; None is automatic. Set to None by a change of mode.
    camera : (float, float, float)
        Where the camera stands; it looks at the origin of a scene in which sqrt(area) of each shape is 1.
    message, hint : str
        See `GuardedWidget`.
    """

    _page_title = "Shapes"
    mode: traitlets.Unicode[str, str | bytes] = traitlets.Unicode()
    k = traitlets.Int(1, min=1)
    limits = traitlets.Tuple(traitlets.Float(), traitlets.Float(), default_value=None, allow_none=True)
    camera = traitlets.Tuple(traitlets.Float(), traitlets.Float(), traitlets.Float(), default_value=(0.0, 0.0, 1.0))

    def __init__(self) -> None:
        self._modes: dict[str, Callable[[int], Field]] = {}
        self._viewer: Viewer | None = None
        self._field: Field | None = None
        self._titles: Sequence[str] = ()
        self._settling = False
        super().__init__()

    # -- for subclasses -----------------------------------------------------------------------------

    @property
    def _open_viewer(self) -> Viewer:
        """The viewer, where there must be one."""
        if self._viewer is None:
            raise RuntimeError("the widget was closed, or never came to show anything")
        return self._viewer

    def _assemble(
        self,
        viewer: Viewer,
        titles: Sequence[str],
        mode: str,
        *,
        beside: Sequence[ipywidgets.Widget] = (),
        below: Sequence[ipywidgets.Widget] = (),
    ) -> None:
        """Put the parts together and show the first mode; more controls beside the list of modes, more lines below."""
        self._viewer = viewer
        self._titles = titles
        self._mode_list = controls.choice("colour", list(self._modes), mode)
        self._k_slider = controls.whole("k", 1, 1, 20)
        self._span_slider = controls.span()
        self._legend = ipywidgets.HTML(layout={"margin": "0 10px 0 0"})
        self._info = ipywidgets.HTML()
        self._saved = ipywidgets.HTML()
        reset = controls.button("reset view", "back to the first view")
        reset.on_click(lambda _: viewer.reset())
        picture = controls.button("snapshot", "a picture of what is shown, to save")
        picture.on_click(lambda _: self._offer_snapshot())
        for fallback in viewer.fallbacks:
            fallback.redraw.on_click(lambda _: self._draw_fallbacks())
        viewer.on_camera(lambda position: self.set_trait("camera", position))
        self.camera = viewer.camera
        self.observe(self._camera_set, "camera")
        self.observe(lambda _: self._refresh(new_mode=True), "mode")
        self.observe(lambda _: self._refresh(new_mode=True), "k")
        self.observe(lambda _: self._refresh(), "limits")
        self._span_slider.observe(self._span_moved, "value")
        traitlets.link((self, "k"), (self._k_slider, "value"))
        self.children = [
            controls.row(self._mode_list, self._k_slider, *beside, reset, picture, self._saved),
            viewer.widget,
            controls.row(self._legend, self._span_slider),
            self._info,
            *below,
            self._message_line,
        ]
        self.mode = mode
        traitlets.link((self, "mode"), (self._mode_list, "value"))

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
            if new_mode:
                count = self._columns(self.mode)
                self._k_slider.max = max(count, 1)
                self._k_slider.layout.display = "" if count > 1 else "none"
            self.hint = self._missing(self.mode)
            if self.hint:
                return
            field = self._modes[self.mode](self.k)
            self._field = field
            self._settling = True
            try:
                if new_mode:
                    self.set_trait("limits", None)
                self._show_span(field)
            finally:
                self._settling = False
            for pane, colors in zip(self._viewer.panes, field.colors(self.limits), strict=True):
                pane.set_colors(colors)
            self._legend.value = field.legend(self.limits)

    # -- for users ----------------------------------------------------------------------------------

    @property
    def modes(self) -> tuple[str, ...]:
        """Names that `mode` can take."""
        return tuple(self._modes)

    def reset_view(self) -> None:
        """Put the camera back to where it was at first."""
        if self._viewer is not None:
            self._viewer.reset()

    def snapshot(self, path: str | PathLike[str] | None = None) -> bytes:
        """PNG of what is shown, with titles and colour bar, drawn in software; written to the path if given."""
        if self._viewer is None:
            raise ParameterError(f"there is nothing to draw: {self.message}")
        png = snapshot(self._viewer, self._titles, self._field, self.limits)
        if path is not None:
            with atomic_write(path) as file:
                file.write(png)
        return png

    def to_html(self, path: str | PathLike[str], *, modes: Sequence[str] | None = None) -> None:
        """Write one web page that opens anywhere, offline: shapes that turn together, modes, marks, partners.

        Parameters
        ----------
        path : path
        modes : sequence of str, optional
            Which modes the page offers; by default all of `modes` that can be shown now.
        """
        from qgeo_widgets.export import Page, write_page

        if self._viewer is None:
            raise ParameterError(f"there is nothing to write: {self.message}")
        unknown = set(modes or ()) - set(self._modes)
        if unknown:
            raise ParameterError(f"unknown modes {sorted(unknown)}; there are {', '.join(self._modes)}")
        chosen = modes or [name for name in self.modes if not self._missing(name)]
        for name in chosen:
            if self._missing(name):
                raise ParameterError(f"mode {name!r} cannot be written yet. {self._missing(name)}")
        page = Page(
            title=self._page_title,
            names=self._titles,
            modes=[(name, [self._modes[name](k + 1) for k in range(self._columns(name))]) for name in chosen],
            start=list(chosen).index(self.mode) if self.mode in chosen else 0,
            step=min(self.k, self._columns(self.mode)),
            limits=self.limits,
            **{"info": self._info.value, **self._page_extras()},
        )
        write_page(path, self._viewer, page, data_url(self.snapshot()))

    def close(self) -> None:
        """Free everything, here and in the browser."""
        if self._viewer is not None:
            self._viewer.close()
        self._viewer = None
        self._field = None
        self._modes = {}
        self.unobserve_all()
        close_tree(self)

    # -- inside -------------------------------------------------------------------------------------

    def _page_extras(self) -> dict[str, Any]:
        """What a page of this widget holds besides: keywords of `export.Page`."""
        return {}

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

    def _camera_set(self, change: Any) -> None:
        if self._viewer is not None and tuple(change["new"]) != self._viewer.camera:
            self._viewer.camera = change["new"]

    def _show_span(self, field: Field) -> None:
        bounds = field.bounds
        self._span_slider.layout.display = "none" if bounds is None or not bounds[1] > bounds[0] else ""
        if self.limits is None or bounds is None:
            self._span_slider.value = (0.0, 100.0)
        else:
            low, high = ((limit - bounds[0]) / ((bounds[1] - bounds[0]) or 1.0) for limit in self.limits)
            self._span_slider.value = (100 * min(max(low, 0.0), 1.0), 100 * min(max(high, 0.0), 1.0))

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

    def _offer_snapshot(self) -> None:
        with self._guarded():
            url = data_url(self.snapshot())
            self._saved.value = f'<a download="qgeo-snapshot.png" href="{url}">save snapshot.png</a>'

    def _draw_fallbacks(self) -> None:
        viewer = self._open_viewer
        for pane, fallback in zip(viewer.panes, viewer.fallbacks, strict=True):
            fallback.show(png_url(pane_picture(viewer, pane)))

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        bundle = super()._repr_mimebundle_(**kwargs)
        if self._viewer is None or not bundle:
            return bundle
        data, *rest = bundle if isinstance(bundle, tuple) else (bundle,)
        self._draw_fallbacks()
        # What shows no widgets (a code host, an exported notebook) shows this.
        data = {**data, "image/png": self.snapshot()}
        return (data, *rest) if isinstance(bundle, tuple) else data
