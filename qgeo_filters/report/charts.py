"""Charts of numbers: the distance matrix as an image (paper, Fig. 1) and the spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import MaxNLocator
from scipy.cluster.hierarchy import leaves_list, linkage, optimal_leaf_ordering
from scipy.spatial.distance import squareform

from qgeo_filters.errors import ParameterError
from qgeo_filters.hosts.dispatch import SurfaceLike, as_surface
from qgeo_filters.report.colors import MISSING, ordered_colors, sequential
from qgeo_filters.report.panels import STYLE, Panel, draw_panel, new_figure
from qgeo_filters.report.view import View, best_view

if TYPE_CHECKING:
    from qgeo_filters.geodesics.path.geodesic_path import GeodesicPath

_ROWS = 700  # as many as the picture has pixels


def matrix_order(matrix: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """Order of the rows (n,) in which neighbours in the matrix are neighbours on the surface.

    The leaves of an average-linkage tree, turned so that consecutive leaves are as close as can be
    (Bar-Joseph, Gifford, Jaakkola, Bioinformatics 17, 2001). Above 700 rows, of 700 of them evenly spaced,
    each followed by the rows that it is nearest to.
    """
    matrix = np.asarray(matrix)
    some = _evenly(np.arange(len(matrix)))
    if len(some) < 3:
        return np.arange(len(matrix))
    rows = np.asarray(matrix[some], dtype=np.float64)
    rows[~np.isfinite(rows)] = 2.0 * rows[np.isfinite(rows)].max()
    part = rows[:, some]
    condensed = squareform(0.5 * (part + part.T), checks=False)
    leaves = leaves_list(optimal_leaf_ordering(linkage(condensed, "average"), condensed))
    rank = np.empty(len(some), dtype=np.int64)
    rank[leaves] = np.arange(len(some))
    return np.argsort(rank[rows.argmin(axis=0)], kind="stable")


def plot_distance_matrix(
    matrix: npt.ArrayLike,
    surface: SurfaceLike | None = None,
    *,
    order: npt.ArrayLike | None = None,
    label: str = "distance (mesh units)",
    view: View | None = None,
) -> Figure:
    """Figure of the matrix of all distances as an image (paper, Fig. 1), one colour bar.

    Parameters
    ----------
    matrix : array-like, shape (n, n)
        More than 700 rows are shown by 700 of them, evenly spaced in the order. Grey where infinite.
    surface : Surface, or whatever `as_surface` takes, optional
        Shown beside the matrix in the colours of a strip along its rows, so that a row can be found on the shape.
    order : array-like of int, shape (n,), optional
        Order of rows and columns, `matrix_order` by default.
    label : str
    view : View, optional

    Raises
    ------
    ValueError
        If the matrix is not square, or the order not as long as it.
    """
    surface = None if surface is None else as_surface(surface)
    matrix = np.asarray(matrix)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise ParameterError(f"the distance matrix must be square, got shape {matrix.shape}")
    order = matrix_order(matrix) if order is None else np.asarray(order)
    if order.shape != (len(matrix),):
        raise ParameterError(f"order has shape {order.shape}, but the matrix has {len(matrix)} rows")
    shown = _evenly(order)
    part = np.asarray(matrix[np.ix_(shown, shown)], dtype=np.float64)
    with matplotlib.rc_context(STYLE):
        if surface is None:
            figure = new_figure(4.4, 3.8)
            _draw_matrix(figure, figure.add_gridspec(1, 1)[0], part, label, len(order))
            return figure
        figure = new_figure(7.4, 3.8)
        grid = figure.add_gridspec(1, 2, width_ratios=[1.0, 1.25])
        colors = ordered_colors(len(order))
        rank = np.empty(len(order), dtype=np.int64)
        rank[order] = np.arange(len(order))
        options = {"labels": rank, "colors": colors}
        view = view or best_view(surface.vertices, surface.faces)
        draw_panel(figure, grid[0], Panel(surface, view, "where the rows are", options), 3.2, 3.3)
        axes = _draw_matrix(figure, grid[1], part, label, len(order))
        strip = axes.inset_axes((-0.055, 0.0, 0.035, 1.0))
        strip.imshow(colors[:, None], aspect="auto", interpolation="antialiased")
        strip.set_axis_off()
    return figure


def _evenly(order: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """At most 700 entries, evenly spaced."""
    return order[np.unique(np.linspace(0, len(order) - 1, min(len(order), _ROWS)).round().astype(int))]


def plot_spectrum(eigenvalues: npt.ArrayLike, *, label: str = r"$|\gamma_k|\,/\,|\gamma_1|$") -> Figure:
    """Figure of the eigenvalues' magnitudes, on a logarithmic scale, relative to the first; the sign is the colour.

    Parameters
    ----------
    eigenvalues : array-like, shape (k,)
        By decreasing magnitude.
    label : str
        Of the vertical axis.
    """
    values = np.asarray(eigenvalues, dtype=np.float64)
    if values.ndim != 1 or values.size == 0:
        raise ParameterError(f"eigenvalues must have shape (k,) with k >= 1, got {values.shape}")
    size = np.abs(values) / max(float(np.abs(values).max()), 1e-300)
    k = np.arange(1, len(values) + 1)
    figure = new_figure(4.6, 3.2)
    with matplotlib.rc_context(STYLE):
        axes = figure.add_subplot()
        axes.plot(k, size, color="0.75", linewidth=1.0, zorder=1)
        for sign, color, name in ((1, "#b2352f", "positive"), (-1, "#2c5fa8", "negative")):
            chosen = np.sign(values) == sign
            if chosen.any():
                axes.scatter(k[chosen], size[chosen], 26, color=color, label=f"{name} ({chosen.sum()})", zorder=2)
        axes.set_yscale("log")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))
        axes.set(xlabel="k", ylabel=label, title="eigenvalues by decreasing magnitude")
        axes.grid(True, which="major", color="0.92", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.legend(frameon=False, title=r"sign of $\gamma_k$")
    return figure


def plot_path_curvature(path: GeodesicPath) -> Figure:
    """Figure of the geodesic curvature, eq. (1), at the points of a path, over the way gone.

    Parameters
    ----------
    path : GeodesicPath
        Anything with ``points`` (p, 3) and ``kappa_g`` (p - 2,).
    """
    step = np.linalg.norm(np.diff(np.asarray(path.points, dtype=np.float64), axis=0), axis=1)
    way = np.cumsum(step)[:-1]
    figure = new_figure(4.6, 2.6)
    with matplotlib.rc_context(STYLE):
        axes = figure.add_subplot()
        axes.axhline(0.0, color="0.75", linewidth=0.8, zorder=0)
        axes.vlines(way, 0.0, path.kappa_g, color="#2c5fa8", linewidth=1.2)
        axes.plot(way, path.kappa_g, "o", color="#2c5fa8", markersize=3.0)
        axes.set(
            xlabel="way from the start (mesh units)",
            ylabel=r"$\kappa_g$ (radians)",
            xlim=(0.0, float(step.sum()) or 1.0),
        )
        if np.abs(path.kappa_g).max(initial=0.0) < 1e-3:
            axes.set_ylim(-1e-3, 1e-3)
    return figure


def _draw_matrix(figure: Figure, place: SubplotSpec, part: npt.NDArray[np.float64], label: str, count: int) -> Axes:
    axes = figure.add_subplot(place)
    scale = sequential(part)
    colormap = scale.colormap.with_extremes(bad=MISSING)
    image = axes.imshow(
        np.ma.masked_invalid(part),
        cmap=colormap,
        norm=scale.norm,
        interpolation="antialiased",
        extent=(0, count, count, 0),
    )
    axes.set(xlabel="vertex, in order", title=f"distances of {count} × {count} vertices")
    axes.tick_params(labelleft=False, left=False)
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    bar = figure.colorbar(image, ax=axes, fraction=0.046, pad=0.03)
    bar.set_label(label)
    return axes
