"""Pictures of what a viewer shows, drawn without WebGL: snapshots, and stand-ins where there is no WebGL."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np

from qgeo_filters.report.glyphs import Glyph, ball, tube
from qgeo_filters.report.render import render_mesh
from qgeo_filters.report.view import View
from qgeo_widgets.fields import Field, Limits
from qgeo_widgets.rendering.camera_view import CameraView
from qgeo_widgets.rendering.pane import Pane
from qgeo_widgets.rendering.viewer import Viewer
from qgeo_widgets.snapshot_figure import Chart, Form, Picture, figure_bytes, picture_size

_BACKGROUND = (0.969, 0.969, 0.973)
_FLAT = View(np.eye(3), np.array([0.0, 1.0, 0.0]))
# Of the picture, that `View.fit` leaves free on each side: here the frame itself is to fill the picture.
_MARGIN = 0.03


def pane_picture(viewer: Viewer, pane: Pane, width: int = 400, height: int | None = None) -> Picture:
    """Picture of one pane, uint8 RGB, as the camera shows it: with its perspective, nearness and place."""
    size = width, round(width * viewer.size[1] / viewer.size[0]) if height is None else height
    view = viewer.camera_view()
    vertices, seen = view.flattened(pane.placement.to_scene(pane.surface.vertices))
    faces = pane.surface.faces[seen[pane.surface.faces].all(axis=1)]
    if not len(faces):  # the camera looks away, or stands within
        blank = np.rint(255 * np.array(_BACKGROUND)).astype(np.uint8)
        return np.tile(blank, (size[1], size[0], 1))
    return render_mesh(
        vertices,
        faces,
        **_paint(viewer, pane),
        view=_FLAT,
        shown=view.frame * (1.0 - 2.0 * _MARGIN),
        glyphs=[glyph for glyph in (_flat(solid, view) for solid in _glyphs(viewer, pane)) if len(glyph.faces)],
        size=size,
        background=_BACKGROUND,
        supersample=2,
    )


def snapshot(
    viewer: Viewer,
    titles: Sequence[str],
    field: Field | None,
    limits: Limits | None,
    *,
    before: Sequence[tuple[str, Picture]] = (),
    chart: Chart | None = None,
    dpi: int = 144,
    form: Form = "png",
) -> bytes:
    """PNG or SVG of all panes as the camera shows them, with titles, legend, pictures before them and a chart."""
    size = picture_size(viewer.size, dpi)
    panes = [(title, pane_picture(viewer, pane, *size)) for pane, title in zip(viewer.panes, titles, strict=True)]
    pictures = [*before, *panes]
    return figure_bytes(pictures, [viewer.size] * len(pictures), field, limits, chart, dpi, form)


def png_url(picture: Picture) -> str:
    """The picture as a data URL."""
    buffer = io.BytesIO()
    matplotlib.image.imsave(buffer, picture, format="png")
    return data_url(buffer.getvalue())


def data_url(picture: bytes, form: Form = "png") -> str:
    """A picture as a data URL."""
    kind = "svg+xml" if form == "svg" else form
    return f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"


def _paint(viewer: Viewer, pane: Pane) -> dict[str, Any]:
    """Colours of a pane as `render_mesh` takes them."""
    if viewer.texture is not None and pane.places is not None:
        return {"places": pane.places, "texture": viewer.texture.at}
    if pane.regions is None:
        return {"colors": pane.colors, "cells": pane.cells}
    labels, palette = pane.regions
    return {"labels": labels, "colors": palette}


def _glyphs(viewer: Viewer, pane: Pane) -> list[Glyph]:
    """Marks and lines of a pane as solids in the scene, as large as in the browser."""
    to_scene, radius = pane.placement.to_scene, viewer.mark_radius
    glyphs = [ball(to_scene(point), radius, color) for point, color in pane.marks.values()]
    return glyphs + [tube(to_scene(line.points), radius / 3, line.color) for line in pane.lines.values()]


def _flat(glyph: Glyph, view: CameraView) -> Glyph:
    vertices, seen = view.flattened(glyph.vertices)
    return Glyph(vertices, glyph.faces[seen[glyph.faces].all(axis=1)], glyph.color)
