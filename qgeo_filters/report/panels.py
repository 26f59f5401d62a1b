"""Figures made of panels: pictures of surfaces with titles and colour bars, without Matplotlib's global state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from qgeo_filters.report.colors import ColorScale
from qgeo_filters.report.render import render_mesh
from qgeo_filters.report.ticks import bar_locator
from qgeo_filters.report.view import View
from qgeo_filters.surface import Surface

DPI = 160
STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlepad": 4.0,
    "axes.linewidth": 0.7,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "mathtext.fontset": "dejavusans",
    "axes.spines.top": False,
    "axes.spines.right": False,
}


@dataclass(frozen=True)
class Panel:
    """One picture of a surface.

    Attributes
    ----------
    surface : Surface
    view : View
    title : str
    options : dict
        What `render_mesh` takes besides: values, colors, scale, isolines, glyphs ...
    """

    surface: Surface
    view: View
    title: str = ""
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def aspect(self) -> float:
        """Width of what the picture has room for divided by its height."""
        shown = self.options.get("shown")
        return self.view.aspect(self.surface.vertices[np.unique(self.surface.faces)] if shown is None else shown)


def new_figure(width: float, height: float) -> Figure:
    """Empty figure of that many inches on an Agg canvas: it needs no display and joins no global list."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(width, height), dpi=DPI, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def panel_figure(
    panels: Sequence[Panel],
    *,
    columns: int | None = None,
    width: float = 7.2,
    scale: ColorScale | None = None,
    scale_label: str = "",
    title: str = "",
) -> Figure:
    """Figure of panels in rows, one colour bar under all of them.

    Parameters
    ----------
    panels : sequence of Panel
    columns : int, optional
        All panels in one row by default.
    width : float
        Of the figure, in inches. The height follows from the shapes.
    scale : ColorScale, optional
        Draws the colour bar, with ``scale_label``.
    title : str
        Above all panels.
    """
    columns = len(panels) if columns is None else min(columns, len(panels))
    rows = -(-len(panels) // columns)
    # One size for all: the widest picture's shape, within reason.
    aspect = float(np.clip(max(panel.aspect for panel in panels), 0.5, 2.2))
    panel_width = min(width / columns, 5.2)
    panel_height = min(panel_width / aspect, 4.6)
    panel_width = min(panel_width, panel_height * aspect * 1.15)
    titled = any(panel.title for panel in panels)
    height = rows * (panel_height + 0.27 * titled) + 0.62 * (scale is not None) + 0.35 * bool(title)
    figure = new_figure(max(panel_width * columns, 2.6), height)
    with matplotlib.rc_context(STYLE):
        grid = figure.add_gridspec(rows, columns)
        axes = []
        for index, panel in enumerate(panels):
            axes.append(draw_panel(figure, grid[divmod(index, columns)], panel, panel_width, panel_height))
        if scale is not None:
            add_color_bar(figure, axes, scale, scale_label)
        if title:
            figure.suptitle(title, fontsize=10.5)
    return figure


def draw_panel(figure: Figure, place: SubplotSpec, panel: Panel, width: float, height: float) -> Axes:
    """Axes without a frame that show the picture at the figure's own resolution; width and height in inches."""
    axes = figure.add_subplot(place)
    size = max(int(width * DPI), 32), max(int(height * DPI), 32)
    picture = render_mesh(panel.surface.vertices, panel.surface.faces, view=panel.view, size=size, **panel.options)
    show_picture(axes, picture)
    if panel.title:
        axes.set_title(panel.title)
    return axes


def show_picture(axes: Axes, picture: npt.NDArray[np.uint8]) -> None:
    """Picture in axes without ticks and frame."""
    axes.imshow(picture, interpolation="antialiased")
    axes.set_axis_off()


def add_color_bar(figure: Figure, axes: Sequence[Axes], scale: ColorScale, label: str, **options: Any) -> None:
    """Horizontal colour bar under the axes, with its limits and its label."""
    style = {"orientation": "horizontal", "fraction": 0.05, "pad": 0.02, "shrink": 0.62, "aspect": 34, **options}
    bar = figure.colorbar(ScalarMappable(scale.norm, scale.colormap), ax=list(axes), **style)
    bar.locator = bar_locator(scale.low, scale.high)
    bar.update_ticks()
    bar.set_label(label)
    bar.outline.set_linewidth(0.5)
