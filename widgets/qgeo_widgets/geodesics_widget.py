"""The widget of quasi-geodesics: a path between two points, and how the curvature's weight leads it."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import partial
from typing import Any

import ipywidgets
import numpy as np
import numpy.typing as npt
import traitlets

from qgeo_filters._typing import RepairOption
from qgeo_filters.defaults import CURVATURE_WEIGHT
from qgeo_filters.differential.scalar import Scalar, surface_scalar
from qgeo_filters.geodesics.matrix import distances
from qgeo_filters.geodesics.path.geodesic_path import GeodesicPath
from qgeo_filters.validation import checked_index
from qgeo_widgets import chart, controls
from qgeo_widgets.base import ShapeWidget, chosen
from qgeo_widgets.coloring import ATTRIBUTE
from qgeo_widgets.fields import Field, ScalarField, number_field
from qgeo_widgets.path_pair import PathPair, PathPairs
from qgeo_widgets.rendering.backends import new_viewer
from qgeo_widgets.rendering.scene_placement import placement_of
from qgeo_widgets.shape import Shape
from qgeo_widgets.snapshot_figure import Chart, Picture

SCALAR = "curvature scalar f"
DISTANCE = "distance from the source"
_SOURCE, _TARGET, _PLACE = (0.98, 0.70, 0.10), (0.86, 0.11, 0.16), (0.48, 0.25, 0.71)
_BEFORE = (0.35, 0.37, 0.42)
#: Vertices up to which the path follows the slider of the weight; beyond, it is sought when the slider is let go.
_LIVE = 5000


class GeodesicsWidget(ShapeWidget):
    """The shortest path on a shape, and what straightening alone finds; see `qgeo_widgets.geodesics`.

    Attributes
    ----------
    source, target : int or None
        Ends of the path. Clicks set them in turn.
    curvature_weight : float
        The curvature's weight in the metric; 0 gives the surface's own geodesics.
    before : bool
        Whether the path straightened from one along edges is shown too: locally shortest, and often longer.
    place : float
        Where on the path the cursor stands, from 0 at the source to 1.
    path : GeodesicPath or None
        The shortest path, which is shown: on what is measured, as are its triangles.
    path_before : GeodesicPath or None
        The other one.
    """

    _page_title = "A quasi-geodesic"
    _takes_repair = True
    source = traitlets.Int(None, allow_none=True)
    target = traitlets.Int(None, allow_none=True)
    curvature_weight = traitlets.Float(CURVATURE_WEIGHT, min=0.0)
    before = traitlets.Bool(True)
    place = traitlets.Float(0.5, min=0.0, max=1.0)
    path = traitlets.Instance(GeodesicPath, allow_none=True, read_only=True)
    path_before = traitlets.Instance(GeodesicPath, allow_none=True, read_only=True)

    def __init__(
        self, mesh: Any, *, source: int | None, target: int | None, curvature_weight: float, scalar: Scalar,
        repair: RepairOption, size: tuple[int, int],
    ) -> None:  # fmt: skip
        super().__init__()
        with self._guarded():
            with self._long.during("Repairing the shape"):
                shape = self._shape = Shape(mesh, "X", curvature_weight, scalar, repair, "all")
            surface = shape.surface
            self._scalar = surface_scalar(shape.measured, shape.scalar)
            self._distances: tuple[tuple[int, float], npt.NDArray[np.float64]] | None = None
            self._pairs_of: tuple[float, PathPairs] | None = None
            self.curvature_weight = curvature_weight
            viewer = new_viewer(
                [surface],
                [placement_of(surface, shape.measured)],
                size,
                [f"<b>shape</b>, {surface.n_vertices} vertices"],
            )
            self._modes = {SCALAR: self._scalar_field, DISTANCE: self._distance_field}
            for name in surface.attributes:
                self._modes[ATTRIBUTE + name] = partial(self._attribute_field, name)
            top, live = max(0.3, curvature_weight), shape.measured.n_vertices <= _LIVE
            weight = controls.number("curvature weight λ", curvature_weight, 0.0, top, 0.005, live=live)
            before = controls.tick("before: straightened from edges", True, "thin and grey; locally shortest only")
            self._chart = ipywidgets.HTML(layout={"margin": "0"})
            cursor = ipywidgets.FloatSlider(
                value=0.5, min=0.0, max=1.0, step=0.005, readout=False,
                tooltip="place along the path",
                layout={"width": f"calc({chart.WIDTH} - {chart.LEFT + chart.RIGHT - 20}px)",
                        "margin": f"0 0 4px {chart.LEFT - 12}px"},
            )  # fmt: skip
            title = ipywidgets.HTML("geodesic curvature of the path; the slider moves the violet point")
            self._plot = ipywidgets.VBox(
                [title, self._chart, cursor], layout={"display": "none", "overflow": "visible"}
            )
            traitlets.link((self, "curvature_weight"), (weight, "value"))
            traitlets.link((self, "before"), (before, "value"))
            traitlets.link((self, "place"), (cursor, "value"))
            viewer.put_beside(self._plot)
            viewer.on_pick(self._clicked)
            self._assemble(viewer, ["shape"], SCALAR, beside=[weight, before])
            self.observe(lambda _: self._find(), ["source", "target", "curvature_weight"])
            self.observe(lambda _: self._show_path(), "before")
            self.observe(lambda _: self._show_place(), "place")
            self.source, self.target = source, target
            self._find()

    @property
    def weight(self) -> float:
        """Old name of `curvature_weight`, for one more release."""
        _warn_of_the_old_name()
        return float(self.curvature_weight)

    @weight.setter
    def weight(self, value: float) -> None:
        _warn_of_the_old_name()
        self.curvature_weight = value

    def _columns(self, mode: str) -> int:
        return self._shape.columns(mode.removeprefix(ATTRIBUTE)) if mode.startswith(ATTRIBUTE) else 1

    def _missing(self, mode: str) -> str:
        absent = mode == DISTANCE and self.source is None
        return "Click the source of a path: the distances from it are then shown." if absent else ""

    # -- the path -----------------------------------------------------------------------------------

    @traitlets.validate("source", "target")
    def _valid_vertex(self, proposal: Any) -> int | None:
        vertex = proposal["value"]
        if vertex is not None and self._viewer is not None:
            checked_index(vertex, self._shape.surface.n_vertices, proposal["trait"].name)
        return vertex

    def _clicked(self, pane: int, vertex: int) -> None:
        if self.source is None or self.target is not None:
            with self.hold_trait_notifications():
                self.source, self.target = vertex, None
        else:
            self.target = vertex

    def _find(self) -> None:
        if self._viewer is None:
            return
        with self._guarded():
            pane = self._viewer.panes[0]
            vertices = self._shape.surface.vertices
            pane.set_mark("source", None if self.source is None else vertices[self.source], _SOURCE)
            pane.set_mark("target", None if self.target is None else vertices[self.target], _TARGET)
            pair = None  # where there is no path, the last one does not stay
            try:
                pair = self._found()
            finally:
                with self.hold_trait_notifications():
                    self.set_trait("path_before", None if pair is None else pair.from_edges)
                    self.set_trait("path", None if pair is None else pair.shortest)
                self._show_path()
                if self.mode == DISTANCE:
                    self._refresh()

    def _found(self) -> PathPair | None:
        if self.source is None or self.target is None:
            return None
        self._info.value = controls.table([["Seeking the shortest path …"]])  # up to seconds on a large shape
        return self._pairs.between(*(self._shape.stand_in(vertex) for vertex in (self.source, self.target)))

    @property
    def _pairs(self) -> PathPairs:
        """Paths in the current metric; the last one is kept."""
        if self._pairs_of is None or self._pairs_of[0] != self.curvature_weight:
            metric = self._shape.metric_of_weight(self.curvature_weight)
            self._pairs_of = self.curvature_weight, PathPairs(metric)
        return self._pairs_of[1]

    def _show_path(self) -> None:
        if self._viewer is None:
            return
        pane, path, other = self._viewer.panes[0], self.path, self.path_before
        pane.set_line("before", other.points if other is not None and self.before else None, _BEFORE, 2.5)
        pane.set_line("path", None if path is None else path.points, _TARGET)
        self._plot.layout.display = "none" if path is None else ""
        self._show_place()
        if path is None or other is None:
            step = "the source" if self.source is None else "the target"
            self._info.value = controls.table([[f"Click {step} of the path."]])
            return

        def length(value: float) -> str:
            return f"{value / self._shape.unit:.4f} √area"

        def on_surface(points: npt.NDArray[np.float64]) -> str:
            return length(float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()))

        both = path, other
        longer = 100 * (other.length / path.length - 1) if path.length > 0 else 0.0
        rows = [
            ["length in the metric", *(length(each.length) for each in both), length(other.lengths[0])],
            ["length on the surface", *(on_surface(p) for p in (path.points, other.points, other.initial_points))],
            ["longer than the shortest", "", f"{max(longer, 0.0):.1f} %", ""],
            ["change of f on the way", *(f"{np.abs(np.diff(self._felt(each))).sum():.2f}" for each in both), ""],
            ["locally shortest", *("yes" if each.converged else "no" for each in both), ""],
        ]
        head = [f"vertex {self.source} to {self.target}", "shortest", "before: straightened from edges", "along edges"]
        if self._shape.report:
            rows.append(["in place of the mesh", self._shape.report])
        self._info.value = controls.table(rows, head)

    def _felt(self, path: GeodesicPath) -> npt.NDArray[np.float64]:
        """The scalar at the points of a path."""
        corners = self._scalar[self._shape.measured.faces[path.faces]]
        return np.einsum("pi,pi->p", corners, path.barycentric)

    def _way(self, path: GeodesicPath) -> npt.NDArray[np.float64]:
        steps = np.linalg.norm(np.diff(path.points, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)]) / self._shape.unit

    def _show_place(self) -> None:
        if self._viewer is None:
            return
        path = self.path
        if path is None:
            self._viewer.panes[0].set_mark("place", None)
            return
        way = self._way(path)
        here = self.place * way[-1]
        point = [np.interp(here, way, path.points[:, axis]) for axis in range(3)]
        self._viewer.panes[0].set_mark("place", point, _PLACE)
        self._chart.value = chart.curvature_chart(way[1:-1], path.kappa_g, float(way[-1]), float(here))

    # -- colours ------------------------------------------------------------------------------------

    def _scalar_field(self, k: int) -> Field:
        return ScalarField([self._shape.carried(self._scalar)], "f, in standard deviations", True)

    def _distance_field(self, k: int) -> Field:
        source = chosen(self.source)
        key = source, self.curvature_weight
        if self._distances is None or self._distances[0] != key:
            row = distances(self._shape.measured, [self._shape.stand_in(source)], self._pairs.metric)[0]
            self._distances = key, self._shape.carried(row) / self._shape.unit
        return ScalarField(
            [self._distances[1]], f"distance from vertex {source} at λ = {self.curvature_weight:.3f} / √area"
        )

    def _attribute_field(self, name: str, k: int) -> Field:
        return number_field([self._shape.attribute(name, k)], name)

    def _pictured(self) -> tuple[Sequence[tuple[str, Picture]], Chart | None]:
        path = self.path
        if path is None:
            return (), None
        way = self._way(path)
        end = float(way[-1])
        return (), partial(
            chart.draw_curvature, way=way[1:-1], kappa=path.kappa_g, length=end, cursor=float(self.place) * end
        )

    def _page_extras(self) -> dict[str, Any]:
        return {
            "info": self._info.value + (self._chart.value if self.path is not None else ""),
            "lasting": ("source", "target", "path", "before", "place"),  # the page is about this path
        }


def _warn_of_the_old_name() -> None:
    warnings.warn(
        "GeodesicsWidget: weight is now called curvature_weight; the old name goes with the next release",
        DeprecationWarning,
        stacklevel=3,
    )
