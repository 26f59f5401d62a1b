"""Regions of equal colour on two shapes (paper, Fig. 6)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.matching.maps.functional_map import functional_map, nearest_neighbors, procrustes
from qgeo_filters.sampling import farthest_in_embedding
from qgeo_filters.validation import checked_count

_TURNS = 20


def eigenfunction_regions(
    phi_x: FloatArray, phi_y: FloatArray, p2p: IndexArray, areas_x: FloatArray, count: int = 12
) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Region of each vertex of X and of Y, shapes (n_x,) and (n_y,), with equal numbers for matching regions.

    X is cut into clusters of its vertices in the space of the eigenfunctions (k-means from farthest
    points, which needs no random start); a vertex of Y belongs to the cluster that is nearest through the
    functional map.

    Parameters
    ----------
    phi_x, phi_y : (n_x, k), (n_y, k) float64
        Eigenfunctions of both shapes.
    p2p : (n_x,) int
        Vertex of Y for each vertex of X.
    areas_x : (n_x,) float64
    count : int
        Number of regions, at most n_x.
    """
    count = checked_count(count, 1, len(phi_x), "the number of regions")
    carried = phi_x @ procrustes(functional_map(phi_x, phi_y, p2p, areas_x))
    centres = carried[farthest_in_embedding(carried, count)]
    for _ in range(_TURNS):
        label = nearest_neighbors(carried, centres)
        weight = np.bincount(label, areas_x, count)
        sums = np.column_stack([np.bincount(label, areas_x * column, count) for column in carried.T])
        moved = np.where(weight[:, None] > 0, sums / np.where(weight > 0, weight, 1.0)[:, None], centres)
        if np.allclose(moved, centres):
            break
        centres = moved
    return nearest_neighbors(carried, centres).astype(np.int32), nearest_neighbors(phi_y, centres).astype(np.int32)
