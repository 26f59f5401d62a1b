"""An animation as a file of any of the kinds that it can be kept or shown as."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from qgeo_filters.animation.sequence import Animation
from qgeo_filters.errors import ParameterError
from qgeo_filters.report.animated_glb import write_animated_glb
from qgeo_filters.report.film import write_film
from qgeo_filters.report.view import View

#: Kinds of file, by their suffix.
KINDS = (".glb", ".gif", ".mp4", ".npz")


def write_animation(
    path: str | PathLike[str],
    animation: Animation,
    *,
    seconds: float | None = None,
    names: tuple[str, str] = ("X", "Y"),
    view: View | None = None,
) -> None:
    """Write an animation as a scene, as a film, or as arrays.

    Parameters
    ----------
    path : path
        ``.glb``: binary glTF with morph targets, which Blender, three.js and Windows play; ``.gif`` or ``.mp4``: a
        moving picture; ``.npz``: see `Animation.to_npz`.
    animation : Animation
        Of a `Transfer` both shapes are shown, X beside Y, what belongs together in one colour.
    seconds : float, optional
        How long it takes; by default a twelfth of a second a frame, and at least two seconds.
    names : (str, str)
        Of X and Y.
    view : View, optional
        From where it is seen; `best_view` of the first frame by default, of a `Transfer` that of Y at rest.

    Raises
    ------
    ParameterError
        Another kind of file, or a time that is not positive.
    MissingPackageError
        MP4 without the extra ``video``.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> folder = tempfile.TemporaryDirectory()
    >>> x = qg.testing.sample_surface()
    >>> qg.write_animation(pathlib.Path(folder.name) / "grow.glb", qg.Animation(x, [x.vertices, 2 * x.vertices]))
    >>> sorted(path.name for path in pathlib.Path(folder.name).iterdir())
    ['grow.glb']
    >>> folder.cleanup()
    """
    suffix = checked_kind(path)
    if not isinstance(animation, Animation):
        raise ParameterError(f"an Animation is written, or a Transfer, got {type(animation).__name__}")
    if suffix == ".npz":
        animation.to_npz(path)
    elif suffix == ".glb":
        write_animated_glb(path, animation, seconds=seconds, names=names, view=view)
    else:
        write_film(path, animation, seconds=seconds, names=names, view=view)


def checked_kind(path: str | PathLike[str]) -> str:
    """The suffix, if it is one of a kind that can be written, or `ParameterError`."""
    suffix = Path(path).suffix.lower()
    if suffix not in KINDS:
        raise ParameterError(
            f"an animation is written as {', '.join(KINDS[:-1])} or {KINDS[-1]}, got {Path(path).name}"
        )
    return suffix
