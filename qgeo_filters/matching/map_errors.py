"""Errors of a map against the true one, on a target as people give it."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.geodesics.pairs import paired_distances
from qgeo_filters.hosts.dispatch import surface_and_repair
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.surface import Surface


def map_errors(
    y: Surface, p2p: IndexArray, truth: IndexArray, repaired: bool, matched: Repair | None, workers: int | None = None
) -> FloatArray:
    """Geodesic distance between vertices of Y, (n,), in units of sqrt(area); NaN where one of them is -1.

    Parameters
    ----------
    y : Surface
        Where it is not manifold or not welded, distances and area are those of what is; a vertex that had to go for
        that has none.
    p2p, truth : (n,) int64
        Vertices of Y; -1: none.
    repaired : bool
        Whether it was repaired for the match, in one piece: distances are those on what was matched.
    matched : Repair, optional
        What was matched in its place, if that is known.
    workers : int, optional
        Threads; all cores by default.
    """
    repair = matched or _as_matched(y, repaired)
    stands = np.arange(y.n_vertices) if repair is None else repair.vertex_of_original
    image, target = (np.where(one >= 0, stands[one], -1) for one in (p2p, truth))
    known = (image >= 0) & (target >= 0)
    errors = np.full(len(p2p), np.nan)
    surface = y if repair is None else repair.surface
    errors[known] = paired_distances(surface, image[known], target[known], workers=workers) / np.sqrt(surface.area)
    return errors


def _as_matched(y: Surface, repaired: bool) -> Repair | None:
    return surface_and_repair(y, "force", "largest")[1] if repaired else surface_and_repair(y, "auto", "all")[1]
