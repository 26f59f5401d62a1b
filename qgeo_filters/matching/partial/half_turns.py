"""Places of a shape the other way up, or back to front, on one that it was placed on.

Where arms have grown onto a body, distances tell its upper end from the lower one no longer: of upright places of a
person on such a surface often none is proposed, but one that is upside down is. The deformation tells which is right.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.matching.partial.part_choice import PartChoice, PlacedPart


def half_turns(vertices: FloatArray, areas: FloatArray) -> list[IndexArray]:
    """Vertex (n,) nearest to each after half a turn of the shape about each principal axis of its area, in its pose.

    Parameters
    ----------
    vertices : (n, 3) float64
    areas : (n,) float64
        Area of each vertex.
    """
    centred = vertices - areas @ vertices / areas.sum()
    axes = np.linalg.eigh((centred.T * areas) @ centred)[1].T
    tree = cKDTree(centred)
    turned = [2 * np.outer(centred @ axis, axis) - centred for axis in axes]
    return [np.asarray(tree.query(points)[1], dtype=np.int64) for points in turned]


def turned_places(choice: PartChoice, places: Sequence[PlacedPart]) -> list[PlacedPart]:
    """Some places after each half turn of X, registered."""
    points = choice.x.fps[: choice.mapper.count]
    turns = half_turns(choice.x.vertices, choice.x.areas)
    maps = [place.map.p2p[turn[points]] for place in places for turn in turns]
    return choice.placed([(choice.proposed(images, "turned by half a turn"), images) for images in maps])
