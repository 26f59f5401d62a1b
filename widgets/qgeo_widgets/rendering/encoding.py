"""Shapes as the browser module gets them, in notebooks and on pages: arrays within dictionaries."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_widgets.rendering.pane import Line, Mark, Pane, css_color
from qgeo_widgets.rendering.region_borders import region_borders
from qgeo_widgets.rendering.viewer import FIELD_OF_VIEW, Viewer

_STEPS = 65535


def quantised(points: npt.ArrayLike) -> dict[str, Any]:
    """Points (..., 3) in 16 bits each of the box around them: a hundredth of a pixel on any screen."""
    places = np.asarray(points, dtype=np.float64)
    flat = places.reshape(-1, 3)
    low = flat.min(axis=0)
    step = (flat.max(axis=0) - low) / _STEPS
    steps = np.rint((places - low) / np.where(step > 0, step, 1.0)).astype(np.uint16)
    return {"bytes": steps, "low": low.tolist(), "step": step.tolist()}


def indices(faces: IntArray, n_vertices: int) -> npt.NDArray[np.unsignedinteger[Any]]:
    """Triangles (m, 3) in as few bytes as there may be."""
    return faces.astype(np.uint16 if n_vertices <= _STEPS + 1 else np.uint32)


def shape_data(pane: Pane, title: str) -> dict[str, Any]:
    """What stays of a pane: positions, triangles, title, and the frames of what moves."""
    shown, to_scene = pane.display.shown, pane.placement.to_scene
    data = {
        "title": title + pane.caption,
        "positions": quantised(to_scene(shown.vertices) if pane.motion is None else pane.motion.positions[0]),
        "index": indices(shown.faces, shown.n_vertices),
    }
    if pane.display.is_proxy:
        data["numbers"] = pane.display.at_vertices(np.arange(pane.surface.n_vertices, dtype=np.int32))
    if pane.motion is not None and len(pane.motion.times) > 1:
        data["frames"] = quantised(pane.motion.positions)
    return data


def color_bytes(colors: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Colours from 0 to 1 in bytes."""
    return np.rint(255.0 * np.clip(colors, 0.0, 1.0)).astype(np.uint8)


def paint_data(pane: Pane) -> dict[str, Any]:
    """What colours a pane now, and what is said of its vertices."""
    at = pane.display.at_vertices
    return {
        "rgb": color_bytes(at(pane.colors)),
        "values": None if pane.values is None else at(np.asarray(pane.values)).astype(np.float32),
        "names": list(pane.names) or None,
        "borders": None if pane.regions is None else border_data(pane, *pane.regions),
        "cells": None if pane.cells is None else at(pane.cells).astype(np.float32),
        "places": None if pane.places is None else at(pane.places).astype(np.float32),
    }


def border_data(pane: Pane, labels: npt.NDArray[np.integer], palette: FloatArray) -> dict[str, Any]:
    """Pieces of the triangles in which regions (n,) meet, and their colours of the palette (k, 3)."""
    shown, placement = pane.display.shown, pane.placement
    borders = region_borders(shown.faces, pane.display.at_vertices(labels))
    return {
        "positions": borders.at_points(placement.to_scene(shown.vertices)).astype(np.float32),
        "normals": borders.at_points(shown.vertex_normals @ placement.axes.T).astype(np.float32),
        "rgb": color_bytes(palette[borders.labels]),
    }


def mark_data(pane: Pane, slot: str, mark: Mark) -> dict[str, Any]:
    """A mark in the scene."""
    return {"slot": slot, "place": pane.placement.to_scene(mark.point).tolist(), "color": css_color(mark.color)}


def line_data(pane: Pane, slot: str, line: Line) -> dict[str, Any]:
    """A line in the scene."""
    points = pane.placement.to_scene(line.points).astype(np.float32)
    return {"slot": slot, "points": points, "color": css_color(line.color), "width": line.width}


def scene_data(viewer: Viewer, titles: Sequence[str]) -> dict[str, Any]:
    """What a view is made from, see ``View`` in the browser module."""
    motion = viewer.panes[0].motion
    return {
        "size": list(viewer.size),
        "fov": FIELD_OF_VIEW,
        "home": list(viewer.home),
        "radius": viewer.mark_radius,
        "times": None if motion is None else motion.times.tolist(),
        "panes": [shape_data(pane, title) for pane, title in zip(viewer.panes, titles, strict=True)],
    }


def converted(item: Any, convert: Callable[[np.ndarray], Any]) -> Any:
    """The same dictionaries and lists with something else in place of each array."""
    if isinstance(item, np.ndarray):
        return convert(item)
    if isinstance(item, dict):
        return {key: converted(value, convert) for key, value in item.items()}
    return [converted(value, convert) for value in item] if isinstance(item, (list, tuple)) else item


def with_bytes(item: Any) -> Any:
    """The same with bytes in place of arrays, as messages to the browser take them."""
    return converted(item, np.ndarray.tobytes)
