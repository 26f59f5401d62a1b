"""Pictures of a table of distances between shapes: a tree, a map of the plane, and the table itself in colours."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any, TypeAlias

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.cluster.hierarchy import dendrogram, leaves_list, linkage, optimal_leaf_ordering
from scipy.spatial.distance import squareform

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import ParameterError, require_package
from qgeo_filters.report.colors import MISSING, distinct, sequential
from qgeo_filters.report.panels import STYLE, new_figure
from qgeo_filters.validation import listed

#: Group of each shape, by name or in the order of the rows.
Groups: TypeAlias = Mapping[str, Hashable] | Sequence[Hashable]

# Okabe and Ito, "Color universal design", 2008, in an order in which neighbours differ in lightness too. Their yellow,
# which white paper swallows, comes last and darker.
_SAFE = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#000000", "#b5a300")
# Beside colours, by which groups are told in an embedding.
_MARKERS = "osD^vP*X<>"
# More labels than these would cover each other.
_LABELLED = 60


def plot_dendrogram(distances: Any, groups: Groups | None = None, *, label: str = "distance") -> Figure:
    """Figure of the tree by which shapes join, the nearest first; names in the colours of their groups.

    Parameters
    ----------
    distances : DataFrame or array-like, shape (m, m)
        Symmetric, as `Collection.distances` returns them; without labels shapes are numbered from 0.
    groups : mapping of name to group, or sequence, optional
    label : str
        Of the axis.

    Raises
    ------
    ParameterError
        No symmetric square of numbers, fewer than two shapes, groups that do not fit.
    """
    names, square = _named_square(distances)
    colors = _GroupColors.of(names, groups)
    tree = _tree(square)
    figure = new_figure(6.4, max(2.0, 0.8 + 0.17 * len(names)))
    with matplotlib.rc_context(STYLE):
        axes = figure.add_subplot()
        found = dendrogram(
            tree, labels=names, orientation="left", ax=axes, color_threshold=0.0, above_threshold_color="0.45",
            leaf_font_size=min(9.0, 9.0 * _LABELLED / len(names)),
        )  # fmt: skip
        order = [names[leaf] for leaf in found["leaves"] or ()]
        for text, name in zip(axes.get_yticklabels(), order, strict=True):
            text.set_color(colors.of_name(name))
        axes.spines["left"].set_visible(False)
        axes.tick_params(axis="y", length=0)
        axes.set(xlabel=f"{label} (average linkage)")
        colors.legend(figure, markers=False)
    return figure


def plot_embedding(
    distances: Any, groups: Groups | None = None, *, label: str = "distance", labelled: bool | None = None
) -> Figure:
    """Figure of the shapes as points of the plane, as far from each other as the distances say, as well as can be.

    Parameters
    ----------
    distances, groups
        As in `plot_dendrogram`.
    label : str
    labelled : bool, optional
        Whether each point has its name; up to 60 shapes by default.

    Raises
    ------
    ParameterError
        See `plot_dendrogram`.
    MissingPackageError
        Without scikit-learn.

    Notes
    -----
    Metric multidimensional scaling (SMACOF) from a fixed seed: the same table gives the same picture. The caption says
    how well the plane holds the distances (Kruskal's stress 1; above .2 little can be read from it).
    """
    names, square = _named_square(distances)
    colors = _GroupColors.of(names, groups)
    places, stress = embedding(square)
    figure = new_figure(5.4, 4.6)  # half a page, beside the table
    with matplotlib.rc_context(STYLE):
        axes = figure.add_subplot()
        for number, group in enumerate(colors.groups or ("",)):
            chosen = [i for i, name in enumerate(names) if not colors.groups or colors.group_of[name] == group]
            axes.scatter(
                places[chosen, 0], places[chosen, 1], 34, color=colors.color(number), marker=colors.marker(number),
                linewidths=0.4, edgecolors="white", zorder=2,
            )  # fmt: skip
        if labelled or (labelled is None and len(names) <= _LABELLED):
            for name, place in zip(names, places, strict=True):
                axes.annotate(name, place, (4, 3), textcoords="offset points", fontsize=6.5, color="0.3")
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.1)
        axes.grid(True, color="0.93", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.set(xlabel=f"{label}, embedded in the plane (stress {stress:.2f})")
        colors.legend(figure)
    return figure


def plot_heat_map(
    distances: Any, groups: Groups | None = None, *, label: str = "distance", ordered: bool = True
) -> Figure:
    """Figure of the table in colours, near shapes beside each other.

    Grey where a distance is not known, white where a shape meets itself: the colours are for what lies between them.

    Parameters
    ----------
    distances, groups
        As in `plot_dendrogram`; distances may be NaN here, and need not be symmetric.
    label : str
    ordered : bool
        Whether rows are in the order of the tree's leaves (`matrix_order`), or as they are.
    """
    names, square = _named_square(distances, complete=False)
    colors = _GroupColors.of(names, groups)
    order: npt.NDArray[np.integer] = np.arange(len(names))
    if ordered and len(names) > 2:
        both = np.fmin(square, square.T)  # one way may be known only
        order = leaves_list(_tree(np.where(np.isnan(both), 2 * np.nanmax(np.r_[both.ravel(), 0.0]), both)))
    shown = square[np.ix_(order, order)]
    itself = np.eye(len(shown), dtype=bool)
    known = shown[~itself]
    scale = sequential(known)
    side = float(np.clip(1.6 + 0.15 * len(names), 3.4, 9.0))
    figure = new_figure(side + 0.9, side)
    with matplotlib.rc_context(STYLE):
        axes = figure.add_subplot()
        image = axes.imshow(
            np.ma.masked_invalid(shown), cmap=scale.colormap.with_extremes(bad=MISSING), norm=scale.norm
        )
        axes.imshow(np.ma.masked_array(np.ones(itself.shape), ~itself), cmap=ListedColormap(["white"]))
        size = min(8.0, 8.0 * _LABELLED / (1.4 * len(names)))
        ticks = np.arange(len(names))
        axes.set_xticks(ticks, [names[i] for i in order], rotation=90, fontsize=size)
        axes.set_yticks(ticks, [names[i] for i in order], fontsize=size)
        for text, i in zip([*axes.get_xticklabels(), *axes.get_yticklabels()], [*order, *order], strict=True):
            text.set_color(colors.of_name(names[i]))
        axes.tick_params(length=0)
        figure.colorbar(image, ax=axes, fraction=0.046, pad=0.03).set_label(label)
        colors.legend(figure, markers=False)
    return figure


def embedding(square: FloatArray) -> tuple[FloatArray, float]:
    """Points (m, 2) whose distances are nearly those of a table, and the stress 1 that is left."""
    manifold = require_package("sklearn.manifold", "collections", "an embedding of shapes")

    largest = float(square.max()) or 1.0
    centred = square / largest
    # Classical scaling is the start: of all shapes at once, and the same on every machine.
    gram = centred**2
    gram = -0.5 * (gram - gram.mean(axis=0) - gram.mean(axis=1)[:, None] + gram.mean())
    values, vectors = np.linalg.eigh(gram)
    vectors = vectors * np.where(vectors[np.abs(vectors).argmax(axis=0), np.arange(len(vectors))] < 0, -1.0, 1.0)
    start = vectors[:, [-1, -2]] * np.sqrt(np.maximum(values[[-1, -2]], 0.0))
    places, _ = manifold.smacof(centred, n_components=2, init=start, n_init=1, random_state=0, normalized_stress=False)
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2)
    stress = float(np.sqrt(((gaps - centred) ** 2).sum() / max(float((centred**2).sum()), 1e-300)))
    return largest * places, stress


class _GroupColors:
    """Colours and markers of groups, in the order in which they come."""

    def __init__(self, names: list[str], group_of: dict[str, Hashable]) -> None:
        self.group_of = group_of
        self.groups = tuple(dict.fromkeys(group_of[name] for name in names)) if group_of else ()
        many = len(self.groups) > len(_SAFE)
        self._colors: list[Any] = list(distinct(len(self.groups))) if many else list(_SAFE)

    @classmethod
    def of(cls, names: list[str], groups: Groups | None) -> _GroupColors:
        if groups is None:
            return cls(names, {})
        if isinstance(groups, Mapping):
            missing = [name for name in names if name not in groups]
            if missing:
                raise ParameterError(f"there is no group of {listed(missing)} ({len(missing)} such shapes)")
            return cls(names, {name: groups[name] for name in names})
        if len(groups) != len(names):
            raise ParameterError(f"there are {len(groups)} groups for {len(names)} shapes")
        return cls(names, dict(zip(names, groups, strict=True)))

    def color(self, number: int) -> Any:
        return self._colors[number]

    def marker(self, number: int) -> str:
        return _MARKERS[number % len(_MARKERS)]

    def of_name(self, name: str) -> Any:
        return self.color(self.groups.index(self.group_of[name])) if self.groups else "0.15"

    def legend(self, figure: Figure, *, markers: bool = True) -> None:
        """An entry for each group, below the picture."""
        if not self.groups:
            return
        handles = [
            Line2D([], [], linestyle="", color=self.color(k), marker=self.marker(k) if markers else "s", label=str(g))
            for k, g in enumerate(self.groups)
        ]
        figure.legend(handles=handles, frameon=False, loc="outside lower center", ncols=min(5, len(handles)))


def _named_square(distances: Any, complete: bool = True) -> tuple[list[str], FloatArray]:
    """Names of the rows, and the distances, checked; with 0 on the diagonal."""
    square = np.array(distances, dtype=np.float64)
    if square.ndim != 2 or square.shape[0] != square.shape[1]:
        raise ParameterError(f"the distances must be square, got shape {square.shape}")
    if len(square) < 2:
        raise ParameterError("a picture of distances needs at least two shapes")
    index, columns = getattr(distances, "index", range(len(square))), getattr(distances, "columns", None)
    names = [str(name) for name in index]
    if columns is not None and names != [str(name) for name in columns]:
        raise ParameterError("the columns of the distances must have the names of the rows, in the same order")
    np.fill_diagonal(square, 0.0)
    if (square < 0).any():
        i, j = np.argwhere(square < 0)[0]
        raise ParameterError(f"the distance of {names[i]} and {names[j]} is {square[i, j]:g}, which is negative")
    if complete:
        _check_complete(names, square)
        square = 0.5 * (square + square.T)
    return names, square


def _check_complete(names: list[str], square: npt.NDArray[np.float64]) -> None:
    lost = np.argwhere(~np.isfinite(square))
    if lost.size:
        i, j = lost[0]
        raise ParameterError(
            f"the distance of {names[i]} and {names[j]} is not known ({len(lost)} such): leave these shapes out, or "
            "compute them"
        )
    gaps = np.abs(square - square.T)
    i, j = np.unravel_index(gaps.argmax(), gaps.shape)
    if gaps[i, j] > 1e-6 * square.max():
        raise ParameterError(
            f"the distances are not symmetric: {square[i, j]:g} from {names[i]} to {names[j]}, {square[j, i]:g} back"
        )


def _tree(square: FloatArray) -> npt.NDArray[np.float64]:
    condensed = squareform(square, checks=False)
    found: npt.NDArray[np.float64] = optimal_leaf_ordering(linkage(condensed, "average"), condensed)
    return found
