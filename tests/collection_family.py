"""A family of bent creatures in triangulations of one connectivity, whose true maps are the identity."""

from __future__ import annotations

import numpy as np
from shapes import bent, creature

from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.surface import Surface

NAMES = ("a", "b", "c", "d", "e", "f")


def family(level: int = 2) -> dict[str, Surface]:
    """Six poses, by name."""
    vertices, faces = creature(left=1.0, level=level)
    return {name: Surface(bent(vertices, 0.12 * i), faces) for i, name in enumerate(NAMES)}


def true_maps(shapes: dict[str, Surface]) -> dict[tuple[str, str], np.ndarray]:
    """The identity for each pair of different shapes, in both directions."""
    return {(x, y): np.arange(shapes[x].n_vertices) for x in shapes for y in shapes if x != y}


def mirrored(surface: Surface) -> np.ndarray:
    """Vertex nearest to the image of each under x -> -x."""
    gaps = np.linalg.norm(surface.vertices[:, None] * [-1, 1, 1] - surface.vertices[None], axis=2)
    return gaps.argmin(axis=1)


def points_of(place: BarycentricMap, surface: Surface) -> np.ndarray:
    """Where a map goes, (n, 3)."""
    return place.pulled_back(surface.vertices)
