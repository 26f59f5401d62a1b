"""Maps between repaired meshes brought back to the vertices that were given."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray
from qgeo_filters.closest_points import nearest_facing_vertices
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.surface import Surface

# Where a place between the images of three corners is farther than so many of the longest edges from that of the
# nearest corner, the map is torn there, and the nearest corner is taken.
_TORN = 2.0


def keep_vertices(*repairs: Repair | None) -> bool:
    """Whether all vertices of what was repaired, or not, are given ones."""
    return all(repair is None or repair.keeps_vertices for repair in repairs)


def images_on_given(images: IndexArray, of: Repair | None, on: Repair | None, target: Surface) -> IndexArray:
    """Given vertex of one shape for each given vertex of another, or of the same.

    Parameters
    ----------
    images : (n,) int64
        Vertex of ``target`` for each vertex of the repaired shape; -1: none.
    of, on : Repair, optional
        Of the shape whose vertices are mapped, and of that on which they are mapped; None: it is as it was given.
    target : Surface
        What is mapped onto: ``on.surface``, where it was repaired.

    Returns
    -------
    (n_given,) int64
        By index where vertices were kept. A wrap has vertices of its own, and fewer: the given vertex that is nearest
        to the place between their images, and faces the same way. -1 where there is none.
    """
    if keep_vertices(of, on):
        if on is not None:
            images = np.where(images >= 0, on.origin[np.maximum(images, 0)], -1)
        return images if of is None else of.map_back(images)
    corner = images if of is None else of.map_back(images)  # -1 where a vertex has no place, or no image
    if of is on and of is not None and np.array_equal(images, np.arange(len(images))):
        return np.where(corner >= 0, np.arange(len(corner)), -1)  # what moves nothing moves nothing
    there = np.column_stack([target.vertices, target.vertex_normals])
    places = np.where((corner >= 0)[:, None], there[corner], np.nan)
    if of is not None:
        between = of.map_back(np.where((images >= 0)[:, None], there[images], np.nan))
        gap = np.linalg.norm(between[:, :3] - places[:, :3], axis=1)
        smooth = gap < _TORN * target.edge_lengths.max()  # not where a corner has no image: NaN
        places = np.where(smooth[:, None], between, places)
    return nearest_facing_vertices(places, given_places(on, target), target)


def given_places(repair: Repair | None, surface: Surface) -> np.ndarray:
    """Given vertices beside the normals of the repaired surface (n_given, 6); NaN where one is gone."""
    normals = surface.vertex_normals
    if repair is None:
        return np.column_stack([surface.vertices, normals])
    return np.column_stack([repair.given.vertices, repair.map_back(normals)])
