"""The widget that compares two shapes, to see whether a correspondence is right."""

from __future__ import annotations

from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import ipywidgets
import numpy as np
import numpy.typing as npt
import traitlets

from qgeo_filters._typing import FloatArray
from qgeo_filters.defaults import EIGENPAIRS
from qgeo_filters.filters import stages
from qgeo_filters.report.colors import position_colors
from qgeo_filters.validation import checked_index
from qgeo_widgets import controls
from qgeo_widgets.base import ATTRIBUTE, EIGENFUNCTION, ShapeWidget
from qgeo_widgets.fields import ColorField, Field, ScalarField, number_field, region_field
from qgeo_widgets.scene_placement import aligned_placement, placement_of
from qgeo_widgets.shape import Shape
from qgeo_widgets.vertex_map import VertexMap
from qgeo_widgets.viewer import Viewer

if TYPE_CHECKING:
    from qgeo_filters.matching.match_result import MatchResult

Pick = tuple[str, int]

CARRIED = "colours carried from X to Y"
REGIONS = "matched regions"
DISTORTION = "distortion of distances"
DISTANCE = "distance from the picked point"
ERROR = "error against the truth"
_SIDES = ("x", "y")
_COLORS = {"first": (0.86, 0.11, 0.16), "second": (0.98, 0.70, 0.10)}


class CompareWidget(ShapeWidget):
    """Two linked views and the map between them; see `qgeo_widgets.compare`.

    Attributes
    ----------
    picked, second : (str, int) or None
        The points that were clicked, as ``("x", vertex)`` or ``("y", vertex)``. A third click starts anew.
    follow : bool
        Whether a click also shows the distances from it.
    flip : bool
        Show the mirrored twin of the map: the map followed by the self-symmetry of Y.
    """

    _page_title = "Two shapes and the map between them"
    picked = traitlets.Tuple(traitlets.Enum(_SIDES), traitlets.Int(), default_value=None, allow_none=True)
    second = traitlets.Tuple(traitlets.Enum(_SIDES), traitlets.Int(), default_value=None, allow_none=True)
    follow = traitlets.Bool(True)
    flip = traitlets.Bool(False)

    def __init__(
        self,
        x: Any,
        y: Any,
        *,
        p2p: npt.ArrayLike | None,
        truth: npt.ArrayLike | None,
        curvature_weight: float,
        size: tuple[int, int],
        progress: bool,
    ) -> None:
        super().__init__()
        with self._guarded():
            self._shapes = Shape(x, "X", curvature_weight), Shape(y, "Y", curvature_weight)
            one, other = surfaces = [shape.surface for shape in self._shapes]
            self._correspondence: MatchResult | None = None
            self._map = self._given = VertexMap(one, other, self._matched(progress) if p2p is None else p2p)
            self._truth = None if truth is None else VertexMap(one, other, truth)
            self._errors_of: dict[bool, FloatArray] = {}
            placement_x = placement_of(surfaces[0])
            seen = surfaces[1].vertices[self._map.forward]
            placement_y = aligned_placement(surfaces[1], seen, placement_x.to_scene(surfaces[0].vertices))
            titles = [f"<b>{s.name}</b>, {s.surface.n_vertices} vertices" for s in self._shapes]
            viewer = Viewer(surfaces, [placement_x, placement_y], size, titles)
            self._modes = self._make_modes()
            follow = controls.tick("distances on click", True, "a click also shows the distances from the point")
            flip = controls.tick("mirrored", False, "the map followed by the self-symmetry of Y")
            self._orientation = ipywidgets.HTML()
            traitlets.link((self, "follow"), (follow, "value"))
            traitlets.link((self, "flip"), (flip, "value"))
            viewer.on_pick(self._clicked)
            self._assemble(viewer, ["X", "Y"], CARRIED, beside=[follow, flip], below=[self._orientation])
            self.observe(lambda _: self._show_picks(), ["picked", "second"])
            self.observe(lambda _: self._flip(), "flip")
            self._show_picks()
            self._show_orientation()

    @property
    def p2p(self) -> npt.NDArray[np.int64]:
        """The map that is shown, (n_x,): vertex of Y for each vertex of X."""
        return self._map.forward

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Vertex of X and vertex of Y for each point that was clicked."""
        return [self._pair(pick) for pick in (self.picked, self.second) if pick is not None]

    # -- the map ------------------------------------------------------------------------------------

    def _matched(self, progress: bool) -> npt.NDArray[np.integer]:
        one, other = (shape.surface for shape in self._shapes)
        found = self._correspondence = stages.correspondence_of(one, other, True, progress)
        return found.p2p

    def _flip(self) -> None:
        with self._guarded():
            mirror = self._mirror if self.flip else None
            if self.flip and mirror is None:
                self.flip = False  # the map that is shown is the one that was given
                self.message = "No symmetry was found on Y, so that the map has no mirrored twin."
                return
            self._map = self._given if mirror is None else self._given.then(mirror)
            self._show_orientation()
            self._show_picks()
            self._refresh(new_mode=True)

    @cached_property
    def _mirror(self) -> npt.NDArray[np.integer] | None:
        """Mirror vertex of each vertex of Y; None where no symmetry is found."""
        symmetry = stages.symmetry_of(self._shapes[1].surface)
        return symmetry.p2p if symmetry.found else None

    def _show_orientation(self) -> None:
        value = self._map.orientation
        verdict = (
            "keeps the orientation" if value > 0.1 else "is mirrored" if value < -0.1 else "has no clear orientation"
        )
        rows = [["map", f"{verdict} (mean cosine of carried and own normals {value:+.2f})"]]
        found = self._correspondence
        if found is not None:
            sure = "confident" if found.confident else "not confident"
            rows.append(
                ["score", f"{found.score:.4f} √area, mean distortion of distances; {sure}: {found.explanation}"]
            )
        self._orientation.value = controls.table(rows)

    # -- picking ------------------------------------------------------------------------------------

    @traitlets.validate("picked", "second")
    def _valid_pick(self, proposal: Any) -> Pick | None:
        pick = proposal["value"]
        if pick is not None and self._viewer is not None:
            checked_index(pick[1], self._shapes[_SIDES.index(pick[0])].surface.n_vertices, proposal["trait"].name)
        return pick

    def _clicked(self, pane: int, vertex: int) -> None:
        pick = _SIDES[pane], vertex
        if self.picked is None or self.second is not None:
            self.set_trait("second", None)
            self.picked = pick
            if self.follow:
                self.mode = DISTANCE
        else:
            self.second = pick

    def _pair(self, pick: Pick) -> tuple[int, int]:
        side, vertex = pick
        if side == "x":
            return vertex, int(self._map.forward[vertex])
        return int(self._map.backward[vertex]), vertex

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
