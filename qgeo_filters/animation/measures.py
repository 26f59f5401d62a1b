"""What a motion does to a surface: how far lengths change, and where it folds over."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.animation.sequence import Animation
from qgeo_filters.surface import Surface
from qgeo_filters.triangle_geometry import face_crosses, unit_normals

# Neighbours whose normals have a product below this lie on each other: more than 120 degrees between them.
_FOLDED = -0.5


def edge_changes(animation: Animation) -> FloatArray:
    """Mean relative change of the lengths of edges, from rest, in each frame, (k,)."""
    surface = animation.surface
    rest = surface.edge_lengths
    kept = rest > 0
    ends = surface.edges[kept]
    moved = np.linalg.norm(animation.positions[:, ends[:, 0]] - animation.positions[:, ends[:, 1]], axis=2)
    changes: FloatArray = np.abs(moved / rest[kept] - 1).mean(axis=1)
    return changes


def folded_edges(surface: Surface, positions: FloatArray) -> int:
    """Number of edges across which two triangles lie on each other that do not at rest."""
    half = np.flatnonzero(surface.twins.ravel() > np.arange(3 * surface.n_faces))
    one, other = half // 3, surface.twins.ravel()[half] // 3
    cosines = []
    for places in (surface.vertices, positions):
        normals = unit_normals(face_crosses(places, surface.faces))
        cosines.append(np.einsum("ij,ij->i", normals[one], normals[other]))
    return int(np.sum((cosines[1] < _FOLDED) & (cosines[0] >= _FOLDED)))
