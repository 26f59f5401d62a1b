"""What colours two shapes that are compared: what is carried through their map, and how good it is."""

from __future__ import annotations

from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
import traitlets

from qgeo_filters._typing import FloatArray
from qgeo_filters.defaults import EIGENPAIRS
from qgeo_filters.errors import ParameterError
from qgeo_filters.report.colors import position_colors
from qgeo_widgets.coloring import ATTRIBUTE, CARRIED, EIGENFUNCTION
from qgeo_widgets.fields import ColorField, Field, ScalarField, number_field, region_field
from qgeo_widgets.matching_widget import MatchingWidget
from qgeo_widgets.texture import Texture, texture_places
from qgeo_widgets.vertex_map import VertexMap

if TYPE_CHECKING:
    from qgeo_filters.matching.match_result import MatchResult

REGIONS = "matched regions"
DISTORTION = "distortion of distances"
DISTANCE = "distance from the picked point"
CHECKERBOARD = "checkerboard carried from X to Y"
TEXTURE = "texture carried from X to Y"
PAINTED = "painted region"
ERROR = "error against the truth"
_CELL = 0.06  # of the checkerboard, in sqrt(area) of X


class ComparedColors(MatchingWidget):
    """Modes of a widget of two shapes and the map between them.

    Attributes
    ----------
    painted : list of int
        Vertices of X in the painted region, ascending; what is painted on Y is what is mapped there.
    """

    painted: traitlets.List[int] = traitlets.List(traitlets.Int())

    def _set_truth(self, truth: Any) -> None:
        """The map that errors are against, or None."""
        one, other = (shape.surface for shape in self._shapes)
        self._truth = None if truth is None else VertexMap(one, other, truth, "truth")
        self._errors_of: dict[bool, FloatArray] = {}

    def _set_texture(self, texture: Any, coordinates: Any, on_scene: FloatArray) -> None:
        """The picture that is carried, or None; a bad one is a sentence, and all else is shown."""
        self._texture: Texture | None = None
        if texture is None and coordinates is not None:
            raise ParameterError("texture_coordinates need a texture")
        with self._guarded():
            found = None if texture is None else Texture.of(texture)
            if found is not None:
                surface = self._shapes[0].surface
                self._places = texture_places(surface, coordinates, lambda: found.projected(on_scene))
                self._texture = found

    def _make_modes(self) -> dict[str, Any]:
        modes: dict[str, Any] = {
            CARRIED: self._carried_field,
            CHECKERBOARD: self._checker_field,
            EIGENFUNCTION: self._eigen_field,
        }
        found = self._correspondence
        if found is not None:
            modes |= {REGIONS: partial(self._region_field, found), DISTORTION: partial(self._distortion_field, found)}
        modes[DISTANCE] = self._distance_field
        modes[PAINTED] = self._painted_field
        if self._texture is not None:
            modes[TEXTURE] = partial(self._texture_field, self._texture)
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
        return ColorField([colors, self._carried(colors)], label)

    def _checker_field(self, k: int) -> Field:
        places = self._open_viewer.panes[0].placement.to_scene(self._shapes[0].surface.vertices) / _CELL
        colors = self._position_colors
        label = "a checkerboard through the space around X, carried to Y: where the map tears, many cells crowd"
        return ColorField([colors, self._carried(colors)], label, cells=[places, self._carried(places)])

    def _texture_field(self, texture: Texture, k: int) -> Field:
        places = [self._places, self._carried(self._places)]
        label = "the texture of X, carried to Y: where the map tears, it is stretched"
        return ColorField([texture.at(each) for each in places], label, places=places)

    def _carried(self, values: FloatArray) -> FloatArray:
        """Values (n, d) of X on Y: within triangles where the match is known, else from vertex to vertex."""
        found = self._correspondence
        if found is None or self._map is not self._given:
            return values[self._map.backward]
        carried = found.transfer(values)
        return np.where(np.isfinite(carried), carried, values[self._map.backward])

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
        return number_field([shape.attribute_or_nan(name, k) for shape in self._shapes], name)

    def _painted_field(self, k: int) -> Field:
        on_x = np.full(self._shapes[0].surface.n_vertices, -1)
        on_x[list(self.painted)] = 0
        label = f"{len(self.painted)} vertices painted on X, and where they are on Y"
        return region_field([on_x, on_x[self._map.backward]], label, ["painted"], "the rest")


def _small(number: int) -> str:
    return "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(number))
