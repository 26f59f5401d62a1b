"""Light on a picture: normals at its pixels, two lamps, and darker creases."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.ndimage import gaussian_filter

from qgeo_filters._typing import FloatArray, SingleArray
from qgeo_filters.report.raster import Fragments
from qgeo_filters.surface import Surface


def _unit(*direction: float) -> npt.NDArray[np.float32]:
    return (np.array(direction) / np.linalg.norm(direction)).astype(np.float32)


# Directions towards the lamps: right, up, towards the viewer.
_KEY = _unit(-0.45, 0.65, 0.80)
_FILL = _unit(0.85, 0.05, 0.40)
_CREASE = float(np.cos(np.radians(45.0)))


def corner_normals(surface: Surface) -> FloatArray:
    """Unit normal at each corner of each triangle, shape (m, 3, 3).

    That of the vertex, turned to the triangle's own side (neighbours may be oriented otherwise), or that of
    the triangle where the two are more than 45 degrees apart: edges of a cube stay sharp.
    """
    own = np.repeat(surface.face_normals[:, None, :], 3, axis=1)
    smooth = surface.vertex_normals[surface.faces]
    agreement = np.einsum("fci,fci->fc", own, smooth)[..., None]
    return np.where(np.abs(agreement) < _CREASE, own, smooth * np.sign(agreement))


def pixel_normals(corners: FloatArray, fragments: Fragments, axes: FloatArray) -> SingleArray:
    """Unit normals in the viewer's axes at pixels that see a triangle, shape (pixels, 3), turned to the viewer."""
    seen = (corners @ axes.T).astype(np.float32)
    facing = seen.sum(axis=1)[:, 2]
    seen *= np.where(facing < 0, -1.0, 1.0).astype(np.float32)[:, None, None]
    normals = np.einsum("pc,pci->pi", fragments.weights, seen[fragments.face])
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def lit(albedo: SingleArray, normals: SingleArray) -> SingleArray:
    """Colours (pixels, 3) of matt material under the key light, a weak fill light and light from all around."""
    key = np.maximum(normals @ _KEY, 0.0)
    fill = np.maximum(normals @ _FILL, 0.0)
    around = 0.5 + 0.5 * normals[:, 1]
    light = 0.46 + 0.12 * around + 0.50 * key + 0.16 * fill
    half = _unit(*(_KEY + np.array([0.0, 0.0, 1.0])))
    gloss = 0.10 * np.maximum(normals @ half, 0.0) ** 40
    return np.clip(albedo * light[:, None] + gloss[:, None], 0.0, 1.0)


def crease_darkening(depth: SingleArray, radius: float, strength: float = 0.35) -> SingleArray:
    """Factor of at most 1 for every pixel, smaller where its surroundings stand in front of it.

    Unsharp masking of the depth (Luft, Colditz, Deussen, "Image enhancement by unsharp masking the depth
    buffer", SIGGRAPH 2006): separates a leg from the body behind it.
    """
    seen = np.isfinite(depth)
    known = np.where(seen, depth, 0.0).astype(np.float32)
    cover = gaussian_filter(seen.astype(np.float32), radius)
    around = gaussian_filter(known, radius) / np.maximum(cover, 1e-6)
    before = np.clip((around - known) / (4.0 * radius), 0.0, 1.0)
    return np.where(seen, 1.0 - strength * before, 1.0).astype(np.float32)
