"""Pictures of what a viewer shows, drawn without WebGL: snapshots, and stand-ins where there is no WebGL."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt

from qgeo_filters.report.glyphs import Glyph, ball, tube
from qgeo_filters.report.panels import Panel, panel_figure
from qgeo_filters.report.render import render_mesh
from qgeo_filters.report.view import View
from qgeo_widgets.fields import Field, Limits, ScalarField
from qgeo_widgets.pane import Pane
from qgeo_widgets.viewer import Viewer

_BACKGROUND = (0.969, 0.969, 0.973)


def pane_picture(viewer: Viewer, pane: Pane, width: int = 400) -> npt.NDArray[np.uint8]:
    """Picture of one pane from where the camera stands, uint8 RGB."""
    size = width, round(width * viewer.size[1] / viewer.size[0])
    return render_mesh(
        pane.surface.vertices,
        pane.surface.faces,
        **_paint(pane),
        view=_view(viewer, pane),
        glyphs=_glyphs(pane),
        size=size,
        background=_BACKGROUND,
        supersample=2,
    )


def snapshot(viewer: Viewer, titles: Sequence[str], field: Field | None, limits: Limits | None) -> bytes:
    """PNG of all panes from where the camera stands, with their titles and the colour bar."""
    panels = [
        Panel(pane.surface, _view(viewer, pane), title, {**_paint(pane), "glyphs": _glyphs(pane)})
        for pane, title in zip(viewer.panes, titles, strict=True)
    ]
    scale = field.scale(limits) if isinstance(field, ScalarField) and field.bounds else None
    label = field.label if field is not None else ""
    figure = panel_figure(panels, scale=scale, scale_label=label, title="" if scale else label)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    return buffer.getvalue()


def png_url(picture: npt.NDArray[np.uint8]) -> str:
    """The picture as a data URL."""
    buffer = io.BytesIO()
    matplotlib.image.imsave(buffer, picture, format="png")
    return data_url(buffer.getvalue())


def data_url(png: bytes) -> str:
    """A PNG as a data URL."""
    return "data:image/png;base64," + base64.b64encode(png).decode()


def _view(viewer: Viewer, pane: Pane) -> View:
    return View(viewer.view_axes() @ pane.placement.axes, pane.placement.axes[1])


def _paint(pane: Pane) -> dict[str, Any]:
    """Colours of a pane as `render_mesh` takes them."""
    if pane.regions is None:
        return {"colors": pane.colors}
    labels, palette = pane.regions
    return {"labels": labels, "colors": palette}


def _glyphs(pane: Pane) -> list[Glyph]:
    radius = 0.012 * float(np.linalg.norm(np.ptp(pane.surface.vertices, axis=0)))
    glyphs = [ball(point, 1.2 * radius, color) for point, color in pane.marks.values()]
    for curve, color in pane.lines.values():
        if np.ptp(curve, axis=0).any():
            glyphs.append(tube(curve, 0.45 * radius, color))
    return glyphs
