"""A widget as one web page that opens offline: our browser module inside, arrays compressed, nothing loaded."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files as resources
from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import IndexArray
from qgeo_filters.atomic import atomic_write
from qgeo_widgets.fields import ColorField, Field, Limits, RegionField, ScalarField
from qgeo_widgets.page_block import PageBlock
from qgeo_widgets.rendering import browser_module
from qgeo_widgets.rendering.display_mesh import DisplayMesh
from qgeo_widgets.rendering.encoding import border_data, color_bytes, line_data, mark_data, scene_data
from qgeo_widgets.rendering.motion import Motion
from qgeo_widgets.rendering.pane import Pane
from qgeo_widgets.rendering.viewer import Viewer

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
    block = PageBlock()
    titles = [
        f"<b>{escape(name)}</b>, {pane.surface.n_vertices} vertices"
        for pane, name in zip(viewer.panes, page.names, strict=True)
    ]
    setup = scene_data(viewer, titles)
    for shape, pane, name in zip(setup["panes"], viewer.panes, page.names, strict=True):
        shape |= {"name": name, **_marked(pane, page.lasting)}
    data = {
        "setup": setup,
        "camera": {"position": viewer.camera, "target": viewer.target},
        "look": viewer.look,
        "texture": None if viewer.texture is None else viewer.texture.encoded,
        "start": page.start,
        "step": page.step,
        "info": bool(page.info),
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
        "partners": None if page.partners is None else _partner_data(page.partners, viewer.panes),
        "matrix": page.matrix or None,
        "motion": page.motion or None,
    }
    description = json.dumps(block.placed(data))
    parts = {
        "title": escape(page.title),
        "style": browser_module.style() + _resource("page.css"),
        "still": still,
        "hint": escape(page.hint),
        "info": page.info,
        # Nothing within a script element may look like its end.
        "data": description.replace("<", "\\u003c"),
        "arrays": block.text(),
        "licence": browser_module.licence(),
        "renderer": browser_module.script().replace("</script", "<\\/script"),
        "failure": _resource("failure.js"),
    }
    template = _resource("page.html")
    pieces = template.split("@")
    return "".join(piece if k % 2 == 0 else parts[piece] for k, piece in enumerate(pieces))


def matrix_data(
    image: npt.NDArray[np.uint8],
    rows: npt.NDArray[np.floating],
    vertices: IndexArray,
    display: DisplayMesh,
    strip: str,
    title: str,
    span: Limits,
) -> dict[str, Any]:
    """What a page needs of a matrix: its picture (m, m, 3), its rows (m, n), their vertices (m,), their scale."""
    rows = display.at_vertices(rows.T).T
    shown = ScalarField([rows.astype(np.float64, copy=False)], "distance from the row's vertex / √area", span=span)
    index, lut = _indexed(rows, shown, None)
    return {
        "count": len(image),
        "title": escape(title),
        "strip": strip,
        "image": np.asarray(image, dtype=np.uint8),
        "rows": index,
        "lut": lut,
        "vertices": vertices.astype(np.int32),
        "drawn": display.drawn_at(vertices).astype(np.int32),
        "legend": shown.legend(None),
        "drawing": shown.drawing(None),
        "scale": _span(shown, None),
    }


def motion_data(motion: Motion | None, state: Mapping[str, Any]) -> dict[str, Any]:
    """What a page needs to play: times of the frames (k,), and time, speed, loop and seconds at first."""
    return {} if motion is None else {"times": motion.times.tolist(), **state}


def _partner_data(partners: Sequence[npt.NDArray[np.integer]], panes: Sequence[Pane]) -> list[dict[str, Any]]:
    """Partner of each drawn vertex of two panes: the vertex of the other shape, and the one that is drawn for it."""
    data = []
    for images, pane, other in zip(partners, panes, reversed(panes), strict=True):
        there = pane.display.at_vertices(np.asarray(images, dtype=np.int64))
        data.append({"vertices": there.astype(np.int32), "drawn": other.display.drawn_at(there).astype(np.int32)})
    return data


def _marked(pane: Pane, lasting: tuple[str, ...]) -> dict[str, Any]:
    """Marks and lines, and which of them a click leaves."""
    return {
        "marks": [{**mark_data(pane, *each), "lasts": each[0].startswith(lasting)} for each in pane.marks.items()],
        "lines": [{**line_data(pane, *each), "lasts": each[0].startswith(lasting)} for each in pane.lines.items()],
    }


def _painted(shown: Field, limits: Limits | None, panes_drawn: Sequence[Pane]) -> dict[str, Any]:
    """A field as the page paints it: an index into 256 colours at each vertex, or its colour."""
    panes: list[dict[str, Any]]
    if isinstance(shown, ScalarField):
        panes = []
        for values, pane in zip(shown.values, panes_drawn, strict=True):
            index, lut = _indexed(pane.display.at_vertices(values), shown, limits)
            panes.append({"lut": lut, "index": index})
        return {**_legends(shown, limits), "panes": panes, "scale": _span(shown, limits)}
    panes = [
        {"rgb": color_bytes(pane.display.at_vertices(rgb))}
        for rgb, pane in zip(shown.colors(None), panes_drawn, strict=True)
    ]
    if isinstance(shown, ColorField):
        for name, each in (("cells", shown.cells), ("places", shown.places)):
            for values, pane, entry in zip(each, panes_drawn, panes, strict=bool(each)):
                entry[name] = pane.display.at_vertices(values).astype(np.float32)
    if not isinstance(shown, RegionField):
        return {**_legends(shown, limits), "panes": panes}
    for pane, numbers, entry in zip(panes_drawn, shown.numbers(), panes, strict=True):
        entry["regions"] = pane.display.at_vertices(numbers).astype(np.int32)
        entry["borders"] = border_data(pane, numbers, shown.palette)
    return {**_legends(shown, limits), "panes": panes, "names": list(shown.names)}


def _legends(shown: Field, limits: Limits | None) -> dict[str, str]:
    return {"legend": shown.legend(limits), "drawing": shown.drawing(limits)}


def _span(shown: ScalarField, limits: Limits | None) -> Limits:
    scale = shown.scale(limits)
    return scale.low, scale.high


def _indexed(
    values: npt.NDArray[np.floating], shown: ScalarField, limits: Limits | None
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint8]]:
    """Row of a table of colours for each value, and the table; its last row is for what is not finite."""
    scale = shown.scale(limits)
    last = _STEPS - 2
    span = (scale.high - scale.low) or 1.0
    finite = np.isfinite(values)
    place = np.clip((np.where(finite, values, scale.low) - scale.low) / span, 0.0, 1.0)
    index = np.where(finite, np.rint(last * place), _STEPS - 1).astype(np.uint8)
    table = scale(np.append(np.linspace(scale.low, scale.high, _STEPS - 1), np.nan))
    return index, color_bytes(table)


def _resource(name: str) -> str:
    return (resources("qgeo_widgets") / "page" / name).read_text(encoding="utf-8")
