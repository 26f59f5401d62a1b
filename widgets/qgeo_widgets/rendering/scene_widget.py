"""The model of a view in the browser, which the renderer module follows."""

from __future__ import annotations

from typing import Any

import anywidget
import traitlets

from qgeo_widgets.rendering.browser_module import as_anywidget, style
from qgeo_widgets.rendering.motion import TICKS


class SceneWidget(anywidget.AnyWidget):
    """Everything that a view shows, as the browser gets it; see `qgeo_widgets.rendering.encoding`.

    Attributes
    ----------
    setup : dict
        Shapes, size, first camera: what does not change.
    paints, marks, lines : list
        An entry for each shape.
    camera : dict
        ``position`` and ``target``; set by the browser, too.
    look : dict
        What the panel of the view sets: edges, flat, orthographic, opacity, light, background.
    legend : str
        SVG, for pictures that are saved as such.
    texture : bytes
        PNG or JPEG that lies on the shapes where paints have places on it.
    brush : bool
        Whether a press on a shape paints, and does not turn it.
    tick : float
        Time of what moves, in ticks of a clock, see `TICKS`.
    stills : list of str
        Pictures for where nothing can be drawn.
    """

    _esm = as_anywidget()
    _css = style()
    setup = traitlets.Dict().tag(sync=True)
    paints: traitlets.List[Any] = traitlets.List().tag(sync=True)
    marks: traitlets.List[Any] = traitlets.List().tag(sync=True)
    lines: traitlets.List[Any] = traitlets.List().tag(sync=True)
    camera: traitlets.Dict[str, Any] = traitlets.Dict().tag(sync=True)
    look: traitlets.Dict[str, Any] = traitlets.Dict().tag(sync=True)
    legend: traitlets.Unicode[str, str | bytes] = traitlets.Unicode().tag(sync=True)
    texture = traitlets.Bytes(b"").tag(sync=True)
    brush = traitlets.Bool(False).tag(sync=True)
    tick = traitlets.Float(0.0).tag(sync=True)
    ticks = traitlets.Int(TICKS).tag(sync=True)
    stills: traitlets.List[Any] = traitlets.List().tag(sync=True)
