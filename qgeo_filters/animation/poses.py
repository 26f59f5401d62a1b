"""Poses of a surface: positions of its own vertices, from arrays or meshes of its triangles."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Set
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray
from qgeo_filters.array_likes import as_array, is_array, is_array_like
from qgeo_filters.errors import MeshError, ParameterError, concerning
from qgeo_filters.hosts.dispatch import SurfaceLike, as_given, is_mesh, layers_of, raw_mesh
from qgeo_filters.repair.winding import is_inside_out
from qgeo_filters.surface import Surface
from qgeo_filters.validation import checked_vertices, real_numbers

# Least share of the triangles that poses have in common with their reference, some edges flipped.
_COMMON = 0.9
_SCANS = "; scans=True takes poses in any triangulation"


def listed_poses(poses: Any, name: str = "poses") -> Iterable[Any]:
    """Poses one after the other: the members of a sequence, or the one that was given.

    Parameters
    ----------
    poses : array-like (k, n, 3) or (n, 3), mesh or path, or any iterable of arrays (n, 3), meshes and paths
        Each layer of a MeshSet is a pose; of one in a sequence its current mesh is. A tuple of two arrays is one mesh
        if the second holds whole numbers, and two poses otherwise.
    name : str
        Of the argument, for errors.

    Raises
    ------
    ParameterError
        Anything else, and what is in no order.
    """
    if is_mesh(poses):
        return layers_of(poses)
    if is_array(poses):
        array = as_array(poses)
        if array.ndim == 2:
            return [array]
        if array.ndim != 3 and array.dtype != object:
            raise ParameterError(f"{name} must have shape (k, n, 3) or (n, 3), got {array.shape}")
        return list(array)
    if isinstance(poses, (Mapping, Set, bytes)) or not isinstance(poses, Iterable):
        raise ParameterError(
            f"{name} must be a mesh, or a sequence of meshes, paths and arrays, got {type(poses).__name__}"
        )
    return [poses] if isinstance(poses, (list, tuple)) and poses and _is_point(poses[0]) else poses


def given_shape(mesh: SurfaceLike, name: str) -> tuple[Surface, tuple[str, ...]]:
    """Surface of a mesh of any kind that has an area, and what was left out to hold it; errors begin with a name."""
    with concerning(name):
        surface, left = as_given(mesh, "auto")
        return with_area(surface), left


def with_area(surface: Surface) -> Surface:
    """The same surface, or `MeshError`: lengths are compared with the root of the area."""
    if not surface.area > 0:
        raise MeshError("the surface has no area: all of its triangles are flat")
    return surface


def given_poses(reference: Surface, poses: Any) -> Iterator[FloatArray]:
    """Positions (n, 3) of the reference's vertices in each pose that has its triangles.

    Parameters
    ----------
    reference : Surface
    poses : see `listed_poses`

    Raises
    ------
    ParameterError
        Positions of another number of vertices, not finite, all in one place, or those of a mirror image; a mesh of
        other triangles; no pose at all.
    """
    count = 0
    for count, pose in enumerate(listed_poses(poses), start=1):
        with concerning(f"pose {count - 1}"):
            yield given_pose(reference, pose)
    if count == 0:
        raise ParameterError("no poses were given")


def given_pose(reference: Surface, pose: Any) -> FloatArray:
    """Positions (n, 3) of the reference's vertices in one pose, as `given_poses` takes it."""
    if has_no_triangles(pose):
        return _checked(reference, pose, _SCANS)
    surface, left = as_given(pose, "auto")
    if surface.n_vertices == reference.n_vertices and not same_triangles(reference, surface):
        raise ParameterError("as many vertices as the reference, but other triangles: scans=True matches it first")
    # What the repair left out has been given some place, which is none of the pose.
    return _checked(reference, raw_mesh(pose, repair=True).vertices if left else surface.vertices, _SCANS)


def pose_surface(reference: Surface, pose: Any) -> tuple[Surface, tuple[str, ...]]:
    """A pose as a surface, with what was left out to hold it; positions alone have the reference's triangles."""
    if has_no_triangles(pose):
        return with_area(reference.with_vertices(_checked(reference, pose))), ()
    surface, left = as_given(pose, "auto")
    return with_area(surface), left


def has_no_triangles(pose: Any) -> bool:
    """Whether a pose is an array of positions, and no mesh; two rows of something are a (vertices, faces) pair."""
    return is_array_like(pose) and not (isinstance(pose, (list, tuple)) and len(pose) == 2)


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


def _is_point(value: Any) -> bool:
    """Whether it is the first row of positions, rather than the first of several poses."""
    if isinstance(value, (list, tuple)):
        return bool(value) and all(isinstance(number, (int, float, np.number)) for number in value)
    return is_array(value) and as_array(value).ndim == 1


def _checked(reference: Surface, positions: npt.ArrayLike, otherwise: str = "") -> FloatArray:
    array = real_numbers(positions, "positions")
    if array.shape != reference.vertices.shape:
        raise ParameterError(
            f"positions of shape {array.shape}, but the reference has {reference.n_vertices} vertices{otherwise}"
        )
    lost = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if lost.size:
        raise ParameterError(f"{lost.size} of {len(array)} vertices are not finite, the first is {lost[0]}")
    checked_vertices(array)  # neither too wide nor too narrow for squares of lengths
    if not np.ptp(array, axis=0).any():
        raise ParameterError("all vertices are in one place")
    if reference.winding in ("outward", "inward") and is_inside_out(array, reference.vertices, reference.faces):
        raise ParameterError("inside out, as a mirror image of the reference is: reflect one of the two first")
    return array
