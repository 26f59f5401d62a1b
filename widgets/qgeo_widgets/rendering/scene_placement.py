"""Where shapes stand in a scene: centred, upright, of one size, and seen from the same side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.report.view import best_view
from qgeo_filters.surface import Surface


@dataclass(frozen=True, eq=False)
class ScenePlacement:
    """Similarity from a surface's own coordinates to those of a scene, where sqrt(area) of what is measured is 1.

    Attributes
    ----------
    center : (3,) float64
        Goes to the origin.
    axes : (3, 3) float64
        Rotation; its rows point right, up and towards the viewer.
    scale : float
    """

    center: FloatArray
    axes: FloatArray
    scale: float

    def to_scene(self, points: npt.ArrayLike) -> FloatArray:
        """Points (..., 3) in the scene."""
        return (np.asarray(points, dtype=np.float64) - self.center) @ self.axes.T * self.scale

    def to_surface(self, points: npt.ArrayLike) -> FloatArray:
        """Points (..., 3) of the scene in the surface's own coordinates."""
        return np.asarray(points, dtype=np.float64) @ self.axes / self.scale + self.center

    def turned(self) -> ScenePlacement:
        """The same after half a turn about the scene's vertical axis: the back of the shape."""
        return ScenePlacement(self.center, np.diag([-1.0, 1.0, -1.0]) @ self.axes, self.scale)


def placement_of(surface: Surface, measured: Surface | None = None) -> ScenePlacement:
    """ScenePlacement that shows the surface upright, from three quarters and a little from above.

    Parameters
    ----------
    surface : Surface
    measured : Surface, optional
        What has its area and its outside in its place, such as a wrap: walls inside count for nothing.
    """
    outside = measured or surface
    return _centered(surface, best_view(outside.vertices, outside.faces).axes, outside)


def aligned_placement(
    surface: Surface, points: npt.ArrayLike, targets: npt.ArrayLike, measured: Surface | None = None
) -> ScenePlacement:
    """Placement in which points of the surface lie as near as a rotation can bring them to targets in the scene.

    Parameters
    ----------
    surface : Surface
    points, targets : array-like, shape (p, 3)
        In the surface's coordinates, and in the scene's.
    measured : Surface, optional
        As of `placement_of`.

    References
    ----------
    Kabsch, "A solution for the best rotation to relate two sets of vectors", Acta Cryst. A32, 1976.
    """
    source = np.asarray(points, dtype=np.float64)
    target = np.asarray(targets, dtype=np.float64)
    u, _, vt = np.linalg.svd((target - target.mean(axis=0)).T @ (source - source.mean(axis=0)))
    axes = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    return _centered(surface, axes, measured or surface)


def reach(points: FloatArray, slope: float, aspect: float) -> tuple[float, float]:
    """How far points of a scene lie from its origin, and the least distance of a camera that keeps all of them in view.

    It looks at the origin from the horizon, and still sees all of them when they are turned about the vertical axis.

    Parameters
    ----------
    points : (p, 3) float64
    slope : float
        Tangent of half the angle that the camera sees from bottom to top.
    aspect : float
        Width of the picture divided by its height.
    """
    x, y, z = np.abs(points).T
    sideways = np.hypot(x, z)
    farthest = float(np.hypot(sideways, y).max())
    # What is near looks larger: a point turned to the front must not leave the picture at the top, nor one on its way
    # there, where the line of sight touches its circle, at the side.
    upward = float((y / slope + sideways).max())
    distance = max(upward, float(sideways.max()) * float(np.hypot(1.0, 1.0 / (slope * aspect))))
    return farthest or 1.0, distance or 1.0


def _centered(surface: Surface, axes: FloatArray, measured: Surface) -> ScenePlacement:
    """ScenePlacement with these axes whose origin is the middle of the box around what has faces."""
    used = surface.vertices[np.unique(surface.faces)] @ axes.T
    center = axes.T @ (0.5 * (used.min(axis=0) + used.max(axis=0)))
    return ScenePlacement(center, axes, 1.0 / np.sqrt(measured.area) if measured.area > 0 else 1.0)
