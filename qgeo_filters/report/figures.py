"""Figures of results on surfaces; each function returns a Matplotlib `Figure`, written by ``figure.savefig``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.report.charts import plot_distance_matrix, plot_path_curvature, plot_spectrum
from qgeo_filters.report.colors import distinct, diverging, sequential
from qgeo_filters.report.glyphs import ball, tube
from qgeo_filters.report.maps import plot_correspondence, plot_symmetry
from qgeo_filters.report.panels import Panel, panel_figure
from qgeo_filters.report.shown import SIDES, labels_of, scale_of
from qgeo_filters.report.view import View, best_view
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_index

if TYPE_CHECKING:
    from qgeo_filters.geodesics.path.geodesic_path import GeodesicPath
    from qgeo_filters.spectral.spectrum import Spectrum

__all__ = [
    "plot_attribute",
    "plot_correspondence",
    "plot_distance_field",
    "plot_distance_matrix",
    "plot_eigenfunctions",
    "plot_path",
    "plot_path_curvature",
    "plot_scalar",
    "plot_spectrum",
    "plot_surface",
    "plot_symmetry",
]

MARK = (0.86, 0.11, 0.16)
_LINES = 18


def plot_scalar(
    surface: SurfaceLike,
    values: npt.ArrayLike,
    label: str = "",
    *,
    signed: bool | None = None,
    view: View | None = None,
) -> Figure:
    """Figure of one value per vertex on the surface, with a colour bar.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    values : array-like, shape (n,)
        Grey where not finite.
    label : str
        Name and unit for the colour bar.
    signed : bool, optional
        Colours diverge from zero; by default where both signs occur.
    view : View, optional
    """
    surface = as_surface(surface)
    values = np.asarray(values, dtype=np.float64)
    scale = scale_of(values, signed)
    panel = Panel(surface, view or _view_of(surface), options={"values": values, "scale": scale})
    return panel_figure([panel], width=4.2, scale=scale, scale_label=label)


def plot_surface(surface: SurfaceLike, *, title: str = "", view: View | None = None) -> Figure:
    """Figure of the bare surface, its boundary in red."""
    surface = as_surface(surface)
    radius = 0.25 * _radius(surface)
    edges = {tuple(edge) for edge in surface.edges[surface.boundary_edges].tolist()}
    glyphs = []
    for loop in surface.boundary_loops:
        # Of what is not manifold the boundary may be a chain that does not close.
        closed = tuple(sorted((int(loop[0]), int(loop[-1])))) in edges
        line = surface.vertices[np.append(loop, loop[0]) if closed else loop]
        if np.ptp(line, axis=0).any():
            glyphs.append(tube(line, radius, MARK))
    panel = Panel(surface, view or _view_of(surface), title, {"glyphs": glyphs})
    return panel_figure([panel], width=4.2)


def plot_attribute(
    surface: SurfaceLike, name: str, values: npt.ArrayLike, *, view: View | None = None, images: bool = False
) -> Figure:
    """Figure of a named attribute of any width: whole numbers as regions, columns side by side (the first six).

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    name : str
    values : array-like, shape (n,) or (n, k)
    view : View, optional
    images : bool
        Whether the values are vertices of the same surface, such as mirror images: not their numbers are shown, a
        vertex and its image have one colour (`plot_symmetry`).
    """
    surface = as_surface(surface)
    if images:
        return plot_symmetry(surface, p2p=values, title=name, view=view)
    values = np.asarray(values).reshape(surface.n_vertices, -1)
    view = view or _view_of(surface)
    if values.shape[1] == 1 and (regions := labels_of(values[:, 0])):
        numbers = values[:, 0].astype(np.int64)
        options = {"labels": regions[0], "colors": distinct(regions[1])}
        if numbers.min() == -1 and numbers.max() == 1:  # two sides, and what lies between them
            options = {"labels": numbers + 1, "colors": SIDES[[1, 2, 0]]}
        return panel_figure([Panel(surface, view, name, options)], width=4.2)
    if values.shape[1] == 1:
        return plot_scalar(surface, values[:, 0], name, view=view)
    shown = values[:, :6].astype(np.float64)
    finite = shown[np.isfinite(shown)]
    signed = bool(finite.size) and float(finite.min()) < 0
    scale = diverging(shown) if signed else sequential(shown)
    panels = [
        Panel(surface, view, f"column {k}", {"values": shown[:, k], "scale": scale}) for k in range(shown.shape[1])
    ]
    return panel_figure(panels, columns=3, scale=scale, scale_label=name)


def plot_eigenfunctions(
    surface: SurfaceLike,
    spectrum: Spectrum,
    indices: Sequence[int] | None = None,
    *,
    columns: int = 3,
    view: View | None = None,
) -> Figure:
    r"""Figure of eigenfunctions on the surface, all on one scale centred on zero.

    Shown without unit, :math:`\phi_k \sqrt{A}` with :math:`A` the surface's area: a constant function would be
    1 everywhere.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    spectrum : Spectrum
    indices : sequence of int, optional
        Which eigenfunctions, from 0; the first six by default.
    columns : int
    view : View, optional
    """
    surface = as_surface(surface)
    count = spectrum.eigenfunctions.shape[1]
    chosen = list(range(min(6, count))) if indices is None else [checked_index(k, count, "index") for k in indices]
    values = spectrum.eigenfunctions[:, chosen] * np.sqrt(surface.area)
    scale = diverging(values)
    view = view or _view_of(surface)
    panels = [
        Panel(
            surface,
            view,
            rf"$\phi_{{{k + 1}}}$    $\gamma$ = {spectrum.eigenvalues[k]:.3g}",
            {"values": values[:, j], "scale": scale, "isolines": [0.0] if values[:, j].min() < 0 else []},
        )
        for j, k in enumerate(chosen)
    ]
    return panel_figure(panels, columns=columns, scale=scale, scale_label=r"$\phi_k\,\sqrt{A}$ (line: zero)")


def plot_distance_field(
    surface: SurfaceLike,
    distances: npt.ArrayLike,
    source: int | Sequence[int] | None = None,
    *,
    label: str = "distance (mesh units)",
    lines: int = _LINES,
    view: View | None = None,
) -> Figure:
    """Figure of the distances from a source with lines of equal distance.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    distances : array-like, shape (n,)
        Grey where infinite (other pieces of the surface).
    source : int or sequence of int, optional
        Vertices to mark.
    label : str
    lines : int
        About how many lines; their spacing is a round number, which the colour bar's label names.
    view : View, optional
    """
    surface = as_surface(surface)
    distances = np.asarray(distances, dtype=np.float64)
    scale = sequential(distances)
    locator = MaxNLocator(max(lines, 1), steps=[1, 2, 2.5, 5, 10])
    levels = np.asarray(locator.tick_values(scale.low, scale.high))
    levels = levels[(levels > scale.low) & (levels < scale.high)]
    spacing = f", a line every {levels[1] - levels[0]:g}" if len(levels) > 1 else ""
    marks = [] if source is None else np.atleast_1d(source).tolist()
    glyphs = [
        ball(surface.vertices[checked_index(v, surface.n_vertices, "source")], _radius(surface), MARK) for v in marks
    ]
    view = view or _view_of(surface, surface.vertices[marks].mean(axis=0) if marks else None)
    options = {"values": distances, "scale": scale, "isolines": levels, "glyphs": glyphs}
    return panel_figure([Panel(surface, view, options=options)], width=4.2, scale=scale, scale_label=label + spacing)


def plot_path(surface: SurfaceLike, path: GeodesicPath, *, view: View | None = None) -> Figure:
    """Figure of a path on the surface; its start is the lighter of the two marks.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
    path : GeodesicPath
        Anything with ``points`` (p, 3) and ``length``.
    view : View, optional
    """
    surface = as_surface(surface)
    points = np.asarray(path.points, dtype=np.float64)
    radius = _radius(surface)
    glyphs = [ball(points[0], 1.25 * radius, (0.98, 0.75, 0.18)), ball(points[-1], 1.25 * radius, MARK)]
    if np.ptp(points, axis=0).any():
        glyphs.append(tube(points, 0.5 * radius, MARK))
    view = view or _view_of(surface, points.mean(axis=0))
    panel = Panel(surface, view, f"length {path.length:.5g} mesh units", {"glyphs": glyphs})
    return panel_figure([panel], width=4.2)


def _view_of(surface: Surface, focus: npt.NDArray[np.float64] | None = None) -> View:
    """Best view; the one of the two opposite ones from whose side a point of interest lies nearer."""
    view = best_view(surface.vertices, surface.faces)
    if focus is None:
        return view
    middle = 0.5 * (surface.vertices.min(axis=0) + surface.vertices.max(axis=0))
    other = view.turned(180.0)
    return view if (focus - middle) @ view.axes[2] >= (focus - middle) @ other.axes[2] else other


def _radius(surface: Surface) -> float:
    """Radius of the mark of a point."""
    return 0.012 * float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
