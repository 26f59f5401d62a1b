"""Colours of values: perceptually uniform scales, diverging ones centred on zero, and sets of distinct colours."""

from __future__ import annotations

from dataclasses import dataclass

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize, to_rgb

from qgeo_filters._typing import FloatArray

MISSING = (0.62, 0.62, 0.62)  # values that are not finite
SEQUENTIAL = "viridis"
# Blue - near white - red with equal lightness steps on both sides (after Kovesi, arXiv:1509.03700).
DIVERGING = LinearSegmentedColormap.from_list(
    "qgeo_diverging", ["#123a8c", "#3a6fc4", "#8db4e2", "#f1f0ee", "#eaa48d", "#cf5246", "#8c1230"]
)

_EIGHT = np.array(
    [to_rgb(name) for name in ("#3d45b3", "#e3ae32", "#199045", "#8c69a6", "#3ab1f6", "#980a00", "#e2eb4a", "#6e3965")]
)


@dataclass(frozen=True)
class ColorScale:
    """Colours of the numbers between two limits.

    Attributes
    ----------
    colormap : Colormap
    low, high : float
        Values of the first and the last colour; values beyond get those.
    """

    colormap: Colormap
    low: float
    high: float

    def __call__(self, values: npt.ArrayLike) -> FloatArray:
        """RGB in [0, 1], shape (..., 3); grey where a value is not finite."""
        values = np.asarray(values, dtype=np.float64)
        finite = np.isfinite(values)
        span = self.high - self.low
        unit = (np.where(finite, values, self.low) - self.low) / (span if span > 0 else 1.0)
        rgb = np.asarray(self.colormap(np.clip(unit, 0.0, 1.0)))[..., :3]
        return np.where(finite[..., None], rgb, MISSING)

    @property
    def norm(self) -> Normalize:
        """The same limits for Matplotlib's colour bars."""
        return Normalize(self.low, self.high)


def sequential(values: npt.ArrayLike, colormap: str | Colormap = SEQUENTIAL) -> ColorScale:
    """Scale from the smallest to the largest finite value."""
    finite = np.asarray(values, dtype=np.float64)
    finite = finite[np.isfinite(finite)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    return ColorScale(matplotlib.colormaps[colormap] if isinstance(colormap, str) else colormap, low, high)


def diverging(values: npt.ArrayLike, quantile: float = 0.995) -> ColorScale:
    """Scale centred on zero up to a high quantile of the magnitudes, so that a few outliers do not wash it out."""
    finite = np.abs(np.asarray(values, dtype=np.float64))
    finite = finite[np.isfinite(finite)]
    top = float(np.quantile(finite, quantile)) if finite.size else 1.0
    top = top or (float(finite.max()) if finite.size else 1.0) or 1.0
    return ColorScale(DIVERGING, -top, top)


def distinct(count: int) -> FloatArray:
    """Colours (count, 3) for numbered regions: neighbours in number differ much in hue and in lightness.

    The first eight, and the grey of missing values, stay apart for those who see red, green or blue less too: no two
    are nearer than .12 in Oklab, as they are or as simulated by Machado, Oliveira and Fernandes, "A
    physiologically-based model for simulation of color vision deficiency", 2009.
    """
    k = np.arange(max(count - len(_EIGHT), 0))
    hue = 250.0 + 137.50776 * k  # the golden angle: never near one of the last few
    lightness = np.take([0.62, 0.78, 0.54], k % 3)
    return np.vstack([_EIGHT[:count], _from_oklch(lightness, np.full(len(k), 0.125), hue)])


def ordered_colors(count: int) -> FloatArray:
    """Colours (count, 3) once around the hues, so that a place in an order can be found again."""
    return _from_oklch(np.full(count, 0.72), np.full(count, 0.13), np.linspace(20.0, 320.0, count))


def position_colors(positions: npt.ArrayLike, axes: FloatArray) -> FloatArray:
    """Colour of each point by its place, shape (n, 3): what is near in space is near in colour.

    Hue runs along the widest of the view's first two axes, lightness along the other, chroma along the third.

    Parameters
    ----------
    positions : array-like, shape (n, 3)
    axes : (3, 3) float64
        Of a `View`.
    """
    seen = np.asarray(positions, dtype=np.float64) @ axes.T
    extent = np.ptp(seen, axis=0)
    unit = (seen - seen.min(axis=0)) / np.maximum(extent, 0.25 * max(float(extent.max()), 1e-300))
    along, across = (0, 1) if extent[0] >= extent[1] else (1, 0)
    return _from_oklch(0.48 + 0.38 * unit[:, across], 0.05 + 0.11 * unit[:, 2], 20.0 + 290.0 * unit[:, along])


def mirror_colors(positions: npt.ArrayLike, p2p: npt.ArrayLike, axes: FloatArray) -> FloatArray:
    """Colour of each point by the middle between it and its mirror point, shape (n, 3): equal on both sides.

    Seen across the mirror plane the two places of a pair fall together, whatever the pose.

    Parameters
    ----------
    positions : array-like, shape (n, 3)
    p2p : array-like of int, shape (n,)
        Mirror image of each point; -1: none, and grey.
    axes : (3, 3) float64
        Of a `View`.
    """
    places, images = np.asarray(positions, dtype=np.float64), np.asarray(p2p)
    partners = np.where(images < 0, np.arange(len(places)), images)
    colors = position_colors(0.5 * (places + places[partners]), axes)
    return np.where(images[:, None] < 0, MISSING, colors)


def carried_colors(colors: FloatArray, p2p: npt.ArrayLike) -> FloatArray:
    """Colour of the image of each vertex, shape (n, 3); grey where it has none (-1)."""
    images = np.asarray(p2p)
    return np.where(images[:, None] < 0, MISSING, colors[images])


def _from_oklch(
    lightness: npt.NDArray[np.floating], chroma: npt.NDArray[np.floating], hue: npt.NDArray[np.floating]
) -> FloatArray:
    """SRGB of perceptual lightness, chroma and hue in degrees (Ottosson, "A perceptual color space", 2020).

    What a screen cannot show is moved straight towards the grey of equal lightness until it can.
    """
    a, b = chroma * np.cos(np.radians(hue)), chroma * np.sin(np.radians(hue))
    cones = np.stack([lightness, a, b], axis=-1) @ np.array(
        [[1.0, 1.0, 1.0], [0.3963377774, -0.1055613458, -0.0894841775], [0.2158037573, -0.0638541728, -1.2914855480]]
    )
    linear = cones**3 @ np.array(
        [
            [4.0767416621, -1.2684380046, -0.0041960863],
            [-3.3077115913, 2.6097574011, -0.7034186147],
            [0.2309699292, -0.3413193965, 1.7076147010],
        ]
    )
    grey = lightness[..., None] ** 3
    excess = np.maximum((linear - grey) / (1.0 - grey), (grey - linear) / grey).max(axis=-1, keepdims=True)
    linear = np.clip(grey + (linear - grey) / np.maximum(excess, 1.0), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
