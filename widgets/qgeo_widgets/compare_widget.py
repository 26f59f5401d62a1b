"""The widget that compares two shapes, to see whether a correspondence is right."""

from __future__ import annotations

from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import traitlets

from qgeo_filters._typing import FloatArray
from qgeo_filters.defaults import EIGENPAIRS
from qgeo_filters.report.colors import position_colors
from qgeo_widgets import controls
from qgeo_widgets.coloring import ATTRIBUTE, EIGENFUNCTION
from qgeo_widgets.fields import ColorField, Field, ScalarField, number_field, region_field
from qgeo_widgets.matching_widget import SIDES, MatchingWidget
from qgeo_widgets.rendering.backends import new_viewer
from qgeo_widgets.rendering.scene_placement import aligned_placement, placement_of
from qgeo_widgets.shape import Shape
from qgeo_widgets.vertex_map import VertexMap

if TYPE_CHECKING:
    from qgeo_filters.matching.match_result import MatchResult

CARRIED = "colours carried from X to Y"
REGIONS = "matched regions"
DISTORTION = "distortion of distances"
DISTANCE = "distance from the picked point"
ERROR = "error against the truth"
_COLORS = {"first": (0.86, 0.11, 0.16), "second": (0.98, 0.70, 0.10)}


class CompareWidget(MatchingWidget):
    """Two linked views and the map between them; see `qgeo_widgets.compare`, and `MatchingWidget` for more attributes.

    Attributes
    ----------
    follow : bool
        Whether a click also shows the distances from it.
    """

    _page_title = "Two shapes and the map between them"
    follow = traitlets.Bool(True)

    def __init__(
        self,
        x: Any,
        y: Any,
        *,
        p2p: npt.ArrayLike | MatchResult | None,
        truth: npt.ArrayLike | None,
        curvature_weight: float,
        size: tuple[int, int],
        progress: bool,
    ) -> None:
        super().__init__()
        with self._guarded():
            self._set_up((Shape(x, "X", curvature_weight), Shape(y, "Y", curvature_weight)), p2p, progress)
            one, other = surfaces = [shape.surface for shape in self._shapes]
            self._truth = None if truth is None else VertexMap(one, other, truth, "truth")
            self._errors_of: dict[bool, FloatArray] = {}
            placement_x = placement_of(surfaces[0])
            seen = surfaces[1].vertices[self._map.forward]
            placement_y = aligned_placement(surfaces[1], seen, placement_x.to_scene(surfaces[0].vertices))
            titles = [f"<b>{s.name}</b>, {s.surface.n_vertices} vertices" for s in self._shapes]
            viewer = new_viewer(surfaces, [placement_x, placement_y], size, titles)
            self._modes = self._make_modes()
            follow = controls.tick("distances on click", True, "a click also shows the distances from the point")
            traitlets.link((self, "follow"), (follow, "value"))
            viewer.on_pick(self._clicked)
            beside, below = self._map_controls()
            self._assemble(viewer, ["X", "Y"], CARRIED, beside=[follow, *beside], below=below)
            self.observe(lambda _: self._show_picks(), ["picked", "second"])
            self._show_picks()
            self._show_orientation()

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Vertex of X and vertex of Y for each point that was clicked."""
        return [self._pair(pick) for pick in (self.picked, self.second) if pick is not None]

    # -- the map ------------------------------------------------------------------------------------

    def _map_changed(self) -> None:
        self._errors_of = {}
        mode, self._modes = self.mode, self._make_modes()
        if tuple(self._mode_list.options) != self.modes:
            with self.hold_trait_notifications():
                self._mode_list.options = self.modes
                self.mode = self._mode_list.value = mode
        self._show_orientation()
        self._show_picks()
        self._refresh(new_mode=True)

    # -- picking ------------------------------------------------------------------------------------

    def _clicked(self, pane: int, vertex: int) -> None:
        pick = SIDES[pane], vertex
        if self.picked is None or self.second is not None:
            self.set_trait("second", None)
            self.picked = pick
            if self.follow:
                self.mode = DISTANCE
        else:
            self.second = pick

    def _show_picks(self) -> None:
        if self._viewer is None:
            return
        with self._guarded():
            for slot, pick in (("first", self.picked), ("second", self.second)):
                pair = (None, None) if pick is None else self._pair(pick)
                for pane, vertex in zip(self._viewer.panes, pair, strict=True):
                    place = None if vertex is None else pane.surface.vertices[vertex]
                    pane.set_mark(slot, place, _COLORS[slot])
            lengths: list[str] = []
            with self._guarded():  # between two pieces there is no path, the points are described all the same
                lengths = self._path_lengths()
            self._info.value = self._described(lengths)
            if self.mode == DISTANCE:
                self._refresh()

    def _described(self, lengths: list[str]) -> str:
        if not self.pairs:
            return controls.table([["Click a point on either shape; a second click draws the quasi-geodesics."]])
        head = ["", "X", "Y"]
        rows = []
        for name, (i, j) in zip(("first point", "second point"), self.pairs, strict=False):
            rows.append([name, f"vertex {i}", f"vertex {j}"])
            values = [dict(s.described(v)) for s, v in zip(self._shapes, (i, j), strict=True)]
            rows += [[key, *(v.get(key, "–") for v in values)] for key in sorted(values[0] | values[1])]
            if self._truth is not None:
                rows.append(["error there", f"{self._errors(self._truth)[i]:.4f} √area", ""])
        return controls.table(rows + ([["quasi-geodesic", *lengths]] if lengths else []), head)

    def _path_lengths(self) -> list[str]:
        """Draw the path between two picked points on each shape; its lengths as text, none unless there are two."""
        ends, panes = self.pairs, self._open_viewer.panes
        for pane in panes:
            pane.set_line("path", None)
        if len(ends) < 2:
            return []
        from qgeo_filters.geodesics.path.paths import quasi_geodesic

        lengths = []
        for side, (pane, shape) in enumerate(zip(panes, self._shapes, strict=True)):
            path = quasi_geodesic(shape.surface, ends[0][side], ends[1][side], shape.metric)
            pane.set_line("path", path.points, _COLORS["first"])
            lengths.append(f"{path.length / shape.unit:.4f} √area")
        return lengths

    # -- colours ------------------------------------------------------------------------------------

    def _make_modes(self) -> dict[str, Any]:
        modes: dict[str, Any] = {CARRIED: self._carried_field, EIGENFUNCTION: self._eigen_field}
        found = self._correspondence
        if found is not None:
            modes |= {REGIONS: partial(self._region_field, found), DISTORTION: partial(self._distortion_field, found)}
        modes[DISTANCE] = self._distance_field
        if self._truth is not None:
            modes[ERROR] = partial(self._error_field, self._truth)
        for name in {**self._shapes[0].surface.attributes, **self._shapes[1].surface.attributes}:
            modes[ATTRIBUTE + name] = partial(self._attribute_field, name)
        return modes

    def _missing(self, mode: str) -> str:
        absent = mode == DISTANCE and self.picked is None
        return "Click a point on one of the shapes: the distances from it are then shown." if absent else ""

    def _takes_long(self, mode: str) -> bool:
        return mode == EIGENFUNCTION and any(shape.spectrum_takes_long for shape in self._shapes)

    def _columns(self, mode: str) -> int:
        if mode == EIGENFUNCTION:
            return min(EIGENPAIRS, *(shape.surface.n_vertices for shape in self._shapes))
        if mode.startswith(ATTRIBUTE):
            return max(shape.columns(mode.removeprefix(ATTRIBUTE)) for shape in self._shapes)
        return 1

    @cached_property
    def _position_colors(self) -> FloatArray:
        surface = self._shapes[0].surface
        return position_colors(surface.vertices, self._open_viewer.panes[0].placement.axes)

    def _carried_field(self, k: int) -> Field:
        colors = self._position_colors
        label = "each point of Y has the colour of its partner on X; on X the colour tells the place"
        return ColorField([colors, colors[self._map.backward]], label)

    def _region_field(self, found: MatchResult, k: int) -> Field:
        return region_field([found.regions_x, found.regions_y], "regions of one colour belong together")

    def _distortion_field(self, found: MatchResult, k: int) -> Field:
        label = "mean |d(p, q) − d(Tp, Tq)| of the map that was found / √area"
        return ScalarField([found.distortion, found.distortion[self._given.backward]], label)

    def _eigen_field(self, k: int) -> Field:
        on_x, on_y = (shape.eigenfunction(k) for shape in self._shapes)
        # An eigenfunction has no sign of its own: that of Y is turned to agree with X through the map.
        agreement = float((self._shapes[0].surface.vertex_areas * on_x) @ on_y[self._map.forward])
        return ScalarField([on_x, on_y if agreement >= 0 else -on_y], f"φ{_small(k)} √A (no unit)", True)

    def _distance_field(self, k: int) -> Field:
        ends = self.pairs[0]
        fields = [shape.distances_from(v) for shape, v in zip(self._shapes, ends, strict=True)]
        return ScalarField(fields, f"distance from vertex {ends[0]} of X and {ends[1]} of Y / √area")

    def _errors(self, truth: VertexMap) -> FloatArray:
        from qgeo_filters.evaluation import geodesic_error

        if self.flip not in self._errors_of:
            y = self._shapes[1].surface
            self._errors_of[self.flip] = geodesic_error(self._map.forward, truth.forward, y)
        return self._errors_of[self.flip]

    def _error_field(self, truth: VertexMap, k: int) -> Field:
        errors = self._errors(truth)
        label = f"geodesic error on Y / √area (mean {errors.mean():.4f}, largest {errors.max():.4f})"
        return ScalarField([errors, errors[self._map.backward]], label)

    def _attribute_field(self, name: str, k: int) -> Field:
        values = []
        for shape in self._shapes:
            absent = not shape.columns(name)
            values.append(np.full(shape.surface.n_vertices, np.nan) if absent else shape.attribute(name, k))
        return number_field(values, name)

    def _page_extras(self) -> dict[str, Any]:
        return {
            "partners": [self._map.forward, self._map.backward],
            "hint": "Click a point on either shape: its partner is marked on the other.",
        }


def _small(number: int) -> str:
    return "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(number))
