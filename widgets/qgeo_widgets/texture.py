"""A picture that lies on a shape: read from a file or an array, and the place of each vertex on it."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image, UnidentifiedImageError

from qgeo_filters._typing import FloatArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.report.colors import MISSING
from qgeo_filters.surface import Surface

# Pixels of the longer side of what is kept: more than a shape has on screen.
_LARGEST = 1024
# What files call the two numbers, as one attribute or as two.
_PAIRS = (("uv",), ("texture_coordinates",), ("texcoord",), ("s", "t"), ("u", "v"), ("texture_u", "texture_v"))


@dataclass(frozen=True, eq=False)
class Texture:
    """A picture in the unit square, repeated beyond it; the first coordinate runs right, the second up.

    Attributes
    ----------
    pixels : (h, w, 3) uint8
        The first row is the upper edge.
    """

    pixels: npt.NDArray[np.uint8]

    @classmethod
    def of(cls, texture: Any) -> Texture:
        """A texture from a path, or from an array (h, w), (h, w, 3) or (h, w, 4), bytes or numbers from 0 to 1."""
        image = _read(texture) if isinstance(texture, (str, os.PathLike)) else _from_array(texture)
        if image.mode in ("RGBA", "LA", "PA") or "transparency" in image.info:
            image = image.convert("RGBA")
            image = Image.alpha_composite(Image.new("RGBA", image.size, "white"), image)
        image = image.convert("RGB")
        image.thumbnail((_LARGEST, _LARGEST), Image.Resampling.LANCZOS)
        return cls(np.asarray(image))

    def at(self, places: FloatArray) -> FloatArray:
        """Colours from 0 to 1 at places (n, 2), interpolated between pixels; grey where they are not finite."""
        height, width = self.pixels.shape[:2]
        known = np.asarray(np.isfinite(places).all(axis=1))
        u, v = np.where(known[:, None], places, 0.0).T
        x, y = u * width - 0.5, (1.0 - v) * height - 0.5
        left, top = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
        right, low = (x - left)[:, None], (y - top)[:, None]

        def pixel(row: npt.NDArray[np.int64], column: npt.NDArray[np.int64]) -> FloatArray:
            return self.pixels[row % height, column % width] / 255.0

        upper = (1 - right) * pixel(top, left) + right * pixel(top, left + 1)
        lower = (1 - right) * pixel(top + 1, left) + right * pixel(top + 1, left + 1)
        return np.where(known[:, None], (1 - low) * upper + low * lower, MISSING)

    @cached_property
    def encoded(self) -> npt.NDArray[np.uint8]:
        """PNG or JPEG for browsers, whichever is shorter."""
        image = Image.fromarray(self.pixels)
        files = []
        for kind, options in (("PNG", {"optimize": True}), ("JPEG", {"quality": 92, "subsampling": 0})):
            buffer = io.BytesIO()
            image.save(buffer, kind, **options)
            files.append(buffer.getvalue())
        return np.frombuffer(min(files, key=len), dtype=np.uint8)

    def projected(self, points: FloatArray) -> FloatArray:
        """Places (n, 2) of points of the scene on the picture as it is thrown at them from the front, whole."""
        height, width = self.pixels.shape[:2]
        low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
        extent = np.maximum(high - low, 1e-300)
        size = max(extent[0] * height / width, extent[1])
        return 0.5 + (points[:, :2] - (low + high) / 2) / np.array([size * width / height, size])


def texture_places(surface: Surface, given: Any, otherwise: Callable[[], FloatArray]) -> FloatArray:
    """Place of each vertex on a texture, (n, 2).

    Parameters
    ----------
    surface : Surface
    given : str, array-like or None
        Name of an attribute with two columns, or the places; None takes an attribute that is named like one, or two.
    otherwise : callable
        What they are where there is no such attribute.
    """
    name = "texture_coordinates"
    if given is None:
        for names in _PAIRS:
            found = [surface.attributes[each] for each in names if each in surface.attributes]
            table = [np.reshape(each, (surface.n_vertices, -1)) for each in found if each.dtype.kind in "fiu"]
            if len(table) == len(names) and sum(each.shape[1] for each in table) == 2:
                return np.hstack(table).astype(np.float64)
        return otherwise()
    if isinstance(given, str):
        if given not in surface.attributes:
            known = ", ".join(sorted(surface.attributes)) or "none"
            raise ParameterError(f"X has no attribute {given!r} for {name} (it has: {known})")
        given = surface.attributes[given]
    try:
        places = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{name} are no numbers: {error}") from error
    if places.shape != (surface.n_vertices, 2):
        raise ParameterError(f"{name} have shape {places.shape}, expected ({surface.n_vertices}, 2)")
    return places


def _read(path: str | os.PathLike[str]) -> Image.Image:
    try:
        with Image.open(path) as image:
            image.load()
            return image.copy()
    except FileNotFoundError as error:
        raise ParameterError(f"texture {os.fspath(path)}: there is no such file") from error
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, SyntaxError, ValueError) as error:
        raise ParameterError(f"texture {os.fspath(path)} cannot be read as a picture: {error}") from error


def _from_array(values: Any) -> Image.Image:
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ParameterError(f"texture is no array: {error}") from error
    shaped = array.ndim == 2 or (array.ndim == 3 and array.shape[2] in (3, 4))
    if not shaped or 0 in array.shape:
        raise ParameterError(f"texture has shape {array.shape}, expected (h, w), (h, w, 3) or (h, w, 4)")
    if array.dtype.kind == "f":
        if not (np.isfinite(array).all() and array.min() >= 0 and array.max() <= 1):
            raise ParameterError("texture must hold bytes, or numbers from 0 to 1")
        array = np.rint(255 * array)
    elif array.dtype != np.uint8:
        raise ParameterError(f"texture must hold bytes, or numbers from 0 to 1, not {array.dtype}")
    return Image.fromarray(np.ascontiguousarray(array, dtype=np.uint8))
