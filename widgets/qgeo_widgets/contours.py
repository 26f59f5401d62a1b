"""Curves on a surface where a function of its vertices changes sign."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.surface import Surface


def sign_changes(surface: Surface, values: npt.ArrayLike) -> list[FloatArray]:
    """Polylines (p, 3) along which piecewise linear values are zero; closed ones end where they begin.

    Parameters
    ----------
    surface : Surface
        Manifold.
    values : array-like, shape (n,)
        A zero counts as positive, so that the curve passes through that vertex.
    """
    f = np.asarray(values, dtype=np.float64)
    positive = f >= 0
    a, b = surface.edges.T
    crossed = positive[a] != positive[b]
    share = np.divide(f[a], f[a] - f[b], out=np.zeros(len(a)), where=crossed)
    points = surface.vertices[a] + share[:, None] * (surface.vertices[b] - surface.vertices[a])
    # Each triangle with both signs joins two crossed edges.
    cut = crossed[surface.face_edges]
    pairs = surface.face_edges[cut.sum(axis=1) == 2][cut[cut.sum(axis=1) == 2]].reshape(-1, 2)
    neighbours: dict[int, list[int]] = {}
    for one, other in pairs.tolist():
        neighbours.setdefault(one, []).append(other)
        neighbours.setdefault(other, []).append(one)
    ends = [edge for edge, near in neighbours.items() if len(near) == 1]
    seen: set[int] = set()
    curves = []
    for start in [*ends, *neighbours]:
        if start in seen:
            continue
        chain = [start]
        seen.add(start)
        while True:
            onward = [edge for edge in neighbours[chain[-1]] if edge not in seen]
            if not onward:
                break
            chain.append(onward[0])
            seen.add(onward[0])
        if len(chain) > 2 and start in neighbours[chain[-1]]:
            chain.append(start)
        if len(chain) > 1:
            curves.append(points[chain])
    return curves
