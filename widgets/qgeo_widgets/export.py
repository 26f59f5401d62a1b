"""A widget as one web page that opens offline: three.js inside, arrays as base64, nothing loaded from anywhere."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.metadata import files
from importlib.resources import files as resources
from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MissingPackageError
from qgeo_widgets.fields import Field, Limits, RegionField, ScalarField
from qgeo_widgets.legend import css
from qgeo_widgets.motion import Motion
from qgeo_widgets.pane import Pane
from qgeo_widgets.region_borders import region_borders
from qgeo_widgets.viewer import FIELD_OF_VIEW, Viewer

_STEPS = 256


@dataclass(frozen=True)
class Page:
    """What a page shows.

    Attributes
    ----------
    title : str
    names : sequence of str
        Of the panes.
    modes : sequence of (str, sequence of Field)
        Name and fields; more than one field gets a slider.
    start, step : int
        Mode and field that are shown first, from 0 and from 1.
    limits : (float, float) or None
        Of the first field's colours.
    hint : str
        What clicking does.
    lasting : tuple of str
        What the slots of marks and lines begin with that a click on the page leaves; others belong to the last pick.
    info : str
        HTML under the legend.
    partners : sequence of two (n,) int, optional
        Vertex of the other pane for each vertex of a pane, -1 for none.
    matrix : mapping, optional
        Picture of a matrix whose rows are functions on the first pane, see `matrix_data`.
    motion : mapping, optional
        Frames of every pane and how they are played, see `motion_data`.
    """

    title: str
    names: Sequence[str]
    modes: Sequence[tuple[str, Sequence[Field]]]
    start: int = 0
    step: int = 1
    limits: Limits | None = None
    hint: str = ""
    lasting: tuple[str, ...] = ("landmark", "axis")
    info: str = ""
    partners: Sequence[npt.NDArray[np.integer]] | None = None
    matrix: Mapping[str, Any] = field(default_factory=dict)
    motion: Mapping[str, Any] = field(default_factory=dict)


def write_page(path: str | PathLike[str], viewer: Viewer, page: Page, still: str) -> None:
    """Write the page to a file, whole or not at all; ``still`` is the URL of a picture for where there is no WebGL."""
    text = page_text(viewer, page, still)
    with atomic_write(path) as file:
        file.write(text.encode())


def page_text(viewer: Viewer, page: Page, still: str) -> str:
    """Text of the page."""
    data = {
        "size": viewer.size,
        "fov": FIELD_OF_VIEW,
        "home": viewer.home,
        "camera": viewer.camera,
        "target": viewer.camera_view().target.tolist(),
        "radius": viewer.mark_radius,
        "start": page.start,
        "step": page.step,
        "info": bool(page.info),
        "shapes": [_shape(pane, name, page.lasting) for pane, name in zip(viewer.panes, page.names, strict=True)],
        "modes": [
            {
                "name": name,
                "steps": [
                    _painted(f, page.limits if (m, k) == (page.start, page.step) else None, viewer.panes)
                    for k, f in enumerate(fields, start=1)
                ],
            }
            for m, (name, fields) in enumerate(page.modes)
        ],
        "partners": None if page.partners is None else [_b64(p, np.int32) for p in page.partners],
        "matrix": page.matrix or None,
        "motion": page.motion or None,
    }
    parts = {
        "title": escape(page.title),
        "style": _resource("page.css"),
        "still": still,
        "hint": escape(page.hint),
        "info": page.info,
        # Nothing within a script element may look like its end.
        "data": json.dumps(data).replace("<", "\\u003c"),
        "licence": _resource("licence.txt"),
        "three": three_js().replace("</script", "<\\/script"),
        "orbit": _resource("orbit.js"),
        "motion": _resource("motion.js"),
        "failure": _resource("failure.js"),
        "script": _resource("page.js"),
    }
    template = _resource("page.html")
    pieces = template.split("@")
    return "".join(piece if k % 2 == 0 else parts[piece] for k, piece in enumerate(pieces))


def matrix_data(
    image: npt.NDArray[np.uint8],
    rows: npt.NDArray[np.floating],
    vertices: npt.NDArray[np.integer],
    strip: str,
    title: str,
    span: Limits,
) -> dict[str, Any]:
    """What a page needs of a matrix: its picture (m, m, 3), its rows (m, n), their vertices (m,), their scale."""
    shown = ScalarField([rows.astype(np.float64, copy=False)], "distance from the row's vertex / √area", span=span)
    index, lut = _indexed(rows, shown, None)
    return {
        "count": len(image),
        "title": escape(title),
        "strip": strip,
        "image": _b64(image, np.uint8),
        "rows": _b64(index, np.uint8),
        "lut": _b64(lut, np.uint8),
        "vertices": _b64(vertices, np.int32),
        "legend": shown.legend(None),
    }


def motion_data(motions: Sequence[Motion], state: Mapping[str, Any]) -> dict[str, Any]:
    """What a page needs to play: frames (k, m, 3), their times (k,), and time, speed, loop and seconds at first."""
    return {
        "times": motions[0].times.tolist(),
        "frames": [_b64(motion.positions, np.float32) for motion in motions],
        **state,
    }


def three_js() -> str:
    """Text of the three.js that pythreejs ships."""
    for file in files("pythreejs") or ():
        if file.name == "three.js" and "nbextensions" in file.parts:
            return file.read_text(encoding="utf-8")
    raise MissingPackageError("to_html needs the three.js of pythreejs, which its installation here does not hold")


def _shape(pane: Pane, name: str, lasting: tuple[str, ...]) -> dict[str, Any]:
    surface, placement = pane.surface, pane.placement
    title, numbers = f"<b>{escape(name)}</b>, {surface.n_vertices} vertices{pane.page_caption}", None
    if pane.page_mesh is not None:
        if pane.page_mesh.is_proxy:
            numbers = _b64(pane.page_mesh.at_vertices(np.arange(surface.n_vertices)), np.int32)
        surface = pane.page_mesh.shown
    return {
        "name": name,
        "title": title,
        "numbers": numbers,
        "positions": _b64(placement.to_scene(surface.vertices), np.float32),
        "normals": _b64(surface.vertex_normals @ placement.axes.T, np.float32),
        "index": _b64(surface.faces, np.uint32),
        "marks": [
            {
                "place": placement.to_scene(place).tolist(),
                "color": css(np.asarray(color)),
                "lasts": slot.startswith(lasting),
            }
            for slot, (place, color) in pane.marks.items()
        ],
        "lines": [
            {
                "points": _b64(placement.to_scene(curve), np.float32),
                "color": css(np.asarray(color)),
                "lasts": slot.startswith(lasting),
            }
            for slot, (curve, color) in pane.lines.items()
        ],
    }


def _painted(shown: Field, limits: Limits | None, panes_drawn: Sequence[Pane]) -> dict[str, Any]:
    """A field as the page paints it: an index into 256 colours at each vertex, or its colour."""
    panes: list[dict[str, Any]]
    if isinstance(shown, ScalarField):
        panes = []
        for values, pane in zip(shown.values, panes_drawn, strict=True):
            index, lut = _indexed(_on_page(values, pane), shown, limits)
            panes.append({"lut": _b64(lut, np.uint8), "index": _b64(index, np.uint8)})
    else:
        panes = [
            {"rgb": _b64(np.rint(255 * _on_page(rgb, pane)), np.uint8)}
            for rgb, pane in zip(shown.colors(None), panes_drawn, strict=True)
        ]
    if isinstance(shown, RegionField):
        for pane, numbers, entry in zip(panes_drawn, shown.numbers(), panes, strict=True):
            entry["borders"] = _sharpened(pane, numbers, shown.palette)
    return {"legend": shown.legend(limits), "panes": panes}


def _sharpened(pane: Pane, numbers: IndexArray, palette: FloatArray) -> dict[str, Any]:
    """Pieces of the triangles in which regions meet, and their colours."""
    mesh = pane.surface if pane.page_mesh is None else pane.page_mesh.shown
    borders = region_borders(mesh.faces, _on_page(numbers, pane))
    return {
        "positions": _b64(borders.at_points(pane.placement.to_scene(mesh.vertices)), np.float32),
        "normals": _b64(borders.at_points(mesh.vertex_normals @ pane.placement.axes.T), np.float32),
        "rgb": _b64(np.rint(255 * palette[borders.labels]), np.uint8),
    }


def _on_page(values: npt.NDArray[Any], pane: Pane) -> npt.NDArray[Any]:
    return values if pane.page_mesh is None else pane.page_mesh.at_vertices(values)


def _indexed(
    values: npt.NDArray[np.floating], shown: ScalarField, limits: Limits | None
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float64]]:
    """Row of a table of colours for each value, and the table; its last row is for what is not finite."""
    scale = shown.scale(limits)
    last = _STEPS - 2
    span = (scale.high - scale.low) or 1.0
    finite = np.isfinite(values)
    place = np.clip((np.where(finite, values, scale.low) - scale.low) / span, 0.0, 1.0)
    index = np.where(finite, np.rint(last * place), _STEPS - 1).astype(np.uint8)
    table = scale(np.append(np.linspace(scale.low, scale.high, _STEPS - 1), np.nan))
    return index, np.rint(255 * table)


def _b64(array: npt.ArrayLike, dtype: Any) -> str:
    return base64.b64encode(np.ascontiguousarray(array, dtype=dtype).tobytes()).decode()


def _resource(name: str) -> str:
    return (resources("qgeo_widgets") / "page" / name).read_text(encoding="utf-8")
