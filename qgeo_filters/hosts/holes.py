"""Holes of a surface filled with triangles: by MeshLab, without a vertex more."""

from __future__ import annotations

import numpy as np

from qgeo_filters.errors import ParameterError
from qgeo_filters.surface import Surface


def checked_holes(fill_holes: bool | int) -> int:
    """Most edges of the holes that are filled: 0 for none, as many as there may be for True."""
    if isinstance(fill_holes, bool):
        return 2**31 - 1 if fill_holes else 0
    if not isinstance(fill_holes, (int, np.integer)) or fill_holes < 3:
        raise ParameterError(f"fill_holes must be True, False or a number of edges from 3 on, got {fill_holes!r}")
    return int(fill_holes)


def filled(surface: Surface, most_edges: int) -> tuple[Surface, str]:
    """The manifold surface with its holes of at most so many edges filled, and a sentence on it, empty if none was.

    Vertices, attributes and faces stay; the faces that fill the holes come last.
    """
    if not most_edges or not len(surface.boundary_edges):
        return surface, ""
    import pymeshlab  # only where it is used: it takes a second

    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(surface.vertices, surface.faces))
    done = meshes.meshing_close_holes(maxholesize=most_edges, newfaceselected=False, selfintersection=False)
    closed, added = int(done["closed_holes"]), int(done["new_faces"])
    if not added:
        return surface, ""
    faces = meshes.current_mesh().face_matrix()
    said = f"{closed} hole{'s' * (closed > 1)} filled with {added} face{'s' * (added > 1)}"
    return Surface(surface.vertices, faces, surface.attributes), said
