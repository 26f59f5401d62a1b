"""The figure of a snapshot: panes side by side at their size on screen, titles, legend, and a chart below."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import Literal

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.patches import Patch

from qgeo_filters.errors import ParameterError
from qgeo_filters.report.panels import STYLE, new_figure, show_picture
from qgeo_widgets.fields import Field, Limits, ScalarField

Chart = Callable[[Axes], None]
Form = Literal["png", "svg"]
FORMS: tuple[Form, ...] = ("png", "svg")
Picture = npt.NDArray[np.uint8]

_GAP, _TITLE, _LEGEND, _CHART = 0.12, 0.3, 0.75, 2.1  # inches
_PER_INCH = 96  # pixels of a screen, as browsers count
_MOST_NAMES = 24


def figure_bytes(
    pictures: Sequence[tuple[str, Picture]],
    sizes: Sequence[tuple[int, int]],
    field: Field | None,
    limits: Limits | None,
    chart: Chart | None,
    dpi: int,
    form: Form = "png",
) -> bytes:
    """PNG or SVG of pictures that are so many pixels wide and high on screen, with the legend of a field and a chart.

    In SVG the pictures are pixels, all around them is text and lines.
    """
    inches = np.array(sizes, dtype=np.float64) / _PER_INCH
    width = float(inches[:, 0].sum()) + _GAP * (len(sizes) + 1)
    named = field is not None and bool(field.label)
    below = _LEGEND * named + _CHART * (chart is not None)
    height = _TITLE + float(inches[:, 1].max()) + _GAP + below
    with matplotlib.rc_context({**STYLE, "svg.fonttype": "none", "svg.hashsalt": "qgeo"}):
        figure = new_figure(width, height)
        figure.set_layout_engine("none")
        figure.set_dpi(dpi)

        def axes_at(left: float, bottom: float, wide: float, high: float) -> Axes:
            return figure.add_axes((left / width, bottom / height, wide / width, high / height))

        left = _GAP
        for (title, picture), (wide, high) in zip(pictures, inches.tolist(), strict=True):
            axes = axes_at(left, height - _TITLE - high, wide, high)
            show_picture(axes, picture)
            axes.set_title(title)
            left += wide + _GAP
        if field is not None and named:
            _draw_legend(axes_at, field, limits, width, below)
        if chart is not None:
            chart(axes_at(0.75, 0.5, width - 1.0, _CHART - 0.6))
        buffer = io.BytesIO()
        # Nothing in a file of its time and make: the same picture is the same file.
        absent = {"Software": None} if form == "png" else {"Date": None, "Creator": None}
        figure.savefig(buffer, format=form, dpi=dpi, metadata=absent)
    return buffer.getvalue()


def picture_form(path: str | PathLike[str] | None, form: Form | None) -> Form:
    """What a picture is written as: what was said, else what its path ends in, else PNG."""
    if form is not None and form not in FORMS:
        raise ParameterError(f"form must be one of {', '.join(FORMS)}, got {form!r}")
    if form is None and path is not None and Path(path).suffix.lower() == ".svg":
        return "svg"
    return form or "png"


def picture_size(size: tuple[int, int], dpi: int) -> tuple[int, int]:
    """Pixels of a picture that fills its place in the figure."""
    return max(round(size[0] * dpi / _PER_INCH), 1), max(round(size[1] * dpi / _PER_INCH), 1)


def _draw_legend(
    axes_at: Callable[[float, float, float, float], Axes],
    field: Field,
    limits: Limits | None,
    width: float,
    top: float,
) -> None:
    if isinstance(field, ScalarField) and field.bounds:
        axes = axes_at(0.2 * width, top - 0.22, 0.6 * width, 0.14)
        scale = field.scale(limits)
        bar = axes.figure.colorbar(ScalarMappable(scale.norm, scale.colormap), cax=axes, orientation="horizontal")
        bar.set_label(field.label)
        bar.outline.set_linewidth(0.5)
        return
    axes = axes_at(_GAP, top - _LEGEND, width - 2 * _GAP, _LEGEND)
    axes.set_axis_off()
    axes.text(0.5, 0.86, field.label, ha="center", va="center", transform=axes.transAxes, wrap=True)
    key = () if isinstance(field, ScalarField) else field.key
    if key:
        patches = [Patch(color=tuple(color), label=name) for color, name in key[:_MOST_NAMES]]
        axes.legend(handles=patches, loc="lower center", ncols=min(len(patches), 12), frameon=False, fontsize=7.5)
