"""Pictures of surfaces in motion: film strips, and films as GIF or MP4."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from os import PathLike
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from qgeo_filters.animation.sequence import Animation
from qgeo_filters.atomic import atomic_path, atomic_write
from qgeo_filters.errors import ParameterError, require_package
from qgeo_filters.report.panels import DPI, new_figure, show_picture
from qgeo_filters.report.reel import Reel, reels
from qgeo_filters.report.render import Image
from qgeo_filters.report.view import View

_HEIGHT = 320  # pixels of a frame of a film
_LEAST = 2.0  # seconds by default: a few poses that have little to do with each other are not to flicker by
_SHORTEST, _LONGEST = 1e-3, 60.0  # seconds of a frame: what GIF and encoders of MP4 can say


def plot_film_strip(
    animation: Animation, count: int = 6, *, names: tuple[str, str] = ("X", "Y"), view: View | None = None
) -> Figure:
    """Figure of some frames side by side, evenly spread; of a `Transfer` those of X above those of Y.

    Parameters
    ----------
    animation : Animation
    count : int
        Number of frames; fewer where there are fewer.
    names : (str, str)
        Of X and Y.
    view : View, optional
        `best_view` of the first frame by default, of a `Transfer` that of Y at rest; the same for both shapes.
    """
    rows = reels(animation, names, view)
    chosen = np.unique(np.linspace(0, len(animation) - 1, min(max(count, 1), len(animation))).round().astype(int))
    width = min(7.2 / len(chosen), 2.4)
    heights = [width / reel.aspect for reel in rows]
    figure = new_figure(width * len(chosen), sum(heights) + 0.25)
    grid = figure.add_gridspec(len(rows), len(chosen), height_ratios=heights)
    for i, (reel, height) in enumerate(zip(rows, heights, strict=True)):
        for j, frame in enumerate(chosen):
            axes = figure.add_subplot(grid[i, j])
            show_picture(axes, reel.picture(reel.animation.positions[frame], max(int(height * DPI), 32)))
            if i == 0:
                axes.set_title(f"{animation.times[frame]:.3g}", fontsize=8)
            if j == 0 and len(rows) > 1:
                axes.text(-0.02, 0.5, reel.name, transform=axes.transAxes, ha="right", va="center", fontsize=9)
    return figure


def write_film(
    path: str | PathLike[str],
    animation: Animation,
    *,
    seconds: float | None = None,
    names: tuple[str, str] = ("X", "Y"),
    view: View | None = None,
) -> None:
    """Write the frames as a moving picture; of a `Transfer` X beside Y.

    Parameters
    ----------
    path : path
        ``.gif``, or ``.mp4`` (with the extra ``video``).
    animation : Animation
    seconds : float, optional
        How long it takes; by default a twelfth of a second a frame, and at least two seconds.
    names, view
        See `plot_film_strip`.

    Raises
    ------
    ParameterError
        Another kind of file, or a time that is not positive.
    MissingPackageError
        No encoder for MP4.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in (".gif", ".mp4"):
        raise ParameterError(f"a film is written as .gif or .mp4, got {Path(path).name}")
    seconds = checked_seconds(seconds, len(animation))
    if not _SHORTEST <= seconds / len(animation) <= _LONGEST:
        raise ParameterError(
            f"a frame of a film lasts from {_SHORTEST:g} to {_LONGEST:g} s: {len(animation)} frames do not fit "
            f"{seconds:g} s"
        )
    shapes = reels(animation, names, view)
    pictures = (_beside(shapes, frame) for frame in range(len(animation)))
    if suffix == ".gif":
        _write_gif(path, list(pictures), seconds)
    else:
        _write_mp4(path, pictures, len(animation) / seconds)


def checked_seconds(seconds: float | None, frames: int) -> float:
    """How long so many frames take, as given or by default; `ParameterError` for what is no time."""
    if seconds is None:
        return max(frames / 12.0, _LEAST)
    number = isinstance(seconds, (int, float, np.number)) and not isinstance(seconds, bool)
    if not number or not (np.isfinite(seconds) and seconds > 0):
        raise ParameterError(f"seconds must be a positive number, got {seconds!r}")
    return float(seconds)


def _beside(shapes: Sequence[Reel], frame: int) -> Image:
    """One frame of all shapes, left to right."""
    return np.concatenate([reel.picture(reel.animation.positions[frame], _HEIGHT) for reel in shapes], axis=1)


def _write_gif(path: str | PathLike[str], pictures: list[Image], seconds: float) -> None:
    from PIL import Image as pillow

    first, *others = (pillow.fromarray(picture) for picture in pictures)
    content = io.BytesIO()
    # GIF counts in hundredths of a second, and viewers slow down what is quicker than two.
    duration = max(20, 10 * round(100 * seconds / len(pictures)))
    first.save(content, "GIF", save_all=True, append_images=others, duration=duration, loop=0)
    with atomic_write(path) as file:
        file.write(content.getvalue())


def _write_mp4(path: str | PathLike[str], pictures: Iterator[npt.NDArray[np.uint8]], rate: float) -> None:
    encoder = require_package("imageio_ffmpeg", "video", "a film as .mp4")
    first = next(pictures)
    with atomic_path(path) as temporary:
        writer = encoder.write_frames(str(temporary), (first.shape[1], first.shape[0]), fps=rate, macro_block_size=2)
        writer.send(None)
        writer.send(np.ascontiguousarray(first))
        for picture in pictures:
            writer.send(np.ascontiguousarray(picture))
        writer.close()
