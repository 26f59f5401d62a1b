"""Poses of a surface: positions of its own vertices, from arrays, meshes of its triangles, or scans of any."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.animation.places import Places, places_on, warned
from qgeo_filters.array_likes import as_array, is_tensor
from qgeo_filters.closest_points import closest_points
from qgeo_filters.deformation.pose import posed
from qgeo_filters.errors import ParameterError, concerning
from qgeo_filters.hosts.dispatch import as_given, raw_mesh
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.repair.winding import is_inside_out
from qgeo_filters.sampling import farthest_in_embedding
from qgeo_filters.surface import Surface

# Below which a scan's shape is that of its reference rather than the scan's own, in sqrt(area).
_SCAN_LENGTH = 0.03
# A scan follows the one before where they are so near, in sqrt(area): then points of the one are marks on the other.
_NEXT, _MARKS = 0.05, 24
# Least share of the triangles that poses have in common with their reference, some edges flipped.
_COMMON = 0.9


def given_poses(reference: Surface, poses: Any) -> Iterator[FloatArray]:
    """Positions (n, 3) of the reference's vertices in each pose that has its triangles.

    Parameters
    ----------
    reference : Surface
    poses : array-like (k, n, 3), or sequence of (n, 3) arrays, meshes and paths

    Raises
    ------
    ParameterError
        Positions of another number of vertices, not finite, all in one place, or those of a mirror image; a mesh of
        other triangles; no pose at all.
    """
    count = 0
    for count, pose in enumerate(_listed(poses), start=1):
        with concerning(f"pose {count - 1}"):
            yield given_pose(reference, pose)
    if count == 0:
        raise ParameterError("no poses were given")


def scanned_poses(reference: Surface, scans: Any, accept_unsure: bool = False) -> Iterator[FloatArray]:
    """Positions (n, 3) of the reference's vertices in each pose, of which there is a scan in any triangulation.

    Each scan is matched with the reference, and the reference brought onto it as rigidly as possible. Where a scan lies
    near the one before, marks on that one steer the match.

    Raises
    ------
    ParameterError
        A scan whose match is not sure, unless that is accepted, with a warning; one that reverses the orientation.
    """
    follower, count = ScanFollower(reference, accept_unsure), 0
    for count, scan in enumerate(_listed(scans), start=1):
        with concerning(f"pose {count - 1}"):
            positions = follower(scan, f"pose {count - 1}")
        yield positions
    if count == 0:
        raise ParameterError("no poses were given")


class ScanFollower:
    """Brings a reference onto one scan after the other, as `scanned_poses` says; a scan that fails leaves no trace."""

    def __init__(self, reference: Surface, accept_unsure: bool = False) -> None:
        self._prepared, self._reference, self._accept_unsure = PreparedShape(reference), reference, accept_unsure
        self._before: FloatArray | None = None

    def __call__(self, scan: Any, called: str) -> FloatArray:
        """Positions (n, 3) of the reference's vertices; warnings say what the scan is called."""
        surface, _ = as_given(scan, "auto")
        marks = None if self._before is None else _marks(self._reference, self._before, surface)
        found = match(self._prepared, surface, landmarks=marks)
        places = places_on(surface, self._reference, found, self._accept_unsure)
        warned(f"{called}: {doubt}" for doubt in places.doubts)
        self._before = laid_onto(self._reference, surface, places, _SCAN_LENGTH)
        return self._before


def laid_onto(body: Surface, surface: Surface, places: Places, length: float) -> FloatArray:
    """Positions (n, 3) of a body on the surface, of any size, that it is mapped to; its own shape below a length."""
    grown = body.with_vertices(np.sqrt(surface.area / body.area) * body.vertices)
    return posed(grown, places.on_x.pulled_back(surface.vertices), length, length)


def same_triangles(reference: Surface, other: Surface) -> bool:
    """Whether two surfaces have the same vertices in the same order, some flipped edges apart."""
    if reference.n_vertices != other.n_vertices:
        return False
    if np.array_equal(reference.faces, other.faces):
        return True
    keys = []
    for faces in (reference.faces, other.faces):
        ordered = np.sort(faces.astype(np.int64), axis=1)
        keys.append((ordered[:, 0] * reference.n_vertices + ordered[:, 1]) * reference.n_vertices + ordered[:, 2])
    common = np.isin(keys[0], keys[1]).mean()
    return bool(common >= _COMMON)


def _listed(poses: Any) -> Iterable[Any]:
    if isinstance(poses, (Surface, str, tuple)) or hasattr(poses, "__fspath__"):
        raise ParameterError("poses must be a sequence: put a single one into a list")
    given: Any = as_array(poses) if is_tensor(poses) else poses
    if not isinstance(given, Iterable):
        raise ParameterError(f"poses must be a sequence of arrays, meshes and paths, got {type(given).__name__}")
    if isinstance(given, np.ndarray) and given.ndim == 2:
        raise ParameterError(f"poses must have shape (k, n, 3), got {given.shape}: put a single one into a list")
    listed: Iterable[Any] = given
    return listed


def given_pose(reference: Surface, pose: Any) -> FloatArray:
    """Positions (n, 3) of the reference's vertices in one pose, as `given_poses` takes it."""
    if isinstance(pose, (np.ndarray, list)) or is_tensor(pose):
        return _checked(reference, pose)
    surface, left = as_given(pose, "auto")
    if surface.n_vertices == reference.n_vertices and not same_triangles(reference, surface):
        raise ParameterError("as many vertices as the reference, but other triangles: scans=True matches it first")
    # What the repair left out has been given some place, which is none of the pose.
    return _checked(reference, raw_mesh(pose, repair=True).vertices if left else surface.vertices)


def _checked(reference: Surface, positions: npt.ArrayLike) -> FloatArray:
    array = as_array(positions).astype(np.float64)
    if array.shape != reference.vertices.shape:
        raise ParameterError(
            f"positions of shape {array.shape}, but the reference has {reference.n_vertices} vertices; "
            "scans=True takes poses in any triangulation"
        )
    lost = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if lost.size:
        raise ParameterError(f"{lost.size} of {len(array)} vertices are not finite, the first is {lost[0]}")
    if not np.ptp(array, axis=0).any():
        raise ParameterError("all vertices are in one place")
    if reference.winding in ("outward", "inward") and is_inside_out(array, reference.vertices, reference.faces):
        raise ParameterError("inside out, as a mirror image of the reference is: reflect one of the two first")
    return array


def _marks(reference: Surface, before: FloatArray, scan: Surface) -> tuple[FloatArray, FloatArray] | None:
    """Points of the reference, and those of the scan nearest to where they were before; None if that is far."""
    near = closest_points(before, scan).pulled_back(scan.vertices)
    if np.linalg.norm(near - before, axis=1).max() > _NEXT * np.sqrt(reference.area):
        return None
    chosen = farthest_in_embedding(reference.vertices, min(_MARKS, reference.n_vertices))
    return reference.vertices[chosen], near[chosen]
