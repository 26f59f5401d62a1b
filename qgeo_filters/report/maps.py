"""Figures of maps between surfaces: matched places in one colour, sides of a symmetry, regions, poses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.report.colors import carried_colors, distinct, mirror_colors, position_colors
from qgeo_filters.report.panels import Panel, panel_figure
from qgeo_filters.report.shown import SIDES, pose_colors
from qgeo_filters.report.view import View, best_view
from qgeo_filters.surface import Surface

_TURNS = (0.0, 180.0, 60.0, -60.0, 120.0, -120.0)  # degrees


def view_alike(x: SurfaceLike, view_x: View, y: SurfaceLike, p2p: npt.ArrayLike) -> View:
    """View of Y that shows what is seen of X: of six around Y, the one in which most images face the same way.

    Parameters
    ----------
    x : Surface, or whatever `as_surface` takes
    view_x : View
    y : Surface, or whatever `as_surface` takes
    p2p : array-like of int, shape (n_x,)
        Vertex of Y for each vertex of X; -1: no partner, and no part in it.
    """
    x, y = as_surface(x), as_surface(y)
    images = np.asarray(p2p)
    seen = np.sign(x.vertex_normals @ view_x.axes[2]) * x.vertex_areas * (images >= 0)
    normals = y.vertex_normals[images]
    views = [best_view(y.vertices, y.faces).turned(degrees) for degrees in _TURNS]
    return max(views, key=lambda view: float(seen @ np.sign(normals @ view.axes[2])))


def plot_correspondence(
    x: SurfaceLike,
    y: SurfaceLike,
    p2p: npt.ArrayLike,
    *,
    names: tuple[str, str] = ("X", "Y"),
    views: tuple[View, View] | None = None,
) -> Figure:
    """Figure of two surfaces where every vertex of X has the colour of the vertex of Y that it is mapped to.

    Parameters
    ----------
    x, y : Surface, or whatever `as_surface` takes
    p2p : array-like of int, shape (n_x,)
        Vertex of Y for each vertex of X; -1: no partner, and grey.
    names : (str, str)
    views : (View, View), optional
        By default the same side of both.
    """
    x, y = as_surface(x), as_surface(y)
    target = np.asarray(p2p)
    if target.shape != (x.n_vertices,):
        raise ParameterError(f"p2p has shape {target.shape}, but X has {x.n_vertices} vertices")
    if views is None:
        view = best_view(x.vertices, x.faces)
        views = view, view_alike(x, view, y, target)
    view_x, view_y = views
    colors = position_colors(y.vertices, view_y.axes)
    panels = [
        Panel(x, view_x, names[0], {"colors": carried_colors(colors, target)}),
        Panel(y, view_y, names[1], {"colors": colors}),
    ]
    return panel_figure(panels)


def plot_symmetry(
    surface: SurfaceLike,
    labels: npt.ArrayLike | None = None,
    *,
    p2p: npt.ArrayLike | None = None,
    title: str = "",
    view: View | None = None,
) -> Figure:
    """Figure of the self-symmetry from both sides (paper, Fig. 5): matched places have one colour.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    labels : array-like of int, shape (n,), optional
        Region of each vertex; the two halves of a symmetric region have one label. Grey where negative.
    p2p : array-like of int, shape (n,), optional
        Mirror image of each vertex, in place of labels: a vertex has the colour of the middle between it and
        its image.
    title : str
    view : View, optional

    Raises
    ------
    ValueError
        Unless exactly one of labels and p2p is given.
    """
    surface = as_surface(surface)
    if (labels is None) == (p2p is None):
        raise ParameterError("give labels or p2p, one of them")
    view = view or best_view(surface.vertices, surface.faces)
    options: dict[str, object]
    if labels is not None:
        numbers = np.asarray(labels)
        options = {"labels": numbers, "colors": distinct(int(numbers.max(initial=-1)) + 1)}
    else:
        assert p2p is not None
        options = {"colors": mirror_colors(surface.vertices, p2p, view.axes)}
    panels = [Panel(surface, view, options=options), Panel(surface, view.turned(180.0), options=options)]
    return panel_figure(panels, title=title)


def plot_sides(surface: SurfaceLike, side: npt.ArrayLike, *, view: View | None = None) -> Figure:
    """Figure of the two sides of a symmetry and of the axis between them (red), from both sides.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    side : array-like of int, shape (n,)
        1 and -1 on the sides, 0 on the axis.
    view : View, optional
    """
    surface = as_surface(surface)
    sides = np.asarray(side)
    if sides.shape != (surface.n_vertices,) or not np.isin(sides, (-1, 0, 1)).all():
        raise ParameterError(f"side must be -1, 0 or 1 for each of the {surface.n_vertices} vertices")
    options = {"labels": np.where(sides == 0, 2, (1 - sides) // 2).astype(np.int64), "colors": SIDES}
    view = view or best_view(surface.vertices, surface.faces)
    return panel_figure([Panel(surface, turned, options=options) for turned in (view, view.turned(180.0))])


def plot_region_pair(
    x: SurfaceLike,
    y: SurfaceLike,
    regions_x: npt.ArrayLike,
    regions_y: npt.ArrayLike,
    *,
    names: tuple[str, str] = ("X", "Y"),
    views: tuple[View, View] | None = None,
) -> Figure:
    """Figure of two surfaces where regions of equal number have one colour (paper, Fig. 6).

    Parameters
    ----------
    x, y : Surface, or whatever `as_surface` takes
    regions_x, regions_y : array-like of int, shapes (n_x,) and (n_y,)
        Grey where negative.
    names : (str, str)
    views : (View, View), optional
    """
    x, y = as_surface(x), as_surface(y)
    labels = np.asarray(regions_x), np.asarray(regions_y)
    colors = distinct(int(max(part.max(initial=-1) for part in labels)) + 1)
    views = views or (best_view(x.vertices, x.faces), best_view(y.vertices, y.faces))
    panels = [
        Panel(surface, view, name, {"labels": part, "colors": colors})
        for surface, view, name, part in zip((x, y), views, names, labels, strict=True)
    ]
    return panel_figure(panels)


def plot_poses(
    surfaces: Sequence[SurfaceLike],
    maps: Sequence[npt.ArrayLike],
    *,
    names: Sequence[str] = (),
    columns: int = 4,
    view: View | None = None,
) -> Figure:
    """Figure of poses in the colours of the first, carried over along maps: equal places have one colour.

    One camera sees them all as they stand, from where most is seen of the first, at one scale: that of their areas.

    Parameters
    ----------
    surfaces : sequence of Surface, or of whatever `as_surface` takes
    maps : sequence of array-like of int, shape (n,)
        Vertex of each pose for each of the n vertices of the first. A vertex that is not an image has the colour of the
        nearest one that is.
    names : sequence of str
        Titles.
    columns : int
    view : View, optional
        Of all.
    """
    if len(maps) != len(surfaces):
        raise ParameterError(f"one map for each of the {len(surfaces)} poses is needed, got {len(maps)}")
    poses = [as_surface(surface) for surface in surfaces]
    if not poses:
        raise ParameterError("there are no poses to be drawn")
    camera = view or best_view(poses[0].vertices, poses[0].faces)
    titles = list(names) or [""] * len(surfaces)
    panels = [
        Panel(surface, camera, title, {"colors": colors, "shown": room})
        for surface, colors, room, title in zip(
            poses, pose_colors(poses, maps, camera), _equal_rooms(poses, camera), titles, strict=True
        )
    ]
    return panel_figure(panels, columns=columns)


def _equal_rooms(poses: Sequence[Surface], view: View) -> list[FloatArray]:
    """Two corners of a box for each pose, (2, 3), that all pictures show at one scale, in units of sqrt(area)."""
    units = [float(np.sqrt(pose.area)) for pose in poses]
    seen = [pose.vertices[np.unique(pose.faces)] @ view.axes.T for pose in poses]
    half = np.max([np.ptp(points, axis=0) / (2 * unit) for points, unit in zip(seen, units, strict=True)], axis=0)
    middles = [0.5 * (points.min(axis=0) + points.max(axis=0)) for points in seen]
    return [
        np.stack([middle - unit * half, middle + unit * half]) @ view.axes
        for middle, unit in zip(middles, units, strict=True)
    ]
