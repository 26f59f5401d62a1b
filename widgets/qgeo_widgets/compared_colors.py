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
from qgeo_widgets.fields import ColorField, Field, ScalarField, grey_where_missing, number_field, region_field
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
        self._truth = None if truth is None else self._map_of(truth, "truth")
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
            return min(EIGENPAIRS, *(shape.measured.n_vertices for shape in self._shapes))
        if mode.startswith(ATTRIBUTE):
            return max(shape.columns(mode.removeprefix(ATTRIBUTE)) for shape in self._shapes)
        return 1

    @cached_property
    def _position_colors(self) -> FloatArray:
        surface = self._shapes[0].surface
        return position_colors(surface.vertices, self._open_viewer.panes[0].placement.axes)

    def _carried_field(self, k: int) -> Field:
        colors = [grey_where_missing(each) for each in self._on_both(self._position_colors)]
        label = "each point of Y has the colour of its partner on X; on X the colour tells the place"
        return ColorField(colors, label + self._note)

    def _checker_field(self, k: int) -> Field:
        places = self._open_viewer.panes[0].placement.to_scene(self._shapes[0].surface.vertices) / _CELL
        colors = [grey_where_missing(each) for each in self._on_both(self._position_colors)]
        label = "a checkerboard through the space around X, carried to Y: where the map tears, many cells crowd"
        return ColorField(colors, label + self._note, cells=self._on_both(places))

    def _texture_field(self, texture: Texture, k: int) -> Field:
        places = self._on_both(self._places)
        label = "the texture of X, carried to Y: where the map tears, it is stretched"
        return ColorField([texture.at(each) for each in places], label + self._note, places=places)

    @property
    def _note(self) -> str:
        """What grey means, where there is any."""
        return f"; grey: {self._alone}" if any(self._map.unmatched) else ""

    def _on_both(self, values: FloatArray) -> list[FloatArray]:
        """Values (n, d) of X on X and, carried, on Y; NaN where a vertex has no partner."""
        return [np.where(self._map.forward[:, None] >= 0, values, np.nan), self._carried(values)]

    def _carried(self, values: FloatArray) -> FloatArray:
        """Values (n, d) of X on Y: within triangles where the match is known, else from vertex to vertex."""
        found, simply = self._correspondence, self._map.on_y(values)
        if found is None or self._map is not self._given:
            return simply
        carried = found.transfer(values)
        return np.where(np.isfinite(carried), carried, simply)

    def _region_field(self, found: MatchResult, k: int) -> Field:
        return region_field(
            [found.regions_x, found.regions_y], "regions of one colour belong together", loose_name="no partner"
        )

    def _distortion_field(self, found: MatchResult, k: int) -> Field:
        label = "mean |d(p, q) − d(Tp, Tq)| of the map that was found / √area"
        return ScalarField([found.distortion, self._given.on_y(found.distortion)], label)

    def _eigen_field(self, k: int) -> Field:
        on_x, on_y = (shape.eigenfunction(k) for shape in self._shapes)
        # An eigenfunction has no sign of its own: that of Y is turned to agree with X through the map.
        images = self._map.forward
        products = np.where(images >= 0, on_x * on_y[images], np.nan)
        agreement = np.nansum(self._shapes[0].surface.vertex_areas * products)
        return ScalarField([on_x, on_y if agreement >= 0 else -on_y], f"φ{_small(k)} √A (no unit)", True)

    def _distance_field(self, k: int) -> Field:
        ends = self.pairs[0]
        fields = [
            shape.distances_from(v) if v >= 0 else np.full(shape.surface.n_vertices, np.nan)
            for shape, v in zip(self._shapes, ends, strict=True)
        ]
        at = " and ".join(f"{v} of {shape.name}" for shape, v in zip(self._shapes, ends, strict=True) if v >= 0)
        alone = ", which has no partner," if min(ends) < 0 else ""
        return ScalarField(fields, f"distance from vertex {at}{alone} / √area")

    def _errors(self, truth: VertexMap) -> FloatArray:
        """Error of each vertex of X (n_x,); NaN where it has no partner, or the truth is not known."""
        from qgeo_filters.matching.map_errors import map_errors

        if self.flip not in self._errors_of:
            y = self._shapes[1]
            self._errors_of[self.flip] = map_errors(y.surface, self._map.forward, truth.forward, False, y.repair)
        return self._errors_of[self.flip]

    def _error_field(self, truth: VertexMap, k: int) -> Field:
        errors = self._errors(truth)
        known = errors[np.isfinite(errors)]
        said = f"mean {known.mean():.4f}, largest {known.max():.4f}" if known.size else "of no vertex known"
        if 0 < known.size < len(errors):
            said += f", of {known.size} of {len(errors)} vertices"
        return ScalarField([errors, self._map.on_y(errors)], f"geodesic error on Y / √area ({said})")

    def _attribute_field(self, name: str, k: int) -> Field:
        return number_field([shape.attribute_or_nan(name, k) for shape in self._shapes], name)

    def _painted_field(self, k: int) -> Field:
        on_x = np.full(self._shapes[0].surface.n_vertices, -1)
        on_x[list(self.painted)] = 0
        label = f"{len(self.painted)} vertices painted on X, and where they are on Y"
        return region_field([on_x, self._map.on_y(on_x)], label, ["painted"], "the rest")


def _small(number: int) -> str:
    return "".join("₀₁₂₃₄₅₆₇₈₉"[int(digit)] for digit in str(number))
