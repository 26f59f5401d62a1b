"""What colours the shapes: numbers through a scale with a legend, or colours that mean places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.report.colors import MISSING, ColorScale, distinct, diverging, sequential
from qgeo_widgets.legend import color_bar, swatches
from qgeo_widgets.legend_drawing import bar_drawing, swatch_drawing

Limits = tuple[float, float]
_MOST_KEYS = 24  # names of regions that a legend has room for


@dataclass(frozen=True, eq=False)
class ScalarField:
    """A number at each vertex of each pane.

    Attributes
    ----------
    values : sequence of (n,) float64
        One array for each pane; grey where not finite.
    label : str
        Name and unit.
    signed : bool
        Whether the scale is centred on zero.
    span : (float, float), optional
        Values of the first and the last colour where they are others than those that occur here, to share a scale.
    """

    values: Sequence[FloatArray]
    label: str
    signed: bool = False
    span: Limits | None = None

    @property
    def bounds(self) -> Limits | None:
        """Smallest and largest finite value, or the span; symmetric about zero if signed; None without any."""
        joined = np.concatenate([np.ravel(v) for v in self.values])
        finite = joined[np.isfinite(joined)]
        if not finite.size:
            return None
        if self.span is not None:
            return self.span
        if self.signed:
            top = float(np.abs(finite).max())
            return -top, top
        return float(finite.min()), float(finite.max())

    def scale(self, limits: Limits | None) -> ColorScale:
        """Colour scale between the limits, or the automatic ones."""
        joined = np.concatenate([np.ravel(v) for v in self.values])
        scale = diverging(joined) if self.signed else sequential(joined)
        limits = limits or self.span
        return scale if limits is None else replace(scale, low=limits[0], high=limits[1])

    def colors(self, limits: Limits | None) -> list[FloatArray]:
        """RGB of every vertex, one array for each pane."""
        scale = self.scale(limits)
        return [scale(values) for values in self.values]

    def legend(self, limits: Limits | None) -> str:
        """Colour bar with ticks as HTML."""
        return color_bar(self.scale(limits), self.label, missing=self._missing)

    def drawing(self, limits: Limits | None) -> str:
        """The same as SVG."""
        return bar_drawing(self.scale(limits), self.label, missing=self._missing)

    @property
    def _missing(self) -> bool:
        return any(not np.isfinite(values).all() for values in self.values)


@dataclass(frozen=True, eq=False)
class ColorField:
    """A colour at each vertex of each pane, explained in a sentence.

    Attributes
    ----------
    rgb : sequence of (n, 3) float64
        One array for each pane.
    label : str
    key : sequence of (color, str)
        Names of the colours.
    cells : sequence of (n, 3) float64
        Coordinates in which a checkerboard of cells of size 1 lies over the colours, one array for each pane; or none.
    places : sequence of (n, 2) float64
        Places on the texture that is seen instead of the colours, one array for each pane; or none.
    """

    rgb: Sequence[FloatArray]
    label: str
    key: Sequence[tuple[FloatArray, str]] = ()
    cells: Sequence[FloatArray] = ()
    places: Sequence[FloatArray] = ()

    bounds: None = None

    def colors(self, limits: Limits | None) -> list[FloatArray]:
        """The colours themselves; they have no limits."""
        return list(self.rgb)

    def legend(self, limits: Limits | None) -> str:
        """The sentence as HTML, with swatches where there is a key."""
        return swatches(self.label, self.key)

    def drawing(self, limits: Limits | None) -> str:
        """The same as SVG."""
        return swatch_drawing(self.label, self.key)


@dataclass(frozen=True, eq=False)
class RegionField:
    """Numbered regions of each pane, one colour each, with borders that cut through triangles.

    Attributes
    ----------
    labels : sequence of (n,) int
        One array for each pane; negative in no region.
    palette : (k + 1, 3) float64
        Colours of the regions, and the one of none.
    label : str
        A sentence.
    key : sequence of (color, str)
        Names of the colours.
    names : sequence of str
        Of all rows of the palette.
    """

    labels: Sequence[npt.NDArray[np.integer]]
    palette: FloatArray
    label: str
    key: Sequence[tuple[FloatArray, str]] = ()
    names: Sequence[str] = ()

    bounds: None = None

    def numbers(self) -> list[IndexArray]:
        """Row of the palette for each vertex of each pane."""
        return [np.where(labels < 0, len(self.palette) - 1, labels).astype(np.int64) for labels in self.labels]

    def colors(self, limits: Limits | None) -> list[FloatArray]:
        """RGB of every vertex, one array for each pane."""
        return [self.palette[numbers] for numbers in self.numbers()]

    def legend(self, limits: Limits | None) -> str:
        """The sentence as HTML, with swatches."""
        return swatches(self.label, self.key)

    def drawing(self, limits: Limits | None) -> str:
        """The same as SVG."""
        return swatch_drawing(self.label, self.key)


Field = ScalarField | ColorField | RegionField


def grey_where_missing(rgb: FloatArray) -> FloatArray:
    """Colours (n, 3), grey where they are not finite."""
    return np.where(np.isfinite(rgb), rgb, MISSING)


def region_field(
    labels: Sequence[npt.NDArray[np.integer]], label: str, names: Sequence[str] = (), loose_name: str = "none"
) -> RegionField:
    """Field of numbered regions, equal numbers in equal colours; grey where the number is negative."""
    count = int(max(int(numbers.max(initial=-1)) for numbers in labels)) + 1
    count = max(count, len(names), 1)
    palette = np.vstack([distinct(count), np.full((1, 3), 0.62)])
    loose = any((numbers < 0).any() for numbers in labels)
    names = list(names) or [str(k) for k in range(count)]
    key = [(palette[k], name) for k, name in enumerate(names[:_MOST_KEYS])]
    key += [(palette[count], loose_name)] if loose else []
    return RegionField(labels, palette, label, key, [*names[:count], *[""] * (count - len(names)), loose_name])


def number_field(values: Sequence[FloatArray], label: str) -> ScalarField:
    """Field whose scale is centred on zero where both signs occur."""
    joined = np.concatenate([np.ravel(v) for v in values])
    finite = joined[np.isfinite(joined)]
    return ScalarField(values, label, bool(finite.size and finite.min() < 0 < finite.max()))
