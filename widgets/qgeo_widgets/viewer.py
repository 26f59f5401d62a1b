"""The one class behind which pythreejs hides: a few pictures of surfaces under one camera."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import ipywidgets
import numpy as np
import pythreejs as three

from qgeo_filters.errors import ParameterError
from qgeo_filters.surface import Surface
from qgeo_widgets.camera_view import CameraView
from qgeo_widgets.disposal import close_tree
from qgeo_widgets.fallback_image import STYLE, FallbackImage
from qgeo_widgets.motion import Motion
from qgeo_widgets.moving_pane import MovingPane
from qgeo_widgets.pane import Pane
from qgeo_widgets.scene_placement import ScenePlacement, reach

FIELD_OF_VIEW = 26.0
# pythreejs keeps eight WebGL contexts; other canvases are frozen to pictures, which cannot be clicked.
MOST_CANVASES = 8


class Viewer:
    """Surfaces side by side, turned together.

    One camera and one set of orbit controls serve every canvas, which keeps the views in step during a drag, not
    only after it.

    Parameters
    ----------
    surfaces, placements : sequence of Surface and of ScenePlacement
        At least one, at most 12.
    size : (int, int)
        Of each canvas, in pixels.
    titles : sequence of str
    motions : sequence of Motion, optional
        Of surfaces that move; the first view then shows all that they come to, whole.
    """

    def __init__(
        self,
        surfaces: Sequence[Surface],
        placements: Sequence[ScenePlacement],
        size: tuple[int, int],
        titles: Sequence[str],
        motions: Sequence[Motion] = (),
    ) -> None:
        if not 1 <= len(surfaces) <= MOST_CANVASES:
            raise ParameterError(f"a viewer has 1 to {MOST_CANVASES} canvases, not {len(surfaces)}")
        slope = float(np.tan(np.radians(FIELD_OF_VIEW / 2)))
        if motions:
            radius, distance = np.max([motion.reach(slope, size[0] / size[1]) for motion in motions], axis=0).tolist()
        else:
            placed = zip(surfaces, placements, strict=True)
            seen = [placement.to_scene(surface.vertices[np.unique(surface.faces)]) for surface, placement in placed]
            radius, distance = np.max([reach(points, slope, size[0] / size[1]) for points in seen], axis=0).tolist()
        self.home = (0.0, 0.0, 1.05 * distance)
        self._camera = three.PerspectiveCamera(
            fov=FIELD_OF_VIEW, aspect=size[0] / size[1], position=self.home, near=0.02 * radius, far=60 * radius
        )
        self._orbit = three.OrbitControls(controlling=self._camera)
        self.size = size
        self.mark_radius = 0.022 * radius
        shared = self._camera, self._orbit, size, self.mark_radius
        self.moving = [MovingPane(motion, *shared) for motion in motions]
        self.panes: Sequence[Pane] = self.moving or [
            Pane(surface, placement, *shared) for surface, placement in zip(surfaces, placements, strict=True)
        ]
        self._on_camera: list[Callable[[tuple[float, float, float]], None]] = []
        self._camera.observe(self._moved, names="position")
        self.fallbacks = [FallbackImage() for _ in self.panes]
        self.widget = ipywidgets.HBox(
            [
                ipywidgets.HTML(STYLE, layout={"display": "none"}),
                *map(self._framed, self.panes, self.fallbacks, titles),
            ],
            layout={"flex_flow": "row wrap", "overflow": "visible"},
        )

    @property
    def camera(self) -> tuple[float, float, float]:
        """Position of the camera in scene units; it looks at the origin unless it was panned."""
        x, y, z = self._camera.position
        return float(x), float(y), float(z)

    @camera.setter
    def camera(self, position: Sequence[float]) -> None:
        self._camera.position = checked_camera(position)
        self._orbit.exec_three_obj_method("update")

    def reset(self) -> None:
        """Back to where the camera was at first."""
        self._orbit.target = (0.0, 0.0, 0.0)
        self._camera.up = (0.0, 1.0, 0.0)
        self._camera.zoom = 1.0
        self.camera = self.home

    def on_camera(self, callback: Callable[[tuple[float, float, float]], None]) -> None:
        """Call back with the camera's position whenever it was moved."""
        self._on_camera.append(callback)

    def on_pick(self, callback: Callable[[int, int], None]) -> None:
        """Call back with the number of the pane and the vertex nearest to each point that is clicked."""
        for number, pane in enumerate(self.panes):
            pane.on_pick(partial(callback, number))

    def camera_view(self) -> CameraView:
        """What the camera sees, for pictures of it."""
        target = np.asarray(self._orbit.target, dtype=np.float64)
        slope = float(np.tan(np.radians(FIELD_OF_VIEW / 2))) / float(self._camera.zoom)
        return CameraView(np.asarray(self.camera), target, slope, self.size[0] / self.size[1])

    def close(self) -> None:
        """Free everything, here and in the browser."""
        self._on_camera.clear()
        for pane in self.panes:
            pane.close()
        for item in (self.widget, self._orbit, self._camera):
            close_tree(item)

    def _framed(self, pane: Pane, fallback: FallbackImage, title: str) -> ipywidgets.VBox:
        box = ipywidgets.Box([pane.renderer, fallback], layout={"width": f"{self.size[0] + 2}px"})
        box.add_class("qgeo-pane")
        return ipywidgets.VBox(
            [ipywidgets.HTML(title + pane.display.caption), box],
            layout={"margin": "0 6px 4px 0", "overflow": "visible"},
        )

    def _moved(self, change: Any) -> None:
        # Orbit controls report once at first, without having been touched.
        if np.allclose(change["new"], change["old"], rtol=1e-6, atol=1e-6):
            return
        for callback in self._on_camera:
            callback(self.camera)


def checked_camera(position: Sequence[float]) -> tuple[float, float, float]:
    """Where a camera can stand, or `ParameterError`."""
    place = np.asarray(position, dtype=np.float64)
    if place.shape != (3,) or not np.isfinite(place).all() or not place.any():
        raise ParameterError(f"camera must be three finite numbers, not all zero, got {position!r}")
    x, y, z = place.tolist()
    return x, y, z
