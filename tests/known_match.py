"""Results of `match` that are known without matching: the same shape in two triangulations, one of them moved."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree
from shapes import icosphere

from qgeo_filters.matching.maps.barycentric import BarycentricMap, barycentric_map
from qgeo_filters.matching.match_log import MatchLog
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.surface import Surface

TURN = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
AXES = np.array([1.0, 1.4, 0.8])
PLACE = np.array([3.0, -2.0, 5.0])


def moved(points: np.ndarray) -> np.ndarray:
    """Points of X as they are on Y."""
    return 2.0 * points @ TURN + PLACE


def ellipsoids(fine: int = 3, coarse: int = 2) -> MatchResult:
    """A fine ellipsoid X and a coarse one Y, turned, moved and twice as large: 642 and 162 vertices."""
    x = Surface(icosphere(fine)[0] * AXES, icosphere(fine)[1])
    y = Surface(moved(icosphere(coarse)[0] * AXES), icosphere(coarse)[1])
    return known(x, y, moved(x.vertices))


def known(x: Surface, y: Surface, positions: np.ndarray, **others: Any) -> MatchResult:
    """Result of a match that put X at these positions in the frame of Y; the other numbers are made up."""
    p2p = others.pop("p2p", cKDTree(y.vertices).query(positions)[1])
    values: dict[str, Any] = {
        "inverse": cKDTree(positions).query(y.vertices)[1],
        "functional_map": np.eye(20),
        "c_xy": 0.01,
        "distortion": np.linspace(0.0, 0.02, x.n_vertices),
        "score": 0.01,
        "runner_up": 0.2,
        "margin": 3.5,
        "orientation": 0.7,
        "hks_agreement": 0.98,
        "confident": True,
        "explanation": "distances are kept",
        "regions_x": np.zeros(x.n_vertices, dtype=np.int32),
        "regions_y": np.zeros(y.n_vertices, dtype=np.int32),
        "barycentric": barycentric_map(positions, p2p, y),
        "log": MatchLog(),
    }
    return MatchResult(x=x, y=y, p2p=p2p, positions=positions, **{**values, **others})


def without_partners(found: MatchResult, lost_x: np.ndarray, lost_y: np.ndarray) -> MatchResult:
    """The same result, some vertices of both shapes without a partner."""
    p2p, inverse = np.where(lost_x, -1, found.p2p), np.where(lost_y, -1, found.inverse)
    place = found.barycentric
    cut = BarycentricMap(
        np.where(lost_x, -1, place.faces),
        np.where(lost_x[:, None], -1, place.corners),
        np.where(lost_x[:, None], np.nan, place.coordinates),
    )
    positions = np.where(lost_x[:, None], np.nan, found.positions)
    return replace(found, p2p=p2p, inverse=inverse, barycentric=cut, positions=positions)
