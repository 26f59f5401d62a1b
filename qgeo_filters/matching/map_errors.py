"""Errors of a map against the true one, on a target as people give it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray, RepairOption
from qgeo_filters.geodesics.pairs import paired_distances
from qgeo_filters.hosts.dispatch import surface_and_repair
from qgeo_filters.hosts.wrap import says_wrapped
from qgeo_filters.surface import Surface


def map_errors(
    y: Surface, p2p: IndexArray, truth: IndexArray, repairs: Sequence[str], workers: int | None = None
) -> FloatArray:
    """Geodesic distance between vertices of Y, (n,), in units of sqrt(area); NaN where one of them is -1.

    Parameters
    ----------
    y : Surface
        Where it is not manifold or not welded, distances and area are those of what is; a vertex that had to go for
        that has none.
    p2p, truth : (n,) int64
        Vertices of Y; -1: none.
    repairs : sequence of str
        What was repaired of it for the match, in one piece: distances are those on what was matched, a wrap too.
    workers : int, optional
        Threads; all cores by default.
    """
    repair = surface_and_repair(y, _option(repairs), "largest" if repairs else "all")[1]
    stands = np.arange(y.n_vertices) if repair is None else repair.vertex_of_original
    image, target = (np.where(one >= 0, stands[one], -1) for one in (p2p, truth))
    known = (image >= 0) & (target >= 0)
    errors = np.full(len(p2p), np.nan)
    surface = y if repair is None else repair.surface
    errors[known] = paired_distances(surface, image[known], target[known], workers=workers) / np.sqrt(surface.area)
    return errors


def _option(repairs: Sequence[str]) -> RepairOption:
    """What repairs the shape as it was repaired for the match."""
    if not repairs:
        return "auto"
    return "wrap" if says_wrapped(repairs) else "force"
