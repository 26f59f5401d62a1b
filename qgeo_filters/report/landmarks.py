"""Pictures of landmarks on shapes: each landmark in one colour on all."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from qgeo_filters.errors import ParameterError
from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.report.colors import distinct
from qgeo_filters.report.glyphs import ball
from qgeo_filters.report.panels import Panel, panel_figure
from qgeo_filters.report.view import best_view
from qgeo_filters.surface import Surface

# Of a ball, in sqrt(area).
_RADIUS = 0.025


def plot_landmarks(shapes: Mapping[str, Surface], landmarks: Mapping[str, Landmarks], *, columns: int = 4) -> Figure:
    """Figure of shapes with their landmarks as balls; the k-th has one colour on all, one without a place is left out.

    Parameters
    ----------
    shapes : mapping of name to Surface
    landmarks : mapping of name to Landmarks
        Of each shape, in one order.
    columns : int

    Raises
    ------
    ParameterError
        No shape, or one without landmarks.
    """
    lacking = [name for name in shapes if name not in landmarks]
    if lacking or not shapes:
        raise ParameterError(f"{lacking[0]} has no landmarks ({len(lacking)} such)" if lacking else "there is no shape")
    colors = distinct(max(len(landmarks[name].points) for name in shapes))
    panels = []
    for name, shape in shapes.items():
        points = landmarks[name].points
        radius = _RADIUS * float(np.sqrt(shape.area))
        balls = [
            ball(point, radius, tuple(color.tolist()))
            for point, color in zip(points, colors, strict=False)
            if np.isfinite(point).all()
        ]
        panels.append(Panel(shape, best_view(shape.vertices, shape.faces), name, {"glyphs": balls}))
    return panel_figure(panels, columns=columns)
