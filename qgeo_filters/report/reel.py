"""A shape of an animation as it is shown: its frames, its colours, and how it is looked at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.animation.pose_transfer import Transfer
from qgeo_filters.animation.sequence import Animation
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.errors import ParameterError
from qgeo_filters.report.colors import MISSING, position_colors
from qgeo_filters.report.render import CLAY, Image, render_mesh
from qgeo_filters.report.view import View, best_view
from qgeo_filters.surface import Surface

_WIDEST, _NARROWEST = 2.2, 0.5


@dataclass(frozen=True, eq=False)
class Reel:
    """One shape of a film: its frames, its colours, and how it is looked at.

    Attributes
    ----------
    name : str
    animation : Animation
    colors : (n, 3) float64
        RGB of each vertex.
    view : View
    """

    name: str
    animation: Animation
    colors: FloatArray
    view: View

    @property
    def shown(self) -> FloatArray:
        """All places where the shape ever is."""
        used = np.unique(self.animation.surface.faces)
        places: FloatArray = self.animation.positions[:, used].reshape(-1, 3)
        return places

    @property
    def aspect(self) -> float:
        """Width over height of the picture."""
        return float(np.clip(self.view.aspect(self.shown), _NARROWEST, _WIDEST))

    def picture(self, positions: FloatArray, height: int, supersample: int = 2) -> Image:
        """Picture (height, width, 3) with the shape there."""
        size = 2 * round(self.aspect * height / 2), height
        return render_mesh(
            positions,
            self.animation.surface.faces,
            colors=self.colors,
            view=self.view,
            shown=self.shown,
            size=size,
            supersample=supersample,
        )


def reels(animation: Animation, names: tuple[str, str] = ("X", "Y"), view: View | None = None) -> list[Reel]:
    """The shapes of an animation: one in clay; of a `Transfer` both, what belongs together in one colour.

    Seen by the `best_view` of the first frame, or of Y at rest.
    """
    if isinstance(names, str) or len(names) != 2:
        raise ParameterError(f"names must be two, of X and of Y, got {names!r}")
    surface = animation.surface
    if not isinstance(animation, Transfer) or animation.source is None or animation.place is None:
        view = view or standing_view(animation)
        return [Reel(names[-1], animation, np.tile(CLAY, (surface.n_vertices, 1)), view)]
    source = animation.source
    view = view or standing_view(animation)
    of_x, of_y = transfer_colors(source.surface, animation.place, view)
    return [Reel(names[0], source, of_x, view), Reel(names[1], animation, of_y, view)]


def standing_view(animation: Animation) -> View:
    """The best view of the first frame; of a `Transfer` of Y at rest."""
    # Y stands in its own frame at rest, and that is how the view knows what is up; in a pose it may jump or lie.
    carried = isinstance(animation, Transfer) and animation.source is not None and animation.place is not None
    return best_view(animation.surface.vertices if carried else animation.positions[0], animation.surface.faces)


def transfer_colors(x: Surface, place: BarycentricMap, view: View | None = None) -> tuple[FloatArray, FloatArray]:
    """Colours of the vertices of X by their place, and of those of Y, that of their point of X; grey without one."""
    of_x = position_colors(x.vertices, (view or best_view(x.vertices, x.faces)).axes)
    of_y = place.pulled_back(of_x)
    return of_x, np.where(np.isnan(of_y), MISSING, np.clip(of_y, 0.0, 1.0))
