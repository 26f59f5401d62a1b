"""What viewers show of a result first: a colour for each vertex, as in the report's pictures, and its main number.

The one place that decides it, for pictures and for the meshes that are written: ``colors``, which PLY holds as red,
green and blue, and ``quality``, by which MeshLab and others colour and select.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from qgeo_filters._typing import FloatArray
from qgeo_filters.report import colors
from qgeo_filters.report.colors import MISSING, ColorScale, distinct, diverging, position_colors, sequential
from qgeo_filters.report.view import View
from qgeo_filters.surface import Surface

#: Names of the attributes.
COLORS, QUALITY = "colors", "quality"
#: What stands before the name where the mesh has such an attribute of its own.
OWN = "own_"
MOST_REGIONS = 24
# The two sides of a symmetry, and the axis between them.
SIDES = np.array([[0.45, 0.62, 0.85], [0.95, 0.76, 0.45], [0.75, 0.12, 0.18]])


@dataclass(frozen=True, eq=False)
class Shown:
    """Colours (n, 3), sRGB in [0, 1], and a number (n,), where there is one to show; NaN: none, and grey."""

    colors: FloatArray
    quality: FloatArray | None = None

    @classmethod
    def of_values(cls, values: npt.ArrayLike, *, signed: bool | None = None) -> Shown:
        """Numbers in the colours of `plot_scalar`."""
        numbers = np.asarray(values, dtype=np.float64)
        return cls(scale_of(numbers, signed)(numbers), numbers)

    @classmethod
    def of_attribute(cls, values: npt.ArrayLike) -> Shown:
        """An attribute in the colours of `plot_attribute`; of several columns the first."""
        table = np.asarray(values)
        column = table.reshape(len(table), -1)[:, 0]
        labels = labels_of(column) if table.ndim == 1 else None
        if labels is None:
            return cls.of_values(column)
        return cls(label_colors(*labels), column.astype(np.float64))

    def carried(self, carry: Callable[[np.ndarray], np.ndarray]) -> Shown:
        """The same on other vertices."""
        return Shown(carry(self.colors), None if self.quality is None else carry(self.quality))

    def on(self, surface: Surface) -> Surface:
        """The surface with both as its first attributes; those of the same names it keeps, as ``own_colors``."""
        bare = np.isnan(self.colors).any(axis=1, keepdims=True)
        color = np.rint(255 * np.clip(np.where(bare, MISSING, self.colors), 0, 1)).astype(np.uint8)
        shown: dict[str, np.ndarray] = {COLORS: color}
        if self.quality is not None:
            shown[QUALITY] = np.asarray(self.quality, dtype=np.float64)
        own = {f"{OWN}{name}" if name in shown else name: values for name, values in surface.attributes.items()}
        return Surface(surface.vertices, surface.faces).with_attributes({**shown, **own})


def scale_of(values: FloatArray, signed: bool | None = None) -> ColorScale:
    """Scale of numbers: it diverges from zero where asked to, or by default where both signs occur."""
    finite = values[np.isfinite(values)]
    if signed is None:
        signed = bool(finite.size) and float(finite.min()) < 0 < float(finite.max())
    return diverging(values) if signed else sequential(values)


def labels_of(values: np.ndarray) -> tuple[npt.NDArray[np.int64], int] | None:
    """Regions of a few whole numbers, from 0, -1 where they are negative, and how many; None for other numbers."""
    if values.dtype.kind not in "bi":
        return None
    kinds, labels = np.unique(values.astype(np.int64), return_inverse=True)
    if len(kinds) > MOST_REGIONS:
        return None
    return np.where(kinds[labels] < 0, -1, labels).astype(np.int64), len(kinds)


def label_colors(labels: npt.NDArray[np.int64], count: int, colors: FloatArray | None = None) -> FloatArray:
    """Colour of the region of each vertex, (n, 3); grey where it is negative."""
    palette = np.vstack([distinct(count) if colors is None else colors, MISSING])
    return palette[np.where(labels < 0, -1, labels)]


def mirror_colors(surface: Surface, p2p: npt.ArrayLike, view: View) -> FloatArray:
    """Colours (n, 3) by the place of the middle between each vertex and its mirror image, which both share."""
    return colors.mirror_colors(surface.vertices, p2p, view.axes)


def pose_colors(poses: Sequence[Surface], maps: Sequence[npt.ArrayLike], view: View) -> list[FloatArray]:
    """Colours of poses, each (n, 3): those of the first by place, carried over along maps from its vertices.

    A vertex that is not an image has the colour of the nearest one that is.
    """
    colors = position_colors(poses[0].vertices, view.axes)
    found = []
    for surface, image in zip(poses, maps, strict=True):
        reached, first = np.unique(np.asarray(image), return_index=True)
        nearest = cKDTree(surface.vertices[reached]).query(surface.vertices)[1]
        found.append(colors[first[nearest]])
    return found
