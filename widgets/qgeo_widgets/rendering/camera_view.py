"""Where a perspective camera stands, and its picture as one by parallel projection, for pictures in software."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray

# Of the camera's distance from its target: what is nearer is not drawn, as before the near plane in the browser.
_NEAR = 0.02


@dataclass(frozen=True, eq=False)
class CameraView:
    """What an upright perspective camera sees.

    Attributes
    ----------
    position, target : (3,) float64
        Where it stands, and what it looks at, which is the middle of the picture.
    slope : float
        Tangent of half the angle that it sees from bottom to top.
    aspect : float
        Width of the picture divided by its height.
    """

    position: FloatArray
    target: FloatArray
    slope: float
    aspect: float

    @property
    def axes(self) -> FloatArray:
        """Rows that point right, up and towards the viewer, shape (3, 3)."""
        toward = (self.position - self.target) / self.distance
        right = np.cross([0.0, 1.0, 0.0], toward)
        right = right / np.linalg.norm(right) if np.linalg.norm(right) > 1e-9 else np.array([1.0, 0.0, 0.0])
        return np.array([right, np.cross(toward, right), toward])

    @property
    def distance(self) -> float:
        """From the camera to its target."""
        return float(np.linalg.norm(self.position - self.target)) or 1.0

    @property
    def frame(self) -> FloatArray:
        """Two opposite corners of the picture, where `flattened` puts them, shape (2, 3)."""
        height = self.slope * self.distance
        return np.array([[-height * self.aspect, -height, 0.0], [height * self.aspect, height, 0.0]])

    def flattened(self, points: npt.ArrayLike) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Points (p, 3) moved so that a parallel projection along z shows them as the camera does; which it can see.

        The map is projective: straight lines stay straight, what is hidden stays hidden, and about the target it moves
        nothing. What is behind the camera comes to the target.
        """
        x, y, z = ((np.asarray(points, dtype=np.float64) - self.target) @ self.axes.T).T
        gap = self.distance - z
        seen = gap > _NEAR * self.distance
        factor = np.where(seen, self.distance / np.where(seen, gap, 1.0), 0.0)
        return np.stack([x, y, z], axis=1) * factor[:, None], seen
