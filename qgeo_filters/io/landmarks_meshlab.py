"""Landmarks as MeshLab saves picked points: ``.pp``."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

from qgeo_filters.errors import MeshError, reason
from qgeo_filters.io.landmark_text import MISSING, LandmarkSet, position, words_of
from qgeo_filters.io.landmarks import Landmarks


def read_picked_points(path: Path) -> list[LandmarkSet]:
    """Picked points by name; those that are not active have no place."""
    try:
        root = ElementTree.fromstring(path.read_bytes())
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise MeshError(f"no readable XML ({reason(error)})") from error
    if root.tag != "PickedPoints":
        raise MeshError(f"no picked points of MeshLab, but {root.tag[:40]!r}")
    names, points = [], []
    for i, point in enumerate(root.iter("point")):
        names.append(point.get("name") or str(i + 1))
        active = point.get("active", "1") != "0"
        points.append(position([point.get(axis, "") for axis in "xyz"], f"point {i}") if active else MISSING)
    if not points:
        raise MeshError("the file holds no landmarks")
    return [LandmarkSet((), Landmarks(names, points))]


def write_picked_points(path: Path, landmarks: Landmarks) -> bytes:
    """Picked points; landmarks without a place are not active."""
    lines = ["<!DOCTYPE PickedPoints>", "<PickedPoints>", " <DocumentData>", " </DocumentData>"]
    for name, point in zip(landmarks.names, landmarks.points, strict=True):
        words = words_of(point, "")
        x, y, z = words if words[0] else ("0", "0", "0")
        shown = "".join(c if c >= " " and c not in "\ufffe\uffff" else "\ufffd" for c in name)  # what XML can hold
        lines.append(f' <point x="{x}" y="{y}" z="{z}" active="{int(bool(words[0]))}" name={quoteattr(shown)}/>')
    return "\n".join([*lines, "</PickedPoints>", ""]).encode("utf-8", errors="xmlcharrefreplace")
