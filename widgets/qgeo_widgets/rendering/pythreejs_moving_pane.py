"""A pane whose surface moves: the frames lie on the graphics card, and the browser plays them without the kernel."""

from __future__ import annotations

from typing import Any

import ipywidgets
import numpy as np
import pythreejs as three

from qgeo_filters._typing import FloatArray
from qgeo_widgets.rendering.disposal import close_tree
from qgeo_widgets.rendering.motion import TICKS, Motion
from qgeo_widgets.rendering.pythreejs_pane import MATERIAL, PythreejsPane, vectors


class MovingPane(PythreejsPane):
    """A pane that shows an animation at any of its times.

    Frames are morph targets of three.js: it blends positions and normals of the two frames around a time, and few bytes
    say which. An action of three.js that stands still by itself (``timeScale=0``) takes its time from a clock in the
    browser and sets the blend in each picture; so it goes on while the kernel is busy.

    Parameters
    ----------
    motion : Motion
    camera, orbit, size, mark_radius
        See `PythreejsPane`.
    """

    def __init__(self, motion: Motion, camera: Any, orbit: Any, size: tuple[int, int], mark_radius: float) -> None:
        self._moving = motion
        self._moving_mesh: Any = None
        self._action: Any = None
        self._links: list[Any] = []
        super().__init__(motion.animation.surface, motion.placement, camera, orbit, size, mark_radius, motion)

    def _first_look(self) -> tuple[FloatArray, FloatArray]:
        self._normals = self._moving.normals()
        return self._moving.positions[0].astype(np.float64), self._normals[0].astype(np.float64)

    def _make_mesh(self, attributes: dict[str, Any]) -> Any:
        further = {"position": self._moving.positions[1:], "normal": self._normals[1:]}
        del self._normals  # sent, and not needed again
        morphs = {name: [vectors(frame) for frame in frames] for name, frames in further.items()}
        moves = bool(morphs["position"])
        geometry = three.BufferGeometry(attributes=attributes, morphAttributes=morphs if moves else {})
        material = three.MeshLambertMaterial(**MATERIAL, morphTargets=moves, morphNormals=moves)
        # three.js would leave out the mesh where its first frame is not in the picture.
        self._moving_mesh = three.Mesh(geometry, material, frustumCulled=False)
        if moves:
            self._action = self._make_action()
        self.show(float(self._moving.times[0]))
        return self._moving_mesh

    def _make_action(self) -> Any:
        """What sets the blend to that of its time, there and back."""
        times = self._moving.times
        there = TICKS * (times - times[0]) / (times[-1] - times[0])
        shares = self._moving.shares(times)
        track = three.NumberKeyframeTrack(
            name=".morphTargetInfluences",
            times=np.concatenate([there, 2 * TICKS - there[-2::-1]]).astype(np.float32),
            values=np.concatenate([shares, shares[-2::-1]]).astype(np.float32),
        )
        clip = three.AnimationClip(tracks=[track], duration=2.0 * TICKS)
        mixer = three.AnimationMixer(self._moving_mesh)
        return three.AnimationAction(mixer, clip, self._moving_mesh, timeScale=0)

    # -- time ---------------------------------------------------------------------------------------

    def follow(self, clock: ipywidgets.Widget) -> None:
        """Take the time, in ticks, from the value of a clock in the browser, while the pane plays."""
        if self._action is not None:
            self._links.append(ipywidgets.jsdlink((clock, "value"), (self._action, "time")))

    def play(self) -> None:
        """Draw all the time, at the time of the clock."""
        if self._action is not None:
            self._action.play()

    def pause(self, time: float) -> None:
        """Draw no longer than needed, and show the shape at a time."""
        if self._action is not None:
            self._action.pause()
        self.show(time)

    def show(self, time: float) -> None:
        """The shape at a time."""
        self._moving_mesh.morphTargetInfluences = self._moving.weights(time)

    def close(self) -> None:
        """Free all that the pane holds, in the kernel and in the browser."""
        for item in (*self._links, self._action):
            if item is not None:
                close_tree(item)
        self._links.clear()
        super().close()
