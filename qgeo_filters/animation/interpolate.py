"""The way from one pose of a shape to another, and through several."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from tqdm.auto import tqdm

from qgeo_filters._typing import FloatArray, RepairOption
from qgeo_filters.animation.places import MapLike, Places, places_on, warned
from qgeo_filters.animation.poses import given_pose, given_shape, listed_poses, pose_surface, same_triangles
from qgeo_filters.animation.scans import laid_onto
from qgeo_filters.animation.sequence import Animation
from qgeo_filters.barycentric import BarycentricMap
from qgeo_filters.deformation.interpolation import InterpolationPath
from qgeo_filters.errors import ParameterError, concerning
from qgeo_filters.hosts.dispatch import SurfaceLike
from qgeo_filters.matching.match_result import MatchResult
from qgeo_filters.parallel import default_workers, report_progress, single_threaded_blas
from qgeo_filters.surface import Surface
from qgeo_filters.validation import real_numbers

# Below which the mesh of X keeps its shape rather than follow the map onto Y, in sqrt(area).
_ON_Y = 0.02


def interpolate(
    x: SurfaceLike,
    y: Any,
    t: float | npt.ArrayLike,
    correspondence: Any = None,
    *,
    accept_unsure: bool = False,
    repair: RepairOption = "auto",
    workers: int | None = None,
    progress: bool = False,
) -> Animation:
    """Shapes between X and Y, or on a way through several poses, as rigid as possible at every moment.

    Parameters
    ----------
    x : Surface, or whatever `as_surface` takes
        Where the way begins; its triangles are those of the result.
    y : the same, or an array (n_x, 3), or any iterable of such, or an array (k, n_x, 3)
        The other end, or the poses that the way goes through; meshes of the triangles of X, or of any others, or
        positions of its vertices. Of one MeshSet each layer is a pose, of several their current meshes.
    t : float or array-like
        0 is X, 1 is Y (or the first of several), 2 the second, and so on. Growing, where there are several.
    correspondence : MatchResult, BarycentricMap or array-like of int, shape (n_x,), optional
        A match of X and Y, in either direction; or the point, or vertex, of Y for each vertex of X; or, of several
        poses, a list with one, or None, for each. By default a mesh of the same triangles corresponds vertex by vertex,
        and any other is matched.
    accept_unsure : bool
        Whether a match that is not sure is used all the same, with a warning.
    repair : bool, "auto", "force" or "wrap"
        What is repaired where a match is sought, see `match`; what moves is X as it is given, each of its vertices.
    workers : int, optional
        Threads; all cores that the process may use by default.
    progress : bool
        Whether to show a progress bar over the frames.

    Returns
    -------
    Animation
        A frame for each t, which are its times. At the ends the mesh of X lies exactly on X, and on Y where that has
        its triangles, else on Y to within the map's error.

    Raises
    ------
    ParameterError
        Times beyond the ends or not growing; a correspondence that is not sure, reverses the orientation, or is one of
        other shapes.

    Notes
    -----
    See `InterpolationPath`. Size and position change evenly; a body of one size in two poses keeps it.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> turned = x.with_vertices(x.vertices @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    >>> way = qg.interpolate(x, turned, [0, 0.5, 1])
    >>> half = way[1]  # turned by half of the angle, and not squeezed
    >>> bool(np.abs(half.edge_lengths / x.edge_lengths - 1).max() < 1e-6)
    True
    """
    start, notes = given_shape(x, "X")
    poses = list(listed_poses(y, "y"))
    if not poses:
        raise ParameterError("y must be a pose or several, got none")
    times = _checked_times(t, len(poses))
    maps = maps_of(correspondence, len(poses))
    ends, doubts = [start.vertices], tuple[str, ...]()
    with default_workers(workers), single_threaded_blas:
        for k, (pose, given) in enumerate(zip(poses, maps, strict=True)):
            with concerning(f"pose {k}"):
                end, left, places = _end(start, pose, given, accept_unsure, repair)
            ends.append(end)
            notes += left
            if places is not None:
                notes += places.notes + places.doubts
                doubts += places.doubts
        frames: list[FloatArray] = []
        for frame in tqdm(_frames(start, ends, times), total=len(times), desc="frames", disable=not progress):
            frames.append(frame)
            report_progress("frame", len(frames), len(times))
    warned(doubts)
    return Animation(start, np.stack(frames), times, notes)


def maps_of(correspondence: Any, count: int) -> list[MapLike | None]:
    """The map of each of so many poses: those of a list, or one for all of them.

    Raises
    ------
    ParameterError
        A list of another number.
    """
    if not isinstance(correspondence, (list, tuple)) or not any(map(_is_map, correspondence)):
        return [correspondence] * count
    if len(correspondence) != count:
        raise ParameterError(f"one correspondence for each of the {count} poses, got {len(correspondence)}")
    return list(correspondence)


def _is_map(value: Any) -> bool:
    """Whether it is a map, or stands for one, rather than the first vertex of one."""
    return value is None or isinstance(value, (MatchResult, BarycentricMap)) or np.ndim(value) > 0


def _frames(start: Surface, ends: list[FloatArray], times: FloatArray) -> Any:
    """Positions at each time; the path of each leg is made once, and its frames several side by side."""
    legs = np.minimum(times.astype(int), len(ends) - 2)
    for leg in np.unique(legs):
        path = InterpolationPath(start.with_vertices(ends[leg]), ends[leg + 1])
        yield from path.frames(times[legs == leg] - leg)


def _end(
    start: Surface, pose: Any, given: MapLike | None, accept_unsure: bool, repair: RepairOption
) -> tuple[FloatArray, tuple[str, ...], Places | None]:
    """Positions of the vertices of X in the pose of Y, what was left out of Y, and the map, unless it is one to one."""
    surface, left = pose_surface(start, pose)
    if given is None and same_triangles(start, surface):
        return given_pose(start, pose), left, None
    places = places_on(surface, start, given, accept_unsure, repair=repair)
    if np.array_equal(places.on_x.pulled_back(surface.vertices), surface.vertices):
        return surface.vertices, left, places
    return laid_onto(start, surface, places, _ON_Y), left, places


def _checked_times(t: float | npt.ArrayLike, last: int) -> FloatArray:
    times = np.atleast_1d(real_numbers(t, "t"))
    if times.ndim != 1 or not times.size or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise ParameterError("t must be a number, or growing numbers")
    if times[0] < 0 or times[-1] > last:
        raise ParameterError(f"t must be from 0 to {last}, got {times[0]:g} to {times[-1]:g}")
    return times
