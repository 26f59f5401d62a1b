"""The widget that compares two shapes, to see whether a correspondence is right."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import traitlets

from qgeo_filters._typing import RepairOption
from qgeo_filters.validation import checked_index, checked_indices
from qgeo_widgets import controls
from qgeo_widgets.brush import Brush
from qgeo_widgets.compared_colors import CARRIED, DISTANCE, DISTORTION, ERROR, PAINTED, TEXTURE, ComparedColors
from qgeo_widgets.fields import ScalarField
from qgeo_widgets.matching_widget import SIDES
from qgeo_widgets.rendering.backends import new_viewer
from qgeo_widgets.rendering.scene_placement import aligned_placement, placement_of
from qgeo_widgets.shape import Shape
from qgeo_widgets.shown_match import wraps_of_match
from qgeo_widgets.worst_list import WorstList

if TYPE_CHECKING:
    from qgeo_filters.matching.match_result import MatchResult

_COLORS = {"first": (0.86, 0.11, 0.16), "second": (0.98, 0.70, 0.10)}


class CompareWidget(ComparedColors):
    """Two linked views and the map between them; see `qgeo_widgets.compare`, and `MatchingWidget` for more attributes.

    Attributes
    ----------
    follow : bool
        Whether a click also shows the distances from it.
    brush : bool
        Whether the mouse paints a region, and does not turn the shapes.
    """

    _page_title = "Two shapes and the map between them"
    _takes_repair = True
    follow = traitlets.Bool(True)
    brush = traitlets.Bool(False)

    def __init__(
        self,
        x: Any,
        y: Any,
        *,
        p2p: npt.ArrayLike | MatchResult | None,
        truth: npt.ArrayLike | None,
        texture: Any,
        texture_coordinates: Any,
        curvature_weight: float,
        repair: RepairOption,
        size: tuple[int, int],
        progress: bool,
    ) -> None:
        super().__init__()
        with self._guarded():
            with self._long.during("Repairing the shapes"):
                around = wraps_of_match(x, y, repair, p2p)
                one, other = (
                    Shape(mesh, name, curvature_weight, repair=repair) for mesh, name in zip(around, "XY", strict=True)
                )
            self._set_up((one, other), p2p, progress)
            surfaces = [shape.surface for shape in self._shapes]
            self._set_truth(truth)
            placement_x = placement_of(one.surface, one.measured)
            known = self._map.forward >= 0
            seen, targets = other.surface.vertices[self._map.forward[known]], one.surface.vertices[known]
            placement_y = aligned_placement(other.surface, seen, placement_x.to_scene(targets), other.measured)
            placement_y = replace(placement_y, scale=placement_y.scale * self._larger)
            self._set_texture(texture, texture_coordinates, placement_x.to_scene(surfaces[0].vertices))
            titles = [f"<b>{s.name}</b>, {s.surface.n_vertices} vertices" for s in self._shapes]
            viewer = new_viewer(surfaces, [placement_x, placement_y], size, titles)
            viewer.set_texture(self._texture)
            self._modes = self._make_modes()
            follow = controls.tick("distances on click", True, "a click also shows the distances from the point")
            traitlets.link((self, "follow"), (follow, "value"))
            viewer.on_pick(self._clicked)
            beside, below = self._map_controls()
            brush = controls.tick("paint", False, "draw a region on one of the shapes, and see it on the other")
            traitlets.link((self, "brush"), (brush, "value"))
            wipe = controls.button("wipe", "nothing is painted any more")
            wipe.on_click(lambda _: self.set_trait("painted", []))
            self._worst = WorstList(self.look_at)
            controls_beside = [follow, *beside, brush, wipe]
            first = CARRIED if self._texture is None else TEXTURE
            self._assemble(viewer, ["X", "Y"], first, beside=controls_beside, below=[self._worst, *below])
            self.observe(lambda change: self._open_viewer.set_brush(change["new"]), "brush")
            self.observe(lambda _: self._show_painted(), "painted")
            self.observe(lambda _: self._show_picks(), ["picked", "second"])
            self._show_picks()
            self._show_orientation()

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Vertex of X and vertex of Y for each point that was clicked; -1 where it has no partner."""
        return [self._pair(pick) for pick in (self.picked, self.second) if pick is not None]

    @property
    def _larger(self) -> float:
        """How much larger than with sqrt(area) 1 Y is drawn: a part is as large as it is on the whole."""
        found = self._correspondence
        return 1.0 if found is None else float(np.sqrt(found.overlap_x / found.overlap_y))

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

    def _paint(self, new_mode: bool) -> None:
        super()._paint(new_mode)
        field = self._field
        values = field.values[0] if self.mode in (ERROR, DISTORTION) and isinstance(field, ScalarField) else None
        self._worst.show(self._shapes[0].surface, values)

    def look_at(self, vertex: int) -> None:
        """Pick a vertex of X, and turn the shapes so that it faces the camera."""
        checked_index(vertex, self._shapes[0].surface.n_vertices, "vertex")
        self.set_trait("second", None)
        self.picked = ("x", vertex)
        viewer = self._open_viewer
        facing = viewer.panes[0].placement.axes @ self._shapes[0].normals[vertex]
        upright = np.clip(facing, [-1.0, -0.9, -1.0], [1.0, 0.9, 1.0])  # not along the axis that it turns about
        if np.linalg.norm(upright) > 0:
            viewer.reset()  # it may have been moved aside
            self.camera = tuple((np.linalg.norm(viewer.home) * upright / np.linalg.norm(upright)).tolist())

    # -- painting -----------------------------------------------------------------------------------

    @traitlets.validate("painted")
    def _valid_region(self, proposal: Any) -> list[int]:
        vertices: list[int] = proposal["value"]
        if self._viewer is not None:
            checked_indices(vertices, self._shapes[0].surface.n_vertices, "painted")
        return sorted(set(vertices))

    @cached_property
    def _brushes(self) -> tuple[Brush, Brush]:
        one, other = (Brush(shape.surface, shape.normals, shape.unit) for shape in self._shapes)
        return one, other

    def _dab(self, side: int, vertex: int) -> None:
        touched = self._brushes[side].dab(vertex)
        if side == 1:
            touched = np.flatnonzero(np.isin(self._map.forward, touched))
        self.painted = [*self.painted, *touched.tolist()]

    def _show_painted(self) -> None:
        if self.painted and self.mode != PAINTED:
            self.mode = PAINTED
        else:
            self._refresh()

    # -- picking ------------------------------------------------------------------------------------

    def _clicked(self, pane: int, vertex: int) -> None:
        if self.brush:
            self._dab(pane, vertex)
            return
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
                    place = None if vertex is None or vertex < 0 else pane.surface.vertices[vertex]
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
            rows.append([name, *(f"vertex {v}" if v >= 0 else "no partner" for v in (i, j))])
            values = [dict(s.described(v)) if v >= 0 else {} for s, v in zip(self._shapes, (i, j), strict=True)]
            rows += [[key, *(v.get(key, "–") for v in values)] for key in sorted(values[0] | values[1])]
            if self._truth is not None and i >= 0:
                error = self._errors(self._truth)[i]
                rows.append(["error there", f"{error:.4f} √area" if np.isfinite(error) else "not known", ""])
        return controls.table(rows + ([["quasi-geodesic", *lengths]] if lengths else []), head)

    def _path_lengths(self) -> list[str]:
        """Draw the path between two picked points on each shape; its lengths as text, none unless there are two.

        On what is measured: a wrap lies a little off the mesh that is shown. None on a shape where one has no partner.
        """
        ends, panes = self.pairs, self._open_viewer.panes
        for pane in panes:
            pane.set_line("path", None)
        if len(ends) < 2:
            return []
        from qgeo_filters.geodesics.path.paths import quasi_geodesic

        lengths = []
        for side, (pane, shape) in enumerate(zip(panes, self._shapes, strict=True)):
            if min(ends[0][side], ends[1][side]) < 0:
                lengths.append("–")
                continue
            source, target = (shape.stand_in(end[side]) for end in ends)
            path = quasi_geodesic(shape.measured, source, target, shape.metric)
            pane.set_line("path", path.points, _COLORS["first"])
            lengths.append(f"{path.length / shape.unit:.4f} √area")
        return lengths

    def _page_extras(self) -> dict[str, Any]:
        return {
            "partners": [self._map.forward, self._map.backward],
            "hint": "Click a point on either shape: its partner is marked on the other.",
        }
