"""What every widget of the package has: modes that colour shapes, limits, camera, messages, snapshots, pages."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from os import PathLike
from typing import TYPE_CHECKING, Any

import ipywidgets
import traitlets
from IPython.display import HTML, display

from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import ParameterError
from qgeo_filters.validation import checked_count
from qgeo_widgets import controls
from qgeo_widgets.cell_widgets import replace_earlier
from qgeo_widgets.coloring import ColoredWidget
from qgeo_widgets.offscreen import data_url, pane_picture, png_url, snapshot
from qgeo_widgets.rendering.disposal import close_tree
from qgeo_widgets.rendering.viewer import Viewer, checked_camera
from qgeo_widgets.saved_image import LIVE, display_with_image
from qgeo_widgets.snapshot_figure import FORMS, Chart, Form, Picture, picture_form

if TYPE_CHECKING:
    from qgeo_widgets.export import Page


def chosen(vertex: int | None) -> int:
    """The vertex, where one must have been chosen."""
    if vertex is None:
        raise RuntimeError("no vertex was chosen, and what needs one was asked for")
    return vertex


class ShapeWidget(ColoredWidget):
    """Shapes coloured by a choice of modes, with a legend, a range slider and a line for messages.

    A subclass makes its viewer, fills ``_modes`` and calls ``_assemble``, all within ``_guarded``: what a user can
    mend is then a sentence in the widget, and the widget stays usable. A bug is raised where it happens.

    Attributes
    ----------
    camera : (float, float, float)
        Where the camera stands; it looks at the origin of a scene in which sqrt(area) of each shape is 1 (of a part and
        a whole, of X).
    mode, k, limits
        What colours them, see `ColoredWidget`.
    message, hint : str
        What is to be said, see `GuardedWidget`.
    """

    _page_title = "Shapes"
    camera = traitlets.Tuple(traitlets.Float(), traitlets.Float(), traitlets.Float(), default_value=(0.0, 0.0, 1.0))

    def __init__(self) -> None:
        self._titles: Sequence[str] = ()
        super().__init__()
        replace_earlier(self)

    # -- for subclasses -----------------------------------------------------------------------------

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
        self._make_color_controls(mode)
        self._info = ipywidgets.HTML()
        self._saved = ipywidgets.HTML()
        reset = controls.button("reset view", "back to the first view")
        reset.on_click(lambda _: viewer.reset())
        picture = controls.button("snapshot", "a picture of what is shown, to save")
        picture.on_click(lambda _: self._offer_snapshot())
        viewer.on_redraw(self._draw_stills)
        viewer.on_camera(lambda position: self.set_trait("camera", position))
        self.camera = viewer.camera
        self.observe(self._camera_set, "camera")
        self._watch_color_controls()
        self.children = [
            controls.row(self._mode_list, self._k_slider, *beside, reset, picture, self._saved),
            viewer.widget,
            controls.row(self._legend, self._span_slider),
            self._info,
            *below,
            self._message_line,
            self._long,
        ]
        self.mode = mode

    # -- for users ----------------------------------------------------------------------------------

    def reset_view(self) -> None:
        """Put the camera back to where it was at first."""
        if self._viewer is not None:
            self._viewer.reset()

    def snapshot(self, path: str | PathLike[str] | None = None, *, dpi: int = 144, form: Form | None = None) -> bytes:
        """PNG or SVG of what is shown, from where the camera stands, with titles, legend and chart; drawn in software.

        Parameters
        ----------
        path : path, optional
            File that it is written to.
        dpi : int
            Pixels for an inch, of which 96 pixels on screen are one: 96 is as large as on screen. From 20 to 1200.
        form : {"png", "svg"}, optional
            SVG keeps titles, legend and chart as text and lines, and holds the shapes as pixels. By default what the
            path ends in, PNG without one.
        """
        checked_count(dpi, 20, 1200, "dpi")
        chosen_form = picture_form(path, form)
        if self._viewer is None:
            raise ParameterError(f"there is nothing to draw: {self.message}")
        before, chart = self._pictured()
        picture = snapshot(
            self._viewer, self._titles, self._field, self.limits,
            before=before, chart=chart, dpi=dpi, form=chosen_form,
        )  # fmt: skip
        if path is not None:
            with atomic_write(path) as file:
                file.write(picture)
        return picture

    def to_html(self, path: str | PathLike[str], *, modes: Sequence[str] | None = None) -> None:
        """Write one web page that opens anywhere, offline: shapes that turn together, modes, marks, partners.

        Parameters
        ----------
        path : path
        modes : sequence of str, optional
            Which modes the page offers; by default all of `modes` that can be shown now.
        """
        from qgeo_widgets.export import write_page

        page = self._page(modes)
        write_page(path, self._open_viewer, page, data_url(self.snapshot()))

    def embed(self, *, modes: Sequence[str] | None = None, height: int = 760) -> HTML:
        """The page of `to_html` as the output of a cell: live without a kernel, and offline in what nbconvert makes.

        Parameters
        ----------
        modes : sequence of str, optional
            Which modes the page offers, as of `to_html`.
        height : int
            Of the frame that holds the page, in pixels, as wide as the cell.

        Returns
        -------
        IPython.display.HTML
            The last line of a cell shows it. The notebook grows by the whole page, about a megabyte.
        """
        from qgeo_widgets.export import page_text

        checked_count(height, 100, 10_000, "height")
        page = self._page(modes)
        text = escape(page_text(self._open_viewer, page, data_url(self.snapshot())))
        style = f"width:100%;height:{height}px;border:0"
        return HTML(f'<div><iframe title="{escape(page.title)}" srcdoc="{text}" style="{style}"></iframe></div>')

    def _page(self, modes: Sequence[str] | None) -> Page:
        """What a page shows of this widget."""
        from qgeo_widgets.export import Page

        if self._viewer is None:
            raise ParameterError(f"there is nothing to write: {self.message}")
        unknown = set(modes or ()) - set(self._modes)
        if unknown:
            raise ParameterError(f"unknown modes {sorted(unknown)}; there are {', '.join(self._modes)}")
        chosen = modes or [name for name in self.modes if not self._missing(name)]
        for name in chosen:
            if self._missing(name):
                raise ParameterError(f"mode {name!r} cannot be written yet. {self._missing(name)}")
        return Page(
            title=self._page_title,
            names=self._titles,
            modes=[(name, [self._modes[name](k + 1) for k in range(self._columns(name))]) for name in chosen],
            start=list(chosen).index(self.mode) if self.mode in chosen else 0,
            step=min(self.k, self._columns(self.mode)),
            limits=self.limits,
            **{"info": self._info.value, **self._page_extras()},
        )

    def close(self) -> None:
        """Free everything, here and in the browser; what runs is cancelled."""
        self._long.cancel()
        if self._viewer is not None:
            self._viewer.close()
        self._viewer = None
        self._field = None
        self._modes = {}
        self.unobserve_all()
        close_tree(self)

    # -- inside -------------------------------------------------------------------------------------

    def _pictured(self) -> tuple[Sequence[tuple[str, Picture]], Chart | None]:
        """What a snapshot shows besides: pictures before the panes, with titles, and a chart below."""
        return (), None

    def _page_extras(self) -> dict[str, Any]:
        """What a page of this widget holds besides: keywords of `export.Page`."""
        return {}

    @traitlets.validate("camera")
    def _valid_camera(self, proposal: Any) -> tuple[float, ...]:
        return proposal["value"] if self._viewer is None else checked_camera(proposal["value"])

    def _camera_set(self, change: Any) -> None:
        if self._viewer is not None and tuple(change["new"]) != self._viewer.camera:
            self._viewer.camera = change["new"]

    def _offer_snapshot(self) -> None:
        with self._guarded():
            pictures = {form: data_url(self.snapshot(form=form), form) for form in FORMS}
            links = [
                f'<a download="qgeo-snapshot.{form}" href="{url}">{form.upper()}</a>' for form, url in pictures.items()
            ]
            self._saved.value = f"save snapshot: {', '.join(links)}"

    def _draw_stills(self) -> None:
        viewer = self._open_viewer
        viewer.show_stills([png_url(pane_picture(viewer, pane)) for pane in viewer.panes])

    def _ipython_display_(self, **kwargs: Any) -> None:
        bundle = super()._repr_mimebundle_(**kwargs)
        data = bundle[0] if isinstance(bundle, tuple) else bundle
        name = f"{type(self).__name__}: {self._page_title}"
        if self._viewer is None or not data:
            display(data or {"text/plain": name}, raw=True)
            return
        self._draw_stills()
        self.add_class(LIVE + self.model_id)
        display_with_image(data, self.model_id, name, self.snapshot(dpi=96))

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        bundle = super()._repr_mimebundle_(**kwargs)
        if self._viewer is None or not bundle:
            return bundle
        data, *rest = bundle if isinstance(bundle, tuple) else (bundle,)
        self._draw_stills()
        # What shows no widgets (a code host, an exported notebook) shows this.
        data = {**data, "image/png": self.snapshot()}
        return (data, *rest) if isinstance(bundle, tuple) else data
