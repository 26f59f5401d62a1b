"""The widget of the distance matrix: rows of the matrix as functions on the shape (paper, Fig. 1)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import ipywidgets
import numpy as np
import numpy.typing as npt
import traitlets

from qgeo_filters._typing import IndexArray, RepairOption
from qgeo_filters.caching import cache
from qgeo_filters.errors import ParameterError
from qgeo_filters.fingerprint import content_key
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.report.charts import matrix_order
from qgeo_filters.report.colors import ordered_colors
from qgeo_widgets import controls
from qgeo_widgets.base import ShapeWidget, chosen
from qgeo_widgets.coloring import ATTRIBUTE
from qgeo_widgets.fields import ColorField, Field, Limits, ScalarField, grey_where_missing, number_field
from qgeo_widgets.legend import css
from qgeo_widgets.rendering.backends import new_matrix_pane, new_viewer
from qgeo_widgets.rendering.scene_placement import placement_of
from qgeo_widgets.shape import Shape
from qgeo_widgets.snapshot_figure import Chart, Picture

DISTANCE = "distances of the row"
ORDER = "where the rows are"
_LINE = 255, 45, 85
_ROWS = 600  # as many as the picture has pixels


class MatrixWidget(ShapeWidget):
    """The matrix of quasi-geodesic distances beside the shape; see `qgeo_widgets.matrix`.

    Attributes
    ----------
    row : int
        Row of the picture that is shown on the shape, -1 for none. Follows the mouse over the matrix.
    picked : int or None
        The vertex whose distances are shown: that of the row, or one that was clicked on the shape.
    """

    _page_title = "Distance matrix"
    _takes_repair = True
    row = traitlets.Int(-1)
    picked = traitlets.Int(None, allow_none=True)

    def __init__(
        self, mesh: Any, *, curvature_weight: float, matrix: npt.ArrayLike | None, repair: RepairOption, size: int
    ) -> None:
        super().__init__()
        with self._guarded():
            with self._long.during("Repairing the shape"):
                shape = Shape(mesh, "X", curvature_weight, repair=repair, pieces="all")
            self._shape = shape
            self._placing = False
            sample = _evenly(np.flatnonzero(shape.stand_ins >= 0), _ROWS)
            self._long.announce()
            with self._long.during("Measuring distances", at_once=True):
                table = _checked_rows(matrix, sample, shape)
            order = matrix_order(table[:, sample])
            self._vertex_of_row = sample[order]
            self._table = table[order]
            self._row_of_vertex = {int(v): r for r, v in enumerate(self._vertex_of_row)}
            reached = table[np.isfinite(table)]
            self._span = 0.0, float(reached.max(initial=0.0)) or 1.0  # of the matrix and the shape alike
            image = self._image(None)
            viewer = new_viewer(
                [shape.surface], [placement_of(shape.surface, shape.measured)], (size, size), [_title(shape)]
            )
            self._pane = new_matrix_pane(image, size)
            self._modes = {DISTANCE: self._distance_field, ORDER: self._order_field}
            for name in shape.surface.attributes:
                self._modes[ATTRIBUTE + name] = partial(self._attribute_field, name)
            self._pane.on_hover(lambda row, column: self.set_trait("row", row))
            self._pane.on_click(self._entry)
            viewer.on_pick(lambda _, vertex: self.set_trait("picked", vertex))
            title = f"distances between {len(sample)} of {shape.surface.n_vertices} vertices, neighbours side by side"
            strip = ipywidgets.HTML(_strip(len(sample)), layout={"flex": "none"})
            matrix_side = ipywidgets.VBox(
                [ipywidgets.HTML(title), ipywidgets.HBox([strip, self._pane.widget])],
                layout={
                    "overflow": "visible",
                    "margin": "0 6px 4px 0",
                    "flex": "1 1 310px",
                    "max_width": f"{size + 24}px",
                },
            )
            viewer.put_beside(matrix_side, first=True)
            self._assemble(viewer, ["shape"], ORDER)
            self.observe(self._row_chosen, "row")
            self.observe(self._vertex_chosen, "picked")
            self._info.value = controls.table([["Move over the matrix, or click on the shape."]])

    def _missing(self, mode: str) -> str:
        absent = mode == DISTANCE and self.picked is None
        return (
            "Move over the matrix or click on the shape: the distances of that vertex are then shown." if absent else ""
        )

    def _columns(self, mode: str) -> int:
        return self._shape.columns(mode.removeprefix(ATTRIBUTE)) if mode.startswith(ATTRIBUTE) else 1

    # -- the matrix ---------------------------------------------------------------------------------

    def _image(self, limits: Limits | None) -> npt.NDArray[np.uint8]:
        """Picture of the square part of the matrix, in the colours that distances have on the shape."""
        square = self._table[:, self._vertex_of_row].astype(np.float64)
        return np.rint(255 * ScalarField([square], "", span=self._span).scale(limits)(square)).astype(np.uint8)

    def _refresh(self, *, new_mode: bool = False) -> None:
        super()._refresh(new_mode=new_mode)
        if self._viewer is not None and self._field is not None:
            self._pane.set_image(self._image(self.limits if str(self.mode) == DISTANCE else None))

    def _pictured(self) -> tuple[Sequence[tuple[str, Picture]], Chart | None]:
        picture = self._pane.image.copy()
        if self.picked is not None and self.row >= 0:
            thick = max(1, len(picture) // 150)
            picture[max(self.row - thick // 2, 0) :][:thick] = _LINE
        return [(f"distances between {len(picture)} vertices", picture)], None

    # -- choosing -----------------------------------------------------------------------------------

    @traitlets.validate("row")
    def _valid_row(self, proposal: Any) -> int:
        row = proposal["value"]
        if self._viewer is not None and not -1 <= row < len(self._table):
            raise traitlets.TraitError(f"row must be -1 or one of the {len(self._table)} rows, got {row}")
        return row

    @traitlets.validate("picked")
    def _valid_vertex(self, proposal: Any) -> int | None:
        vertex = proposal["value"]
        if vertex is not None and self._viewer is not None and not 0 <= vertex < self._shape.surface.n_vertices:
            raise traitlets.TraitError(f"picked must be one of {self._shape.surface.n_vertices} vertices, got {vertex}")
        return vertex

    def _row_chosen(self, change: Any) -> None:
        if change["new"] >= 0 and not self._placing:
            self.picked = int(self._vertex_of_row[self.row])

    def _vertex_chosen(self, change: Any) -> None:
        if self._viewer is None:
            return
        vertex = self.picked
        self._viewer.panes[0].set_mark("other", None)  # of the entry that was clicked before
        if vertex is None:
            self._viewer.panes[0].set_mark("picked", None)
            self._refresh(new_mode=True)
            return
        nearest = self._row_of_vertex.get(vertex)
        if nearest is None and self._shape.stand_ins[vertex] < 0:  # near no row
            self._viewer.panes[0].set_mark("picked", self._shape.surface.vertices[vertex])
            with self._guarded():
                self._shape.stand_in(vertex)
            return
        if nearest is None:
            nearest = int(self._table[:, vertex].argmin())
        self._placing = True  # the line goes to the nearest row, the pick stays
        try:
            self.row = nearest
        finally:
            self._placing = False
        self._pane.show(nearest)
        self._viewer.panes[0].set_mark("picked", self._shape.surface.vertices[vertex])
        if str(self.mode) == DISTANCE:
            self._refresh()
        else:
            self.set_trait("mode", DISTANCE)
        if self._field is not None and not self.message:
            self._describe(vertex)

    def _entry(self, row: int, column: int) -> None:
        """A click on an entry of the matrix: both of its vertices are marked."""
        if self._viewer is None:
            return
        self.row = row
        other = int(self._vertex_of_row[column])
        self._pane.show(row, column)
        self._viewer.panes[0].set_mark("other", self._shape.surface.vertices[other], (0.98, 0.75, 0.18))
        length = self._table[row, other]
        self._describe(int(self._vertex_of_row[row]), [("entry", f"d({self.picked}, {other}) = {length:.4f} √area")])

    def _describe(self, vertex: int, more: Any = ()) -> None:
        field = self._distances(vertex)
        reached = field[np.isfinite(field)]
        rows = [("vertex", str(vertex)), ("row", str(self.row)), ("farthest", f"{reached.max():.4f} √area")]
        self._info.value = controls.table([*rows, *self._shape.described(vertex), *more])

    # -- colours ------------------------------------------------------------------------------------

    def _distances(self, vertex: int) -> npt.NDArray[np.float64]:
        row = self._row_of_vertex.get(vertex)
        return self._shape.distances_from(vertex) if row is None else self._table[row].astype(np.float64)

    def _distance_field(self, k: int) -> Field:
        picked = chosen(self.picked)
        return ScalarField([self._distances(picked)], f"distance from vertex {picked} / √area", span=self._span)

    def _order_field(self, k: int) -> Field:
        known = np.asarray(np.isfinite(self._table).any(axis=0))
        nearest = np.where(known, self._table, 0.0).argmin(axis=0)
        label = "each point has the colour of the strip beside the matrix at its row"
        colors = np.where(known[:, None], ordered_colors(len(self._table))[nearest], np.nan)
        return ColorField([grey_where_missing(colors)], label)

    def _attribute_field(self, name: str, k: int) -> Field:
        return number_field([self._shape.attribute(name, k)], name)

    def _page_extras(self) -> dict[str, Any]:
        from qgeo_widgets.export import matrix_data

        strip = _strip(len(self._table))
        title = f"distances between {len(self._table)} vertices"
        display = self._open_viewer.panes[0].display
        data = matrix_data(self._image(None), self._table, self._vertex_of_row, display, strip, title, self._span)
        return {"matrix": data, "hint": "Move over the matrix to see its rows on the shape; click on the shape."}

    def close(self) -> None:
        """Free everything, here and in the browser."""
        if self._viewer is not None:
            self._pane.close()
        super().close()


def _checked_rows(matrix: npt.ArrayLike | None, sample: npt.NDArray[np.int64], shape: Shape) -> npt.NDArray[np.float32]:
    """Distances from the sample to all vertices, in units of sqrt(area)."""
    n = shape.surface.n_vertices
    if matrix is None:
        surface, metric, sources = shape.measured, shape.metric, shape.stand_ins[sample]
        key = content_key("matrix_rows", surface.vertices, surface.faces, metric.edge_lengths, sources)
        rows = shape.carried(cache.get(key, lambda: distances(surface, sources, metric)).T).T
    else:
        given = np.asarray(matrix)
        if given.shape != (n, n):
            raise ParameterError(f"the matrix has shape {given.shape}, but the mesh has {n} vertices")
        rows = given[sample]
    return (rows / shape.unit).astype(np.float32)


def _evenly(vertices: IndexArray, most: int) -> IndexArray:
    return vertices[np.unique(np.linspace(0, len(vertices) - 1, min(len(vertices), most)).round().astype(np.int64))]


def _title(shape: Shape) -> str:
    return f"<b>shape</b>, {shape.surface.n_vertices} vertices"


def _strip(count: int) -> str:
    """The colours of the rows as a strip as high as the picture of the matrix."""
    colors = ordered_colors(count)[np.linspace(0, count - 1, 40).round().astype(int)]
    gradient = ", ".join(map(css, colors))
    style = f"width:12px;height:100%;margin-right:4px;background:linear-gradient({gradient})"
    return f'<div class="qgeo-strip" style="{style}"></div>'
