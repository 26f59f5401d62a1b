"""The widget of a collection: a grid of shapes in one colouring, carried from a template."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import traitlets
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.collection.collection import Collection
from qgeo_filters.collection.composition import checked_maps
from qgeo_filters.collection.consistent import How
from qgeo_filters.errors import ParameterError, concerning
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.hosts.repair import Repair
from qgeo_filters.report.colors import position_colors
from qgeo_filters.surface import Surface
from qgeo_widgets import controls
from qgeo_widgets.base import ShapeWidget
from qgeo_widgets.coloring import ATTRIBUTE
from qgeo_widgets.fields import ColorField, Field, ScalarField, number_field
from qgeo_widgets.rendering.backends import most_shapes, new_viewer
from qgeo_widgets.rendering.scene_placement import aligned_placement, placement_of
from qgeo_widgets.shape import Shape

CARRIED = "colours carried from the template"
DISTANCE = "distance from the picked point"
_COLOR = (0.86, 0.11, 0.16)


class CollectionWidget(ShapeWidget):
    """Shapes side by side, turned together; see `qgeo_widgets.collection`.

    Attributes
    ----------
    picked : int or None
        Vertex of the template that was clicked, there or on another shape; it can be set.
    names : tuple of str
        The shapes that are shown, the template first.
    """

    _page_title = "A collection of shapes"
    picked = traitlets.Int(None, allow_none=True)

    def __init__(
        self,
        shapes: Collection | Mapping[str, Any],
        maps: How | Mapping[str, Any],
        *,
        template: str | None,
        page: int,
        size: tuple[int, int],
    ) -> None:
        super().__init__()
        self.names: tuple[str, ...] = ()
        with self._guarded():
            self.names, pages = _shown(list(shapes.names if isinstance(shapes, Collection) else shapes), template, page)
            surfaces = self._surfaces(shapes)
            self._template = self._measured_template(shapes, surfaces[0])
            self._places = self._maps_to_template(
                dict(zip(self.names, surfaces, strict=True)), self._known_maps(shapes, maps)
            )
            first = placement_of(surfaces[0])
            placements = [first]
            for surface, place in zip(surfaces[1:], self._places[1:], strict=True):
                known = place.faces >= 0
                targets = first.to_scene(place.pulled_back(surfaces[0].vertices)[known])
                placements.append(aligned_placement(surface, surface.vertices[known], targets))
            titles = [f"<b>{name}</b>, {s.n_vertices} vertices" for name, s in zip(self.names, surfaces, strict=True)]
            viewer = new_viewer(surfaces, placements, size, titles)
            self._modes = {CARRIED: self._carried_field, DISTANCE: self._distance_field}
            for name in surfaces[0].attributes:
                self._modes[ATTRIBUTE + name] = partial(self._attribute_field, name)
            viewer.on_pick(self._clicked)
            self._assemble(viewer, list(self.names), CARRIED)
            self._page_of = f"page {page} of {pages}; " if pages > 1 else ""
            self.observe(lambda _: self._show_pick(), "picked")
            self._show_pick()

    def _surfaces(self, shapes: Collection | Mapping[str, Any]) -> list[Surface]:
        """The meshes that are shown: as they were given, of a `Repair` too."""
        found = []
        for name in self.names:
            with concerning(name):
                if isinstance(shapes, Collection):
                    found.append(shapes.surface(name))
                else:
                    shape = shapes[name]
                    found.append(shape.given if isinstance(shape, Repair) else as_surface(shape))
        return found

    def _measured_template(self, shapes: Collection | Mapping[str, Any], surface: Surface) -> Shape:
        """The template, with its repair or wrap: that of the collection, or the one that was given."""
        name = self.names[0]
        with concerning(name):
            if isinstance(shapes, Collection):
                return Shape(surface, name, repair=shapes.settings.repair)
            return Shape(shapes[name] if isinstance(shapes[name], Repair) else surface, name)

    def _known_maps(self, shapes: Collection | Mapping[str, Any], maps: How | Mapping[str, Any]) -> Mapping[str, Any]:
        """The maps that were given, or those of a collection; what is not matched yet is matched now."""
        if not isinstance(maps, str):
            return maps
        if not isinstance(shapes, Collection):
            raise ParameterError(f"maps={maps!r} are maps of a Collection; of shapes alone give maps by name")
        self._long.announce()
        with self._long.during("Seeking the maps", at_once=True):
            return shapes.maps_to(self.names[0], maps, names=self.names)

    def _maps_to_template(self, surfaces: dict[str, Any], maps: Mapping[str, Any]) -> list[BarycentricMap]:
        """Point of the template for each vertex of each shape."""
        template = self.names[0]
        missing = [name for name in self.names[1:] if name not in maps]
        if missing:
            raise ParameterError(f"there is no map from {missing[0]} to {template} ({len(missing)} such shapes)")
        own = surfaces[template]
        checked = checked_maps(surfaces, {(name, template): maps[name] for name in self.names[1:]})
        for (name, _), place in checked.items():
            if (place.faces < 0).all():
                raise ParameterError(f"no vertex of {name} has a partner on {template}")
        identity = BarycentricMap.at_vertices(np.arange(own.n_vertices), own.faces, own.n_vertices)
        return [identity, *checked.values()]

    # -- picking ------------------------------------------------------------------------------------

    def _clicked(self, pane: int, vertex: int) -> None:
        partner = int(self._places[pane].nearest_corner[vertex]) if pane else vertex
        if partner < 0:
            self.message = f"Vertex {vertex} of {self.names[pane]} has no partner on {self.names[0]}."
            return
        self.picked = partner

    @traitlets.validate("picked")
    def _known_vertex(self, proposal: Any) -> int | None:
        vertex: int | None = proposal["value"]
        if vertex is None or self._viewer is None or 0 <= vertex < self._template.surface.n_vertices:
            return vertex
        self.message = (
            f"{self.names[0]} has {self._template.surface.n_vertices} vertices, numbered from 0; no {vertex}."
        )
        return self.picked

    @property
    def partners(self) -> tuple[int, ...]:
        """Vertex of each shape whose image on the template is nearest to the picked one; empty without a pick."""
        if self.picked is None or self._viewer is None:
            return ()
        at = self._template.surface.vertices[self.picked]
        found = [self.picked]
        for place in self._places[1:]:
            known = np.flatnonzero(place.faces >= 0)
            images = place.pulled_back(self._template.surface.vertices)[known]
            found.append(int(known[cKDTree(images).query(at)[1]]))
        return tuple(found)

    def _show_pick(self) -> None:
        if self._viewer is None:
            return
        with self._guarded():
            partners = self.partners
            for number, pane in enumerate(self._viewer.panes):
                pane.set_mark("picked", pane.surface.vertices[partners[number]] if partners else None, _COLOR)
            text = f"{self._page_of}click a point on any shape: it is marked on all."
            rows = [[name, f"vertex {v}"] for name, v in zip(self.names, partners, strict=False)]
            self._info.value = controls.table(rows or [[text[0].upper() + text[1:]]])
            if self.mode == DISTANCE:
                self._refresh(new_mode=True)

    # -- colours ------------------------------------------------------------------------------------

    def _missing(self, mode: str) -> str:
        absent = mode == DISTANCE and self.picked is None
        return "Click a point on one of the shapes: the distances from it are then shown." if absent else ""

    def _columns(self, mode: str) -> int:
        return self._template.columns(mode.removeprefix(ATTRIBUTE)) if mode.startswith(ATTRIBUTE) else 1

    def _carried(self, values: FloatArray) -> list[FloatArray]:
        return [values, *(place.pulled_back(values) for place in self._places[1:])]

    def _carried_field(self, k: int) -> Field:
        axes = self._open_viewer.panes[0].placement.axes
        colors = self._carried(position_colors(self._template.surface.vertices, axes))
        label = f"each point has the colour of its partner on {self.names[0]}; grey: none"
        return ColorField([np.where(np.isnan(rgb), 0.62, rgb) for rgb in colors], label)

    def _distance_field(self, k: int) -> Field:
        vertex = self.partners[0]
        values = self._carried(np.asarray(self._template.distances_from(vertex), dtype=np.float64))
        return ScalarField(values, f"distance from vertex {vertex} on {self.names[0]} / √area")

    def _attribute_field(self, name: str, k: int) -> Field:
        return number_field(self._carried(np.asarray(self._template.attribute(name, k), dtype=np.float64)), name)


def _shown(names: list[str], template: str | None, page: int) -> tuple[tuple[str, ...], int]:
    """Names of the shapes of a page, the template first, and how many pages there are."""
    if not names:
        raise ParameterError("there is no shape")
    first = names[0] if template is None else template
    if first not in names:
        raise ParameterError(f"there is no shape called {first!r} to be the template, only {', '.join(names[:8])}")
    others = [name for name in names if name != first]
    room = most_shapes() - 1
    pages = max(1, -(-len(others) // room))
    if not 1 <= page <= pages:
        raise ParameterError(f"page must be between 1 and {pages}, got {page}")
    return (first, *others[(page - 1) * room : page * room]), pages
