"""A shape with the triangles of another one, the template: what statistics of shapes are made of."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import IndexArray, RepairOption
from qgeo_filters.animation.places import MapLike, Places, places_on, warned
from qgeo_filters.animation.scans import laid_onto
from qgeo_filters.closest_points import closest_points
from qgeo_filters.collection.unfolding import put_onto
from qgeo_filters.hosts.dispatch import SurfaceLike, as_given
from qgeo_filters.parallel import default_workers, single_threaded_blas
from qgeo_filters.surface import Surface

# Below which the template's shape is kept before it is put onto the surface, in sqrt(area): longer loses places,
# shorter folds triangles.
_LENGTH = 0.01


def remesh_like(
    template: SurfaceLike,
    shape: SurfaceLike,
    correspondence: MapLike | None = None,
    *,
    accept_unsure: bool = False,
    repair: RepairOption = "auto",
    workers: int | None = None,
) -> Surface:
    """The shape with the template's triangles: vertex i is at the same place as vertex i of the template.

    Parameters
    ----------
    template, shape : Surface, or whatever `as_surface` takes
        Two shapes that bend into each other, in any triangulation, position and size.
    correspondence : MatchResult, BarycentricMap or array-like of int, shape (n,), optional
        A match of the two, in either direction; or the point, or vertex, of the shape for each vertex of the template
        (-1: none). By default it is found by `match`.
    accept_unsure : bool
        Whether a match that is not sure is used all the same, with a warning.
    repair : bool, "auto", "force" or "wrap"
        What is repaired where a match is sought, see `match`: with "wrap" raw CT, say, is matched as a closed surface
        around it. The vertices are all of those of the template as it was given.
    workers : int, optional
        Threads; all cores that the process may use by default. The result does not depend on it.

    Returns
    -------
    Surface
        The template's n vertices, triangles and attributes, where the shape is. Each vertex with a partner lies on the
        surface of the shape, or on the closed surface around it that was matched; the others are where the template
        bends to as rigidly as possible.

    Raises
    ------
    ParameterError
        A correspondence that is not sure, reverses the orientation, or is one of other shapes.
    MeshError
        Shapes that cannot be matched.

    Warns
    -----
    UserWarning
        A match that is not sure; triangles that are turned over on the surface, where the map folds or the template is
        much coarser than the shape.

    Notes
    -----
    A map that is right to within an edge or two folds small triangles. So the template is brought onto the images of
    its vertices as rigidly as possible (`posed`) and put onto the surface near these images (`put_onto`), where folds
    that are left are evened out.

    Examples
    --------
    >>> template = qg.testing.sample_surface()
    >>> longer = template.with_vertices(template.vertices * [1, 1, 1.2])
    >>> shape = qg.Surface(longer.vertices[::-1], 161 - longer.faces)  # the same in another numbering
    >>> same = qg.remesh_like(template, shape, 161 - np.arange(162))  # without a map it is found
    >>> bool((same.faces == template.faces).all()), bool(np.allclose(same.vertices, longer.vertices, atol=0.02))
    (True, True)
    """
    with default_workers(workers), single_threaded_blas:
        body, target = as_given(template, "auto")[0], as_given(shape, "auto")[0]
        places = places_on(target, body, correspondence, accept_unsure, repair=repair)
        remeshed, doubts = laid_along(body, target, places)
    warned(doubts)
    return remeshed


def laid_along(template: Surface, shape: Surface, places: Places) -> tuple[Surface, tuple[str, ...]]:
    """The shape with the template's triangles along a map that is known, and what is to be warned of."""
    laid = template.with_vertices(laid_onto(template, shape, places, _LENGTH))
    vertices, turned = put_onto(*_outside(laid, shape, places))
    doubts = places.doubts
    if turned.size:
        count = f"{turned.size} of {template.n_faces}"
        doubts += (f"{count} triangles are turned over on the surface, the first is {turned[0]}",)
    return template.with_vertices(vertices), doubts


def _outside(laid: Surface, target: Surface, places: Places) -> tuple[Surface, Surface, IndexArray]:
    """What is put onto what, and from where: the outsides, where shapes were wrapped.

    Of pieces, and of walls with two sides, nobody knows else which way a triangle should look.
    """
    near = places.on_x.nearest_corner
    around_target, around_body = places.wraps
    if around_body is not None:
        given = around_body.given
        middles = closest_points(given.vertices[given.faces].mean(axis=1), around_body.surface)
        outwards = np.einsum("ij,ij->i", given.face_normals, around_body.surface.face_normals[middles.faces]) >= 0
        laid = Surface(laid.vertices, np.where(outwards[:, None], laid.faces, laid.faces[:, ::-1]))
    if around_target is not None:
        target, near = around_target.surface, np.where(near >= 0, around_target.vertex_of_original[near], -1)
    return laid, target, near
