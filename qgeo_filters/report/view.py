"""Directions to look from: an upright view from three quarters that shows as much as it can."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from qgeo_filters._typing import FloatArray, IntArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.report.raster import rasterize

_THREE_QUARTER = 30.0  # degrees from the broadside: depth shows, and the silhouette is still wide


@dataclass(frozen=True, eq=False)
class View:
    """Parallel projection: the rows of ``axes`` point to the right, up and towards the viewer.

    Attributes
    ----------
    axes : (3, 3) float64
        A rotation.
    vertical : (3,) float64
        The direction in space that is up for the shape, about which `turned` turns.
    """

    axes: FloatArray
    vertical: FloatArray

    def turned(self, degrees: float) -> View:
        """The view after the viewer has walked around the shape, to the right for positive angles."""
        turn = Rotation.from_rotvec(np.radians(degrees) * self.vertical).as_matrix()
        return View(self.axes @ turn.T, self.vertical)

    def aspect(self, vertices: FloatArray) -> float:
        """Width of the picture of the vertices divided by its height; at least 0.05, at most 20."""
        width, height = np.ptp(vertices @ self.axes[:2].T, axis=0)
        return float(np.clip(width / max(float(height), 1e-300), 0.05, 20.0))

    def fit(self, vertices: FloatArray, width: int, height: int, margin: float = 0.03) -> Projection:
        """Projection of width x height pixels that shows all of the vertices, as large as fits.

        Raises
        ------
        ValueError
            If the picture has no pixels.
        """
        if min(width, height) < 1:
            raise ParameterError(f"a picture must be at least 1 x 1 pixels, got {width} x {height}")
        axes = self.axes * [[1.0], [-1.0], [1.0]]
        seen = vertices @ axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        room = (1 - 2 * margin) * np.array([width, height])
        extent = (high - low)[:2]
        scale = float(np.min(room[extent > 0] / extent[extent > 0])) if extent.any() else 1.0
        offset = np.array([0.5 * width, 0.5 * height, 0.0]) - 0.5 * scale * (low + high)
        return Projection(axes * scale, offset, scale)


@dataclass(frozen=True, eq=False)
class Projection:
    """Map from space to a picture: pixels to the right, pixels down, depth towards the viewer in pixels."""

    matrix: FloatArray
    offset: FloatArray
    scale: float  # pixels a unit of length

    def project(self, points: FloatArray) -> FloatArray:
        """Picture coordinates of points in space, shape (n, 3)."""
        return points @ self.matrix.T + self.offset


def view_from(azimuth: float, elevation: float = 15.0, up: str = "y") -> View:
    """View from an azimuth (degrees, about the upward axis, 0 looks at the next axis but one) and elevation.

    Parameters
    ----------
    azimuth, elevation : float
        Degrees. With ``up="y"`` azimuth 0 looks from +z and 90 from +x; with ``up="z"`` 0 looks from +x and 90 from +y.
    up : {"x", "y", "z"}
        The axis that points up in the picture.
    """
    if up not in ("x", "y", "z"):
        raise ParameterError(f"up must be 'x', 'y' or 'z', got {up!r}")
    k = "xyz".index(up)
    a, e = np.radians([azimuth, elevation])
    front, side, vertical = np.roll(np.eye(3), -(k + 1), axis=0)
    horizontal = np.cos(a) * front + np.sin(a) * side
    toward = np.cos(e) * horizontal + np.sin(e) * vertical
    above = np.cos(e) * vertical - np.sin(e) * horizontal
    return View(np.array([np.cross(above, toward), above, toward]), vertical)


def best_view(vertices: FloatArray, faces: IntArray, up: str | None = None) -> View:
    """View from three quarters: 30 degrees off the widest silhouette, a little above the horizon.

    Of the four such quarters, the one from which most triangles are seen: meshes are finer where there is
    more to see, so that this finds faces rather than backs.

    Parameters
    ----------
    vertices : (n, 3) float64
    faces : (m, 3) int32
        Vertices without a face do not count.
    up : {"x", "y", "z"}, optional
        Axis that points up; guessed with `upright_axis` by default.
    """
    used, corners = np.unique(faces, return_inverse=True)
    vertices, faces = vertices[used], corners.reshape(faces.shape).astype(np.int32)
    up = upright_axis(vertices) if up is None else up
    extent = np.ptp(vertices, axis=0)
    height = extent["xyz".index(up)]
    flat = height < 0.5 * np.delete(extent, "xyz".index(up)).min()
    elevation = 40.0 if flat else 15.0  # what lies flat is looked at from higher up
    azimuths = np.arange(0.0, 180.0, 15.0)
    silhouettes = [_silhouette(vertices, faces, view_from(a, elevation, up)) for a in azimuths]
    broadside = float(azimuths[int(np.argmax(silhouettes))])
    quarters = [view_from(broadside + d, elevation, up) for d in (_THREE_QUARTER, -_THREE_QUARTER)]
    quarters += [view_from(broadside + 180.0 + d, elevation, up) for d in (_THREE_QUARTER, -_THREE_QUARTER)]
    return max(quarters, key=lambda view: _faces_seen(vertices, faces, view))


def upright_axis(vertices: FloatArray) -> str:
    """Which of the usual upward axes, y or z, the shape stands on.

    The axis along which the shape would not fall over: its centroid lies above the convex hull of the
    lowest 3 % of it. If both or none do, the one along which the lowest point is at 0; else y.
    """
    scores = []
    for name in ("y", "z"):
        k = "xyz".index(name)
        height = vertices[:, k]
        extent = float(np.ptp(height))
        ground = np.delete(vertices[height <= height.min() + 0.03 * extent], k, axis=1)
        stands = _contains(ground, np.delete(vertices.mean(axis=0), k))
        rests_at_zero = abs(float(height.min())) <= 0.02 * extent
        scores.append((2 * stands + rests_at_zero, name))
    return max(scores, key=lambda item: item[0])[1]


def _contains(points: FloatArray, point: FloatArray) -> bool:
    """Whether the convex hull of points in the plane contains a point."""
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):  # fewer than three points, or all on a line
        return False
    return bool((hull.equations @ np.append(point, 1.0) <= 0).all())


def _silhouette(vertices: FloatArray, faces: IntArray, view: View, size: int = 96) -> float:
    """Area of the silhouette, in squared units of length."""
    projection = view.fit(vertices, size, size, margin=0.0)
    return float((rasterize(projection.project(vertices), faces, size, size).face >= 0).sum()) / projection.scale**2


def _faces_seen(vertices: FloatArray, faces: IntArray, view: View, size: int = 320) -> int:
    """Number of triangles of which a point is seen."""
    projection = view.fit(vertices, size, size, margin=0.0)
    return len(np.unique(rasterize(projection.project(vertices), faces, size, size).face))
