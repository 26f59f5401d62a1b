"""Where a map is worst: the places themselves, seen from near, on the shape and at their images."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.report.colors import carried_colors, position_colors
from qgeo_filters.report.glyphs import ball
from qgeo_filters.report.panels import Panel, panel_figure
from qgeo_filters.report.view import View, best_view
from qgeo_filters.surface import Surface

_APART = 0.2  # of two places, in sqrt(area): else all were neighbours of one
_AROUND = 0.3  # half the width of what is seen around a place, in sqrt(area)
_SMOOTHED = 0.08  # radius of what a place's normal is the mean over
_STEEPEST = 0.8  # sine of the elevation that a place is looked at from
_MARK = (0.86, 0.11, 0.16)
_RADIUS = 0.015  # of a mark, in sqrt(area)


def worst_places(surface: SurfaceLike, values: npt.ArrayLike, count: int = 3, *, apart: float = _APART) -> IndexArray:
    """Vertices of the largest values, the worst first, no two near each other; (k,) with k at most ``count``.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    values : array-like, shape (n,)
        What is not finite is passed over.
    count : int
    apart : float
        Least distance of two places, in sqrt(area).

    Examples
    --------
    >>> from qgeo_filters.report.worst_places import worst_places
    >>> surface = qg.testing.sample_surface()
    >>> worst = worst_places(surface, surface.vertices[:, 0], 2)
    >>> bool(worst[0] == surface.vertices[:, 0].argmax()), len(worst)
    (True, 2)
    """
    surface = as_surface(surface)
    measured = np.asarray(values, dtype=np.float64)
    if measured.shape != (surface.n_vertices,):
        raise ParameterError(f"values have shape {measured.shape}, but there are {surface.n_vertices} vertices")
    left = np.where(np.isfinite(measured), measured, -np.inf)
    left[surface.unreferenced_vertices] = -np.inf
    found: list[int] = []
    while len(found) < count and np.isfinite(left).any():
        worst = int(left.argmax())
        found.append(worst)
        gaps = np.linalg.norm(surface.vertices - surface.vertices[worst], axis=1)
        left[gaps < apart * np.sqrt(surface.area)] = -np.inf
    return np.array(found, dtype=np.int64)


def plot_worst_places(
    x: SurfaceLike,
    y: SurfaceLike,
    p2p: npt.ArrayLike,
    values: npt.ArrayLike,
    places: npt.ArrayLike,
    *,
    names: tuple[str, str] = ("X", "Y"),
    colors: npt.ArrayLike | None = None,
    numbered: bool = True,
) -> Figure:
    """Figure of places of X in the upper row, and of their images on Y below, each looked at from outside.

    Parameters
    ----------
    x, y : Surface, or whatever `as_surface` takes
        Equal for a symmetry.
    p2p : array-like of int, shape (n_x,)
        Vertex of Y for each vertex of X; -1: no partner.
    values : array-like, shape (n_x,)
        What is bad there: in the titles.
    places : array-like of int, shape (k,)
        Vertices of X, see `worst_places`; they are marked by red balls, and so are their images. Where the surface
        hides one, the ball is before what hides it, and the title says so.
    names : (str, str)
    colors : array-like, shape (n_y, 3), optional
        Of the vertices of Y, carried over to X along the map; those of their place by default.
    numbered : bool
        Whether titles have the numbers of the vertices.

    Examples
    --------
    >>> from qgeo_filters.report.worst_places import plot_worst_places, worst_places
    >>> x = qg.testing.sample_surface()
    >>> found = qg.match(x, x.with_vertices(2 * x.vertices))
    >>> places = worst_places(x, found.distortion)
    >>> figure = plot_worst_places(found.x, found.y, found.p2p, found.distortion, places)
    >>> len(figure.axes) == 2 * len(places)
    True
    """
    x, y = as_surface(x), as_surface(y)
    images, measured = np.asarray(p2p), np.asarray(values, dtype=np.float64)
    chosen = np.atleast_1d(np.asarray(places, dtype=np.int64))
    if not chosen.size:
        raise ParameterError("there are no places to be drawn")
    view = best_view(y.vertices, y.faces)
    of_y = position_colors(y.vertices, view.axes) if colors is None else np.asarray(colors, dtype=np.float64)
    of_x = carried_colors(of_y, images)

    def title(name: str, vertex: int) -> str:
        return f"{name}, vertex {vertex}" if numbered else name

    upper = [_near(x, place, of_x, f"{title(names[0], place)}: {measured[place]:.3g}") for place in chosen.tolist()]
    lower = [
        _near(y, image, of_y, title(names[1], image)) if image >= 0 else Panel(y, view, "no partner")
        for image in images[chosen].tolist()
    ]
    return panel_figure([*upper, *lower], columns=len(chosen))


def _near(surface: Surface, vertex: int, colors: FloatArray, title: str) -> Panel:
    """The surface around a vertex, seen along its normal but from no steeper than upright pictures are."""
    middle, unit = surface.vertices[vertex], float(np.sqrt(surface.area))
    view = _facing(surface, vertex, unit)
    covered = _covered(surface, vertex, view)
    room = middle + _AROUND * unit * np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]) @ view.axes
    mark = ball(middle + covered * view.axes[2], _RADIUS * unit, _MARK)
    title = f"{title}, hidden" if covered > _RADIUS * unit else title
    return Panel(surface, view, title, {"colors": colors, "glyphs": [mark], "shown": room})


def _covered(surface: Surface, vertex: int, view: View) -> float:
    """How far before a vertex the foremost point of the surface lies that hides it, in a mouth or a fold; else 0."""
    seen = (surface.vertices - surface.vertices[vertex]) @ view.axes.T
    a, b, c = (seen[surface.faces[:, corner]] for corner in range(3))
    weights = np.column_stack([one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0] for one, two in ((b, c), (c, a), (a, b))])
    total = weights.sum(axis=1)
    over = ((weights >= 0).all(axis=1) | (weights <= 0).all(axis=1)) & (total != 0)
    depths = np.column_stack([a[over, 2], b[over, 2], c[over, 2]])
    return float(max(((weights[over] * depths).sum(axis=1) / total[over]).max(initial=0.0), 0.0))


def _facing(surface: Surface, vertex: int, unit: float) -> View:
    upright = best_view(surface.vertices, surface.faces)
    near = np.linalg.norm(surface.vertices - surface.vertices[vertex], axis=1) <= _SMOOTHED * unit
    outwards = (surface.vertex_areas[near, None] * surface.vertex_normals[near]).sum(axis=0)
    length = np.linalg.norm(outwards)
    if not length > 0:
        return upright
    outwards /= length
    up = upright.vertical
    rise = float(np.clip(outwards @ up, -_STEEPEST, _STEEPEST))
    level = outwards - (outwards @ up) * up
    if np.linalg.norm(level) < 1e-6:  # it looks straight up or down: from the side that the whole is seen from
        level = upright.axes[2] - (upright.axes[2] @ up) * up
    level /= np.linalg.norm(level)
    toward = np.sqrt(1 - rise**2) * level + rise * up
    right = np.cross(up, toward)
    right /= np.linalg.norm(right)
    return View(np.array([right, np.cross(toward, right), toward]), up)
