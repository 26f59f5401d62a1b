"""Colours of vertices, the attribute ``colors``, in the forms in which files hold them."""

from __future__ import annotations

import numpy as np

from qgeo_filters._typing import FloatArray

COLORS = "colors"


def is_color(name: str, values: np.ndarray) -> bool:
    """Whether an attribute is the vertices' colours: ``colors``, (n, 3) or (n, 4), bytes or numbers from 0 to 1."""
    return name == COLORS and (is_shade(values) or (values.dtype == np.uint8 and values.shape[1:] in ((3,), (4,))))


def is_shade(values: np.ndarray) -> bool:
    """Whether these are colours from 0 to 1."""
    of_colors = values.dtype.kind == "f" and values.shape[1:] in ((3,), (4,))
    return of_colors and bool(np.all((values >= 0) & (values <= 1)))


def as_bytes(values: np.ndarray) -> np.ndarray:
    """Colours as bytes, of bytes or of numbers from 0 to 1."""
    if values.dtype == np.uint8:
        return values
    return np.rint(values.astype(np.float64) * 255).astype(np.uint8)


def as_shade(values: np.ndarray) -> FloatArray:
    """Colours as numbers from 0 to 1."""
    return values / 255.0 if values.dtype == np.uint8 else values.astype(np.float64)


def linear_bytes(values: np.ndarray) -> np.ndarray:
    """RGBA, 8 bit, (n, 4), of sRGB colours: those of glTF's vertices are linear."""
    shade = as_shade(values)
    color = shade[:, :3]
    linear = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    alpha = shade[:, 3:] if shade.shape[1] == 4 else np.ones((len(shade), 1))
    return as_bytes(np.hstack([linear, alpha]))
