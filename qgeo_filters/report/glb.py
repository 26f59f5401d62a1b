"""A map as a scene for 3D viewers: both shapes side by side, what belongs together in one colour."""

from __future__ import annotations

from os import PathLike

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.io.gltf_writing import colored_mesh
from qgeo_filters.io.landmarks import Landmarks
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.report.colors import MISSING, ordered_colors, position_colors
from qgeo_filters.report.maps import view_alike
from qgeo_filters.report.view import View, best_view

_RADIUS = 0.008  # of the ball of a landmark, as a share of the shape's extent
_GAP = 0.15  # between the shapes, as a share of the wider one


def map_colors(found: MatchResult, view_y: View) -> tuple[FloatArray, FloatArray]:
    """Colours of the vertices of X and of Y: those of Y by their place, carried over to X; grey without partner."""
    places = position_colors(found.y.vertices, view_y.axes)
    carried = found.transfer(places, to="x")
    return (
        np.where(np.isnan(carried), MISSING, np.clip(carried, 0.0, 1.0)),
        np.where(found.inverse[:, None] < 0, MISSING, places),
    )


def write_match_glb(
    path: str | PathLike[str], found: MatchResult, *, normalize: bool = True, landmarks: Landmarks | None = None
) -> None:
    """Write both shapes, at full resolution, as binary glTF with a colour for each vertex.

    Parameters
    ----------
    path : path
    found : MatchResult
        Vertices of X have the colours of their images on Y; those without a partner are grey.
    normalize : bool
        Whether both are drawn in one size, whatever their areas.
    landmarks : Landmarks, optional
        Of X: small balls there and at their images on Y, of one colour for each, called ``X NAME`` and ``Y NAME``.

    Notes
    -----
    The nodes ``X`` and ``Y`` turn, scale and move the shapes so that a viewer shows them from the side of the report's
    picture, X on the left; their meshes have the coordinates that were given.
    """
    import trimesh

    x, y = found.x, found.y
    view = best_view(x.vertices, x.faces)
    views = view, view_alike(x, view, y, found.p2p)
    colors = map_colors(found, views[1])
    units = np.sqrt(x.area), np.sqrt(y.area if normalize else x.area)
    scene = trimesh.Scene()
    placements = [
        placed_beside(surface.vertices[surface.faces.ravel()], view_of, unit, side)
        for surface, view_of, unit, side in zip((x, y), views, units, (-1.0, 1.0), strict=True)
    ]
    for name, surface, color, placement in zip("XY", (x, y), colors, placements, strict=True):
        mesh = colored_mesh(surface.vertices, surface.faces, color, surface.vertex_normals)
        scene.add_geometry(mesh, node_name=name, geom_name=f"{name} mesh", transform=placement)
    if landmarks is not None:
        for name, surface, marks, placement in zip(
            "XY", (x, y), (landmarks, found.landmarks(landmarks)), placements, strict=True
        ):
            places = np.where(np.isnan(marks.points), surface.vertices[marks.vertices], marks.points)
            radius = _RADIUS * float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
            for k, color in enumerate(ordered_colors(len(marks))):
                if marks.is_known[k]:
                    ball = trimesh.creation.icosphere(subdivisions=2, radius=radius)
                    mesh = colored_mesh(ball.vertices + places[k], ball.faces, np.tile(color, (len(ball.vertices), 1)))
                    called = f"{name} {marks.names[k]}"
                    scene.add_geometry(mesh, node_name=f"{called} ({k + 1})", geom_name=called, transform=placement)
    content = scene.export(file_type="glb", include_normals=True)
    with atomic_write(path) as file:
        file.write(content)


def placed_beside(points: FloatArray, view: View, unit: float, side: float) -> FloatArray:
    """Placement (4, 4) of points: seen as in a view, of that unit, left (-1), right (1) of the origin, or there (0)."""
    turned = points @ view.axes.T / unit
    low, high = turned.min(axis=0), turned.max(axis=0)
    shift = -0.5 * (low + high)
    shift[0] += side * 0.5 * (1 + _GAP) * (high[0] - low[0])
    placement = np.eye(4)
    placement[:3, :3] = view.axes / unit
    placement[:3, 3] = shift
    return placement
