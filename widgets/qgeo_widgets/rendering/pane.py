"""What is shown of one surface: mesh, colours, marks, lines and picking; a backend draws it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.surface import Surface
from qgeo_widgets.rendering.display_mesh import DisplayMesh
from qgeo_widgets.rendering.motion import Motion
from qgeo_widgets.rendering.scene_placement import ScenePlacement

Color = tuple[float, float, float]

CLAY = np.array([0.82, 0.83, 0.86], dtype=np.float32)
RED: Color = (0.86, 0.11, 0.16)
# Extent, in the scene, of a curve that runs from a point to itself but for rounding.
_NO_LENGTH = 1e-6


class Mark(NamedTuple):
    """A ball at a point, in the surface's coordinates."""

    point: FloatArray
    color: Color


class Line(NamedTuple):
    """A curve through points (p, 3), in the surface's coordinates, so many pixels wide."""

    points: FloatArray
    color: Color
    width: float


class Pane:
    """A surface in a scene of its own, as it is to be drawn.

    A backend makes it visible: it overrides the methods that begin with ``_draw``.

    Parameters
    ----------
    surface : Surface
    placement : ScenePlacement
    motion : Motion, optional
        How the surface moves; then it is the surface of the first frame.

    Attributes
    ----------
    colors : (n, 3) float32
    regions : ((n,) int, (k, 3) float64) or None
        Rows of a palette, where colours are those of regions with sharp borders.
    values : (n,) float64 or int64, or None
        What the colours stand for, said of the vertex under the mouse; numbers of regions where there are names.
    names : tuple of str
    cells : (n, 3) float64 or None
        Coordinates in which a checkerboard of cells of size 1 lies over the colours.
    places : (n, 2) float64 or None
        Places on the viewer's texture, which is then seen instead of the colours.
    marks, lines : dict of str to Mark and to Line
        By slot.
    """

    def __init__(self, surface: Surface, placement: ScenePlacement, motion: Motion | None = None) -> None:
        self.surface = surface
        self.placement = placement
        self.motion = motion
        self.display = DisplayMesh(surface) if motion is None else motion.display
        self.colors = np.tile(CLAY, (surface.n_vertices, 1))
        self.regions: tuple[IndexArray, FloatArray] | None = None
        self.values: FloatArray | IndexArray | None = None
        self.names: tuple[str, ...] = ()
        self.cells: FloatArray | None = None
        self.places: FloatArray | None = None
        self.marks: dict[str, Mark] = {}
        self.lines: dict[str, Line] = {}
        self._on_pick: list[Callable[[int], None]] = []

    @property
    def caption(self) -> str:
        """What a reader has to know of what is drawn."""
        return ("" if self.motion is None else self.motion.caption) + self.display.caption

    # -- colours ------------------------------------------------------------------------------------

    def set_colors(self, colors: npt.ArrayLike) -> bool:
        """Show these colours (n, 3) in [0, 1]; whether anything had to be sent."""
        new = np.ascontiguousarray(colors, dtype=np.float32)
        if new.shape != self.colors.shape:
            raise ParameterError(f"colors have shape {new.shape}, expected {self.colors.shape}")
        if np.array_equal(new, self.colors):
            return False
        self.colors = new
        self._draw_colors()
        return True

    def set_regions(self, labels: IndexArray | None, palette: FloatArray | None = None) -> None:
        """Sharpen the borders between regions, rows (n,) of the palette (k, 3), over their colours; None undoes it."""
        if labels is None and self.regions is None:
            return
        self.regions = None if labels is None or palette is None else (labels, palette)
        self._draw_regions()

    def set_values(self, values: FloatArray | IndexArray | None, names: Sequence[str] = ()) -> None:
        """What the colours stand for, (n,), and the names of regions where the values are their numbers."""
        self.values, self.names = values, tuple(names)
        self._draw_values()

    def set_cells(self, cells: FloatArray | None) -> None:
        """Lay a checkerboard over the colours: its cells have size 1 in these coordinates (n, 3); None takes it off."""
        if cells is None and self.cells is None:
            return
        self.cells = cells
        self._draw_cells()

    def set_places(self, places: FloatArray | None) -> None:
        """Show the viewer's texture, each vertex at its place (n, 2) on it; None shows the colours."""
        if places is None and self.places is None:
            return
        self.places = places
        self._draw_places()

    # -- marks and lines ----------------------------------------------------------------------------

    def set_mark(self, slot: str, point: npt.ArrayLike | None, color: Color = RED) -> None:
        """Show a ball at a point (in the surface's coordinates), in place of the one in this slot; None hides it."""
        if point is None:
            if self.marks.pop(slot, None) is None:
                return
        else:
            self.marks[slot] = Mark(np.asarray(point, dtype=np.float64), color)
        self._draw_mark(slot)

    def set_line(self, slot: str, points: npt.ArrayLike | None, color: Color = RED, width: float = 5.0) -> None:
        """Show a curve through points (p, 3) of the surface, in place of the one in this slot; None removes it.

        A curve without length, like the path from a point to itself, shows nothing.
        """
        old = self.lines.pop(slot, None)
        curve = np.empty((0, 3)) if points is None else np.asarray(points, dtype=np.float64)
        if len(curve) > 1 and np.ptp(self.placement.to_scene(curve), axis=0).max() > _NO_LENGTH:
            self.lines[slot] = Line(curve, color, width)
        elif old is None:
            return
        self._draw_line(slot)

    # -- picking ------------------------------------------------------------------------------------

    def on_pick(self, callback: Callable[[int], None]) -> None:
        """Call back with the vertex nearest to each point that is clicked; the end of a drag is no click."""
        self._on_pick.append(callback)

    def clicked(self, corners: npt.ArrayLike, point: npt.ArrayLike) -> None:
        """A point of the scene was clicked, in the drawn triangle with these corners (3,)."""
        triangle = np.asarray(corners, dtype=np.int64)
        if triangle.shape != (3,) or not ((triangle >= 0) & (triangle < self.display.shown.n_vertices)).all():
            return
        vertex = self.display.vertex_at(triangle, self.placement.to_surface(point))
        for callback in self._on_pick:
            callback(vertex)

    # -- motion -------------------------------------------------------------------------------------

    def pose(self, time: float) -> None:
        """Make `surface` that at a time, for pictures without a browser."""
        if self.motion is not None:
            animation = self.motion.animation
            self.surface = animation.surface.with_vertices(animation.at(time))

    # -- for backends -------------------------------------------------------------------------------

    def _draw_colors(self) -> None:
        """Show `colors`."""

    def _draw_regions(self) -> None:
        """Show the borders of `regions`."""

    def _draw_values(self) -> None:
        """Say `values` under the mouse."""

    def _draw_cells(self) -> None:
        """Show the checkerboard of `cells`."""

    def _draw_places(self) -> None:
        """Show the texture at `places`."""

    def _draw_mark(self, slot: str) -> None:
        """Show the mark in a slot, or that there is none."""

    def _draw_line(self, slot: str) -> None:
        """Show the line in a slot, or that there is none."""

    def close(self) -> None:
        """Free all that the pane holds, in the kernel and in the browser."""
        self._on_pick.clear()


def css_color(color: npt.ArrayLike) -> str:
    """A colour of three numbers from 0 to 1 as browsers write it."""
    return "#" + "".join(f"{round(255 * float(channel)):02x}" for channel in np.asarray(color))
