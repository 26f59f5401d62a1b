"""Pairs of points that belong together, from a file of vertices or from two of landmarks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError, ParameterError, reason
from qgeo_filters.io.landmark_files import read_landmarks
from qgeo_filters.io.landmarks import Frame, Landmarks
from qgeo_filters.io.number_files import whole_numbers


def read_hints(paths: Sequence[Path], frame: Frame | None = None) -> IndexArray | tuple[Landmarks, Landmarks]:
    """Landmarks that `match` takes: of one file pairs of vertices, of two the landmarks on X and those on Y.

    Parameters
    ----------
    frame : {"RAS", "LPS"}, optional
        Frame of the meshes: landmarks that say that they are in the other one are turned.

    Raises
    ------
    ParameterError
        More than two files, or no pairs, see `read_pairs`.
    MeshError
        A file of landmarks that cannot be read.
    """
    if len(paths) == 1:
        return read_pairs(paths[0])
    if len(paths) > 2:
        raise ParameterError(f"hints are one file of pairs, or one of landmarks for X and one for Y, got {len(paths)}")
    x, y = (read_landmarks(path) for path in paths)
    if frame is None:
        return x, y
    return x if x.frame is None else x.in_frame(frame), y if y.frame is None else y.in_frame(frame)


def read_pairs(path: Path) -> IndexArray:
    """Vertices (k, 2) of X and of Y, from 0: a pair a line, separated by a comma or white space.

    A first line of names, such as ``x_vertex,y_vertex``, and what follows a ``#`` are passed over.

    Raises
    ------
    ParameterError
        No pairs of whole numbers: which line; the message starts with the path.
    """
    rows: list[list[float]] = []
    text = path.read_text(encoding="utf-8-sig", errors="replace")
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].replace(",", " ").replace(";", " ").split()
        try:
            values = [float(word) for word in words]
        except ValueError:
            if not rows and number == 1:
                continue
            raise ParameterError(f"{path}: line {number} is no pair of vertices: {line.strip()[:60]!r}") from None
        if values and len(values) != 2:
            raise ParameterError(
                f"{path}: line {number} has {len(values)} numbers, expected a vertex of X and one of Y"
            )
        rows += [values] if values else []
    if not rows:
        raise ParameterError(f"{path} holds no pair of vertices: a vertex of X and one of Y a line, from 0")
    try:
        return whole_numbers(np.array(rows), "pairs")
    except MeshError as error:
        raise ParameterError(f"{path}: {reason(error)}") from error
