"""Pictures of shaded surfaces in software: correct hidden surfaces, smooth colours, no screen, no GPU."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, SingleArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.report.colors import MISSING, ColorScale, sequential
from qgeo_filters.report.glyphs import Glyph
from qgeo_filters.report.raster import Fragments, rasterize
from qgeo_filters.report.shading import corner_normals, crease_darkening, lit, pixel_normals
from qgeo_filters.report.view import View, best_view
from qgeo_filters.surface import Surface

Image = npt.NDArray[np.uint8]

CLAY = (0.82, 0.83, 0.86)
_LINE_DARKNESS = 0.6
_CELL_DARKNESS = 0.45


def render_mesh(
    vertices: npt.ArrayLike,
    faces: npt.ArrayLike,
    values: npt.ArrayLike | None = None,
    *,
    colors: npt.ArrayLike | None = None,
    labels: npt.ArrayLike | None = None,
    cells: npt.ArrayLike | None = None,
    places: npt.ArrayLike | None = None,
    texture: Callable[[FloatArray], FloatArray] | None = None,
    scale: ColorScale | None = None,
    isolines: npt.ArrayLike = (),
    glyphs: Sequence[Glyph] = (),
    view: View | None = None,
    shown: npt.ArrayLike | None = None,
    size: tuple[int, int] = (640, 480),
    background: tuple[float, float, float] = (1.0, 1.0, 1.0),
    supersample: int = 3,
) -> Image:
    """Picture of a triangle mesh, shape (height, width, 3), uint8 RGB.

    Both sides of every triangle are drawn, by parallel projection. Values are interpolated over each triangle
    *before* they become a colour, so that colours and iso-lines stay true on coarse meshes.

    Parameters
    ----------
    vertices : array-like, shape (n, 3)
    faces : array-like, shape (m, 3)
    values : array-like, shape (n,), optional
        Shown through ``scale``; grey where not finite.
    colors : array-like, shape (n, 3), optional
        RGB in [0, 1], interpolated; in place of ``values``. With ``labels``, one row for each label.
    labels : array-like of int, shape (n,), optional
        Rows of ``colors``: each point of a triangle has the colour of the label with the most weight among its
        corners, grey where that is negative.
    cells : array-like, shape (n, d), optional
        Coordinates in which a checkerboard of cells of size 1 lies: every other cell is darker. Interpolated over each
        triangle, so that a triangle whose corners lie far apart there shows many cells.
    places : array-like, shape (n, 2), optional
        Of the vertices on a texture, interpolated; with ``texture``, in place of values and colours.
    texture : callable, optional
        From places (p, 2) to RGB in [0, 1], (p, 3).
    scale : ColorScale, optional
        Viridis over the finite values by default.
    isolines : array-like, shape (l,)
        Values at which a line is drawn.
    glyphs : sequence of Glyph
        Points and curves, hidden and shaded like the surface. The picture fits the surface alone.
    view : View, optional
        `best_view` by default.
    shown : array-like, shape (k, 3), optional
        Points that the picture has room for; the surface by default. The frames of a film share them.
    size : (int, int)
        Width and height in pixels.
    background : (r, g, b)
    supersample : int
        Samples in each direction of a pixel.

    Raises
    ------
    MeshError
        What is not a mesh.
    ValueError
        Values or colours of a wrong length, or both given.
    """
    surface = Surface(vertices, faces)
    values = _checked_values(values, surface.n_vertices)
    palette = _checked_colors(colors, labels, surface.n_vertices)
    if values is not None and palette is not None:
        raise ParameterError("give values or colors, not both")
    view = best_view(surface.vertices, surface.faces) if view is None else view
    width, height = size[0] * supersample, size[1] * supersample
    room = surface.vertices[np.unique(surface.faces)] if shown is None else np.asarray(shown, dtype=np.float64)
    projection = view.fit(room, width, height)

    solids = [surface, *(Surface(glyph.vertices, glyph.faces) for glyph in glyphs)]
    starts = np.cumsum([0, *(solid.n_vertices for solid in solids)])
    points = projection.project(np.concatenate([solid.vertices for solid in solids]))
    triangles = np.concatenate([solid.faces + start for solid, start in zip(solids, starts, strict=False)])
    picture = rasterize(points, triangles.astype(np.int32), width, height)
    seen = picture.face >= 0
    fragments = Fragments(picture.face[seen], picture.weights[seen], picture.depth[seen])

    tints = [np.tile(CLAY, (surface.n_faces, 1))]
    tints += [np.tile(glyph.color, (len(glyph.faces), 1)) for glyph in glyphs]
    albedo = np.concatenate(tints).astype(np.float32)[fragments.face]
    own = fragments.face < surface.n_faces
    on_surface = Fragments(fragments.face[own], fragments.weights[own], fragments.depth[own])
    if values is not None:
        scale = sequential(values) if scale is None else scale
        albedo[own] = scale(_interpolated(values, surface, on_surface))
        cover = _isoline_cover(values, np.atleast_1d(isolines), points, surface, on_surface, 0.6 * supersample)
        albedo[own] *= 1.0 - _LINE_DARKNESS * cover[:, None]
    elif palette is not None:
        albedo[own] = _palette_colors(palette, labels, surface, on_surface)
    elif texture is not None and places is not None:
        where = _interpolated(_checked_cells(places, surface.n_vertices, "places"), surface, on_surface)
        albedo[own] = texture(where.astype(np.float64))

    if cells is not None:
        odd = _odd_cells(_checked_cells(cells, surface.n_vertices), surface, on_surface)
        albedo[own] *= 1.0 - _CELL_DARKNESS * odd[:, None]

    normals = pixel_normals(np.concatenate([corner_normals(solid) for solid in solids]), fragments, view.axes)
    # One sample a pixel is enough for what is blurred over a dozen of them.
    darkening = crease_darkening(
        picture.depth[::supersample, ::supersample] / np.float32(supersample), radius=0.012 * min(size)
    )
    darkening = darkening.repeat(supersample, axis=0).repeat(supersample, axis=1)
    canvas = np.empty((height, width, 3), np.float32)
    canvas[:] = background
    canvas[seen] = lit(albedo, normals) * darkening[seen][:, None]
    smooth = canvas.reshape(size[1], supersample, size[0], supersample, 3).mean(axis=(1, 3))
    return np.rint(255.0 * smooth).astype(np.uint8)


def _interpolated(values: FloatArray, surface: Surface, fragments: Fragments) -> SingleArray:
    """Values (n, ...) of the vertices at the pixels; a corner without weight does not count, even if NaN."""
    corners = surface.faces[fragments.face]
    total = np.zeros((len(corners), *values.shape[1:]))
    for k in range(3):
        weight = fragments.weights[:, k].reshape(-1, *(1,) * (values.ndim - 1))
        part = values[corners[:, k]]
        total += weight * (part if np.isfinite(part).all() else np.where(weight > 0, part, 0.0))
    return total.astype(np.float32)


def _palette_colors(
    palette: FloatArray, labels: npt.ArrayLike | None, surface: Surface, fragments: Fragments
) -> FloatArray | SingleArray:
    if labels is None:
        return _interpolated(palette, surface, fragments)
    corners = np.asarray(labels)[surface.faces[fragments.face]]
    # Corners of one label add up, so that borders run straight from one edge's middle to the next.
    support = np.einsum("pij,pj->pi", corners[:, :, None] == corners[:, None, :], fragments.weights)
    label = np.take_along_axis(corners, support.argmax(axis=1)[:, None], axis=1)[:, 0]
    return np.where(label[:, None] >= 0, palette[np.maximum(label, 0)], MISSING)


def _odd_cells(cells: FloatArray, surface: Surface, fragments: Fragments) -> npt.NDArray[np.int64]:
    """1 in every other cell of the checkerboard, 0 in the others and where there is none."""
    place = _interpolated(cells, surface, fragments)
    known = np.isfinite(place).all(axis=1)
    return np.floor(np.where(known.reshape(-1, 1), place, 0.0)).sum(axis=1).astype(np.int64) % 2


def _isoline_cover(
    values: FloatArray,
    levels: FloatArray,
    points: FloatArray,
    surface: Surface,
    fragments: Fragments,
    half_width: float,
) -> SingleArray:
    """Share of each pixel, 0 to 1, under a line of constant width (pixels) at one of the levels."""
    if levels.size == 0:
        return np.zeros(len(fragments.face), np.float32)
    a, b, c = (points[surface.faces[:, k], :2] for k in range(3))
    u, v = b - a, c - a
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):  # values that are not finite, faces seen edge-on
        du, dv = (values[surface.faces[:, k]] - values[surface.faces[:, 0]] for k in (1, 2))
        gradient = np.hypot(v[:, 1] * du - u[:, 1] * dv, u[:, 0] * dv - v[:, 0] * du) / np.abs(area)
        value = _interpolated(values, surface, fragments)
        levels = np.concatenate([[-np.inf], np.sort(levels), [np.inf]])
        above = np.clip(np.searchsorted(levels, value), 1, len(levels) - 1)
        nearest = np.minimum(value - levels[above - 1], levels[above] - value)
        distance = nearest / gradient[fragments.face]
    cover = np.clip(half_width + 0.5 - distance, 0.0, 1.0)
    return np.where(np.isfinite(cover), cover, 0.0).astype(np.float32)


def _checked_values(values: npt.ArrayLike | None, n_vertices: int) -> FloatArray | None:
    if values is None:
        return None
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (n_vertices,):
        raise ParameterError(f"values have shape {array.shape}, but there are {n_vertices} vertices")
    return array


def _checked_cells(cells: npt.ArrayLike, n_vertices: int, name: str = "cells") -> FloatArray:
    array = np.asarray(cells, dtype=np.float64)
    if array.ndim != 2 or len(array) != n_vertices:
        raise ParameterError(f"{name} have shape {array.shape}, expected ({n_vertices}, d)")
    return array


def _checked_colors(colors: npt.ArrayLike | None, labels: npt.ArrayLike | None, n_vertices: int) -> FloatArray | None:
    if colors is None:
        if labels is not None:
            raise ParameterError("labels need colors, one row for each label")
        return None
    array = np.asarray(colors, dtype=np.float64)
    if labels is None:
        if array.shape != (n_vertices, 3):
            raise ParameterError(f"colors have shape {array.shape}, expected ({n_vertices}, 3)")
        return array
    numbers = np.asarray(labels)
    if numbers.shape != (n_vertices,) or numbers.dtype.kind not in "iu":
        raise ParameterError(f"labels must be {n_vertices} whole numbers, got {numbers.dtype} of shape {numbers.shape}")
    if array.ndim != 2 or array.shape[1] != 3 or len(array) <= numbers.max(initial=-1):
        raise ParameterError(
            f"colors have shape {array.shape}, expected one RGB row for each label up to {numbers.max()}"
        )
    return array
