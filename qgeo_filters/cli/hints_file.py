"""Pairs of vertices that belong together, from a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.errors import MeshError, ParameterError, reason
from qgeo_filters.io.number_files import whole_numbers


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
