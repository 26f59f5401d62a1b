"""Deformation transfer: the poses of one shape on another, with no markers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tqdm.auto import tqdm

from qgeo_filters._typing import FloatArray, RepairOption
from qgeo_filters.animation.places import MapLike, places_on, warned
from qgeo_filters.animation.pose_transfer import OTHER_BODY, SAME_BODY, PoseTransfer, Transfer
from qgeo_filters.animation.poses import given_poses, given_shape
from qgeo_filters.animation.scans import scanned_poses
from qgeo_filters.deformation.pose import posed
from qgeo_filters.hosts.dispatch import SurfaceLike
from qgeo_filters.parallel import default_workers, single_threaded_blas
from qgeo_filters.surface import Surface


def transfer_deformation(
    x_reference: SurfaceLike,
    x_poses: Any,
    y_reference: SurfaceLike,
    correspondence: MapLike | None = None,
    *,
    same_pose: bool = True,
    same_body: bool = False,
    scans: bool = False,
    align: bool = True,
    accept_unsure: bool = False,
    repair: RepairOption = "auto",
    workers: int | None = None,
    progress: bool = False,
) -> Transfer:
    """Poses of Y that deform it as the poses of X deform X, with no markers and no equal connectivity.

    Parameters
    ----------
    x_reference, y_reference : Surface, or whatever `as_surface` takes
        The two shapes at rest, in any triangulation, position and size.
    x_poses : array-like (k, n_x, 3), or any iterable of arrays, meshes and paths
        Poses of X: positions of the vertices of the reference, or meshes of its triangles; with ``scans=True`` meshes
        in any triangulation. One array (n_x, 3), mesh or path is one pose; of one MeshSet each layer is a pose (the
        reference is its current mesh), of several their current meshes.
    correspondence : MatchResult, BarycentricMap or array-like of int, shape (n_y,), optional
        A match of the references, in either direction; or the point, or vertex, of X for each vertex of Y (-1: none).
        By default it is found by `match`.
    same_pose : bool
        Whether the references stand in the same pose, as Sumner and Popovic take for granted: then Y is at rest where X
        is. If not, Y is brought into the pose of X's reference first, and takes the poses of X rather than what
        happened to X between them.
    same_body : bool
        Where the references stand in different poses: whether X and Y are one body, so that Y may be put where X is, or
        two, each with proportions of its own.
    scans : bool
        Whether each pose is a mesh of its own, which is matched with the reference first; see `scanned_poses`.
    align : bool
        Whether turn, size and position of X are fitted to Y; without, both must have one frame and one size.
    accept_unsure : bool
        Whether a match that is not sure is used all the same, with a warning.
    repair : bool, "auto", "force" or "wrap"
        What is repaired where a match is sought, see `match`: with "wrap" raw CT, say, is matched as a closed surface
        around it. What moves is Y as it is given, each of its vertices.
    workers : int, optional
        Threads; all cores that the process may use by default. The result does not depend on it.
    progress : bool
        Whether to show a progress bar over the poses.

    Returns
    -------
    Transfer
        The poses of Y in its own frame and size.

    Raises
    ------
    ParameterError
        Poses that do not fit the reference; a correspondence that is not sure, reverses the orientation, or is one of
        other shapes.
    MeshError
        Shapes that cannot be matched.

    Warns
    -----
    UserWarning
        References that seem to stand in different poses with ``same_pose=True``; a correspondence that is not sure.

    See Also
    --------
    transfer_pose : one pose, of another individual, without its reference.
    transferred_poses : one after the other, so that what is finished can be used.

    References
    ----------
    Sumner and Popovic, "Deformation transfer for triangle meshes", SIGGRAPH 2004; with correspondences found as Das and
    Bhandarkar, CVPRW 2018, propose ("in absence of any prior knowledge").

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> poses = [x.vertices * [1, 1, 1 + t] for t in (0.1, 0.2)]
    >>> y = x.with_vertices(2 * x.vertices)
    >>> moved = qg.transfer_deformation(x, poses, y, np.arange(162))  # without the array the map is found
    >>> len(moved), np.allclose(moved.positions[1], 2 * poses[1])
    (2, True)
    """
    with default_workers(workers), single_threaded_blas:
        plan = PoseTransfer.of(
            x_reference,
            y_reference,
            correspondence,
            same_pose=same_pose,
            same_body=same_body,
            align=align,
            accept_unsure=accept_unsure,
            repair=repair,
        )
        poses = list(tqdm(_poses(plan.x, x_poses, scans, accept_unsure, repair), desc="poses", disable=not progress))
        moved = [plan.moved(pose) for pose in poses]
    warned(plan.doubts)
    return plan.result([plan.frame(pose) for pose in poses], moved)


def transferred_poses(
    x_reference: SurfaceLike,
    x_poses: Any,
    y_reference: SurfaceLike,
    correspondence: MapLike | None = None,
    *,
    same_pose: bool = True,
    same_body: bool = False,
    scans: bool = False,
    align: bool = True,
    accept_unsure: bool = False,
    repair: RepairOption = "auto",
) -> Iterator[FloatArray]:
    """The poses of `transfer_deformation` one after the other, (n_y, 3) each, as they are finished.

    Parameters and errors are those of `transfer_deformation`. Nothing is computed before the first is asked for.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> poses = [x.vertices * [1, 1, 1 + t] for t in (0.1, 0.2)]
    >>> y = x.with_vertices(2 * x.vertices)
    >>> for pose in qg.transferred_poses(x, poses, y, np.arange(162)):
    ...     print(pose.shape)
    (162, 3)
    (162, 3)
    """
    plan = PoseTransfer.of(
        x_reference,
        y_reference,
        correspondence,
        same_pose=same_pose,
        same_body=same_body,
        align=align,
        accept_unsure=accept_unsure,
        repair=repair,
    )
    warned(plan.doubts)
    for pose in _poses(plan.x, x_poses, scans, accept_unsure, repair):
        yield plan.moved(pose)


def transfer_pose(
    x: SurfaceLike,
    y: SurfaceLike,
    correspondence: MapLike | None = None,
    *,
    same_body: bool = False,
    accept_unsure: bool = False,
    repair: RepairOption = "auto",
    workers: int | None = None,
) -> Surface:
    """Y in the pose of X, with its own shape: person B as person A stands.

    Parameters
    ----------
    x, y : Surface, or whatever `as_surface` takes
        Two individuals in any pose, triangulation, position and size.
    correspondence, same_body, accept_unsure, repair, workers
        See `transfer_deformation`.

    Returns
    -------
    Surface
        Y, its attributes kept, where X stands and in Y's own size.

    Raises
    ------
    ParameterError, MeshError
        See `transfer_deformation`.

    Warns
    -----
    UserWarning
        A correspondence that is not sure; triangles that no `Surface` can hold and that are left out.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> stretched = x.with_vertices(x.vertices * [1, 1, 1.2])
    >>> y = x.with_vertices(2 * x.vertices)
    >>> posed = qg.transfer_pose(stretched, y, np.arange(162))
    >>> posed
    Surface(162 vertices, 320 faces)
    """
    with default_workers(workers), single_threaded_blas:
        (pose, left_x), (body, left_y) = given_shape(x, "X"), given_shape(y, "Y")
        places = places_on(pose, body, correspondence, accept_unsure, repair=repair)
        targets = places.on_x.pulled_back(pose.vertices) * places.size
        moved = posed(body, targets, *(SAME_BODY if same_body else OTHER_BODY))
    notes = *(f"X: {note}" for note in left_x), *(f"Y: {note}" for note in left_y)
    warned((*notes, *places.doubts))
    share = pose.vertex_areas / pose.area
    return body.with_vertices(moved + share @ pose.vertices * (1 - places.size))


def _poses(x: Surface, poses: Any, scans: bool, accept_unsure: bool, repair: RepairOption) -> Iterator[FloatArray]:
    return scanned_poses(x, poses, accept_unsure, repair) if scans else given_poses(x, poses)
