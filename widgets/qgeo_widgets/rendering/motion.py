"""An animation as the browser gets it: the frames of what is drawn, in the scene, and no more of them than fit."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.animation.sequence import Animation
from qgeo_filters.report.reel import standing_view
from qgeo_widgets.rendering.display_mesh import DisplayMesh
from qgeo_widgets.rendering.scene_placement import ScenePlacement, reach

#: Ticks of a clock from the first frame to the last; as many again lead back.
TICKS = 100_000
#: Bytes of the frames that a browser gets of one pane; a position and a normal in float32 take 24 a vertex.
MOST_BYTES = 64_000_000
#: Frames of one pane: each is two arrays of its own, which take time to arrive however small they are.
MOST_FRAMES = 250
_BYTES = 24
# Below so many vertices a shape is hard to recognise: rather fewer frames.
_FEWEST = 5_000


class Motion:
    """Frames of an animation in a scene.

    Parameters
    ----------
    animation : Animation
    placement : ScenePlacement

    Attributes
    ----------
    display : DisplayMesh
        What is drawn of the surface.
    kept : (k,) int
        Frames that are sent, all of them unless there are too many; between them the browser goes straight.
    """

    def __init__(self, animation: Animation, placement: ScenePlacement) -> None:
        self.animation = animation
        self.placement = placement
        count = min(len(animation), MOST_FRAMES)
        fitting = max(MOST_BYTES // (_BYTES * count), _FEWEST)
        self.display = DisplayMesh(animation.surface, fitting)
        count = max(min(count, MOST_BYTES // (_BYTES * self.display.shown.n_vertices)), 1, min(2, count))
        self.kept = np.linspace(0, len(animation) - 1, count).round().astype(np.int64)

    @property
    def times(self) -> FloatArray:
        """Of the frames that are sent, (k,)."""
        return self.animation.times[self.kept]

    @cached_property
    def positions(self) -> npt.NDArray[np.float32]:
        """Of the vertices that are drawn in each frame that is sent, in the scene, (k, m, 3)."""
        return np.stack([self.placement.to_scene(self._drawn(k)).astype(np.float32) for k in self.kept])

    def normals(self) -> npt.NDArray[np.float32]:
        """Unit normals to those, (k, m, 3)."""
        shown, axes = self.display.shown, self.placement.axes
        return np.stack(
            [(shown.with_vertices(self._drawn(k)).vertex_normals @ axes.T).astype(np.float32) for k in self.kept]
        )

    def weights(self, time: float) -> list[float]:
        """Share of each frame that is sent but the first, whose share is what is left, in the shape at a time."""
        return self.shares(np.array([time]))[0].tolist()

    def shares(self, times: FloatArray) -> FloatArray:
        """The same at several times, one row each, (t, k - 1)."""
        columns = [np.interp(times, self.times, frame) for frame in np.eye(len(self.kept))[1:]]
        return np.stack(columns, axis=1) if columns else np.zeros((len(times), 0))

    @property
    def caption(self) -> str:
        """What a reader has to know of what is drawn."""
        frames = len(self.animation)
        of_them = f", {len(self.kept)} of them sent" if len(self.kept) < frames else ""
        return f", {frames} frame{'s' if frames > 1 else ''}{of_them}"

    def reach(self, slope: float, aspect: float) -> tuple[float, float]:
        """How far the shape comes from the origin in any frame, and the distance of a camera that sees all of it.

        Parameters
        ----------
        slope : float
            Tangent of half the angle that the camera sees from bottom to top.
        aspect : float
            Width of the picture divided by its height.
        """
        used = np.unique(self.animation.surface.faces)
        reaches = [reach(self.placement.to_scene(p[used]), slope, aspect) for p in self.animation.positions]
        farthest, distance = np.max(reaches, axis=0).tolist()
        return farthest, distance

    def _drawn(self, frame: int) -> FloatArray:
        return self.display.at_vertices(self.animation.positions[frame])


def placements_of(animations: Sequence[Animation]) -> list[ScenePlacement]:
    """Placements of one turn and one size, in which each animation is centred on all of its frames.

    The last one decides how they are turned, as films do, and its area is 1.
    """
    last = animations[-1].surface
    axes = standing_view(animations[-1]).axes
    scale = 1.0 / np.sqrt(last.area) if last.area > 0 else 1.0
    placements = []
    for animation in animations:
        seen = animation.positions[:, np.unique(animation.surface.faces)] @ axes.T
        center = axes.T @ (0.5 * (seen.min(axis=(0, 1)) + seen.max(axis=(0, 1))))
        placements.append(ScenePlacement(center, axes, float(scale)))
    return placements
