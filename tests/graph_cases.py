"""Meshes and oracles that the tests of the graph method share."""

from __future__ import annotations

import numpy as np
import pygeodesic.geodesic as pygeodesic
import shapes

from qgeo_filters.geodesics.metric import LiftedMetric
from qgeo_filters.surface import Surface

MANIFOLDS = {
    "blob": lambda: shapes.blob(3),
    "stretched blob": lambda: (shapes.blob(3)[0] * [1, 1, 8], shapes.blob(3)[1]),
    "torus": lambda: shapes.torus(30, 15),
    "open cylinder": lambda: shapes.cylinder(24, 12),
    "sharp cone": lambda: shapes.cone(20, 12, slope=12.0),
    "irregular plane": lambda: shapes.terrain(400, 0),
    "anisotropic plane": lambda: (shapes.terrain(400, 1)[0] * [50, 1, 1], shapes.terrain(400, 1)[1]),
    "Moebius band": lambda: shapes.moebius(30, 3),
}


def lifted_plane(weight: float, n: int = 15, seed: int = 0) -> tuple[LiftedMetric, np.ndarray]:
    """Metric of a planar mesh with a rough scalar, and the vertices of the same surface in space."""
    vertices, faces = shapes.grid(n, 0.3, seed)
    surface = Surface(vertices, faces)
    noise = np.random.default_rng(seed).normal(size=len(vertices))
    scalar = np.sin(7 * vertices[:, 0]) * np.cos(5 * vertices[:, 1]) + 0.3 * noise
    scalar /= scalar.std()
    lifted = vertices.copy()
    lifted[:, 2] = weight * np.sqrt(surface.area) * scalar
    lengths = np.linalg.norm(lifted[surface.edges[:, 0]] - lifted[surface.edges[:, 1]], axis=1)
    return LiftedMetric(surface, scalar, weight, lengths), lifted


def exact_rows(vertices: np.ndarray, faces: np.ndarray, sources: np.ndarray) -> np.ndarray:
    """Exact distances (s, n) by pygeodesic (MMP, Kirsanov's implementation)."""
    solver = pygeodesic.PyGeodesicAlgorithmExact(np.ascontiguousarray(vertices, float), np.ascontiguousarray(faces))
    return np.array([solver.geodesicDistances(np.array([s]), None)[0] for s in sources])


def relative_error(distances: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Signed relative error; where the exact distance is zero the distance itself."""
    return np.where(exact > 0, (distances - exact) / np.where(exact > 0, exact, 1), distances)
